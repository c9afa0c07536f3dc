//! The scatter of readings about a smooth course, in their unit.

/// The smallest change from one reading to the next, which may be the sensor's step; infinite where none changes.
pub fn smallest_change(readings: &[f64]) -> f64 {
    let changes = readings.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|change| *change > 0.0);
    changes.fold(f64::INFINITY, f64::min)
}

/// Standard deviation from the second differences where they are small: noise passes one with the factor √6, a smooth course
/// hardly at all. Zero of fewer than three readings.
pub fn scatter(readings: &[f64]) -> f64 {
    let mut second: Vec<f64> = readings.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    second.sort_unstable_by(f64::total_cmp);
    let median = second.get(second.len() / 2).copied().unwrap_or(0.0);
    // Readings of few steps have few different second differences: their mean square says more than their median.
    let quiet = &second[..second.partition_point(|d| *d <= 4.5 * median)];
    let square = quiet.iter().map(|d| d * d).sum::<f64>() / quiet.len().max(1) as f64;
    (square / 6.0).sqrt()
}
