//! Sensor readings: against the integrator.

use crate::common::{
    assert_independent, assert_same, changed, reference, results, sealed, section_31, set_first,
    with_a_curve_of_the_reading, with_instructions,
};
use chamber::effects::{RecordDelay, SensorDrift, SensorLag, SensorOffset, WarmWall};
use chamber::{EffectSet, effects};
use ensemble::{InstructionSet, Options, Scenario, Solver};

#[test]
fn a_push_of_many_relaxations_behind_a_lagging_sensor_is_integrated() {
    let mut scenarios = sealed(8);
    scenarios.iter_mut().for_each(|s| s.chamber = s.chamber.with(SensorLag::INDEX, &[0.01]));
    let [quick, slow] = [1.0, 1e4].map(|slower| {
        let slow = |s: &Scenario| {
            let push_time_s = slower * s.push_time_s;
            Scenario { push_time_s, duration_s: s.duration_s - s.push_time_s + push_time_s, ..s.clone() }
        };
        let slowed = scenarios.iter().map(slow);
        results(SensorLag::SET, &slowed.collect::<Vec<_>>(), &Options { fit: false, ..Options::default() })
    });
    assert!(quick.iter().all(|o| o.status == Ok(()) && o.exact));
    assert!(slow.iter().all(|o| o.status == Ok(()) && !o.exact));
}

#[test]
fn what_a_sensor_shows_of_a_closed_form_agrees_with_the_integrator() {
    let set = effects::of_sensor().union(WarmWall::SET);
    let rows = changed(512, 41, |k, s, r| {
        let all = [
            (SensorLag::INDEX, k % 2 > 0, r.log_between(1e-4, 1.0)),
            (RecordDelay::INDEX, k % 4 > 1, r.between(0.01, 0.95) * s.push_time_s),
            (SensorOffset::INDEX, k % 3 > 0, r.between(-1e4, 1e4)),
            (SensorDrift::INDEX, k % 5 > 1, r.between(-1e4, 1e4)),
            (WarmWall::INDEX, k % 7 > 4, r.between(-20.0, 20.0)),
        ];
        set_first(s, all);
        if k % 11 > 8 {
            s.initial_temperature_k = r.between(100.0, 600.0);
        }
    });
    let with =
        |solver, relative_tolerance| results(set, &rows, &Options { solver, relative_tolerance, ..Options::default() });
    let mut integrated = with(Solver::Adaptive, 1e-12);
    for (k, (exact, integrated)) in with(Solver::Auto, 1e-8).iter_mut().zip(&mut integrated).enumerate() {
        assert!(exact.exact && !integrated.exact);
        // If a drift outweighs the relaxation no exponential fits, and which one is found is arbitrary.
        if exact.fit.or(integrated.fit).is_some_and(|fit| fit.misfit > 0.1) {
            (exact.fit, integrated.fit) = (None, None);
        }
        assert_same(exact, integrated, 1e-8, &format!("row {k} {:?}", rows[k].chamber.effects.active()));
    }
    for (name, instructions) in InstructionSet::all() {
        assert_independent(name, instructions, set, &rows, &Options::default());
    }
}

#[test]
fn what_a_sensor_shows_by_a_curve_of_its_reading_agrees_with_the_plain_integrator() {
    let (set, rows) = with_a_curve_of_the_reading(256);
    let options = Options { relative_tolerance: 1e-10, ..Options::default() };
    for (k, (s, mut ours)) in rows.iter().zip(results(set, &rows, &options)).enumerate() {
        let mut expected = reference(set, s);
        // If a curve folds the record no exponential fits, and which one is found is arbitrary; and a nearly straight part of an
        // exponential determines τ to a few digits only.
        let of_no_exponential =
            |fit: ensemble::Fit| fit.misfit > 0.1 || fit.time_constant_s > 5.0 * (ours.duration_s - s.push_time_s);
        if [ours.fit, expected.fit].into_iter().flatten().any(of_no_exponential) {
            (ours.fit, expected.fit) = (None, None);
        }
        assert_same(&ours, &expected, 1e-7, &format!("row {k} {:?}", s.chamber.effects.active()));
    }
}

/// Whether the reading of the test of section 3.1, of 5 s, has settled for given values of one sensor effect.
fn settles_behind(effect: usize, values: &[f64]) -> Vec<(String, Vec<bool>)> {
    let set = EffectSet::one(effect);
    let rows: Vec<Scenario> = values.iter().map(|value| section_31(effect, &[*value], 5.0)).collect();
    let mut found = Vec::new();
    for (name, instructions) in InstructionSet::all() {
        for solver in [Solver::Auto, Solver::Adaptive] {
            let options = Options { solver, ..Options::default() };
            let out = with_instructions(instructions, set, &rows, &options);
            let settled = out.iter().map(|o| o.settling_time_s.is_some()).collect();
            found.push((format!("{name} {solver:?}"), settled));
        }
    }
    let plain = rows.iter().map(|s| reference(set, s).settling_time_s.is_some()).collect();
    found.push(("the plain integrator".into(), plain));
    found
}

#[test]
fn a_record_so_late_that_it_does_not_show_the_gas_settle_has_not_settled() {
    // At the end it shows the gas at 5 s minus the delay: during the hold, during the push, or before the test.
    for (name, settled) in settles_behind(RecordDelay::INDEX, &[0.0, 0.01, 1.0, 4.5, 4.9, 4.98, 5.0, 6.0]) {
        assert_eq!(settled, [true, true, true, false, false, false, false, false], "{name}");
    }
}

#[test]
fn a_record_that_lags_so_far_behind_that_it_is_still_on_its_way_has_not_settled() {
    for (name, settled) in settles_behind(SensorLag::INDEX, &[0.0, 0.01, 0.1, 3.0]) {
        assert_eq!(settled, [true, true, true, false], "{name}");
    }
}
