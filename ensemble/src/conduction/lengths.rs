//! Lengths of the steps through a hold, s, the same for all rows. The time scales of the wall's memory and of the relaxation both grow
//! with the elapsed time, and so the lengths are a geometric sequence. The last step goes to the end.

use crate::lanes::WIDTH;
use std::sync::LazyLock;

/// Shortest length, s, and number of lengths per doubling.
const SHORTEST: f64 = 0.001_25;
const A_DOUBLING: usize = 6;
/// Number of lengths: up to a day.
pub const LENGTHS: usize = 168;
/// Number of levels. At each finer level the steps begin with a quarter of the length and each length is used twice as often, so that
/// there are about twice as many steps.
pub const LEVELS: usize = 3;
const FINER: usize = 2 * A_DOUBLING;
/// Largest ratio of the last step to the regular one in its place.
const STRETCHED: f64 = 1.2;

/// The sequence of lengths.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// Index of the first length at the finest level.
    first: usize,
    /// Increase of the index from step to step.
    by: usize,
}

/// For steps that are interpolated from their ends: from 0.02 s, growing by 2^(1/3).
pub const OF_ENDS: Growth = Growth { first: 0, by: 2 };
/// For steps that are interpolated by their own polynomials: from 0.05 s, growing by √2.
pub const OF_NODES: Growth = Growth { first: 8, by: 3 };

/// Length of an index, s.
pub fn length(number: usize) -> f64 {
    static ALL: LazyLock<[f64; LENGTHS]> =
        LazyLock::new(|| core::array::from_fn(|number| SHORTEST * (number as f64 / A_DOUBLING as f64).exp2()));
    ALL[number]
}

impl Growth {
    /// Index of the length of the step after `taken` others at a level.
    pub fn number(self, level: usize, taken: usize) -> usize {
        ((LEVELS - 1 - level) * FINER + self.first + self.by * (taken >> level)).min(LENGTHS - 1)
    }

    /// Number of regular steps of a hold of a given length, s, at a level, and the length of the last step, s.
    fn parted(self, level: usize, hold: f64) -> (usize, f64) {
        let (mut taken, mut left) = (0, hold);
        loop {
            let next = length(self.number(level, taken));
            if left <= next * STRETCHED {
                return (taken, left);
            }
            left -= next;
            taken += 1;
        }
    }

    /// The same for holds, one per lane; most rows of a study have the same length.
    pub fn parted_all(self, level: usize, hold: impl Fn(usize) -> f64) -> [(usize, f64); WIDTH] {
        let (mut length, mut parts) = (hold(0), self.parted(level, hold(0)));
        core::array::from_fn(|lane| {
            if hold(lane) != length {
                (length, parts) = (hold(lane), self.parted(level, hold(lane)));
            }
            parts
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_each_level_fill_the_hold() {
        for (growth, first) in [(OF_ENDS, 0.02), (OF_NODES, 0.0504)] {
            for level in 0..LEVELS {
                for hold in [1e-5, 0.02, 1.0, 5.0, 300.0, 1e6] {
                    let (taken, last) = growth.parted(level, hold);
                    let sum: f64 = (0..taken).map(|step| length(growth.number(level, step))).sum();
                    assert!((sum + last - hold).abs() < 1e-12 * hold && last > 0.0, "{level} {hold}: {taken} {last}");
                }
                let finer = [0, 1, 2].map(|level| length(growth.number(level, 0)) * [1.0, 4.0, 16.0][level]);
                assert!(finer.iter().all(|length| (length / first - 1.0).abs() < 1e-3), "{finer:?}");
            }
        }
    }
}
