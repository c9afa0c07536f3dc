//! Laws that the balances obey for any state, flows and effects: conservation, the paper's own form of the equations, and no
//! change by effects at their neutral values.

#[path = "common/any.rs"]
mod any;

use any::{any_boundary, any_chamber};
use chamber::balance::{self, Balances, Boundary, Conditions, ENERGY, MASS, OWN, STATES, Tight};
use chamber::effects::empirical::{Curve, Term, Variable};
use chamber::effects::{
    self, DeadVolumeSurface, Empirical, GasZones, LaminarLeakage, Leakage, SupplyLeakage,
    TemperatureDependentHeatCapacity, TubeVolume, WallHeating, WarmWall,
};
use chamber::integrate::{Integrator, Tolerance};
use chamber::{AreaLaw, Chamber, EffectSet, HeatTransfer, papers_chamber};
use proptest::prelude::*;

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
    fn effects_on_the_energy_let_no_gas_pass_and_a_tight_chamber_has_the_same_rates(
        chamber in any_chamber(), boundary in any_boundary(), p in 0.5e5..8e5f64, t in 240.0..420.0f64,
    ) {
        let boundary = Boundary { mass_flow_in: 0.0, mass_flow_out: 0.0, ..boundary };
        for index in effects::KEEP_THE_MASS.iter() {
            let (card, set) = (&effects::CARDS[index], EffectSet::one(index));
            let chamber = chamber.with_typical(set);
            let (balance, state) = (Balances::of(chamber), balance::state_at(&chamber, &boundary, p, t));
            let (_, open, own) = balance.evaluate(set, &boundary, &state);
            prop_assert_eq!(open.mass, 0.0, "{}", card.name);
            let contents = balance.contents(&boundary, &state);
            let (_, tight, tight_own) =
                balance.evaluate_within(&Tight, set, &boundary, &contents, &balance::own_states(&state));
            prop_assert_eq!((open.energy, open.pressure), (tight.energy, tight.pressure), "{}", card.name);
            prop_assert_eq!(own, tight_own, "{}", card.name);
        }
    }

    #[test]
    fn the_effects_of_the_wall_are_those_that_move_its_temperature_and_they_do_nothing_else(
        chamber in any_chamber(), boundary in any_boundary(), p in 0.5e5..8e5f64, t in 240.0..420.0f64,
    ) {
        for (index, card) in effects::all() {
            let chamber = chamber.with_typical(EffectSet::one(index));
            let mut state = balance::state_at(&chamber, &boundary, p, t);
            state[OWN..].iter_mut().for_each(|own| *own += 1.0);
            let wall = |set: EffectSet| balance::evaluate(set, &chamber, &boundary, &state).0;
            let (without, with) = (wall(EffectSet::NONE), wall(EffectSet::one(index)));
            let is_of_wall = effects::OF_WALL.has(index);
            prop_assert_eq!(with.wall_temperature != without.wall_temperature, is_of_wall, "{}", card.name);
            let put_back = balance::Conditions { wall_temperature: without.wall_temperature, ..with };
            prop_assert!(!is_of_wall || format!("{put_back:?}") == format!("{without:?}"), "{}", card.name);
        }
    }

    #[test]
    fn gas_that_leaves_a_tight_chamber_is_in_the_tube(
        chamber in any_chamber(), boundary in any_boundary(), p in 0.5e5..8e5f64, t in 240.0..420.0f64,
    ) {
        let boundary = Boundary { mass_flow_in: 0.0, mass_flow_out: 0.0, ..boundary };
        let mut chamber = chamber.with(TubeVolume::INDEX, &[5e-6]);
        for beside in [[0.0; 2], [1e-3, 0.0], [1e-3, 1e-6]] {
            chamber = chamber.with(TemperatureDependentHeatCapacity::INDEX, &beside);
            for value in [0.0, 0.2] {
                let curve = Curve {
                    term: Term::VolumeShare,
                    variable: Variable::Pressure,
                    knots: vec![0.0, 1e6],
                    values: vec![0.0, value],
                };
                chamber = chamber.with(Empirical::INDEX, &curve.parameters());
                let state = balance::state_at(&chamber, &boundary, p, t);
                let (at, rates, _) = balance::evaluate(chamber.active(), &chamber, &boundary, &state);
                let stored = 5e-6 / (at.gas_constant * at.ambient_temperature) * rates.pressure;
                prop_assert!((rates.mass + stored).abs() < 1e-13 * stored.abs(), "{beside:?} {value}: {} {stored}", rates.mass);
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

/// States of a chamber one second apart, with a constant boundary except for the position, which moves at its velocity.
struct Second {
    initial: [f64; STATES],
    end: [f64; STATES],
    /// Conditions of the gas at the end.
    at: Conditions<f64>,
}

/// Starts at a pressure, Pa, and temperature, K.
fn a_second(chamber: &Chamber, boundary: &Boundary, pressure: f64, temperature: f64) -> Second {
    let initial = balance::state_at(chamber, boundary, pressure, temperature);
    let mut run = Integrator::new(0.0, initial, chamber::simulate::tolerance(1e-11, &initial));
    let moved = |t: f64| Boundary { position: boundary.position + boundary.velocity * t, ..*boundary };
    let system = |t: f64, y: &[f64; STATES]| balance::rates(chamber.active(), chamber, &moved(t), y);
    run.advance(&system, 1.0, |_| ()).unwrap();
    let end = run.state;
    Second { initial, end, at: balance::conditions(chamber, &moved(1.0), end[MASS], end[ENERGY]) }
}

fn section_31() -> (Chamber, Boundary) {
    (papers_chamber::section_31(AreaLaw::Total), Boundary { velocity: 0.05, ..Boundary::closed(0.05, 293.0, 1.013e5) })
}

#[test]
fn the_paper_s_form_and_the_conserved_form_stay_together_over_a_stroke_with_flows() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { mass_flow_in: 3e-5, temperature_in: 300.0, mass_flow_out: 1e-5, ..boundary };
    let Second { at, .. } = a_second(&chamber, &boundary, 2e5, 293.0);
    let mut paper = Integrator::new(0.0, [2e5, 293.0], Tolerance { relative: 1e-11, absolute: [1e-9; 2] });
    let system = |t: f64, y: &[f64; 2]| {
        let at = Boundary { position: boundary.position + boundary.velocity * t, ..boundary };
        balance::pressure_temperature_rates(&chamber, &at, y[0], y[1])
    };
    paper.advance(&system, 1.0, |_| ()).unwrap();
    assert!((at.pressure / paper.state[0] - 1.0).abs() < 1e-9, "{} {}", at.pressure, paper.state[0]);
    assert!((at.temperature / paper.state[1] - 1.0).abs() < 1e-9, "{} {}", at.temperature, paper.state[1]);
}

#[test]
fn mass_with_flows_closes_to_rounding() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { mass_flow_in: 3e-5, mass_flow_out: 1e-5, ..boundary };
    let Second { initial, end, .. } = a_second(&chamber, &boundary, 2e5, 293.0);
    assert!((end[MASS] - (initial[MASS] + 2e-5)).abs() < 1e-15 * 100.0 * initial[MASS]);
}

#[test]
fn a_wall_of_finite_capacity_keeps_the_heat_the_gas_gave() {
    // Held piston, wall without outer conductance: gas and wall together keep their energy and end at one temperature.
    let (chamber, boundary) = section_31();
    let boundary = Boundary { velocity: 0.0, ..boundary };
    let chamber = chamber.with(WallHeating::INDEX, &[0.05, 0.0]);
    let Second { initial, end, .. } = a_second(&chamber, &boundary, 4e5, 380.0);
    let wall = OWN + effects::STATE_OFFSETS[WallHeating::INDEX];
    let gas_gave = initial[ENERGY] - end[ENERGY];
    let wall_took = 0.05 * (end[wall] - initial[wall]);
    assert!(gas_gave > 0.0 && (gas_gave / wall_took - 1.0).abs() < 1e-9);
}

#[test]
fn an_isolated_core_is_compressed_without_gain_of_entropy() {
    // H = 0: the core's T2^γ P^(1−γ) is constant whatever the rest of the gas loses to the wall.
    let (chamber, boundary) = section_31();
    let boundary = Boundary { position: 0.1, velocity: -0.05, ..boundary };
    let chamber = chamber.with(GasZones::INDEX, &[0.3, 0.0]);
    let Second { end, at, .. } = a_second(&chamber, &boundary, 1e5, 293.0);
    let core = end[OWN + effects::STATE_OFFSETS[GasZones::INDEX]];
    assert!((core / (293.0 * (at.pressure / 1e5).powf(0.4 / 1.4)) - 1.0).abs() < 1e-9);
    assert!(core > at.temperature + 20.0);
}

#[test]
fn a_tube_takes_the_gas_given_by_its_pressure_and_temperature() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { position: 0.1, velocity: -0.05, ..boundary };
    let tube = 3e-6;
    let chamber = chamber.with(TubeVolume::INDEX, &[tube]);
    let Second { initial, end, at } = a_second(&chamber, &boundary, 1e5, 293.0);
    let stored = tube / (287.0 * 293.0) * (at.pressure - 1e5);
    assert!(((initial[MASS] - end[MASS]) / stored - 1.0).abs() < 1e-8);
}

