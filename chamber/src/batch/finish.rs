//! When sealed tests settle, one a lane.

use super::advance::{Steps, Tried};
use super::look::{Question, look};
use super::sealed::Held;
use crate::lanes::{Lanes, WIDTH};
use crate::real::Real;
use pulp::Arch;

/// Share of the peak-to-final distance within which a relaxation counts as settled.
pub const SETTLED: f64 = 0.01;

/// Time from the begin of the hold until the temperature, which goes from `peak` to `end`, K, stays within 1 % of that
/// distance of its end, s. `system` holds the tests' constants, `log` their steps at the places `steps`.
pub fn settling(arch: Arch, system: &Held, log: &[Tried<1>], steps: &[Steps; WIDTH], peak: Lanes, end: Lanes) -> Lanes {
    let band = (peak - end).abs() * SETTLED;
    // The last accepted step that begins outside the band leads into it.
    let mut picked = Tried::<1>::NONE;
    for lane in 0..WIDTH {
        let Steps { from, to, lane: column } = steps[lane];
        let column = column as usize;
        let leads =
            |step: &&Tried<1>| step.accepted[column] > 0.0 && (step.begin[0][column] - end[lane]).abs() > band[lane];
        if let Some(step) = log[from as usize..to as usize].iter().rev().find(leads) {
            picked.from[lane] = step.from[column];
            picked.length[lane] = step.length[column];
            picked.begin[0][lane] = step.begin[0][column];
            picked.end[0][lane] = step.end[0][column];
            for (slope, of_step) in picked.slopes.iter_mut().zip(&step.slopes) {
                slope[0][lane] = of_step[0][column];
            }
        }
    }
    let question = Question::Enter { between: [Lanes::ZERO, Lanes::ONE], value: end, band };
    let [share, ..] = look(arch, system, &picked, question);
    picked.from + picked.length * share
}
