//! Rows that only the integrator solves: against the plain integrator.

use crate::common::{
    assert_close, assert_same, changed, flowing, heated, reference, results, sealed, section_31, stirred, varied,
    walled, with_instructions,
};
use crate::plain;
use chamber::EffectSet;
use chamber::effects::{Empirical, Leakage, NaturalConvection, RecordDelay, SensorDrift, SensorLag, WallHeating};
use ensemble::{InstructionSet, Options, Scenario};

#[test]
fn each_effect_in_lanes_agrees_with_the_plain_integrator() {
    for (index, card) in chamber::effects::all() {
        let rows = varied(16, Some(index));
        let set = EffectSet::one(index);
        for (k, (s, o)) in rows.iter().zip(results(set, &rows, &Options::default())).enumerate() {
            assert_same(&o, &reference(set, s), 1e-7, &format!("{} row {k}", card.name));
        }
    }
}

#[test]
fn all_effects_together_agree_with_the_plain_integrator() {
    let rows = varied(24, None);
    for (k, (s, o)) in rows.iter().zip(results(EffectSet::ALL, &rows, &Options::default())).enumerate() {
        assert_same(&o, &reference(EffectSet::ALL, s), 1e-7, &format!("row {k}"));
    }
}

#[test]
fn equations_of_their_own_agree_with_the_plain_integrator_whichever_way_the_hold_goes() {
    for (name, (set, rows)) in
        [("walled", walled(200)), ("heated", heated(300)), ("stirred", stirred(300)), ("flowing", flowing(400))]
    {
        let loose = Options { relative_tolerance: 1e-8, fit: false, ..Options::default() };
        let both = results(set, &rows, &Options::default()).into_iter().zip(results(set, &rows, &loose));
        for (k, (s, (tight, loose))) in rows.iter().zip(both).enumerate() {
            let (expected, what) = (reference(set, s), format!("{name} row {k}"));
            assert_same(&tight, &expected, 1e-8, &what);
            if expected.status.is_ok() {
                assert!(tight.energy_error < 1e-7, "{what}: {}", tight.energy_error);
                assert_close(loose.pressure_peak_pa, expected.pressure_peak_pa, 1e-7, &format!("{what}, loose: peak"));
                assert_close(loose.pressure_final_pa, expected.pressure_final_pa, 1e-7, &format!("{what}, loose: end"));
            }
        }
    }
}

#[test]
fn a_leak_that_chokes_or_turns_round_on_the_way_costs_no_accuracy() {
    let scenarios = changed(400, 11, |i, s, r| {
        s.chamber.effects.of_mut(Leakage::INDEX)[0] = r.log_between(1e-13, 1e-11);
        s.mass_flow_in_kg_per_s = r.log_between(1e-7, 1e-5);
        s.duration_s = 5.0;
        if i % 2 == 0 {
            s.initial_pressure_pa = s.ambient_pressure_pa * r.between(1.0, 1.1);
        }
    });
    let set = Leakage::SET;
    let options = Options { relative_tolerance: 1e-8, fit: false, ..Options::default() };
    for (s, ours) in scenarios.iter().zip(results(set, &scenarios, &options)) {
        let expected = reference(set, s);
        assert_close(ours.pressure_peak_pa, expected.pressure_peak_pa, 1e-7, "peak");
        assert_close(ours.pressure_final_pa, expected.pressure_final_pa, 1e-7, "final");
    }
}

#[test]
fn a_push_from_equal_temperatures_costs_no_accuracy_whatever_the_power_of_their_difference() {
    let [natural, late, lagging] = [NaturalConvection::INDEX, RecordDelay::INDEX, SensorLag::INDEX];
    let mut rows = sealed(96);
    for (i, s) in rows.iter_mut().enumerate() {
        s.initial_temperature_k = s.ambient_temperature_k;
        s.chamber.effects.of_mut(natural)[0] = [-0.4, 0.25, 1.0 / 3.0, 1.5][i % 4];
        // The record shows part of the push.
        match i / 4 % 3 {
            0 => {}
            1 => s.chamber.effects.of_mut(late)[0] = 0.3 * s.push_time_s,
            _ => s.chamber.effects.of_mut(lagging)[0] = 0.5 * s.push_time_s,
        }
        if i % 5 == 0 {
            std::mem::swap(&mut s.initial_position_m, &mut s.final_position_m);
        }
        s.duration_s = s.push_time_s + 2.0;
    }
    let set = [natural, late, lagging].into_iter().collect();
    let tight = Options { relative_tolerance: 1e-13, fit: false, ..Options::default() };
    let exact = results(set, &rows, &tight);
    for (k, (ours, exact)) in results(set, &rows, &Options::default()).iter().zip(exact).enumerate() {
        assert_close(ours.pressure_peak_pa, exact.pressure_peak_pa, 2e-9, &format!("peak {k}"));
        assert_close(ours.pressure_final_pa, exact.pressure_final_pa, 2e-9, &format!("final {k}"));
    }
}

