//! The paper's steps 1 to 7 on a computed relaxation.
//!
//! Step 1, P = Pf + ΔP e^(−t/τ), is linear in Pf and ΔP: one nonlinear parameter is left (variable projection with
//! Kaufman's simplification, BIT 15 (1975) 49). The sums over the samples of a record are given as weighted nodes.

use super::outcome::Fit;
use super::scenario::Scenario;
use crate::AreaLaw;
use crate::Geometry;

/// Rate of the record that the regression is meant for, Hz.
pub const SAMPLE_RATE_HZ: f64 = 100.0;
const ITERATIONS: usize = 40;
const CONVERGED: f64 = 1e-9;

/// A pressure, Pa, at a time after the peak, s, that stands for `weight` samples.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Time, s.
    pub time: f64,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Weight.
    pub weight: f64,
}

/// Least squares of P = Pf + ΔP e^(−t/τ): Pf, ΔP in Pa and τ in s; none where the data determine none.
pub fn exponential(nodes: &[Node], guess: f64) -> Option<[f64; 3]> {
    let reference = nodes.last()?.pressure;
    let mut log_tau = guess.ln();
    for _ in 0..ITERATIONS {
        let per_tau = (-log_tau).exp();
        let mut sums = [0.0; 9];
        for node in nodes {
            let (p, w) = (node.pressure - reference, node.weight);
            let x = node.time * per_tau;
            let e = (-x).exp();
            let g = x * e;
            for (sum, term) in sums.iter_mut().zip([1.0, e, g, e * e, e * g, g * g, p, p * e, p * g]) {
                *sum += w * term;
            }
        }
        let [n, e, g, ee, eg, gg, p, pe, pg] = sums;
        // Centred on the constant, then on e.
        let (see, seg, sgg) = (ee - e * e / n, eg - e * g / n, gg - g * g / n);
        let (spe, spg) = (pe - p * e / n, pg - p * g / n);
        let rise = spe / see;
        let step = (spg - spe * seg / see) / (rise * (sgg - seg * seg / see));
        if !step.is_finite() {
            return None;
        }
        if step.abs() < CONVERGED {
            return Some([reference + (p - rise * e) / n, rise, 1.0 / per_tau]);
        }
        log_tau += step.clamp(-1.0, 1.0);
        if (log_tau - guess.ln()).abs() > 12.0 {
            return None;
        }
    }
    None
}

/// Steps 2 to 7 on the result of step 1. None where pressures and strokes contradict each other.
pub fn steps(scenario: &Scenario, positions: [f64; 2], initial_pressure: f64, regression: [f64; 3]) -> Option<Fit> {
    let [pf, rise, tau] = regression;
    let c = &scenario.chamber;
    let swept = positions.map(|x| c.geometry.piston_area * x);
    let rt = c.gas.gas_constant * scenario.ambient_temperature_k;
    let mass = (swept[0] - swept[1]) / rt * (initial_pressure * pf / (pf - initial_pressure));
    let dead_volume = mass * rt / initial_pressure - swept[0];
    let volume = dead_volume + swept[1];
    let as_published = Geometry { dead_volume, area_law: AreaLaw::Total, ..c.geometry };
    let area = as_published.heat_transfer_area(volume);
    let lambda_av = mass * c.gas.cv() / tau / area;
    let settling_in_tau = 100f64.ln();
    let pressure_av = pf + rise * 0.99 / settling_in_tau;
    let temperature_av = volume * pressure_av / (mass * c.gas.gas_constant);
    let h = &c.heat_transfer;
    let lambda0 = lambda_av * (h.reference_pressure * h.reference_temperature / (pressure_av * temperature_av)).sqrt();
    (mass > 0.0 && volume > 0.0 && lambda0.is_finite()).then_some(Fit {
        final_pressure_pa: pf,
        pressure_rise_pa: rise,
        time_constant_s: tau,
        lambda_av_w_per_m2_k: lambda_av,
        lambda0_w_per_m2_k: lambda0,
    })
}
