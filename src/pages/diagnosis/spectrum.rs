//! Amplitude spectral density of residuals: a periodogram at logarithmically spaced frequencies, averaged over records.

use std::f64::consts::TAU;

/// Number of frequencies.
const FREQUENCIES: usize = 90;
/// Longer records are first averaged in groups of rows: a displayed spectrum needs no more.
const MOST_ROWS: usize = 4000;

/// Frequency, Hz, and density, Pa/√Hz, of residuals in Pa; each record comes with its row interval, s.
///
/// Each point is averaged over the band between the midpoints to its neighbours, at three frequencies.
pub fn density(records: &[(f64, &[f64])]) -> Vec<(f64, f64)> {
    let records: Vec<(f64, Vec<f64>)> = records.iter().map(|(row_s, rows)| grouped(*row_s, rows)).collect();
    let longest = records.iter().map(|(s, r)| s * r.len() as f64).fold(0.0, f64::max);
    let fastest = records.iter().map(|(s, _)| *s).fold(f64::INFINITY, f64::min);
    if longest <= 0.0 || !fastest.is_finite() {
        return Vec::new();
    }
    let (low, high) = (1.0 / longest, 0.5 / fastest);
    let ratio = (high / low).powf(1.0 / (FREQUENCIES - 1) as f64);
    (0..FREQUENCIES)
        .filter_map(|k| {
            let centre = low * ratio.powi(k as i32);
            let (mut sum, mut count) = (0.0, 0.0);
            for (row_s, rows) in &records {
                // A record carries no information below the inverse of its length and above half its row rate.
                let own = 1.0 / (row_s * rows.len() as f64)..=0.5 / row_s * (1.0 + 1e-9);
                for f in [-1.0 / 3.0, 0.0, 1.0 / 3.0].map(|exponent| centre * ratio.powf(exponent)) {
                    if own.contains(&f) {
                        sum += power(*row_s, rows, f);
                        count += 1.0;
                    }
                }
            }
            (count > 0.0).then(|| (centre, (sum / count).sqrt()))
        })
        .collect()
}

/// One-sided power spectral density at `f`, Pa²/Hz.
fn power(row_s: f64, rows: &[f64], f: f64) -> f64 {
    // Repeated rotation by one row: accurate enough over a few thousand rows.
    let (step_sin, step_cos) = (TAU * f * row_s).sin_cos();
    let (mut sin, mut cos) = (0.0, 1.0);
    let (mut real, mut imaginary) = (0.0, 0.0);
    for r in rows {
        real += r * cos;
        imaginary += r * sin;
        (sin, cos) = (sin * step_cos + cos * step_sin, cos * step_cos - sin * step_sin);
    }
    2.0 * row_s / rows.len() as f64 * (real * real + imaginary * imaginary)
}

/// Residuals minus their mean, averaged in groups of rows if there are many.
fn grouped(row_s: f64, rows: &[f64]) -> (f64, Vec<f64>) {
    let size = rows.len().div_ceil(MOST_ROWS).max(1);
    let mean = rows.iter().sum::<f64>() / rows.len().max(1) as f64;
    let groups = rows.chunks_exact(size).map(|g| g.iter().sum::<f64>() / size as f64 - mean);
    (row_s * size as f64, groups.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use identify::synthetic::Random;

    #[test]
    fn white_noise_is_flat_at_its_own_density() {
        let mut random = Random::new(5);
        let records: Vec<Vec<f64>> = (0..40).map(|_| (0..1000).map(|_| 100.0 * random.normal()).collect()).collect();
        let of: Vec<(f64, &[f64])> = records.iter().map(|r| (0.01, r.as_slice())).collect();
        // σ √(2 Δt)
        let expected = 100.0 * (2.0f64 * 0.01).sqrt();
        for (f, density) in density(&of).into_iter().filter(|(f, _)| *f > 0.3) {
            assert!((density / expected - 1.0).abs() < 0.35, "{f} Hz: {density}");
        }
    }

    #[test]
    fn a_hum_stands_out_at_its_frequency() {
        let rows: Vec<f64> = (0..2000).map(|i| 50.0 * (TAU * 7.0 * f64::from(i) * 0.01).sin()).collect();
        let found = density(&[(0.01, &rows)]);
        let (at, _) = found.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((at / 7.0 - 1.0).abs() < 0.1, "{at}");
    }

    #[test]
    fn nothing_has_no_spectrum() {
        assert!(density(&[]).is_empty());
    }
}
