//! Laws that the balances obey whatever the state, the flows and the effects: conservation, the paper's own form of the
//! equations, and effects that change nothing at their neutral values.

use chamber::balance::{self, Boundary, ENERGY, MASS, OWN, STATES};
use chamber::effects;
use chamber::integrate::{Integrator, Tolerance};
use chamber::{AreaLaw, Chamber, EffectSet, Gas, Geometry, HeatTransfer};
use proptest::prelude::*;

prop_compose! {
    fn any_chamber()(bore in 0.01..0.2f64, dead_share in 0.0..0.5f64, lambda in 1.0..200.0f64, total in any::<bool>()) -> Chamber {
        let law = if total { AreaLaw::Total } else { AreaLaw::Swept };
        let dead_volume = dead_share * bore * bore * 0.05;
        Chamber::new(Gas::AIR, Geometry::new(bore, 0.0, dead_volume, law), HeatTransfer::at_paper_reference(lambda))
    }
}

prop_compose! {
    fn any_boundary()(position in 0.02..0.3f64, velocity in -1.0..1.0f64, mass_flow_in in 0.0..1e-4f64, temperature_in in 260.0..350.0f64,
        mass_flow_out in 0.0..1e-4f64, ambient_temperature in 260.0..320.0f64) -> Boundary {
        Boundary { position, velocity, mass_flow_in, temperature_in, mass_flow_out, ambient_temperature, ambient_pressure: 1.013e5 }
    }
}

proptest! {
    #[test]
    fn every_effect_at_its_neutral_values_changes_nothing(
        chamber in any_chamber(), boundary in any_boundary(), p in 0.5e5..8e5f64, t in 240.0..420.0f64,
    ) {
        let state = balance::state_at(&chamber, &boundary, p, t);
        let plain = balance::rates(EffectSet::NONE, &chamber, &boundary, &state);
        for (index, card) in effects::all() {
            let with = balance::rates(EffectSet::one(index), &chamber, &boundary, &state);
            for i in [MASS, ENERGY] {
                prop_assert!((with[i] - plain[i]).abs() <= 1e-14 * plain[i].abs(), "{}: {} {}", card.name, with[i], plain[i]);
            }
        }
    }

    #[test]
    fn mass_and_energy_form_agrees_with_equations_1_and_2(
        chamber in any_chamber(), boundary in any_boundary(), p in 0.5e5..8e5f64, t in 240.0..420.0f64,
    ) {
        let state = balance::state_at(&chamber, &boundary, p, t);
        let (at, rates, _) = balance::evaluate(EffectSet::NONE, &chamber, &boundary, &state);
        // T = U/(m cv): dT/T = dU/U − dm/m.
        let temperature_rate = t * (rates.energy / state[ENERGY] - rates.mass / state[MASS]);
        let [dp, dt] = balance::pressure_temperature_rates(&chamber, &boundary, p, t);
        let scale = p * (boundary.velocity.abs() / boundary.position + (boundary.mass_flow_in + boundary.mass_flow_out) / state[MASS]) + dp.abs();
        prop_assert!((at.pressure / p - 1.0).abs() < 1e-14);
        prop_assert!((rates.pressure - dp).abs() < 1e-12 * scale, "{} {dp}", rates.pressure);
        prop_assert!((temperature_rate - dt).abs() < 1e-12 * scale * t / p, "{temperature_rate} {dt}");
    }
}

/// Integrates for one second with the boundary held, but for the position that moves with its velocity.
fn after_a_second(chamber: &Chamber, boundary: &Boundary, initial: [f64; STATES]) -> [f64; STATES] {
    let tolerance = chamber::simulate::tolerance(1e-11, &initial);
    let mut run = Integrator::new(0.0, initial, tolerance);
    let system = |t: f64, y: &[f64; STATES]| {
        let at = Boundary { position: boundary.position + boundary.velocity * t, ..*boundary };
        balance::rates(chamber.active(), chamber, &at, y)
    };
    run.advance(&system, 1.0, |_| ()).unwrap();
    run.state
}

/// The chamber with an effect on: its first parameters as given.
fn with_effect(chamber: Chamber, name: &str, values: &[f64]) -> Chamber {
    let mut effects = chamber.effects;
    effects.of_mut(effects::find(name).unwrap().0)[..values.len()].copy_from_slice(values);
    Chamber { effects, ..chamber }
}

fn section_31() -> (Chamber, Boundary) {
    let geometry = Geometry::new(0.02, 0.0, 1.57e-6, AreaLaw::Total);
    let chamber = Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(26.5));
    (chamber, Boundary { velocity: 0.05, ..Boundary::closed(0.05, 293.0, 1.013e5) })
}

#[test]
fn the_paper_s_form_and_the_conserved_form_stay_together_over_a_stroke_with_flows() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { mass_flow_in: 3e-5, temperature_in: 300.0, mass_flow_out: 1e-5, ..boundary };
    let state = after_a_second(&chamber, &boundary, balance::state_at(&chamber, &boundary, 2e5, 293.0));
    let mut paper = Integrator::new(0.0, [2e5, 293.0], Tolerance { relative: 1e-11, absolute: [1e-9; 2] });
    let system = |t: f64, y: &[f64; 2]| {
        let at = Boundary { position: boundary.position + boundary.velocity * t, ..boundary };
        balance::pressure_temperature_rates(&chamber, &at, y[0], y[1])
    };
    paper.advance(&system, 1.0, |_| ()).unwrap();
    let end = Boundary { position: boundary.position + boundary.velocity, ..boundary };
    let at = balance::conditions(&chamber, &end, state[MASS], state[ENERGY]);
    assert!((at.pressure / paper.state[0] - 1.0).abs() < 1e-9, "{} {}", at.pressure, paper.state[0]);
    assert!((at.temperature / paper.state[1] - 1.0).abs() < 1e-9, "{} {}", at.temperature, paper.state[1]);
}