#[test]
fn a_leak_fills_an_evacuated_chamber_up_to_ambient_pressure_and_no_further() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { velocity: 0.0, ..boundary };
    let chamber = chamber.with(Leakage::INDEX, &[3e-9]);
    for start in [0.3e5, 3e5] {
        let Second { at, .. } = a_second(&chamber, &boundary, start, 293.0);
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

    let chamber = chamber.with(Leakage::INDEX, &[3e-9]);
    let choked = 3e-9 * 2e5 * 1.185 * (293.15f64 / 293.0).sqrt();
    let leaking = balance::rates(chamber.active(), &chamber, &vacuum, &state);
    assert!((leaking[MASS] / -choked - 1.0).abs() < 1e-12, "{leaking:?}");
    assert!(leaking.iter().all(|rate| rate.is_finite()), "{leaking:?}");
}

/// The same chamber without heat transfer.
fn adiabatic(chamber: Chamber) -> Chamber {
    Chamber { heat_transfer: HeatTransfer { coefficient: 0.0, ..chamber.heat_transfer }, ..chamber }
}

#[test]
fn a_surface_beside_the_area_law_s_exchanges_heat_like_it_and_never_gives_a_negative_area() {
    let (chamber, boundary) = section_31();
    let state = balance::state_at(&chamber, &boundary, 2e5, 340.0);
    let heat = |extra: f64| {
        let chamber = chamber.with(DeadVolumeSurface::INDEX, &[extra]);
        balance::evaluate(chamber.active(), &chamber, &boundary, &state).1.heat_flow
    };
    let of_law = chamber.geometry.heat_transfer_area(chamber.geometry.volume(boundary.position));
    assert!((heat(of_law) / heat(0.0) - 2.0).abs() < 1e-14);
    assert!((heat(-0.25 * of_law) / heat(0.0) - 0.75).abs() < 1e-14);
    assert_eq!(heat(-2.0 * of_law).abs(), 0.0);
}

