//! Whether a piston that seems to stop between two moves only turns. A sine passes its turning point so slowly that the travel
//! from row to row is lost in the noise, for many rows in a fast recording.
//!
//! It turns if one smooth curve, a polynomial of degree four, fits the rows of the stop and half as many of each adjacent move,
//! besides those in which the piston may still stand, to within the noise. The corners of a stop do not lie on such a curve, nor
//! does a stop that lasts. At an end of the record, with one adjacent move, the stop's own rows must show travel. Where a record
//! begins with too few rows of a stop for that, the curve must fit three times as many rows of the move.
//! Positions in m.

use super::spline::mean;
use nalgebra::{DMatrix, DVector};
use records::extremes;
use std::ops::Range;

/// Number of parts into which the rows are divided for their means.
const PARTS: usize = 24;
/// Coefficients of the curve.
const COEFFICIENTS: usize = 5;
/// Largest distance of a part's mean from the curve, in standard deviations; noise exceeds it once in fifteen thousand.
const DEVIATIONS: f64 = 4.0;

/// A stop of fewer rows shows no travel.
const FEW_ROWS: usize = 10;
/// Least travel of a turn at an end of the record, over the noise.
const LEAST_TRAVEL: f64 = 5.0;

/// Rows on either side of a row that decide whether it moves: in this many rows of a move the piston may still stand.
pub const REACH: usize = 3;

/// Whether the piston turns in these rows of a stop; `around` covers the stop and the adjacent moves.
pub fn is_turn(position_m: &[f64], stop: Range<usize>, around: Range<usize>, noise_m: f64) -> bool {
    let [at_begin, at_end] = [stop.start == around.start, stop.end == around.end];
    let is_short = at_begin && stop.len() < FEW_ROWS;
    if (at_begin || at_end) && !is_short {
        let without = |is_end: bool| if is_end { 0 } else { REACH };
        let stands = stop.start + without(at_begin)..stop.end - without(at_end);
        if stands.is_empty() || travel(&position_m[stands]) < LEAST_TRAVEL * noise_m {
            return false;
        }
    }
    let beside = if is_short { 3 * (stop.len() + REACH) } else { REACH + stop.len().div_ceil(2) };
    let first = stop.start.saturating_sub(beside).max(around.start);
    let end = (stop.end + beside).min(around.end);
    let size = ((end - first) / PARTS).max(1);
    let means: Vec<f64> = position_m[first..end].chunks_exact(size).map(mean).collect();
    // A curve fits few readings whatever the piston did.
    if means.len() < 2 * COEFFICIENTS {
        return false;
    }
    let last = (means.len() - 1) as f64;
    let power = |row: usize, power: usize| (2.0 * row as f64 / last - 1.0).powi(power as i32);
    let powers = DMatrix::from_fn(means.len(), COEFFICIENTS, power);
    let means = DVector::from_vec(means);
    let curve = powers.clone().svd(true, true).solve(&means, f64::EPSILON);
    let limit = DEVIATIONS * noise_m / (size as f64).sqrt();
    curve.is_ok_and(|curve| (powers * curve - means).amax() < limit)
}

/// Range of the means of twelfths of these rows, m.
fn travel(position_m: &[f64]) -> f64 {
    const PARTS: usize = 12;
    let means: Vec<f64> = position_m.chunks((position_m.len() / PARTS).max(1)).map(mean).collect();
    let (low, high) = extremes(&means);
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    const NOISE_M: f64 = 1e-5;

    fn rows(n: u32, stroke: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut random = Random::new(11);
        (0..n).map(|i| stroke(f64::from(i) / f64::from(n)) + NOISE_M * random.normal()).collect()
    }

    #[test]
    fn a_sine_turns_however_fast_its_rows_follow_each_other() {
        for n in [200, 2000, 20_000] {
            let half = (n as f64 * 0.1) as usize;
            let sine = rows(n, |u| 0.05 - 0.02 * (2.0 * std::f64::consts::PI * u).cos());
            let middle = n as usize / 2;
            assert!(is_turn(&sine, middle - half / 2..middle + half / 2, 0..n as usize, NOISE_M), "{n}");
        }
    }

    #[test]
    fn a_short_rest_before_a_steady_move_is_no_turn() {
        for seed in 0..40 {
            let mut random = Random::new(seed);
            let stroke: Vec<f64> =
                (0..400).map(|i| 3e-5 * f64::from((i - 25).max(0)) + NOISE_M * random.normal()).collect();
            // The first two rows of the move are not seen to move.
            assert!(!is_turn(&stroke, 0..27, 0..400, NOISE_M), "{seed}");
        }
    }

    #[test]
    fn a_piston_that_stops_for_few_readings_does_not_turn() {
        // The moves' first and last rows, in which it stands, belong to the moves.
        let readings = rows(21, |u| 0.05 + 0.02 * f64::from(u > 0.8) - 0.02 * f64::from(u < 0.2));
        assert!(!is_turn(&readings, 8..13, 0..21, NOISE_M));
    }

    #[test]
    fn a_piston_that_stops_between_two_moves_does_not_turn() {
        let back = |u: f64| 0.05 + 0.3 * ((u - 0.5).abs() - 0.1).max(0.0);
        let on = |u: f64| 0.05 + 0.3 * (u - 0.6).max(0.0) + 0.3 * (u - 0.4).min(0.0);
        let gentle = |u: f64| 0.05 + 3.0 * ((u - 0.5).abs() - 0.1).max(0.0).powi(3);
        let strokes: [&dyn Fn(f64) -> f64; 3] = [&back, &on, &gentle];
        for stroke in strokes {
            for n in [200, 2000, 20_000] {
                let middle = n as usize / 2;
                let stop = middle - n as usize / 10..middle + n as usize / 10;
                assert!(!is_turn(&rows(n, stroke), stop, 0..n as usize, NOISE_M), "{n}");
            }
        }
    }
}
