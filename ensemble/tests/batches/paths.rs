//! The path of a row: exact solution, code compiled for its effects, the slow code for any effects, or none.

use crate::common::{results, sealed, varied};
use chamber::card::ClosedForm;
use chamber::{EffectSet, effects};
use ensemble::{Failure, Options, Scenario, Solver, has_code_of_its_own};

#[test]
fn no_effect_by_itself_falls_back_to_the_slow_way_of_all_effects() {
    for (index, card) in effects::all() {
        let mut rows = varied(2, Some(index));
        for s in &mut rows {
            s.mass_flow_in_kg_per_s = 0.0;
        }
        let set = EffectSet::one(index);
        if card.closed_form == ClosedForm::Kept {
            assert!(results(set, &rows, &Options::default()).iter().all(|o| o.exact), "{}", card.name);
        } else {
            assert!(has_code_of_its_own(set), "{}", card.name);
        }
    }
}

#[test]
fn effects_beside_each_other_do_not_fall_back_to_the_slow_way_of_all_effects() {
    let [curve, conduction] = ["empirical", "wall_conduction"].map(|name| effects::find(name).unwrap().0);
    let others: EffectSet =
        effects::all().map(|(index, _)| index).filter(|index| ![curve, conduction].contains(index)).collect();
    assert!(has_code_of_its_own(others));
    let without_states = |index: &usize| effects::CARDS[*index].states.is_empty();
    let beside_the_curve: EffectSet = effects::all().map(|(index, _)| index).filter(without_states).collect();
    for set in [others.intersection(effects::KEEP_THE_MASS), EffectSet::one(conduction), beside_the_curve] {
        assert!(has_code_of_its_own(set));
    }
}

#[test]
fn the_exact_solver_refuses_what_it_has_no_solution_for_and_says_where_it_was_used() {
    let mut rows = sealed(3);
    rows[1].mass_flow_in_kg_per_s = 1e-6;
    let with = |solver| results(EffectSet::NONE, &rows, &Options { solver, ..Options::default() });
    let exact = with(Solver::Exact);
    assert_eq!(exact[1].status, Err(Failure::NoExactSolution));
    assert!(exact[0].exact && exact[2].exact);
    let auto = with(Solver::Auto);
    assert_eq!(auto.iter().map(|o| o.exact).collect::<Vec<_>>(), [true, false, true]);
    assert!(with(Solver::Adaptive).iter().all(|o| !o.exact));
}

#[test]
fn a_row_that_cannot_be_solved_says_why_and_leaves_the_others_alone() {
    let good = sealed(1).remove(0);
    let with = |change: fn(&mut Scenario)| {
        let mut s = good.clone();
        change(&mut s);
        s
    };
    let rows = [
        good.clone(),
        with(|s| s.initial_pressure_pa = -1.0),
        with(|s| s.initial_temperature_k = f64::NAN),
        with(|s| s.final_position_m = -1.0),
        with(|s| s.duration_s = 0.5 * s.push_time_s),
        with(|s| s.push_time_s = 0.0),
        with(|s| s.chamber.effects.of_mut(0)[0] = 1e-12),
        with(|s| s.mass_flow_out_kg_per_s = 1e-3),
        good.clone(),
    ];
    let out = results(EffectSet::NONE, &rows, &Options::default());
    let reasons: Vec<_> = out.iter().map(|o| o.status.err()).collect();
    use Failure::*;
    assert_eq!(reasons[0], None);
    assert_eq!(reasons[1], Some(NotPositive("the initial pressure")));
    assert_eq!(reasons[2], Some(NotPositive("the initial temperature")));
    assert_eq!(reasons[3], Some(NoVolume));
    assert_eq!(reasons[4], Some(EndsInPush));
    assert_eq!(reasons[5], Some(NotPositive("the push time")));
    assert_eq!(reasons[6], Some(EffectNotInSet));
    assert!(matches!(reasons[7], Some(Empty | StepTooSmall | TooManySteps)), "{:?}", reasons[7]);
    assert_eq!(out[0], out[8]);
}
