//! Sealed rows: exact solution, integrated, and integrated as rows with a negligible inflow.

use crate::common::{assert_close, assert_same, hold_for, reference, results, sealed};
use crate::numbers::Numbers;
use chamber::{AreaLaw, EffectSet, effects, papers_chamber};
use ensemble::{Options, Outcome, Scenario, Solver};

/// Sealed tests by their exact solution, integrated, and integrated as rows with a negligible inflow.
fn three_ways(mut scenarios: Vec<Scenario>, fit: bool) -> [Vec<Outcome>; 3] {
    let with = |solver| Options { solver, fit, ..Options::default() };
    let exact = results(EffectSet::NONE, &scenarios, &with(Solver::Exact));
    let integrated = results(EffectSet::NONE, &scenarios, &with(Solver::Adaptive));
    for s in &mut scenarios {
        s.mass_flow_in_kg_per_s = 1e-30;
    }
    let flowing = results(EffectSet::NONE, &scenarios, &with(Solver::Adaptive));
    [exact, integrated, flowing]
}

/// Over a whole short push both error estimates of a step can vanish at once, in one of a few thousand rows.
#[test]
fn no_push_of_many_errs_by_more_than_the_tolerance() {
    let mut scenarios = sealed(1 << 14);
    for s in &mut scenarios {
        s.push_time_s = 0.04;
    }
    for (way, outcomes) in three_ways(scenarios, false).windows(2).enumerate() {
        for (row, (exact, ours)) in outcomes[0].iter().zip(&outcomes[1]).enumerate() {
            let (expected, tolerance) = (exact.pressure_peak_pa, Options::default().relative_tolerance);
            assert_close(ours.pressure_peak_pa, expected, tolerance, &format!("way {way}, row {row}"));
        }
    }
}

#[test]
fn all_three_ways_to_solve_a_sealed_test_read_the_same_from_its_record() {
    let mut scenarios = sealed(256);
    for s in scenarios.iter_mut().step_by(2) {
        // The push ends with a sample.
        s.push_time_s = (s.push_time_s * 100.0).ceil() / 100.0;
    }
    let [exact, integrated, flowing] = three_ways(scenarios, true);
    for (expected, found) in exact.iter().chain(&exact).zip(integrated.iter().chain(&flowing)) {
        assert_close(found.pressure_peak_pa, expected.pressure_peak_pa, 1e-9, "peak");
        assert_close(found.settling_time_s.unwrap(), expected.settling_time_s.unwrap(), 1e-6, "settling");
        let [found, expected] = [found, expected].map(|o| o.fit.unwrap());
        assert_close(found.time_constant_s, expected.time_constant_s, 1e-4, "time constant");
        assert_close(found.final_pressure_pa, expected.final_pressure_pa, 1e-6, "final pressure");
    }
}

#[test]
fn a_gas_that_its_surroundings_warm_or_cool_beyond_the_push_peaks_at_the_end_of_its_record() {
    let mut r = Numbers(23);
    let mut scenarios = sealed(256);
    for s in &mut scenarios {
        s.initial_temperature_k = r.between(200.0, 420.0);
        hold_for(s, r.between(2.0, 15.0));
    }
    let [exact, integrated, flowing] = three_ways(scenarios.clone(), false);
    for ((s, expected), found) in scenarios.iter().zip(&flowing).zip(exact.iter().zip(&integrated)) {
        for found in [found.0, found.1] {
            assert_same(found, expected, 1e-8, &format!("{s:?}"));
        }
    }
    let at_the_end = flowing.iter().filter(|o| o.pressure_peak_pa == o.pressure_final_pa).count();
    assert!((20..=236).contains(&at_the_end), "{at_the_end}");
}

#[test]
fn a_pressure_that_rises_to_the_end_has_not_settled_and_one_that_stands_has() {
    let mut rows = sealed(2);
    for s in &mut rows {
        s.initial_position_m = s.final_position_m;
    }
    rows[0].mass_flow_in_kg_per_s = 1e-6;
    let set = effects::Leakage::SET;
    let out = results(set, &rows, &Options { solver: Solver::Adaptive, fit: false, ..Options::default() });
    assert_eq!(out[0].pressure_peak_pa, out[0].pressure_final_pa);
    assert_eq!(out.iter().map(|o| o.settling_time_s).collect::<Vec<_>>(), [None, Some(0.0)]);
}

