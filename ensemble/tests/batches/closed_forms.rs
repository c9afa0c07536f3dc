//! Effects that keep the closed form, or whose hold is an integral: against the integrator and against exact solutions.

use crate::common::{assert_close, assert_same, convective, relaxing, remembering, results, sealed, with_closed_form};
use chamber::effects;
use ensemble::{Failure, Options, Outcome, Scenario, Solver};

#[test]
fn effects_that_keep_the_closed_form_agree_with_the_integrator_whatever_is_beside_them() {
    let (set, rows) = with_closed_form(256);
    let with = |solver| results(set, &rows, &Options { solver, ..Options::default() });
    for (k, (exact, integrated)) in with(Solver::Auto).iter().zip(with(Solver::Adaptive)).enumerate() {
        assert!(exact.exact && !integrated.exact);
        assert_same(exact, &integrated, 1e-8, &format!("row {k}"));
    }
}

#[test]
fn holds_that_are_integrals_over_the_temperature_agree_with_the_integrator() {
    let (set, rows) = relaxing(1024);
    let with = |solver| results(set, &rows, &Options { solver, relative_tolerance: 1e-12, ..Options::default() });
    assert_holds_agree(&rows, with(Solver::Auto), with(Solver::Adaptive), 1e-10);
}

#[test]
fn natural_convection_alone_agrees_with_the_general_equations() {
    let (set, [rows, general]) = convective(1024);
    let with = |rows: &[Scenario], solver| {
        results(set, rows, &Options { solver, relative_tolerance: 1e-12, ..Options::default() })
    };
    let integrated = with(&general, Solver::Adaptive);
    for solver in [Solver::Auto, Solver::Adaptive] {
        // A step across the wall's temperature does not see the corner there, and each method is affected differently.
        assert_holds_agree(&rows, with(&rows, solver), integrated.clone(), 3e-8);
    }
}

fn assert_holds_agree(rows: &[Scenario], all: Vec<Outcome>, integrated: Vec<Outcome>, tolerance: f64) {
    let mut given_up = 0;
    for (k, (mut ours, mut integrated)) in all.into_iter().zip(integrated).enumerate() {
        if integrated.status == Err(Failure::TooManySteps) {
            assert!(ours.status.is_ok(), "row {k}");
            given_up += 1;
            continue;
        }
        let hold = integrated.duration_s - rows[k].push_time_s;
        if [ours.fit, integrated.fit].into_iter().flatten().any(|fit| fit.time_constant_s > 5.0 * hold) {
            // So short a part of an exponential determines τ to a few digits only, or not at all.
            (ours.fit, integrated.fit) = (None, None);
        }
        if (integrated.pressure_peak_pa / integrated.pressure_final_pa - 1.0).abs() < 1e-9 {
            // At rest when the push ends: only rounding is left.
            (ours.fit, integrated.fit) = (None, None);
            (ours.settling_time_s, integrated.settling_time_s) = (None, None);
        }
        assert_same(&ours, &integrated, tolerance, &format!("row {k}"));
    }
    // At this tolerance rounding stops the integrator where steep laws bring the gas to rest.
    assert!(given_up < 10, "{given_up}");
}

#[test]
fn holds_before_a_wall_that_remembers_agree_with_the_integrator() {
    let (set, rows) = remembering(600);
    let with =
        |solver, relative_tolerance| results(set, &rows, &Options { solver, relative_tolerance, ..Options::default() });
    let integrated = with(Solver::Adaptive, 1e-12);
    for (relative_tolerance, error) in [(1e-10, 5e-9), (1e-7, 1e-8)] {
        let all = with(Solver::Auto, relative_tolerance).into_iter().zip(&integrated).enumerate();
        for (k, (mut ours, integrated)) in all {
            let mut integrated = *integrated;
            let hold = integrated.duration_s - rows[k].push_time_s;
            if integrated.fit.is_some_and(|fit| fit.time_constant_s > 5.0 * hold) {
                // So short a part of an exponential determines τ to a few digits only.
                (ours.fit, integrated.fit) = (None, None);
            }
            assert_same(&ours, &integrated, error, &format!("row {k} {:?}", rows[k].chamber.effects.active()));
        }
    }
}

#[test]
fn a_hold_with_natural_convection_alone_is_as_its_exact_solution() {
    let place = |name: &str| effects::find(name).unwrap().0;
    let [natural, exponents] = ["natural_convection", "pressure_exponent"].map(place);
    let mut rows = sealed(64);
    for s in &mut rows {
        // λ ∝ |T − Tw|^¼ alone.
        s.chamber.effects.of_mut(natural)[0] = 0.25;
        s.chamber.effects.of_mut(exponents).copy_from_slice(&[0.0, 0.0]);
        s.duration_s = s.push_time_s + 5.0;
    }
    let set = [natural, exponents].into_iter().collect();
    for (k, (s, o)) in rows.iter().zip(results(set, &rows, &Options::default())).enumerate() {
        let chamber = &s.chamber;
        let [begin, end] = [s.initial_position_m, s.final_position_m].map(|x| chamber.geometry.volume(x));
        let heat_capacity =
            s.initial_pressure_pa * begin / (chamber.gas.gas_constant * s.initial_temperature_k) * chamber.gas.cv();
        let (wall, peak) = (s.ambient_temperature_k, o.temperature_peak_k);
        let coefficient = chamber.heat_transfer.coefficient * ((peak - wall).abs() / 20.0).powf(0.25);
        let tau = heat_capacity / (coefficient * chamber.geometry.heat_transfer_area(end));
        let exact = chamber::exact::held_natural_convection(peak, wall, tau, 5.0);
        assert_close(o.temperature_final_k, exact, 1e-10, &format!("row {k}"));
    }
}
