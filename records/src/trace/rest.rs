//! Finds the rest before the first movement, separated from it by the position's own noise.

use crate::statistics::{extremes, median, reversal_fraction, white_noise};

/// Movements below this fraction of the travel count as rest.
const REST_FRACTION: f64 = 1e-3;
/// Movement threshold in standard deviations of the position's noise.
const DEVIATIONS: f64 = 6.0;
/// Apparent noise above this fraction of the travel may be the curvature of a motion with few rows: it is, ...
const MOST_NOISE: f64 = 0.005;
/// ...if at most this fraction of the changes reverse the previous one. With noise two of three do.
const MAX_REVERSED_FRACTION: f64 = 0.35;

/// Number of leading rows before the piston moves, at least 1.
///
/// The first half of the rows before a clear movement (a tenth of the travel) is assumed to be near rest: its median is the rest
/// position.
pub fn rows_at_rest(position_m: &[f64]) -> usize {
    let (travel, threshold) = (travel(position_m), movement_threshold(position_m));
    if position_m.is_empty() || travel <= 2.0 * threshold {
        return position_m.len();
    }
    let clear = position_m.iter().position(|x| (x - position_m[0]).abs() > 0.1 * travel).unwrap_or(position_m.len());
    let rest_m = median(position_m[..clear.div_ceil(2)].to_vec());
    let moved = position_m.iter().position(|x| (x - rest_m).abs() > threshold).unwrap_or(position_m.len());
    // A piston that crosses the threshold within one row started in the row before.
    moved.saturating_sub(1).max(1)
}

/// Threshold between position noise and movement, m.
pub fn movement_threshold(position_m: &[f64]) -> f64 {
    let travel = travel(position_m);
    let noise = white_noise(position_m);
    let is_motion =
        noise > MOST_NOISE * travel && reversal_fraction(position_m.iter().copied()) <= MAX_REVERSED_FRACTION;
    let noise = if is_motion { 0.0 } else { noise };
    (DEVIATIONS * noise).max(REST_FRACTION * travel)
}

fn travel(position_m: &[f64]) -> f64 {
    let (low, high) = extremes(position_m);
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp from 0.1 to 0.05 m between rows 50 and 54, with noise of amplitude `noise_m`, m.
    fn push(noise_m: f64) -> Vec<f64> {
        let ideal = |k: usize| 0.1 - 0.0125 * (k.clamp(50, 54) - 50) as f64;
        (0..500).map(|k| ideal(k) + noise_m * ((k * 7919 % 101) as f64 / 50.0 - 1.0)).collect()
    }

    #[test]
    fn rest_ends_where_the_push_begins() {
        assert_eq!(rows_at_rest(&push(0.0)), 50);
        assert!((49..=51).contains(&rows_at_rest(&push(3e-6))), "{}", rows_at_rest(&push(3e-6)));
        assert!((49..=51).contains(&rows_at_rest(&push(2e-4))), "{}", rows_at_rest(&push(2e-4)));
    }

    #[test]
    fn a_piston_that_never_moves_is_always_at_rest() {
        assert_eq!(rows_at_rest(&[0.1; 40]), 40);
        let shaking: Vec<f64> = push(3e-6)[..50].to_vec();
        assert_eq!(rows_at_rest(&shaking), 50);
    }

    #[test]
    fn a_motion_of_few_rows_is_no_noise_of_a_piston_at_rest() {
        assert_eq!(rows_at_rest(&[0.1, 0.08, 0.05]), 1);
        for rows_of_a_period in [8, 15, 30] {
            let angle = |k: i32| std::f64::consts::TAU * f64::from(k) / f64::from(rows_of_a_period);
            let sine: Vec<f64> = (0..=2 * rows_of_a_period).map(|k| 0.09 - 0.02 * angle(k).sin()).collect();
            assert_eq!(rows_at_rest(&sine), 1, "{rows_of_a_period}");
        }
        assert_eq!(rows_at_rest(&[0.1, 0.1, 0.1, 0.08, 0.05]), 2);
    }

    #[test]
    fn a_piston_in_motion_from_the_start_has_one_row_at_rest() {
        let ramp: Vec<f64> = (0..200).map(|k| 0.1 - 2e-4 * f64::from(k)).collect();
        assert_eq!(rows_at_rest(&ramp), 1);
    }
}