#[test]
fn the_regression_on_section_3_1_gives_the_numbers_found_for_it() {
    let test = Scenario::push(papers_chamber::section_31(AreaLaw::Swept), 1e5, [0.1, 0.05], 0.04, 5.04);
    let fit = results(EffectSet::NONE, &[test], &Options::default())[0].fit.unwrap();
    assert_close(fit.time_constant_s, 0.4287, 2e-3, "tau");
    assert_close(fit.lambda_av_w_per_m2_k, 16.08, 2e-3, "lambda_av");
    assert_close(fit.lambda0_w_per_m2_k, 26.13, 2e-3, "lambda0");
}

#[test]
fn sealed_rows_with_their_regressions_agree_with_the_sampled_record() {
    let rows = sealed(64);
    for solver in [Solver::Adaptive, Solver::Auto] {
        for (k, (s, o)) in
            rows.iter().zip(results(EffectSet::NONE, &rows, &Options { solver, ..Options::default() })).enumerate()
        {
            assert_same(&o, &reference(EffectSet::NONE, s), 1e-8, &format!("{solver:?} row {k}"));
        }
    }
}

/// Least-squares τ, s, of the samples of P = Pf/(1 − ε e^(−k t)), by a search over ln τ, unlike anything in the program.
fn least_squares([excess, rate]: [f64; 2], times_s: &[f64]) -> f64 {
    let count = times_s.len() as f64;
    let pressures: Vec<f64> = times_s.iter().map(|t| 1.0 / (1.0 - excess * (-rate * t).exp())).collect();
    let mean_p = pressures.iter().sum::<f64>() / count;
    let residual = |log_tau: f64| {
        let decays: Vec<f64> = times_s.iter().map(|t| (-t / log_tau.exp()).exp()).collect();
        let mean_d = decays.iter().sum::<f64>() / count;
        let products = decays.iter().zip(&pressures).map(|(d, p)| [(d - mean_d) * (p - mean_p), (d - mean_d).powi(2)]);
        let [common, own] = products.fold([0.0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]]);
        pressures.iter().map(|p| (p - mean_p).powi(2)).sum::<f64>() - common * common / own
    };
    let [mut low, mut high] = [0.005, 2.0].map(|share: f64| (share / rate).ln());
    for _ in 0..60 {
        let [a, b] = [(2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0];
        if residual(a) < residual(b) { high = b } else { low = a }
    }
    (0.5 * (low + high)).exp()
}

#[test]
fn the_time_constant_of_a_pressure_of_many_times_the_last_is_that_of_the_least_squares() {
    let mut r = Numbers(61);
    let mut scenarios = sealed(64);
    for s in &mut scenarios {
        s.chamber.geometry.dead_volume = 0.0;
        s.initial_position_m = 20.0;
        s.final_position_m = 20.0 / r.between(10.0, 1000.0);
        s.push_time_s = 0.01;
        hold_for(s, r.between(3.0, 12.0));
    }
    let mut steepest: f64 = 0.0;
    for (row, (s, o)) in scenarios.iter().zip(results(EffectSet::NONE, &scenarios, &Options::default())).enumerate() {
        // From the outcome: 1 − Tw/T decays at the rate k from the peak to the end.
        let [pushed, end] = [o.temperature_peak_k, o.temperature_final_k].map(|t| 1.0 - s.ambient_temperature_k / t);
        let rate = (pushed / end).ln() / (s.duration_s - s.push_time_s);
        let samples = 1..=(100.0 * s.duration_s).floor() as u32;
        let times_s: Vec<f64> = samples.map(|k| f64::from(k) / 100.0 - s.push_time_s).collect();
        let expected = least_squares([pushed, rate], &times_s);
        let ratio = 1.0 / (1.0 - pushed);
        steepest = steepest.max(ratio);
        assert_close(o.fit.unwrap().time_constant_s, expected, 5e-4, &format!("row {row}, ratio {ratio}"));
    }
    assert!(steepest > 10.0, "{steepest}");
}
