//! When sealed tests settle, one a lane.

use crate::advance::{Steps, Tried};
use crate::hermite::Hermite;
use crate::lanes::{Lanes, WIDTH};
use crate::outcome::SETTLED;
use crate::root::{Curve, root};
use crate::sealed::Held;
use chamber::real::Real;
use pulp::{Arch, Simd, WithSimd};

/// Time from the begin of the hold until the temperature, which goes from `begin` to `end`, K, stays within 1 % of that
/// distance of its end, s. `system` holds the tests' constants, `log` their steps at the places `steps`.
pub fn settling(
    arch: Arch,
    system: &Held,
    log: &[Tried<1>],
    steps: &[Steps; WIDTH],
    begin: Lanes,
    end: Lanes,
) -> Lanes {
    let band = (begin - end).abs() * SETTLED;
    // The last accepted step that begins outside the band leads into it.
    let (mut time, mut length) = (Lanes::ZERO, Lanes::ZERO);
    let mut ends = [Lanes::ONE; 2];
    for lane in 0..WIDTH {
        let Steps { from, to, lane: column } = steps[lane];
        let column = column as usize;
        let mut index = to as usize;
        while index > from as usize {
            index -= 1;
            let step = &log[index];
            // States are roots of temperatures.
            let ends_of_step = [step.begin, step.end].map(|state| state[0][column] * state[0][column]);
            if step.accepted[column] > 0.0 && (ends_of_step[0] - end[lane]).abs() > band[lane] {
                time[lane] = step.from[column];
                length[lane] = step.length[column];
                (ends[0][lane], ends[1][lane]) = (ends_of_step[0], ends_of_step[1]);
                break;
            }
        }
    }
    time + length * arch.dispatch(Entry { system, length, ends, end, band })
}

/// Share of a step at which the temperature comes within a band around its end. `ends` are temperatures, K, at its begin
/// and at its end.
struct Entry<'a> {
    system: &'a Held<'a>,
    length: Lanes,
    ends: [Lanes; 2],
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

impl WithSimd for Entry<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Lanes {
        let Self { system, length, ends, end, band } = self;
        let within = Hermite::new(system.series(ends[0], length), system.series(ends[1], length));
        root(&Beyond { within, end, band }, Lanes::ZERO, Lanes::ONE)
    }
}
