//! Cubics through the rows around a row: by least squares through many, or exactly through four.

use nalgebra::{Matrix4, Vector4};

/// Variance of a row's distance from the [`cubic`] through the two rows on either side of it due to the rows' noise, over that of
/// the noise: weights 1, 4/6, 4/6, 1/6, 1/6.
pub const OF_NOISE: f64 = 1.0 + (16.0 + 16.0 + 1.0 + 1.0) / 36.0;

/// Value and slope (per second) at row `at` of the cubic through the `reach` rows on either side of it.
pub fn local_cubic(time_s: &[f64], values: &[f64], at: usize, reach: usize) -> [f64; 2] {
    let rows = at - reach..at + reach + 1;
    let (around, values) = (&time_s[rows.clone()], &values[rows]);
    let scale = 0.5 * (around[around.len() - 1] - around[0]).max(f64::MIN_POSITIVE);
    let mut square = Matrix4::zeros();
    let mut right = Vector4::zeros();
    for (t, v) in around.iter().zip(values) {
        let u = (t - time_s[at]) / scale;
        let row = Vector4::new(1.0, u, u * u, u * u * u);
        square += row * row.transpose();
        right += row * (v - values[0]);
    }
    let fitted = square.cholesky().map(|c| c.solve(&right));
    fitted.map_or([values[reach], 0.0], |c| [values[0] + c[0], c[1] / scale])
}

/// Value at `at` of the cubic through four points.
pub fn cubic(points: [(f64, f64); 4], at: f64) -> f64 {
    let weight = |i: usize| -> f64 {
        (0..4).filter(|&j| j != i).map(|j| (at - points[j].0) / (points[i].0 - points[j].0)).product()
    };
    (0..4).map(|i| weight(i) * points[i].1).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_through_uneven_rows_is_found() {
        let time: Vec<f64> = (0..9).map(|i| 0.1 * f64::from(i) + 0.01 * f64::from(i * i % 5)).collect();
        let values: Vec<f64> = time.iter().map(|t| 2.0 - t + 3.0 * t * t - 0.5 * t * t * t).collect();
        let [value, slope] = local_cubic(&time, &values, 4, 3);
        let t = time[4];
        assert!((value - values[4]).abs() < 1e-12);
        assert!((slope - (-1.0 + 6.0 * t - 1.5 * t * t)).abs() < 1e-9);
    }
}
