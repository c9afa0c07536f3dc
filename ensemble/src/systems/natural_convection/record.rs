//! The record of a hold whose time t is known as a function of u, the relaxations so far, for sums over samples at given times without
//! finding a root for each of them. Between two knots u is the polynomial of degree 7 with the value and the first three derivatives of
//! u at both. From the derivatives of t by u, t1, t2 and t3, those of u by t are
//!
//! 1/t1,  −t2/t1³,  (3 t2² − t1 t3)/t1⁵
//!
//! A hold that slows down with a power of its distance from rest has u = ln(1 + β (t − t0))/n, β = t2/t1² at t0, the start of the part.
//! So the polynomial is one in y = ln(1 + β (t − t0))/β: linear for that law, and for a relaxation at a constant rate.

use super::hold::{Ends, Holds};
use crate::lanes::Lanes;
use crate::numerics::hermite::Hermite;
use crate::numerics::root::Curve;
use crate::regression::relaxing::{self, Relaxing};
use crate::regression::{Guess, Records};
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Smallest β times the part's length: for less, y equals the time to rounding.
const STRAIGHT: f64 = 1e-6;

/// Lays out the records; returns a guess of τ.
pub struct Record<'a> {
    pub holds: &'a Holds,
    pub ends: &'a Ends,
    /// P/T, Pa/K.
    pub per_temperature: Lanes,
    /// Receives the records.
    pub records: &'a mut Records,
}

impl WithSimd for Record<'_> {
    type Output = Guess;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Guess {
        let Self { holds, ends, per_temperature, records } = self;
        let Holds { wall, pushed, push, hold, .. } = *black_box(holds);
        let held = Held { ends, hold, per_temperature };
        relaxing::lay_out(&held, relaxing::SLOWING_ENDS, push, push + hold, records);
        Guess::Relaxation { rate: ends.series.slowness.recip(), excess: Lanes::ONE - wall / pushed, from: push }
    }
}

/// Solved holds.
pub struct Held<'a> {
    ends: &'a Ends,
    hold: Lanes,
    per_temperature: Lanes,
}

impl Relaxing for Held<'_> {
    const IS_LONG: bool = true;
    type Knot = HoldMoment;
    type Trajectory<'a>
        = Trajectory<'a>
    where
        Self: 'a;

    #[inline(always)]
    fn knot(&self, relaxations: f64) -> HoldMoment {
        let Ends { series, relaxations: last, .. } = self.ends;
        let goes_on = *last - relaxations;
        let at = last.min(Lanes::from(relaxations));
        let [time, slopes @ ..] = series.with_slopes(at);
        HoldMoment::new(goes_on.where_positive(time, self.hold), at, slopes)
    }

    #[inline(always)]
    fn time(knot: &HoldMoment) -> Lanes {
        knot.time
    }

    #[inline(always)]
    fn trajectory(&self, [begin, end]: [&HoldMoment; 2]) -> Trajectory<'_> {
        let way = end.time - begin.time;
        // Lanes in which both knots coincide have no samples there.
        let way = way.where_positive(way, Lanes::ONE);
        let [_, rate, bend, _] = begin.relaxations;
        let beta = (bend * -2.0 / rate).max(way.recip() * STRAIGHT);
        let pace = Lanes::ONE + beta * way;
        // Passes through memory: otherwise the compiler computes lane by lane.
        let logarithm = black_box(pace.ln());
        let length = logarithm / beta;
        let ends = black_box([begin.over(length, beta, Lanes::ONE), end.over(length, beta, pace)]);
        let relaxations = black_box(Hermite::new(ends[0], ends[1]));
        Trajectory { held: self, begin: begin.time, way, beta, per_logarithm: logarithm.recip(), relaxations }
    }
}

/// A knot of a hold: the time since the push, s, and the Taylor coefficients of the relaxations in it.
#[derive(Clone, Copy, Debug)]
pub struct HoldMoment {
    time: Lanes,
    relaxations: [Lanes; 4],
}

impl HoldMoment {
    /// From the time, s, and its first three derivatives by the relaxations.
    #[inline(always)]
    pub fn new(time: Lanes, relaxations: Lanes, [first, second, third]: [Lanes; 3]) -> Self {
        let rate = first.recip();
        let square = rate * rate;
        let bend = second * square;
        let twist = (bend * bend * 3.0 - third * (square * rate)) * rate;
        Self { time, relaxations: [relaxations, rate, bend * rate * -0.5, twist * (1.0 / 6.0)] }
    }

    /// Coefficients in powers of y over `length`, given β and dt/dy, `pace`: t changes by pace (y + β y²/2 + β² y³/6).
    #[inline(always)]
    fn over(&self, length: Lanes, beta: Lanes, pace: Lanes) -> [Lanes; 4] {
        let [value, first, second, third] = self.relaxations;
        let (first, second, third) = (first * pace, second * (pace * pace), third * (pace * pace * pace));
        let square = length * length;
        let bend = second + first * beta * 0.5;
        let twist = third + (second + first * beta * (1.0 / 6.0)) * beta;
        [value, first * length, bend * square, twist * (square * length)]
    }
}

/// The pressure between two knots.
pub struct Trajectory<'a> {
    held: &'a Held<'a>,
    /// Time at its start, and length, s.
    begin: Lanes,
    way: Lanes,
    beta: Lanes,
    /// Reciprocal of β y at the end.
    per_logarithm: Lanes,
    relaxations: Hermite,
}

impl Curve for Trajectory<'_> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        // Nodes without weight may lie anywhere.
        let since = (time - self.begin).max(Lanes::ZERO).min(self.way);
        let place = (Lanes::ONE + self.beta * since).ln() * self.per_logarithm;
        let Held { ends: Ends { series, .. }, per_temperature, .. } = self.held;
        series.temperature(self.relaxations.at(place)) * *per_temperature
    }
}

#[cfg(test)]
mod tests {
    use super::super::hold::{Solve, has_series, tests::between};
    use super::*;
    use proptest::prelude::*;
    use pulp::Scalar;

    proptest! {
        #[test]
        fn the_record_from_part_to_part_is_the_series(
            exponent in 0.02..2.4f64, rate in 0.01..100.0f64, wall in 250.0..350.0f64, ratio in 0.4..2.5f64, left in 1e-6..0.99f64,
        ) {
            let from = wall * ratio;
            prop_assume!(has_series(exponent, from, wall));
            let hold = between(exponent, rate, wall, [from, wall + (from - wall) * left]);
            let [exponent, rate, wall, pushed, hold] = [exponent, rate, wall, from, hold].map(Lanes::from);
            let holds = Holds { exponent, rate, wall, pushed, push: Lanes::ONE, hold };
            let ends = Solve(&holds).with_simd(Scalar::new());
            let held = Held { ends: &ends, hold, per_temperature: Lanes::ONE };
            let mut begin = held.knot(0.0);
            for relaxations in relaxing::SLOWING_ENDS {
                let end = held.knot(*relaxations);
                let trajectory = held.trajectory([&begin, &end]);
                for share in [0.0, 0.2, 0.5, 0.9, 1.0] {
                    let [from, to] = [&begin, &end].map(|knot| Held::time(knot)[3]);
                    let time = Lanes::from(from + (to - from) * share);
                    let (found, expected) = (trajectory.at(time)[3], ends.series.temperature(ends.series.after(time))[3]);
                    let allowed = 1e-7 * (from - to).abs().min(1.0).max((pushed[3] - wall[3]).abs());
                    prop_assert!((found - expected).abs() < allowed, "{relaxations} {share}: {found} {expected}");
                }
                begin = end;
            }
        }
    }
}
