//! Where a piston turns within a move, as in a sine or a triangle of many cycles.

use records::extremes;

/// A piston turns where it comes back by this fraction of its travel...
const REVERSAL: f64 = 0.02;
/// ...and by this multiple of the noise of its positions.
const REVERSAL_IN_NOISE: f64 = 10.0;

/// Rows at which the piston turns, from its positions, m, with this noise, m.
pub fn turning_points(position_m: &[f64], noise_m: f64) -> Vec<usize> {
    let (low, high) = extremes(position_m);
    reversals(position_m, (REVERSAL * (high - low)).max(REVERSAL_IN_NOISE * noise_m))
}

/// Rows at which a position, m, turns: it comes back by more than `least_m` from there.
fn reversals(position_m: &[f64], least_m: f64) -> Vec<usize> {
    let mut out = Vec::new();
    // The extreme positions since the last turn; in both directions before the first one.
    let (mut highest, mut lowest) = ((0, f64::NEG_INFINITY), (0, f64::INFINITY));
    let mut rises = None;
    for (row, position) in position_m.iter().copied().enumerate() {
        if position > highest.1 {
            highest = (row, position);
        }
        if position < lowest.1 {
            lowest = (row, position);
        }
        let has_fallen = rises != Some(false) && highest.1 - position > least_m;
        let has_risen = rises != Some(true) && position - lowest.1 > least_m;
        if has_fallen || has_risen {
            // The first stroke has no turn before it.
            if rises.is_some() {
                out.push(if has_fallen { highest.0 } else { lowest.0 });
            }
            rises = Some(has_risen);
            (highest, lowest) = ((row, position), (row, position));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piston_turns_where_it_comes_back_by_more_than_its_noise() {
        let noise = |k: u32| 1e-5 * (f64::from(k * 7919 % 101) / 50.0 - 1.0);
        let sine: Vec<f64> =
            (0..1000).map(|k| 0.1 - 0.03 * (std::f64::consts::TAU * f64::from(k) / 200.0).cos() + noise(k)).collect();
        let found = turning_points(&sine, 1e-5);
        let expected: Vec<usize> = (1..10).map(|k| 100 * k).collect();
        assert_eq!(found.len(), expected.len(), "{found:?}");
        assert!(found.iter().zip(&expected).all(|(a, b)| a.abs_diff(*b) < 5), "{found:?}");
        let push: Vec<f64> = (0..500).map(|k| 0.1 - 1e-4 * f64::from(k) + noise(k)).collect();
        assert_eq!(turning_points(&push, 1e-5), []);
    }
}
