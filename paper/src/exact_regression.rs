//! The exact regression: λ0 from the held piston without averaging.
//!
//! With λ ∝ √(P T) and the piston held, 1/P = (1/Pf)(1 − a e^(−k t)) exactly (design.md, "Exact solutions"), and k = λ(Pf, Tamb)
//! Aq/(m cv). Hence λ0 = m cv k/Aq · √(P0 T0/(Pf Tamb)), with m, Vd and Aq from steps 2 and 4 of the paper, and none of its
//! averages. k in 1/s; a = 1 − Tamb/T at the start of the fit, dimensionless.

use super::Error;
use super::decay::{self, Fit, Reciprocal};
use super::recording::{Recording, Relaxation};
use super::statistics::Estimate;
use super::time_constant::{Push, Regression, Setup, Uncertainty, check_push, check_setup, mass_and_volumes};
use chamber::dual::Dual;
use chamber::real::Real;
use serde::Serialize;

/// Quantities derived from Pf and k. SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantities<R = f64> {
    /// Mass m of the gas, kg.
    pub mass_kg: R,
    /// Dead volume Vd, m³.
    pub dead_volume_m3: R,
    /// Vf, dead volume included, m³.
    pub final_volume_m3: R,
    /// Heat transfer area Aq, m².
    pub area_m2: R,
    /// τ_f = 1/k, s: the decay's time constant near equilibrium.
    pub final_time_constant_s: R,
    /// λ at Pf and Tamb, W/(m² K).
    pub coefficient_final_w_per_m2_k: R,
    /// λ0, W/(m² K).
    pub coefficient_0_w_per_m2_k: R,
}

/// The quantities from Pf, Pa, and k, 1/s, in any number type.
pub fn quantities<R: Real>(
    setup: &Setup,
    ambient_k: R,
    push: &Push<R>,
    final_pressure_pa: R,
    rate: R,
) -> Quantities<R> {
    let [mass, dead, volume] = mass_and_volumes(setup, ambient_k, push, final_pressure_pa);
    let area = setup.area(volume, dead);
    let coefficient = mass * setup.gas.cv() * rate / area;
    Quantities {
        mass_kg: mass,
        dead_volume_m3: dead,
        final_volume_m3: volume,
        area_m2: area,
        final_time_constant_s: rate.recip(),
        coefficient_final_w_per_m2_k: coefficient,
        coefficient_0_w_per_m2_k: coefficient * setup.reference_factor(final_pressure_pa, ambient_k),
    }
}

/// The exact regression of a recording.
#[derive(Clone, Debug)]
pub struct ExactRegression {
    /// Push and hold found in it.
    pub relaxation: Relaxation,
    /// Final pressure Pf, Pa.
    pub final_pressure_pa: Estimate,
    /// a = 1 − Tamb/T at the first fitted row.
    pub amplitude: Estimate,
    /// Decay rate k, 1/s.
    pub rate_per_s: Estimate,
    /// Derived quantities, with intervals.
    pub quantities: Quantities<Estimate>,
    /// The underlying fit.
    pub fit: Fit,
}

