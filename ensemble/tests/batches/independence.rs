//! Rows are independent of their neighbours and their place, and, except for rounding, of the instruction set.

use crate::common::{
    assert_independent, assert_same, convective, flowing, heated, relaxing, remembering, results, sealed, stirred,
    varied, walled, with_a_curve_of_the_reading, with_closed_form, with_instructions,
};
use crate::numbers::Numbers;
use chamber::EffectSet;
use chamber::effects::SensorLag;
use ensemble::{InstructionSet, Options, Solver};

#[test]
fn a_row_does_not_depend_on_its_neighbours() {
    let (natural, [convective, _]) = convective(300);
    let (set, mut lagging) = with_closed_form(300);
    let mut r = Numbers(5);
    for s in &mut lagging {
        s.chamber.effects.of_mut(SensorLag::INDEX)[0] = r.log_between(1e-4, 0.3);
    }
    for ((set, rows), solver) in [
        ((EffectSet::NONE, sealed(700)), Solver::Adaptive),
        ((EffectSet::NONE, sealed(700)), Solver::Auto),
        ((EffectSet::one(0), varied(300, Some(0))), Solver::Auto),
        ((EffectSet::ALL, varied(100, None)), Solver::Auto),
        (relaxing(300), Solver::Auto),
        (remembering(300), Solver::Auto),
        (walled(700), Solver::Auto),
        (stirred(300), Solver::Auto),
        (flowing(700), Solver::Auto),
        (heated(300), Solver::Auto),
        ((natural, convective.clone()), Solver::Auto),
        ((natural, convective), Solver::Adaptive),
        ((set.union(SensorLag::SET), lagging), Solver::Auto),
        (with_closed_form(300), Solver::Auto),
        (with_a_curve_of_the_reading(100), Solver::Auto),
    ] {
        let options = Options { solver, ..Options::default() };
        for (name, instructions) in InstructionSet::all() {
            assert_independent(name, instructions, set, &rows, &options);
        }
    }
}

#[test]
fn every_instruction_set_gives_the_same_but_for_the_last_digits() {
    for ((set, rows), solver) in [
        ((EffectSet::NONE, sealed(64)), Solver::Adaptive),
        (walled(64), Solver::Auto),
        (stirred(64), Solver::Auto),
        (flowing(128), Solver::Auto),
        (heated(64), Solver::Auto),
        ((EffectSet::NONE, sealed(64)), Solver::Auto),
        ((EffectSet::one(0), varied(32, Some(0))), Solver::Auto),
        ((EffectSet::ALL, varied(32, None)), Solver::Auto),
    ] {
        // Natural convection has a corner where gas passes the wall's temperature, and how a step meets it depends on the last digits:
        // by 2e-8 at the default tolerance.
        let options = Options { solver, relative_tolerance: 1e-12, ..Options::default() };
        let widest = results(set, &rows, &options);
        for (name, instructions) in InstructionSet::all() {
            for (k, (o, expected)) in
                with_instructions(instructions, set, &rows, &options).iter().zip(&widest).enumerate()
            {
                assert_same(o, expected, 1e-8, &format!("{name}: row {k}"));
            }
        }
    }
}
