//! What is asked of a relaxation once it is integrated, all lanes at once, from the inside of the steps.

use super::advance::{Steps, Tried};
use super::step::{LaneSystem, dense, within};
use crate::lanes::{Lanes, WIDTH};
use crate::real::Real;
use pulp::{Arch, Simd, WithSimd};

/// Relaxations of one state, one a lane, from its peak to its end.
pub struct Relaxation<'a, const N: usize> {
    /// Steps of all.
    pub log: &'a [Tried<N>],
    /// Where each one's steps stand.
    pub steps: [Steps; WIDTH],
    /// Which state.
    pub state: usize,
    /// Its value at the peak.
    pub peak: Lanes,
    /// Its value at the end.
    pub end: Lanes,
}

/// Share of the peak-to-final distance within which a relaxation counts as settled.
pub const SETTLED: f64 = 0.01;
/// Halvings or better of the bracket around the settling time.
const ROOT_STEPS: usize = 12;

/// Time from the begin of the log until the state stays within 1 % of the peak-to-end distance of its end, s;
/// `system` holds the problems' constants.
pub fn settling<const N: usize, S: LaneSystem<N>>(arch: Arch, r: &Relaxation<N>, system: &S) -> Lanes {
    let band = (r.peak - r.end).abs() * SETTLED;
    // The last accepted step that begins outside the band leads into it.
    let (mut from, mut length) = (Lanes::ZERO, Lanes::ZERO);
    let (mut begin, mut end, mut slopes) = ([Lanes::ONE; N], [Lanes::ONE; N], [[Lanes::ZERO; N]; 13]);
    for lane in 0..WIDTH {
        let steps = r.steps[lane];
        let column = steps.lane as usize;
        let mut index = steps.to as usize;
        while index > steps.from as usize {
            index -= 1;
            let entry = &r.log[index];
            if entry.accepted[column] > 0.0 && (entry.begin[r.state][column] - r.end[lane]).abs() > band[lane] {
                from[lane] = entry.from[column];
                length[lane] = entry.length[column];
                for i in 0..N {
                    begin[i][lane] = entry.begin[i][column];
                    end[i][lane] = entry.end[i][column];
                    for (slope, of_entry) in slopes.iter_mut().zip(&entry.slopes) {
                        slope[i][lane] = of_entry[i][column];
                    }
                }
                break;
            }
        }
    }
    arch.dispatch(Crossing {
        system,
        from,
        length,
        begin_state: begin,
        end_state: end,
        slopes,
        state: r.state,
        end: r.end,
        band,
    })
}

/// How far a state is outside the band, at the share `x` of a step.
#[inline(always)]
fn beyond(terms: &[Lanes; 8], x: Lanes, end: Lanes, side: Lanes, band: Lanes) -> Lanes {
    (within(terms, x) - end) * side - band
}

/// Time at which a state comes within `band` of its end value, s from the begin of the steps' stretch.
struct Crossing<'a, const N: usize, S> {
    system: &'a S,
    from: Lanes,
    length: Lanes,
    begin_state: [Lanes; N],
    end_state: [Lanes; N],
    slopes: [[Lanes; N]; 13],
    state: usize,
    end: Lanes,
    band: Lanes,
}

impl<const N: usize, S: LaneSystem<N>> WithSimd for Crossing<'_, N, S> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Lanes {
        let Self { system, from, length, begin_state, end_state, slopes, state, end, band } = self;
        let all = if I::IS_SCALAR {
            dense::<N, false, S>(system, from, length, &begin_state, &end_state, &slopes)
        } else {
            dense::<N, true, S>(system, from, length, &begin_state, &end_state, &slopes)
        };
        let mut terms = [Lanes::ZERO; 8];
        for (term, of_all) in terms.iter_mut().zip(&all) {
            *term = of_all[state];
        }
        // Illinois' regula falsi on the distance beyond the band: positive at x = 0, negative at x = 1.
        let side = (terms[0] - end).where_positive(Lanes::ONE, -Lanes::ONE);
        let (mut low, mut high) = (Lanes::ZERO, Lanes::ONE);
        let (mut at_low, mut at_high) = (beyond(&terms, low, end, side, band), beyond(&terms, high, end, side, band));
        let mut x = Lanes::ZERO;
        for _ in 0..ROOT_STEPS {
            let span = at_low - at_high;
            let safe = span.where_positive(span, Lanes::ONE);
            x = low + (high - low) * (at_low / safe);
            let value = beyond(&terms, x, end, side, band);
            // The end that is kept a second time loses half its value.
            low = value.where_positive(x, low);
            at_high = value.where_positive(at_high * 0.5, value);
            at_low = value.where_positive(value, at_low * 0.5);
            high = value.where_positive(high, x);
        }
        from + length * x
    }
}
