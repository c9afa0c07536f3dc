//! Pressure or temperature between two knots of a trace: its reciprocal is the polynomial of degree 11 through the values and slopes
//! at the interval's two knots and at four neighbours, in Newton's form (E. Isaacson and H. B. Keller, Analysis of Numerical Methods,
//! 1966, 6.3). The degree is lower if a segment has fewer knots, or where the terms added by a neighbour stop shrinking: then there is
//! a corner in between, whose error a higher degree would only spread.
//!
//! Reciprocals, because in a closed chamber they solve a linear equation: 1/P = (1/Pf)(1 − a e^(−kt)) while the piston is held has no
//! poles, whereas P has.

use crate::integrator::step::View;
use crate::integrator::time_transformation::TimeTransformation;
use crate::lanes::{Lanes, WIDTH};
use crate::numerics::root::Curve;
use chamber::real::{Real, reciprocals};

/// Number of knots used per interval, and of the polynomial's terms.
const KNOTS: usize = 6;
const TERMS: usize = 2 * KNOTS;
/// Smallest distance between knots, relative to the interval: nearer ones add rounding errors rather than information.
const NEAREST: f64 = 0.3;
/// A neighbour is used if its terms, at the middle of the interval, are below this fraction of those of the previous one.
const SHRINK: f64 = 0.5;

/// A point of a trace.
#[derive(Clone, Copy, Debug)]
pub struct Knot {
    /// Integrator time from the segment's start.
    pub at: f64,
    /// Pressure, Pa, and temperature, K, of the gas, and their slopes in integrator time.
    pub view: View<f64>,
    /// Whether the rates have a kink there.
    pub kink: bool,
}

/// The knots used to interpolate a quantity, for one interval per lane: start and end of the interval, then neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Stencils {
    transformation: TimeTransformation<Lanes>,
    /// Integrator times, and the quantity and its slope there.
    at: [Lanes; KNOTS],
    value: [Lanes; KNOTS],
    slope: [Lanes; KNOTS],
    /// Number of knots in use.
    count: Lanes,
}

impl Stencils {
    /// For a quantity between a knot and the next; `of` returns time transformation, knots and the knot's index for each lane's segment.
    pub fn new<'a>(quantity: usize, mut of: impl FnMut(usize) -> (&'a TimeTransformation, &'a [Knot], usize)) -> Self {
        let zero = [Lanes::ZERO; KNOTS];
        let mut all = Self {
            transformation: TimeTransformation::default(),
            at: zero,
            value: zero,
            slope: zero,
            count: Lanes::ZERO,
        };
        for lane in 0..WIDTH {
            let (transformation, knots, index) = of(lane);
            let (picked, count) = pick(knots, index);
            let length = knots[index + 1].at - knots[index].at;
            all.transformation.load(lane, transformation);
            for k in 0..KNOTS {
                let Knot { at, view, .. } = &knots[picked[k]];
                // Unused places must not coincide with others.
                all.at[k][lane] = if k < count { *at } else { *at + length * (k + 1) as f64 };
                all.value[k][lane] = view.value[quantity];
                all.slope[k][lane] = view.slope[quantity];
            }
            all.count[lane] = count as f64;
        }
        all
    }
}

/// Selects the knots for the interval from knot `index` to the next; returns their indices and number.
fn pick(knots: &[Knot], index: usize) -> ([usize; KNOTS], usize) {
    let near = (knots[index + 1].at - knots[index].at) * NEAREST;
    let mut picked = [index; KNOTS];
    picked[1] = index + 1;
    let mut count = 2;
    // Alternately from each side, while there are any.
    let mut sides = [index, index + 1];
    let next_before = |from: usize| (0..from).rev().find(|&i| knots[from].at - knots[i].at > near);
    let next_after = |from: usize| (from + 1..knots.len()).find(|&i| knots[i].at - knots[from].at > near);
    // Those beyond a kink last.
    for beyond_kinks in [false, true] {
        while count < KNOTS {
            let had = count;
            for side in 0..2 {
                if knots[sides[side]].kink && !beyond_kinks {
                    continue;
                }
                let next = if side == 0 { next_before(sides[0]) } else { next_after(sides[1]) };
                if let Some(next) = next.filter(|_| count < KNOTS) {
                    picked[count] = next;
                    sides[side] = next;
                    count += 1;
                }
            }
            if count == had {
                break;
            }
        }
    }
    (picked, count)
}

