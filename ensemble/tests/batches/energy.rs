//! `energy_error` compared with the true error of integrated rows.

use crate::common::results;
use crate::numbers::Numbers;
use chamber::exact::Closed;
use chamber::{AreaLaw, Chamber, EffectSet, Gas, Geometry, HeatTransfer, effects};
use ensemble::{Options, Outcome, Scenario, Solver};

const AMBIENT_K: f64 = 293.0;

fn sealed(count: usize) -> Vec<Scenario> {
    let mut r = Numbers(7);
    let one = |_| {
        let geometry = Geometry::new(r.log_between(0.016, 0.1), 0.0, r.log_between(1e-6, 1e-5), AreaLaw::Total);
        let heat_transfer = HeatTransfer::at_paper_reference(r.log_between(10.0, 80.0));
        let chamber = Chamber::new(Gas::AIR, geometry, heat_transfer);
        let positions = [r.between(0.2, 0.4), r.between(0.05, 0.15)];
        let push_time = r.log_between(0.03, 1.0);
        Scenario::push(chamber, r.between(0.8e5, 8e5), positions, push_time, push_time + 3.0)
    };
    (0..count).map(one).collect()
}

fn integrated(set: EffectSet, rows: &[Scenario], relative_tolerance: f64) -> Vec<Outcome> {
    let out = results(set, rows, &Options { solver: Solver::Adaptive, relative_tolerance, fit: false });
    assert!(out.iter().all(|o| o.status == Ok(())));
    out
}

/// Error of the energies at the end of the push and of the hold, relative to the energy, which is about the work.
fn error(s: &Scenario, o: &Outcome) -> f64 {
    let [begin, end] = [s.initial_position_m, s.final_position_m].map(|x| s.chamber.geometry.volume(x));
    let closed = Closed::filled(&s.chamber, s.initial_pressure_pa, AMBIENT_K, begin, AMBIENT_K);
    let peak = closed.ramp(AMBIENT_K, begin, end, s.push_time_s);
    let last = closed.held(peak, end, o.duration_s - s.push_time_s);
    let wrong = |found: f64, exact: f64| (found / exact - 1.0).abs();
    wrong(o.temperature_final_k, last).max(wrong(o.pressure_peak_pa, closed.pressure(peak, end)))
}

/// Asserts that the energy error is as large as the true error at each tolerance, and falls with it.
fn assert_shows(name: &str, set: EffectSet, rows: &[Scenario], error: impl Fn(usize, &Outcome) -> f64) {
    for (tolerance, most) in [(1e-4, 1e-3), (1e-7, 1e-6), (1e-10, 1e-9)] {
        let outcomes = integrated(set, rows, tolerance);
        let closure = outcomes.iter().map(|o| o.energy_error).fold(0.0, f64::max);
        let error = outcomes.iter().enumerate().map(|(i, o)| error(i, o)).fold(0.0, f64::max);
        println!("{name}, tolerance {tolerance:e}: closure {closure:.1e}, error {error:.1e}");
        assert!(closure > 0.1 * error && closure < most, "{name}, {tolerance:e}: {closure:e} {error:e}");
    }
}

#[test]
fn the_energy_error_is_as_large_as_what_the_solution_is_wrong_by_and_falls_with_it() {
    let closed = sealed(128);
    // Next to nothing flows: with mass and energy as states.
    let mut open = closed.clone();
    open.iter_mut().for_each(|s| s.mass_flow_in_kg_per_s = 1e-30);
    for (name, rows) in [("one equation", &closed), ("mass and energy", &open)] {
        assert_shows(name, EffectSet::NONE, rows, |i, o| error(&rows[i], o));
    }
}

#[test]
fn so_it_is_in_front_of_a_wall_that_warms() {
    let wall = effects::WallHeating::INDEX;
    let (mut rows, mut r) = (sealed(128), Numbers(8));
    for s in &mut rows {
        let parameters = [r.log_between(0.1, 100.0), r.log_between(0.01, 1.0)];
        s.chamber.effects.of_mut(wall).copy_from_slice(&parameters);
    }
    let exact = integrated(EffectSet::one(wall), &rows, 1e-13);
    let wrong = |found: f64, exact: f64| (found / exact - 1.0).abs();
    assert_shows("a wall that warms", EffectSet::one(wall), &rows, |i, o| {
        wrong(o.temperature_final_k, exact[i].temperature_final_k)
            .max(wrong(o.pressure_peak_pa, exact[i].pressure_peak_pa))
    });
}

#[test]
fn the_energy_balance_closes_with_each_effect() {
    for (index, card) in effects::all() {
        let mut rows = sealed(16);
        for s in &mut rows {
            s.chamber = s.chamber.with_typical(EffectSet::one(index));
            (s.mass_flow_in_kg_per_s, s.temperature_in_k) = (1e-6, 310.0);
        }
        let outcomes = integrated(EffectSet::one(index), &rows, 1e-10);
        let worst = outcomes.iter().map(|o| o.energy_error).fold(0.0, f64::max);
        println!("{}: {worst:.1e}", card.name);
        assert!(worst > 0.0 && worst < 1e-7, "{}: {worst:e}", card.name);
    }
}