/// Evaluates a recording by the exact regression.
///
/// # Errors
/// For a recording that is not a push-and-hold test of a closed chamber.
pub fn evaluate(setup: &Setup, recording: &Recording) -> Result<ExactRegression, Error> {
    check_setup(setup)?;
    let relaxation = recording.relaxation()?;
    let fit = decay::fit::<Reciprocal>(&relaxation.time_s, &relaxation.pressure_pa)?;
    let [pf, _, rate] = fit.parameters.into();
    check_push(setup, &relaxation.push(), pf)?;
    let uncertainty = Uncertainty {
        regression: fit.covariance,
        initial_pressure_pa: relaxation.initial_pressure_error_pa,
        ambient_temperature_k: 0.0,
        quantile_95: fit.quantile_95,
    };
    let push = Push {
        initial_pressure_pa: Dual::<5>::variable(relaxation.initial_pressure_pa, 3),
        initial_position_m: relaxation.initial_position_m,
        final_position_m: relaxation.final_position_m,
    };
    let ambient = Dual::variable(setup.ambient_temperature_k, 4);
    let q = quantities(setup, ambient, &push, Dual::variable(pf, 0), Dual::variable(rate, 2));
    let estimate = |number| uncertainty.estimate(number);
    let quantities = Quantities {
        mass_kg: estimate(q.mass_kg),
        dead_volume_m3: estimate(q.dead_volume_m3),
        final_volume_m3: estimate(q.final_volume_m3),
        area_m2: estimate(q.area_m2),
        final_time_constant_s: estimate(q.final_time_constant_s),
        coefficient_final_w_per_m2_k: estimate(q.coefficient_final_w_per_m2_k),
        coefficient_0_w_per_m2_k: estimate(q.coefficient_0_w_per_m2_k),
    };
    let own = |i: usize| Estimate::new(fit.parameters[i], fit.covariance[(i, i)].sqrt(), fit.quantile_95);
    let (final_pressure_pa, amplitude, rate_per_s) = (own(0), own(1), own(2));
    Ok(ExactRegression { relaxation, final_pressure_pa, amplitude, rate_per_s, quantities, fit })
}

/// Rows per time constant of the curve that represents a printed regression.
const ROWS_PER_TIME_CONSTANT: f64 = 50.0;

/// Pf and k of the exact decay whose regression by an exponential, over a hold of `hold_time_constants` τ, is the given one.
///
/// For tables that print a regression without its recording; the longer the assumed hold, the smaller the difference.
///
/// # Errors
/// If no exact decay has this regression.
pub fn decay_of_regression(regression: &Regression, hold_time_constants: f64) -> Result<(f64, f64), Error> {
    let tau = regression.time_constant_s;
    let rows = (hold_time_constants * ROWS_PER_TIME_CONSTANT).ceil() as usize;
    let time_s: Vec<f64> = (0..=rows).map(|i| i as f64 * tau / ROWS_PER_TIME_CONSTANT).collect();
    let (mut pf, mut peak, mut rate) =
        (regression.final_pressure_pa, regression.final_pressure_pa + regression.pressure_rise_pa, 1.0 / tau);
    for _ in 0..100 {
        let a = 1.0 - pf / peak;
        let curve: Vec<f64> = time_s.iter().map(|t| pf / (1.0 - a * (-rate * t).exp())).collect();
        let fitted = decay::fit::<decay::Exponential>(&time_s, &curve)?.parameters;
        let (off_pf, off_rise) = (regression.final_pressure_pa - fitted[0], regression.pressure_rise_pa - fitted[1]);
        let ratio = fitted[2] / tau;
        pf += off_pf;
        peak += off_pf + off_rise;
        rate *= ratio;
        let largest = (off_pf / pf).abs().max((off_rise / pf).abs()).max((ratio - 1.0).abs());
        if largest < 1e-10 {
            return Ok((pf, rate));
        }
    }
    Err(Error::NotConverged { reason: "no exact decay has this regression".to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decay::Exponential;

    #[test]
    fn the_decay_behind_a_regression_has_that_regression() {
        let time_s: Vec<f64> = (0..=500).map(|i| f64::from(i) * 0.01).collect();
        let curve: Vec<f64> = time_s.iter().map(|t| 1.9e5 / (1.0 - 0.22 * (-2.0 * t).exp())).collect();
        let p = decay::fit::<Exponential>(&time_s, &curve).unwrap().parameters;
        let regression = Regression { final_pressure_pa: p[0], pressure_rise_pa: p[1], time_constant_s: p[2] };
        let (pf, rate) = decay_of_regression(&regression, 5.0 / p[2]).unwrap();
        assert!((pf / 1.9e5 - 1.0).abs() < 1e-4, "{pf}");
        assert!((rate / 2.0 - 1.0).abs() < 2e-3, "{rate}");
    }
}
