//! When sealed tests settle, one a lane.

use crate::advance::Steps;
use crate::hermite::Hermite;
use crate::lanes::{Lanes, WIDTH};
use crate::log::Attempted;
use crate::outcome::SETTLED;
use crate::root::{Curve, root};
use crate::sealed::Holding;
use chamber::real::Real;
use pulp::{Arch, Simd, WithSimd};

/// Time from the begin of the hold until the temperature, which goes from `begin` to `end`, K, stays within 1 % of that
/// distance of its end, s. `system` holds the tests' constants, `log` their steps at the places `steps`.
pub fn settling<const N: usize, H: Holding<N>>(
    arch: Arch,
    system: &H,
    log: &[Attempted<N>],
    steps: &[Steps; WIDTH],
    begin: Lanes,
    end: Lanes,
) -> Lanes {
    let band = (begin - end).abs() * SETTLED;
    // The last accepted step that begins outside the band leads into it.
    let (mut time, mut length) = (Lanes::ZERO, Lanes::ZERO);
    let mut ends = [[Lanes::ONE; N]; 2];
    for lane in 0..WIDTH {
        let Steps { from, to, lane: column } = steps[lane];
        let column = column as usize;
        let mut index = to as usize;
        while index > from as usize {
            index -= 1;
            let step = &log[index];
            // States are roots of temperatures.
            let temperature = step.states[0][0][column] * step.states[0][0][column];
            if step.accepted[column] > 0.0 && (temperature - end[lane]).abs() > band[lane] {
                time[lane] = step.from[column];
                length[lane] = step.length[column];
                for side in 0..2 {
                    for i in 0..N {
                        ends[side][i][lane] = step.states[side][i][column];
                    }
                }
                break;
            }
        }
    }
    time + length * arch.dispatch(Entry { system, length, ends, end, band })
}

/// Share of a step at which the temperature comes within a band around its end. `ends` are the states at the step's begin
/// and at its end.
struct Entry<'a, const N: usize, H> {
    system: &'a H,
    length: Lanes,
    ends: [[Lanes; N]; 2],
    end: Lanes,
    band: Lanes,
}

/// How far the temperature is from its end, beyond the band.
struct Beyond {
    within: Hermite<Lanes>,
    end: Lanes,
    band: Lanes,
}

impl Curve for Beyond {
    #[inline(always)]
    fn at(&self, share: Lanes) -> Lanes {
        (self.within.at(share) - self.end).abs() - self.band
    }
}

impl<const N: usize, H: Holding<N>> WithSimd for Entry<'_, N, H> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Lanes {
        let Self { system, length, ends, end, band } = self;
        let within = Hermite::new(system.series(&ends[0], length), system.series(&ends[1], length));
        root(&Beyond { within, end, band }, Lanes::ZERO, Lanes::ONE)
    }
}