#[test]
fn gas_in_a_warm_wall_begins_and_stays_at_rest_at_the_wall_s_temperature() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { velocity: 0.0, ..boundary };
    let chamber = chamber.with(WarmWall::INDEX, &[15.0]);
    let rest = chamber.effects.rest_temperature(boundary.ambient_temperature);
    assert_eq!(rest, 308.0);
    let at_rest =
        balance::rates(chamber.active(), &chamber, &boundary, &balance::state_at(&chamber, &boundary, 2e5, rest));
    assert!(at_rest[MASS] == 0.0 && at_rest[ENERGY].abs() < 1e-12, "{at_rest:?}");
    assert!(a_second(&chamber, &boundary, 2e5, 293.0).at.temperature > 300.0);
}

#[test]
fn a_gas_of_varying_heat_capacity_keeps_its_entropy_in_an_adiabatic_stroke() {
    // ds = cv(T) dT/T + R dV/V = 0: (1 − 293 s + 293² c) ln(T/T0) + (s − 2 · 293 c) (T − T0) + c (T² − T0²)/2 + (γ − 1) ln(V/V0) = 0.
    let (chamber, boundary) = section_31();
    let boundary = Boundary { position: 0.1, velocity: -0.07, ..boundary };
    for [slope, c] in [[1.4e-3, 0.0], [1.2e-4, 0.0], [-4e-4, 0.0], [6e-5, 5e-7], [1.4e-3, -1.4e-6], [0.0, 3e-6]] {
        let chamber = adiabatic(chamber.with(TemperatureDependentHeatCapacity::INDEX, &[slope, c]));
        let Second { at, .. } = a_second(&chamber, &boundary, 2e5, 310.0);
        let volumes = chamber.geometry.volume(0.03) / chamber.geometry.volume(0.1);
        let [logarithm, linear, square] = [1.0 - 293.0 * slope + 293.0 * 293.0 * c, slope - 2.0 * 293.0 * c, 0.5 * c];
        let t = at.temperature;
        let rise = logarithm * (t / 310.0).ln() + linear * (t - 310.0) + square * (t * t - 310.0 * 310.0);
        assert!((rise + 0.4 * volumes.ln()).abs() < 1e-9, "{slope} {c}: {rise}");
        assert!((at.pressure * volumes / (2e5 * t / 310.0) - 1.0).abs() < 1e-12, "{slope} {c}");
    }
}