#[test]
fn mass_with_flows_closes_to_rounding() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { mass_flow_in: 3e-5, mass_flow_out: 1e-5, ..boundary };
    let initial = balance::state_at(&chamber, &boundary, 2e5, 293.0);
    let end = after_a_second(&chamber, &boundary, initial);
    assert!((end[MASS] - (initial[MASS] + 2e-5)).abs() < 1e-15 * 100.0 * initial[MASS]);
}

#[test]
fn a_wall_of_finite_capacity_keeps_the_heat_the_gas_gave() {
    // Held piston, wall without outer conductance: gas and wall together keep their energy and end at one temperature.
    let (chamber, boundary) = section_31();
    let boundary = Boundary { velocity: 0.0, ..boundary };
    let index = effects::find("wall_heating").unwrap().0;
    let chamber = with_effect(chamber, "wall_heating", &[0.05, 0.0]);
    let initial = balance::state_at(&chamber, &boundary, 4e5, 380.0);
    let end = after_a_second(&chamber, &boundary, initial);
    let wall = OWN + effects::STATE_OFFSETS[index];
    let gas_gave = initial[ENERGY] - end[ENERGY];
    let wall_took = 0.05 * (end[wall] - initial[wall]);
    assert!(gas_gave > 0.0 && (gas_gave / wall_took - 1.0).abs() < 1e-9);
}

#[test]
fn an_isolated_core_is_compressed_without_gain_of_entropy() {
    // H = 0: the core's T2^γ P^(1−γ) is constant whatever the rest of the gas loses to the wall.
    let (chamber, boundary) = section_31();
    let boundary = Boundary { position: 0.1, velocity: -0.05, ..boundary };
    let index = effects::find("gas_zones").unwrap().0;
    let chamber = with_effect(chamber, "gas_zones", &[0.3, 0.0]);
    let end = after_a_second(&chamber, &boundary, balance::state_at(&chamber, &boundary, 1e5, 293.0));
    let at_end = Boundary { position: 0.05, ..boundary };
    let at = balance::conditions(&chamber, &at_end, end[MASS], end[ENERGY]);
    let core = end[OWN + effects::STATE_OFFSETS[index]];
    assert!((core / (293.0 * (at.pressure / 1e5).powf(0.4 / 1.4)) - 1.0).abs() < 1e-9);
    assert!(core > at.temperature + 20.0);
}

#[test]
fn a_tube_takes_the_gas_that_its_pressure_and_temperature_say() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { position: 0.1, velocity: -0.05, ..boundary };
    let tube = 3e-6;
    let chamber = with_effect(chamber, "tube_volume", &[tube]);
    let initial = balance::state_at(&chamber, &boundary, 1e5, 293.0);
    let end = after_a_second(&chamber, &boundary, initial);
    let at = balance::conditions(&chamber, &Boundary { position: 0.05, ..boundary }, end[MASS], end[ENERGY]);
    let stored = tube / (287.0 * 293.0) * (at.pressure - 1e5);
    assert!(((initial[MASS] - end[MASS]) / stored - 1.0).abs() < 1e-8);
}

#[test]
fn a_leak_fills_an_evacuated_chamber_up_to_ambient_pressure_and_no_further() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { velocity: 0.0, ..boundary };
    let chamber = with_effect(chamber, "leakage", &[3e-9]);
    for start in [0.3e5, 3e5] {
        let end = after_a_second(&chamber, &boundary, balance::state_at(&chamber, &boundary, start, 293.0));
        let at = balance::conditions(&chamber, &boundary, end[MASS], end[ENERGY]);
        assert!((at.pressure / 1.013e5 - 1.0).abs() < 1e-3, "from {start} to {}", at.pressure);
    }
}

#[test]
fn surroundings_without_pressure_change_a_tight_chamber_s_rates_in_nothing_and_choke_a_leak() {
    let (chamber, boundary) = section_31();
    let vacuum = Boundary { ambient_pressure: 0.0, ..boundary };
    let state = balance::state_at(&chamber, &boundary, 2e5, 293.0);
    assert_eq!(balance::state_at(&chamber, &vacuum, 2e5, 293.0), state);
    let tight = balance::rates(EffectSet::NONE, &chamber, &vacuum, &state);
    assert_eq!(tight, balance::rates(EffectSet::NONE, &chamber, &boundary, &state));

    let chamber = with_effect(chamber, "leakage", &[3e-9]);
    let choked = 3e-9 * 2e5 * 1.185 * (293.15f64 / 293.0).sqrt();
    let leaking = balance::rates(chamber.active(), &chamber, &vacuum, &state);
    assert!((leaking[MASS] / -choked - 1.0).abs() < 1e-12, "{leaking:?}");
    assert!(leaking.iter().all(|rate| rate.is_finite()), "{leaking:?}");
}