#[test]
fn a_curve_over_the_pressure_costs_no_accuracy_at_its_knots() {
    let set = Empirical::SET;
    let rows = changed(64, 24, |_, s, r| {
        s.chamber = s.chamber.with_typical(set);
        let parameters = s.chamber.effects.of_mut(Empirical::INDEX).iter_mut();
        parameters.filter(|typical| typical.abs() < 0.1).for_each(|to| *to = r.between(-0.5, 0.5));
        s.duration_s = 3.0;
    });
    let options = Options { relative_tolerance: 1e-9, fit: false, ..Options::default() };
    for (s, ours) in rows.iter().zip(results(set, &rows, &options)) {
        let expected = plain::run(set, s, 1e-13);
        assert_close(ours.pressure_peak_pa, expected.pressure_peak_pa, 2e-8, "peak");
        assert_close(ours.pressure_final_pa, expected.pressure_final_pa, 2e-8, "final");
    }
}

/// The test of section 3.1 with an effect's first parameters, for several durations.
fn with_effect(effect: usize, numbers: &[f64]) -> (EffectSet, Vec<Scenario>) {
    (EffectSet::one(effect), [10.0, 20.0, 40.0].map(|duration| section_31(effect, numbers, duration)).into())
}

/// The same with a leak.
fn leaking(conductance: f64) -> (EffectSet, Vec<Scenario>) {
    with_effect(Leakage::INDEX, &[conductance])
}

#[test]
fn a_chamber_that_leaks_on_has_not_settled_however_long_the_test() {
    let options = Options { fit: false, ..Options::default() };
    let (set, rows) = leaking(1e-12);
    for (name, instructions) in InstructionSet::all() {
        for (s, o) in rows.iter().zip(with_instructions(instructions, set, &rows, &options)) {
            assert_eq!((o.settling_time_s, o.flows_on), (None, true), "{name}");
            let expected = reference(set, s);
            assert_eq!((expected.settling_time_s, expected.flows_on), (None, true));
        }
    }
}

#[test]
fn gas_that_comes_to_rest_warmer_than_the_surroundings_has_settled() {
    let options = Options { fit: false, ..Options::default() };
    let insulated = with_effect(WallHeating::INDEX, &[1.0, 0.0]);
    let (set, mut rows) = leaking(0.0);
    for s in &mut rows {
        (s.mass_flow_in_kg_per_s, s.mass_flow_out_kg_per_s, s.temperature_in_k) = (5e-6, 5e-6, 350.0);
    }
    for (set, rows) in [insulated, (set, rows)] {
        for (name, instructions) in InstructionSet::all() {
            for (s, o) in rows.iter().zip(with_instructions(instructions, set, &rows, &options)) {
                assert!(o.temperature_final_k - s.ambient_temperature_k > 1.0, "{o:?}");
                let expected = reference(set, s).settling_time_s.unwrap();
                assert_close(o.settling_time_s.unwrap(), expected, 1e-2, name);
            }
        }
    }
}

#[test]
fn a_sensor_that_drifts_by_more_than_a_hundredth_has_not_settled() {
    let options = Options { fit: false, ..Options::default() };
    for (drift, settles) in [(-300.0, false), (300.0, false), (1.0, true)] {
        let (set, rows) = with_effect(SensorDrift::INDEX, &[drift]);
        for (name, instructions) in InstructionSet::all() {
            for (s, o) in rows.iter().zip(with_instructions(instructions, set, &rows, &options)) {
                assert_eq!(o.settling_time_s.is_some(), settles, "{name} {drift}");
                assert_eq!(reference(set, s).settling_time_s.is_some(), settles, "{drift}");
            }
        }
    }
}

#[test]
fn a_leak_too_small_to_show_leaves_the_settling_time_of_a_tight_chamber() {
    let options = Options { fit: false, ..Options::default() };
    let (set, rows) = leaking(1e-16);
    let (_, tight) = leaking(0.0);
    for (name, instructions) in InstructionSet::all() {
        let of = |rows| with_instructions(instructions, set, rows, &options);
        for (leaking, tight) in of(&rows).iter().zip(of(&tight)) {
            assert_close(leaking.settling_time_s.unwrap(), tight.settling_time_s.unwrap(), 1e-2, name);
        }
    }
}
