//! Lengths of steps through a hold, s, the same for all rows: what the wall remembers and what relaxes both change over as long
//! as they have lasted, and so the lengths grow in equal ratios. The last step goes to the end.

use crate::lanes::WIDTH;
use std::sync::LazyLock;

/// The shortest length, s, and how many lengths there are to each doubling.
const SHORTEST: f64 = 0.001_25;
const A_DOUBLING: usize = 6;
/// How many lengths there are: up to a day's.
pub const LENGTHS: usize = 168;
/// How often the steps can be made finer; each time they begin with a fourth of the length, and each length is used twice as
/// often, so that there are about twice as many.
pub const LEVELS: usize = 3;
const FINER: usize = 2 * A_DOUBLING;
/// A last step is at most this much longer than the one that would be next.
const STRETCHED: f64 = 1.2;

/// How the lengths of a hold's steps grow.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// The number of the first length behind the shortest that there can be.
    first: usize,
    /// By how many lengths each step is longer than the one before.
    by: usize,
}

/// Of steps that are read from polynomials between their ends which know only how they end: from 0.02 s by 2^(1/3).
pub const OF_ENDS: Growth = Growth { first: 0, by: 2 };
/// Of steps that are read from their own polynomials: from 0.05 s by √2.
pub const OF_NODES: Growth = Growth { first: 8, by: 3 };

/// Length of a step, s, by its number.
pub fn length(number: usize) -> f64 {
    static ALL: LazyLock<[f64; LENGTHS]> =
        LazyLock::new(|| core::array::from_fn(|number| SHORTEST * (number as f64 / A_DOUBLING as f64).exp2()));
    ALL[number]
}

impl Growth {
    /// The number of the step that comes after `taken` others at a level.
    pub fn number(self, level: usize, taken: usize) -> usize {
        ((LEVELS - 1 - level) * FINER + self.first + self.by * (taken >> level)).min(LENGTHS - 1)
    }

    /// How many steps a hold of a length, s, takes at a level, and how long the last one is beside.
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

    /// The same of holds, one a lane: most rows of a study are held equally long.
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
