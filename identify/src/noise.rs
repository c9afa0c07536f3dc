//! Noise of the pressure readings, from the quiet parts: late windows of rests and holds.
//!
//! Standard deviation about a polynomial of the fourth degree (a fast relaxation still bends within a window), and over
//! how many rows a reading is correlated with its neighbours (1 + 2 Σ ρ_k; white noise: 1). A sensor read out more slowly
//! than the rows, or interpolated, has more than one.

use crate::motion::{Motion, Phase};

/// Noise of the pressure readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of one reading, Pa.
    pub sd_pa: f64,
    /// Rows per independent sample, at least one.
    pub correlation_rows: f64,
    /// Smallest step between readings, Pa.
    pub quantisation_pa: f64,
    /// Relative standard error of the variance.
    pub variance_error: f64,
    /// What the rig states, Pa.
    pub stated_pa: Option<f64>,
}

/// Rows of a window.
const WINDOW: usize = 40;
/// Coefficients of the polynomial about which a window's readings scatter.
const COEFFICIENTS: usize = 5;
const LARGEST_LAG: usize = 12;

impl Noise {
    /// From all records of a rig.
    pub fn estimate<'a>(
        records: impl Iterator<Item = (&'a [f64], &'a [f64], &'a Motion)>,
        stated_pa: Option<f64>,
    ) -> Self {
        let mut variances = Vec::new();
        let mut products = [0.0; LARGEST_LAG + 1];
        let mut quantisation_pa = f64::INFINITY;
        for (time, pressure, motion) in records {
            quantisation_pa = quantisation_pa.min(smallest_step(pressure));
            for s in motion.segments.iter().filter(|s| s.phase != Phase::Move) {
                let rows = s.end - s.first;
                // A rest is quiet throughout, a hold in its later half.
                let from = if s.phase == Phase::Rest { s.first } else { s.first + rows / 2 };
                let size = WINDOW.min(s.end - from);
                if size < 16 {
                    continue;
                }
                for first in (from..=s.end - size).step_by(size) {
                    let rows = first..first + size;
                    let rest = polynomial_residual::<COEFFICIENTS>(&time[rows.clone()], &pressure[rows]);
                    let freedom = (size - COEFFICIENTS) as f64;
                    variances.push((rest.iter().map(|r| r * r).sum::<f64>() / freedom, freedom));
                    for (lag, product) in products.iter_mut().enumerate().take(size) {
                        *product += rest.iter().zip(&rest[lag..]).map(|(a, b)| a * b).sum::<f64>();
                    }
                }
            }
        }
        let freedom: f64 = variances.iter().map(|(_, f)| f).sum();
        let mut variance = robust_mean(&mut variances);
        let mut correlation_rows = 1.0;
        if products[0] > 0.0 {
            let significant = 3.0 / freedom.sqrt();
            for product in &products[1..] {
                // Fitting the polynomial takes some of a window's degrees of freedom, spread over the lags.
                let rho = product / products[0] + COEFFICIENTS as f64 / WINDOW as f64 * 0.5;
                if rho < significant + 0.05 {
                    break;
                }
                correlation_rows += 2.0 * rho;
            }
        }
        let floor = if quantisation_pa.is_finite() { quantisation_pa / 12.0f64.sqrt() } else { 0.0 };
        if variances.is_empty() {
            variance = stated_pa.unwrap_or(0.0).powi(2);
        }
        let mut sd_pa = variance.sqrt().max(floor).max(1e-3);
        if let Some(stated) = stated_pa.filter(|s| *s > 1.2 * sd_pa) {
            // Who states more than the scatter shows has reasons: calibration, hysteresis.
            sd_pa = stated;
        }
        let variance_error = (2.0 * correlation_rows / freedom.max(1.0)).sqrt();
        Self {
            sd_pa,
            correlation_rows,
            quantisation_pa: if floor > 0.0 { quantisation_pa } else { 0.0 },
            variance_error,
            stated_pa,
        }
    }
}

fn smallest_step(values: &[f64]) -> f64 {
    values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 1e-9).fold(f64::INFINITY, f64::min)
}

/// Mean of the windows' variances, or their median where a few windows hold more than noise.
fn robust_mean(variances: &mut [(f64, f64)]) -> f64 {
    let freedom: f64 = variances.iter().map(|(_, f)| f).sum();
    if freedom == 0.0 {
        return 0.0;
    }
    let mean = variances.iter().map(|(v, f)| v * f).sum::<f64>() / freedom;
    variances.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (middle, f) = variances[variances.len() / 2];
    // Median of χ²_f/f, Wilson and Hilferty.
    let median = middle / (1.0 - 2.0 / (9.0 * f)).powi(3);
    if mean > 1.15 * median && median > 0.0 { median } else { mean }
}

/// What is left of `y` about its best straight line in `t`.
pub fn line_residual(t: &[f64], y: &[f64]) -> Vec<f64> {
    polynomial_residual::<2>(t, y)
}

/// Residual about a polynomial of K coefficients, by Gram–Schmidt on the powers of centred time.
fn polynomial_residual<const K: usize>(t: &[f64], y: &[f64]) -> Vec<f64> {
    let n = t.len();
    let centre = t.iter().sum::<f64>() / n as f64;
    let scale = t.iter().map(|t| (t - centre).abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut rest = y.to_vec();
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(K);
    for k in 0..K {
        let mut b: Vec<f64> = t.iter().map(|t| ((t - centre) / scale).powi(k as i32)).collect();
        for other in &basis {
            let share: f64 = b.iter().zip(other).map(|(x, o)| x * o).sum();
            b.iter_mut().zip(other).for_each(|(x, o)| *x -= share * o);
        }
        let norm = b.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm < 1e-9 {
            continue;
        }
        b.iter_mut().for_each(|x| *x /= norm);
        let share: f64 = rest.iter().zip(&b).map(|(r, x)| r * x).sum();
        rest.iter_mut().zip(&b).for_each(|(r, x)| *r -= share * x);
        basis.push(b);
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_leaves_no_residual_and_a_cubic_does() {
        let t: Vec<f64> = (0..40).map(|k| 5.0 + f64::from(k) * 0.01).collect();
        let parabola: Vec<f64> = t.iter().map(|t| 3e5 - 2e3 * t + 50.0 * t * t).collect();
        let cubic: Vec<f64> = t.iter().map(|t| 1e6 * (t - 5.2).powi(3)).collect();
        assert!(polynomial_residual::<3>(&t, &parabola).iter().all(|r| r.abs() < 1e-6));
        assert!(polynomial_residual::<3>(&t, &cubic).iter().any(|r| r.abs() > 100.0));
    }
}
