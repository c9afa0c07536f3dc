//! 95 % intervals of least squares estimates with correlated residuals.
//!
//! cov = s² τ_c (JᵀJ)⁻¹ with s² = Σr²/(n − p) and the residuals' integrated autocorrelation time
//! τ_c = 1 + 2 Σ ρ_k, in rows, summed up to the first ρ_k ≤ 0. The interval is value ± t(97.5 %, n/τ_c − p) · σ.
//! Structured residuals, or rows that repeat the last value of a slow sensor, therefore widen the interval instead of narrowing
//! it.

use nalgebra::{Matrix3, SMatrix, SVector};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A number and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Most probable value, in the unit of its field.
    pub value: f64,
    /// Its 95 % interval, low and high.
    pub ci95: [f64; 2],
}

impl Estimate {
    /// value ± quantile · standard error.
    pub fn new(value: f64, standard_error: f64, quantile: f64) -> Self {
        let half = quantile * standard_error;
        Self { value, ci95: [value - half, value + half] }
    }
}

/// Lags summed before rows are averaged.
const LAGS: usize = 64;

/// Integrated autocorrelation time of residuals, in rows; at least 1.
///
/// Residuals correlated over more than [`LAGS`] rows are averaged in pairs, repeatedly: variance × time × rows of a mean is the
/// variance of the sum of many, whatever the number of rows in a mean. The work thus grows linearly with the rows.
fn autocorrelation_time(residuals: &[f64]) -> f64 {
    let energy = mean_square(residuals);
    if residuals.len() < 2 || energy == 0.0 {
        return 1.0;
    }
    let (mut means, mut rows) = (residuals.to_vec(), 1.0);
    loop {
        if let Some(time) = time_within(&means, LAGS) {
            return (rows * time * mean_square(&means) / energy).max(1.0);
        }
        means = means.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        rows *= 2.0;
    }
}

/// 1 + 2 Σ ρ_k up to the first ρ_k ≤ 0; `None` if that is not among the first `lags`.
fn time_within(values: &[f64], lags: usize) -> Option<f64> {
    let energy: f64 = values.iter().map(|r| r * r).sum();
    let mut time = 1.0;
    for lag in 1..values.len() {
        if lag > lags {
            return None;
        }
        let product: f64 = values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum();
        if product <= 0.0 {
            break;
        }
        time += 2.0 * product / energy;
    }
    Some(time)
}

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|r| r * r).sum::<f64>() / values.len() as f64
}

/// Scale of the covariance, s² τ_c, and the corresponding quantile, for residuals of a fit of `parameters` numbers.
pub fn residual_scale(residuals: &[f64], parameters: usize) -> (f64, f64) {
    let energy: f64 = residuals.iter().map(|r| r * r).sum();
    let correlation = autocorrelation_time(residuals);
    let freedom = (residuals.len() as f64 - parameters as f64).max(1.0);
    let effective = (residuals.len() as f64 / correlation - parameters as f64).max(1.0);
    (energy / freedom * correlation, student_95(effective))
}

/// The 97.5 % quantile of Student's t: half width of a two-sided 95 % interval in standard errors.
pub fn student_95(degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

/// Half width of a 95 % interval in standard errors if the variance is known.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// Standard deviation of a printed number due to rounding to its last place: uniform within half a unit.
pub fn rounding_deviation(last_place: f64) -> f64 {
    last_place / 12f64.sqrt()
}

/// Standard deviation of f from its gradient and the covariance of its arguments.
pub fn propagated<const N: usize>(gradient: &[f64; N], covariance: &SMatrix<f64, N, N>) -> f64 {
    let g = SVector::<f64, N>::from_row_slice(gradient);
    (g.transpose() * covariance * g)[(0, 0)].max(0.0).sqrt()
}

/// (JᵀJ)⁻¹ for three parameters; `None` if the data do not determine them.
pub fn unscaled_covariance(normal: Matrix3<f64>) -> Option<Matrix3<f64>> {
    // Scaled to unit diagonal first: the parameters' units differ by many powers of ten.
    let scale = normal.diagonal().map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 });
    let scaling = Matrix3::from_diagonal(&scale);
    let inverse = (scaling * normal * scaling).try_inverse()?;
    Some(scaling * inverse * scaling)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small generator, so that the test needs no crate and is reproducible.
    fn noise(n: usize) -> Vec<f64> {
        let mut state = 1u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..n).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
    }

    #[test]
    fn independent_residuals_have_an_autocorrelation_time_of_one() {
        assert!((autocorrelation_time(&noise(20_000)) - 1.0).abs() < 0.1);
    }

    #[test]
    fn a_first_order_process_has_the_time_that_theory_gives() {
        // The second process is correlated over many rows.
        for (kept, rows) in [(0.8, 200_000), (0.998, 2_000_000)] {
            let mut last = 0.0;
            let process: Vec<f64> = noise(rows)
                .into_iter()
                .map(|e| {
                    last = kept * last + e;
                    last
                })
                .collect();
            let theory = (1.0 + kept) / (1.0 - kept);
            let found = autocorrelation_time(&process);
            assert!((found / theory - 1.0).abs() < 0.1, "{found} {theory}");
        }
    }

    #[test]
    fn rows_that_repeat_the_last_value_count_once() {
        let plain = noise(5_000);
        let held: Vec<f64> = plain.iter().flat_map(|r| [*r; 10]).collect();
        let (scale, _) = residual_scale(&plain, 3);
        let (held_scale, _) = residual_scale(&held, 3);
        // JᵀJ has ten times the rows, so ten times the scale leaves the interval unchanged.
        assert!((held_scale / scale / 10.0 - 1.0).abs() < 0.1);
    }

    #[test]
    fn quantiles_are_those_of_the_tables() {
        assert!((student_95(5.0) - 2.570_582).abs() < 1e-5);
        assert!((student_95(30.0) - 2.042_272).abs() < 1e-5);
        assert!((student_95(1e4) - NORMAL_95).abs() < 3e-4);
    }
}
