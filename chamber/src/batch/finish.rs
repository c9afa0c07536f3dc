//! What is asked of a relaxation once it is integrated, eight at once, from the inside of the steps.

use super::advance::{Log, Steps};
use super::step::{LaneSystem, dense, within};
use crate::lanes::{Lanes, WIDTH};
use crate::real::Real;
use core::hint::black_box;

/// Eight relaxations of one state from its peak to its end.
pub struct Relaxation<'a, const N: usize> {
    /// Steps of all.
    pub log: &'a Log<N>,
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
/// `system` holds the eight problems' constants.
#[inline(always)]
pub fn settling<const N: usize, const FUSED: bool>(r: &Relaxation<N>, system: &impl LaneSystem<N>) -> Lanes {
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
            let entry = &r.log[steps.group as usize][index];
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
    // Through memory, or the compiler computes on with the lanes one by one.
    let (begin, end, slopes) = black_box((begin, end, slopes));
    let all = dense::<N, FUSED>(system, from, length, &begin, &end, &slopes);
    let mut terms = [Lanes::ZERO; 8];
    for (term, of_all) in terms.iter_mut().zip(&all) {
        *term = of_all[r.state];
    }
    // Illinois' regula falsi on the distance beyond the band: positive at x = 0, negative at x = 1.
    let side = (terms[0] - r.end).where_positive(Lanes::ONE, -Lanes::ONE);
    let beyond = |x: Lanes| (within(&terms, x) - r.end) * side - band;
    let (mut low, mut high) = (Lanes::ZERO, Lanes::ONE);
    let (mut at_low, mut at_high) = (beyond(low), beyond(high));
    let mut x = Lanes::ZERO;
    for _ in 0..ROOT_STEPS {
        let span = at_low - at_high;
        let safe = span.where_positive(span, Lanes::ONE);
        x = low + (high - low) * (at_low / safe);
        let value = beyond(x);
        // The end that is kept a second time loses half its value.
        low = value.where_positive(x, low);
        at_high = value.where_positive(at_high * 0.5, value);
        at_low = value.where_positive(value, at_low * 0.5);
        high = value.where_positive(high, x);
    }
    from + length * x
}
