//! A row is its own: its neighbours, its place and the instruction set change nothing but, for the last, rounding.

use crate::common::{
    assert_independent, assert_same, convective, flowing, heated, kept, relaxing, remembering, results, sealed,
    stirred, varied, walled, with_a_curve_of_the_reading, with_instructions,
};
use crate::numbers::Numbers;
use chamber::{EffectSet, effects};
use ensemble::{InstructionSet, Options, Solver};

#[test]
fn a_row_does_not_depend_on_its_neighbours() {
    let (relaxing, remembering, walled) = (relaxing(300), remembering(300), walled(700));
    let (flowing, heated, stirred) = (flowing(700), heated(300), stirred(300));
    let convective = convective(300);
    let (kept, curved) = (kept(300), with_a_curve_of_the_reading(100));
    let lag = effects::SensorLag::PLACE;
    let (mut r, mut lagging) = (Numbers(5), kept.1.clone());
    for s in &mut lagging {
        s.chamber.effects.of_mut(lag)[0] = r.log_between(1e-4, 0.3);
    }
    for (set, rows, solver) in [
        (EffectSet::NONE, sealed(700), Solver::Adaptive),
        (EffectSet::NONE, sealed(700), Solver::Auto),
        (EffectSet::one(0), varied(300, Some(0)), Solver::Auto),
        (EffectSet::ALL, varied(100, None), Solver::Auto),
        (relaxing.0, relaxing.1, Solver::Auto),
        (remembering.0, remembering.1, Solver::Auto),
        (walled.0, walled.1, Solver::Auto),
        (stirred.0, stirred.1, Solver::Auto),
        (flowing.0, flowing.1, Solver::Auto),
        (heated.0, heated.1, Solver::Auto),
        (convective.0, convective.1[0].clone(), Solver::Auto),
        (convective.0, convective.1[0].clone(), Solver::Adaptive),
        (kept.0.union(EffectSet::one(lag)), lagging, Solver::Auto),
        (kept.0, kept.1, Solver::Auto),
        (curved.0, curved.1, Solver::Auto),
    ] {
        let options = Options { solver, ..Options::default() };
        for (name, instructions) in InstructionSet::all() {
            assert_independent(name, instructions, set, &rows, &options);
        }
    }
}

#[test]
fn every_instruction_set_gives_the_same_but_for_the_last_digits() {
    let (walled, flowing, heated, stirred) = (walled(64), flowing(128), heated(64), stirred(64));
    for (set, rows, solver) in [
        (EffectSet::NONE, sealed(64), Solver::Adaptive),
        (walled.0, walled.1, Solver::Auto),
        (stirred.0, stirred.1, Solver::Auto),
        (flowing.0, flowing.1, Solver::Auto),
        (heated.0, heated.1, Solver::Auto),
        (EffectSet::NONE, sealed(64), Solver::Auto),
        (EffectSet::one(0), varied(32, Some(0)), Solver::Auto),
        (EffectSet::ALL, varied(32, None), Solver::Auto),
    ] {
        // Where gas passes the wall's temperature natural convection has a corner, and how a step meets it depends on the
        // last digits: by 2e-8 at the default tolerance.
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
