//! Lengths of steps through a hold, s, the same for all rows: what the wall remembers and what relaxes both change over as long
//! as they have lasted, and so the lengths grow in equal ratios. The last step goes to the end.

use crate::lanes::WIDTH;
use std::sync::LazyLock;

/// The first step, s, and by how much each is longer than the one before: the cube root of two.
const FIRST: f64 = 0.02;
const RATIO: f64 = 1.259_921_049_894_873_2;
/// How often the steps can be made finer; each time they begin with a fourth of the length, and each length is used twice as
/// often, so that there are about twice as many.
pub const LEVELS: usize = 3;
const FINER: f64 = 4.0;
/// The power of [`RATIO`] that this is.
const FINER_POWER: usize = 6;
/// Powers of the ratio that step lengths are, from the shortest on: up to a day's.
pub const LENGTHS: usize = 84;
/// A last step is at most this much longer than the one that would be next.
const STRETCHED: f64 = 1.2;

/// Length of a step, s, by the power of the ratio that it is longer than the shortest by.
pub fn length(number: usize) -> f64 {
    static ALL: LazyLock<[f64; LENGTHS]> = LazyLock::new(|| {
        core::array::from_fn(|number| FIRST / FINER.powi(LEVELS as i32 - 1) * RATIO.powi(number as i32))
    });
    ALL[number]
}

/// The number of the step that comes after `taken` others at a level.
pub fn number(level: usize, taken: usize) -> usize {
    ((LEVELS - 1 - level) * FINER_POWER + (taken >> level)).min(LENGTHS - 1)
}

/// How many steps of those lengths a hold of a length, s, takes at a level, and how long the last one is beside.
fn parted(level: usize, hold: f64) -> (usize, f64) {
    let (mut taken, mut left) = (0, hold);
    loop {
        let next = length(number(level, taken));
        if left <= next * STRETCHED {
            return (taken, left);
        }
        left -= next;
        taken += 1;
    }
}

/// The same of holds, one a lane: most rows of a study are held equally long.
pub fn parted_all(level: usize, hold: impl Fn(usize) -> f64) -> [(usize, f64); WIDTH] {
    let (mut length, mut parts) = (hold(0), parted(level, hold(0)));
    core::array::from_fn(|lane| {
        if hold(lane) != length {
            (length, parts) = (hold(lane), parted(level, hold(lane)));
        }
        parts
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_each_level_fill_the_hold() {
        for level in 0..LEVELS {
            for hold in [1e-5, 0.02, 1.0, 5.0, 300.0, 1e6] {
                let (taken, last) = parted(level, hold);
                let sum: f64 = (0..taken).map(|step| length(number(level, step))).sum();
                assert!((sum + last - hold).abs() < 1e-12 * hold && last > 0.0, "{level} {hold}: {taken} {last}");
            }
        }
        assert!((length(number(0, 0)) / FIRST - 1.0).abs() < 1e-14);
        assert!((length(number(1, 0)) * FINER / FIRST - 1.0).abs() < 1e-14);
    }
}
