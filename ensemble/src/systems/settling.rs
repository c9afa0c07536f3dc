//! Settling times of tests, one per lane.

use crate::instructions::Wide;
use crate::integrator::log::Attempted;
use crate::integrator::problem::Steps;
use crate::lanes::{Lanes, WIDTH};
use crate::numerics::root::{Beyond, root};
use crate::outcome::SETTLED;
use crate::systems::test_system::{Holding, Within};
use crate::systems::turns::Turns;
use chamber::real::Real;
use pulp::{Arch, Simd, WithSimd};

/// Time from the start of the hold until the reading, which changes from `begin` to `end`, stays within 1 % of that change of its end,
/// s. `log` contains the tests' steps at the indices `steps`.
pub fn times<const N: usize, H: Holding<N>>(
    arch: Arch,
    system: &H,
    log: &[Attempted<N>],
    steps: &[Steps; WIDTH],
    turns: Option<&Turns>,
    [begin, end]: [Lanes; 2],
) -> Lanes {
    let band = (begin - end).abs() * SETTLED;
    // The last accepted step that begins outside the band, or turns there, leads into it.
    let (mut time, mut length, mut low) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
    let mut ends = [[Lanes::ONE; N]; 2];
    for lane in 0..WIDTH {
        let Steps { from, to, lane: column } = steps[lane];
        let column = column as usize;
        let mut index = to as usize;
        while index > from as usize {
            index -= 1;
            let step = &log[index];
            let reading = H::reading(&core::array::from_fn(|i| step.states[0][i][column]));
            let turn = turns.and_then(|turns| turns.beyond(lane, index, end[lane], band[lane]));
            if step.accepted[column] > 0.0 && (turn.is_some() || (reading - end[lane]).abs() > band[lane]) {
                low[lane] = turn.unwrap_or(0.0);
                time[lane] = step.from[column];
                step.put(column, lane, &mut length, &mut ends);
                break;
            }
        }
    }
    time + length * arch.dispatch(Wide(Entry { system, length, ends, low, end, band }))
}

/// Place in a step, after `low`, at which the reading enters a band around its end. `ends` are the states at the step's start and end.
struct Entry<'a, const N: usize, H> {
    system: &'a H,
    length: Lanes,
    ends: [[Lanes; N]; 2],
    low: Lanes,
    end: Lanes,
    band: Lanes,
}

impl<const N: usize, H: Holding<N>> WithSimd for Entry<'_, N, H> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<I: Simd>(self, simd: I) -> Lanes {
        let Self { system, length, ends, low, end, band } = self;
        let within = Within { system, ends: [&ends[0], &ends[1]], length }.polynomial(simd);
        root(&Beyond { curve: &within, value: end, band }, low, Lanes::ONE)
    }
}