#[test]
fn gas_that_enters_brings_the_enthalpy_of_its_own_temperature() {
    // m u(T) − m0 u(T0) = (m − m0) h(Tin), u(T) = cv (T + s (T²/2 − 293 T) + c (T³/3 − 293 T² + 293² T)), h = u + R T.
    let (chamber, boundary) = section_31();
    let boundary = Boundary { velocity: 0.0, mass_flow_in: 3e-5, temperature_in: 390.0, ..boundary };
    let (slope, c) = (1.4e-3, -1.4e-6);
    let chamber = adiabatic(chamber.with(TemperatureDependentHeatCapacity::INDEX, &[slope, c]));
    let Second { initial, end, at } = a_second(&chamber, &boundary, 1e5, 293.0);
    let square = |t: f64| t * t * t / 3.0 - 293.0 * t * t + 293.0 * 293.0 * t;
    let u = |t: f64| 717.5 * (t + slope * (0.5 * t * t - 293.0 * t) + c * square(t));
    let [gained, brought] = [
        end[MASS] * u(at.temperature) - initial[MASS] * u(293.0),
        (end[MASS] - initial[MASS]) * (u(390.0) + 287.0 * 390.0),
    ];
    assert!((gained / brought - 1.0).abs() < 1e-10, "{gained} {brought}");
}

proptest! {
    #[test]
    fn the_pressure_s_rate_is_that_of_the_states_whatever_the_heat_capacity(
        chamber in any_chamber(), boundary in any_boundary(), p in 0.5e5..8e5f64, t in 260.0..400.0f64, slope in -4e-4..2e-3f64,
        curvature in -1.4e-6..4e-6f64,
    ) {
        let chamber = chamber.with(TemperatureDependentHeatCapacity::INDEX, &[slope, curvature]);
        let set = chamber.active();
        let state = balance::state_at(&chamber, &boundary, p, t);
        let (at, rates, _) = balance::evaluate(set, &chamber, &boundary, &state);
        prop_assert!((at.pressure / p - 1.0).abs() < 1e-12 && (at.temperature / t - 1.0).abs() < 1e-12);
        let h = 1e-6;
        let pressure = |h: f64| {
            let later = Boundary { position: boundary.position + h * boundary.velocity, ..boundary };
            balance::conditions(&chamber, &later, state[MASS] + h * rates.mass, state[ENERGY] + h * rates.energy).pressure
        };
        let by_difference = (pressure(h) - pressure(-h)) / (2.0 * h);
        prop_assert!((rates.pressure - by_difference).abs() < 1e-6 * (rates.pressure.abs() + p), "{} {by_difference}", rates.pressure);
    }
}

#[test]
fn a_laminar_leak_is_a_linear_one_for_small_differences_and_grows_with_the_mean_pressure() {
    let (chamber, boundary) = section_31();
    let chamber = chamber.with(LaminarLeakage::INDEX, &[2e-11]);
    let outside = boundary.ambient_pressure;
    let flow = |p: f64| {
        balance::rates(chamber.active(), &chamber, &boundary, &balance::state_at(&chamber, &boundary, p, 300.0))[MASS]
    };
    let density = |t: f64| outside / (287.0 * t);
    assert!((flow(outside + 1.0) / (-2e-11 * density(300.0)) - 1.0).abs() < 1e-5);
    assert!((flow(outside - 1.0) / (2e-11 * density(293.0)) - 1.0).abs() < 1e-5);
    assert!((flow(3.0 * outside) / (-2e-11 * density(300.0) * 4.0 * outside) - 1.0).abs() < 1e-12);
}

#[test]
fn a_valve_that_leaks_fills_the_chamber_up_to_its_supply_and_no_further() {
    let (chamber, boundary) = section_31();
    let boundary = Boundary { velocity: 0.0, ..boundary };
    let chamber = chamber.with(SupplyLeakage::INDEX, &[3e-9, 4e5]);
    for start in [1e5, 6e5] {
        let Second { at, .. } = a_second(&chamber, &boundary, start, 293.0);
        assert!((at.pressure / 4e5 - 1.0).abs() < 1e-3, "from {start} to {}", at.pressure);
    }
}
