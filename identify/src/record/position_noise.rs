//! The noise of a position's record, m.

/// Standard deviation of the position from its second differences where they are small, with the recording's step as
/// the least: noise passes a second difference with the factor √6, a smooth stroke hardly at all.
pub fn position_noise(position_m: &[f64]) -> f64 {
    let mut second: Vec<f64> = position_m.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    second.sort_by(f64::total_cmp);
    let median = second.get(second.len() / 2).copied().unwrap_or(0.0);
    let step = position_m.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 1e-12).fold(f64::INFINITY, f64::min);
    let quantisation = if step.is_finite() { step / 12.0f64.sqrt() } else { 0.0 };
    // Readings of few steps have few different second differences: their mean square says more than their median.
    let quiet = &second[..second.partition_point(|d| *d <= 4.5 * median)];
    let square = quiet.iter().map(|d| d * d).sum::<f64>() / quiet.len().max(1) as f64;
    // A stroke that never rests has no small second differences; then the step alone is believed.
    (square / 6.0).sqrt().max(quantisation.min(1e-4))
}
