//! A quantity between two knots of a trace: the polynomial of degree 7 that has the values and the slopes of the
//! interval's two knots and of two neighbours, in Newton's form (E. Isaacson and H. B. Keller, Analysis of Numerical
//! Methods, 1966, 6.3). Where a segment has fewer knots the degree is lower.

use crate::clock::Clock;
use crate::history::Knot;
use crate::lanes::{Lanes, WIDTH};
use chamber::real::Real;

/// A neighbour nearer than this share of the interval adds rounding rather than knowledge.
const NEAREST: f64 = 0.1;

/// The knots that an interval is interpolated by, of one row.
#[derive(Clone, Copy, Debug)]
pub struct Stencil {
    /// Moments, values and slopes in the integrator's time: of the interval's begin and end, then of its neighbours.
    at: [f64; 4],
    value: [f64; 4],
    slope: [f64; 4],
    /// How many of them there are.
    count: f64,
}

impl Stencil {
    /// For a quantity between knots `index` and the next, of a segment's knots.
    pub fn new(knots: &[Knot], index: usize, quantity: usize) -> Self {
        let length = knots[index + 1].at - knots[index].at;
        let near = length * NEAREST;
        let mut before = (0..index).rev().filter(|&i| knots[index].at - knots[i].at > near);
        let mut after = (index + 2..knots.len()).filter(|&i| knots[i].at - knots[index + 1].at > near);
        let mut picked = [index, index + 1, index, index];
        let mut count = 2;
        let distinct = |picked: &[usize], i: usize| picked.iter().all(|&p| (knots[p].at - knots[i].at).abs() > near);
        // One from each side, then a second from where there is one.
        let candidates = [before.next(), after.next(), before.next(), after.next()];
        for i in candidates.into_iter().flatten() {
            if count < 4 && distinct(&picked[..count], i) {
                picked[count] = i;
                count += 1;
            }
        }
        let mut at = picked.map(|i| knots[i].at);
        for (missing, at) in at.iter_mut().enumerate().skip(count) {
            *at += length * missing as f64;
        }
        Self {
            at,
            value: picked.map(|i| knots[i].view.value[quantity]),
            slope: picked.map(|i| knots[i].view.slope[quantity]),
            count: count as f64,
        }
    }
}

/// The knots of one interval a lane.
#[derive(Clone, Copy, Debug)]
pub struct Stencils {
    clock: Clock<Lanes>,
    at: [Lanes; 4],
    value: [Lanes; 4],
    slope: [Lanes; 4],
    count: Lanes,
}

impl Stencils {
    /// Of each lane, and the clock of its segment.
    pub fn new<'a>(mut of: impl FnMut(usize) -> (&'a Clock, Stencil)) -> Self {
        let zero = [Lanes::ZERO; 4];
        let mut all = Self { clock: Clock::NONE, at: zero, value: zero, slope: zero, count: Lanes::ZERO };
        for lane in 0..WIDTH {
            let (clock, stencil) = of(lane);
            all.clock.load(lane, clock);
            for k in 0..4 {
                all.at[k][lane] = stencil.at[k];
                all.value[k][lane] = stencil.value[k];
                all.slope[k][lane] = stencil.slope[k];
            }
            all.count[lane] = stencil.count;
        }
        all
    }
}

/// A quantity between two knots, of as many rows as there are lanes, over the time from the segment's begin, s.
#[derive(Clone, Copy, Debug)]
pub struct Interpolant {
    clock: Clock<Lanes>,
    begin: Lanes,
    per_length: Lanes,
    /// Places of the two neighbours, the interval being from 0 to 1.
    places: [Lanes; 2],
    terms: [Lanes; 8],
}

impl Interpolant {
    /// The polynomial.
    #[inline(always)]
    pub fn new(stencils: &Stencils) -> Self {
        let Stencils { clock, at, value, slope, count } = stencils;
        let length = at[1] - at[0];
        let per_length = length.recip();
        let places = [(at[2] - at[0]) * per_length, (at[3] - at[0]) * per_length];
        let all = [Lanes::ZERO, Lanes::ONE, places[0], places[1]];
        // Divided differences with each place twice, order by order.
        let mut table = [Lanes::ZERO; 8];
        let mut terms = [Lanes::ZERO; 8];
        terms[0] = value[0];
        for k in 0..4 {
            table[2 * k] = slope[k] * length;
            if k < 3 {
                table[2 * k + 1] = (value[k + 1] - value[k]) / (all[k + 1] - all[k]);
            }
        }
        terms[1] = table[0];
        for order in 2..8 {
            for i in 0..8 - order {
                table[i] = (table[i + 1] - table[i]) / (all[(i + order) / 2] - all[i / 2]);
            }
            terms[order] = (*count - (order / 2) as f64).where_positive(table[0], Lanes::ZERO);
        }
        Self { clock: *clock, begin: at[0], per_length, places, terms }
    }

    /// Its value at a time from the segment's begin, s.
    #[inline(always)]
    pub fn at(&self, time: Lanes) -> Lanes {
        let x = (self.clock.shown(time) - self.begin) * self.per_length;
        let (y, [c, d]) = (x - 1.0, self.places.map(|place| x - place));
        let [t0, t1, t2, t3, t4, t5, t6, t7] = self.terms;
        t0 + x * (t1 + x * (t2 + y * (t3 + y * (t4 + c * (t5 + c * (t6 + d * t7))))))
    }
}