/// A quantity between two knots, one per lane, as a function of the time from the segment's start, s.
#[derive(Clone, Copy, Debug)]
pub struct Interpolant {
    transformation: TimeTransformation<Lanes>,
    begin: Lanes,
    per_length: Lanes,
    /// Places of the knots; the interval reaches from 0 to 1.
    places: [Lanes; KNOTS],
    terms: [Lanes; TERMS],
}

impl Interpolant {
    /// The polynomial through the values and slopes of the stencils.
    #[inline(always)]
    pub fn new(stencils: &Stencils) -> Self {
        let Stencils { transformation, at, count, .. } = stencils;
        let value = reciprocals(stencils.value);
        let mut slope = stencils.slope;
        for k in 0..KNOTS {
            slope[k] = -slope[k] * value[k] * value[k];
        }
        let length = at[1] - at[0];
        let per_length = length.recip();
        let mut places = [Lanes::ZERO; KNOTS];
        for k in 1..KNOTS {
            places[k] = (at[k] - at[0]) * per_length;
        }
        // Divided differences with each place taken twice, order by order.
        let mut table = [Lanes::ZERO; TERMS];
        let mut terms = [Lanes::ZERO; TERMS];
        terms[0] = value[0];
        // One division per knot. If an unused place coincides with another, only its own distances are NaN.
        let mut per_distance = [[Lanes::ONE; KNOTS]; KNOTS];
        for k in 1..KNOTS {
            for i in 0..k {
                per_distance[k][i] = places[k] - places[i];
            }
            per_distance[k] = reciprocals(per_distance[k]);
        }
        for k in 0..KNOTS {
            table[2 * k] = slope[k] * length;
            if k + 1 < KNOTS {
                table[2 * k + 1] = (value[k + 1] - value[k]) * per_distance[k + 1][k];
            }
        }
        terms[1] = table[0];
        for order in 2..TERMS {
            for i in 0..TERMS - order {
                table[i] = (table[i + 1] - table[i]) * per_distance[(i + order) / 2][i / 2];
            }
            terms[order] = (*count - (order / 2) as f64).where_positive(table[0], Lanes::ZERO);
        }
        // The contribution of each knot at the middle.
        let (mut product, mut before) = (Lanes::from(0.25), Lanes::ZERO);
        let mut counts = Lanes::ONE;
        for k in 1..KNOTS {
            let distance = (places[k] - 0.5).abs();
            let adds = product * terms[2 * k].abs().max(terms[2 * k + 1].abs() * distance);
            if k > 1 {
                counts = (before * SHRINK - adds).where_positive(counts, Lanes::ZERO);
                terms[2 * k] = counts.where_positive(terms[2 * k], Lanes::ZERO);
                terms[2 * k + 1] = counts.where_positive(terms[2 * k + 1], Lanes::ZERO);
            }
            before = adds;
            product = product * distance * distance;
        }
        Self { transformation: *transformation, begin: at[0], per_length, places, terms }
    }
}

impl Curve for Interpolant {
    /// Value at a time from the segment's start, s.
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        let x = (self.transformation.shown(time) - self.begin) * self.per_length;
        let mut sum = self.terms[TERMS - 1];
        for order in (1..TERMS).rev() {
            sum = self.terms[order - 1] + (x - self.places[(order - 1) / 2]) * sum;
        }
        sum.recip()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_beyond_a_kink_come_after_the_others_and_count_only_if_their_terms_shrink() {
        // Up to t = 1 the one relaxation, from there on another.
        let relaxation = |t: f64, kink: f64| 2e5 + 5e4 * (-t).exp() + kink * (t - 1.0);
        let slope = |t: f64, kink: f64| -5e4 * (-t).exp() + kink;
        let error = |marked: bool| {
            let knots: Vec<Knot> = (0..9)
                .map(|k| {
                    let at = f64::from(k) * 0.25;
                    let kink = if at < 1.0 { 0.0 } else { 2e3 };
                    let view = View { value: [relaxation(at, kink), 300.0], slope: [slope(at, kink), 0.0] };
                    Knot { at, view, kink: marked && k == 4 }
                })
                .collect();
            // Behind the kink.
            let transformation = TimeTransformation::new(1e-4, 1e-4, 2.0);
            let inside = Interpolant::new(&Stencils::new(0, |_| (&transformation, &knots, 4)));
            (inside.at(Lanes::from(1.1))[2] / relaxation(1.1, 2e3) - 1.0).abs()
        };
        assert!(error(true) < 1e-11 && error(false) > 1e-9, "{:e} {:e}", error(true), error(false));
    }
}
