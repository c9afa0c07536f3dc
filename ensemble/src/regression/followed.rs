//! The record of a hold of which the time t over u, the relaxations so far, is known, for sums over samples at given times: no root
//! has to be found for any of them. From one moment to the next u is a polynomial of degree 7 that has the value and the first three
//! derivatives of u at both. With those of t over u, t1, t2 and t3, the derivatives over t are
//!
//! 1/t1,  −t2/t1³,  (3 t2² − t1 t3)/t1⁵
//!
//! A hold that slows down as a power of its distance from rest has u = ln(1 + β (t − t0))/n, β = t2/t1² at t0, where the part begins.
//! So the polynomial is one in y = ln(1 + β (t − t0))/β: for that law a line, as it is for a relaxation at a constant rate.

use crate::lanes::Lanes;
use crate::numerics::hermite::Hermite;
use crate::numerics::root::Curve;
use crate::regression::relaxing::{Relaxing, SLOWING_ENDS};
use chamber::real::Real;
use core::hint::black_box;

/// β over a part's length, at least: y of less is the time itself but for rounding.
const STRAIGHT: f64 = 1e-6;

/// A hold that was followed to its end, one a lane.
pub trait Followed {
    /// The moment after so many relaxations, or at the end of a hold that has fewer.
    fn moment(&self, relaxations: f64) -> HoldMoment;
    /// Pressure, Pa, after so many.
    fn pressure(&self, relaxations: Lanes) -> Lanes;
}

/// A moment of a hold: the time since the push, s, and Taylor coefficients of the relaxations over it.
#[derive(Clone, Copy, Debug)]
pub struct HoldMoment {
    time: Lanes,
    relaxations: [Lanes; 4],
}

impl HoldMoment {
    /// By the time, s, and its first three derivatives there over the relaxations.
    #[inline(always)]
    pub fn new(time: Lanes, relaxations: Lanes, [first, second, third]: [Lanes; 3]) -> Self {
        let rate = first.recip();
        let square = rate * rate;
        let bend = second * square;
        let twist = (bend * bend * 3.0 - third * (square * rate)) * rate;
        Self { time, relaxations: [relaxations, rate, bend * rate * -0.5, twist * (1.0 / 6.0)] }
    }

    /// Coefficients in powers of y over `length`, of a β, where dt/dy is `pace`: t goes as pace (y + β y²/2 + β² y³/6).
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

/// The record of a followed hold.
pub struct Record<'a, F>(pub &'a F);

impl<F: Followed> Relaxing for Record<'_, F> {
    const ENDS: &'static [f64] = SLOWING_ENDS;
    const IS_LONG: bool = true;
    type Knot = HoldMoment;
    type Course<'a>
        = Course<'a, F>
    where
        Self: 'a;

    #[inline(always)]
    fn knot(&self, relaxations: f64) -> HoldMoment {
        self.0.moment(relaxations)
    }

    #[inline(always)]
    fn time(knot: &HoldMoment) -> Lanes {
        knot.time
    }

    #[inline(always)]
    fn course(&self, [begin, end]: [&HoldMoment; 2]) -> Course<'_, F> {
        let way = end.time - begin.time;
        // Lanes without a way from one to the other have no samples there.
        let way = way.where_positive(way, Lanes::ONE);
        let [_, rate, bend, _] = begin.relaxations;
        let beta = (bend * -2.0 / rate).max(way.recip() * STRAIGHT);
        let pace = Lanes::ONE + beta * way;
        // Results pass through memory: else the compiler computes them lane by lane.
        let logarithm = black_box(pace.ln());
        let length = logarithm / beta;
        let ends = black_box([begin.over(length, beta, Lanes::ONE), end.over(length, beta, pace)]);
        let relaxations = black_box(Hermite::new(ends[0], ends[1]));
        Course { followed: self.0, begin: begin.time, way, beta, per_logarithm: logarithm.recip(), relaxations }
    }
}

/// The pressure from one moment to another.
pub struct Course<'a, F> {
    followed: &'a F,
    /// The time at its start, and its length, s.
    begin: Lanes,
    way: Lanes,
    beta: Lanes,
    /// One over β y at the end.
    per_logarithm: Lanes,
    relaxations: Hermite,
}

impl<F: Followed> Curve for Course<'_, F> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        // Nodes without weight may stand anywhere.
        let since = (time - self.begin).max(Lanes::ZERO).min(self.way);
        let place = (Lanes::ONE + self.beta * since).ln() * self.per_logarithm;
        self.followed.pressure(self.relaxations.at(place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hold that slows down ever less, t = (e^(n u) − 1)/n + u/2.
    struct Slowing(f64);

    impl Slowing {
        fn time(&self, relaxations: f64) -> f64 {
            ((self.0 * relaxations).exp() - 1.0) / self.0 + 0.5 * relaxations
        }
    }

    impl Followed for Slowing {
        fn moment(&self, relaxations: f64) -> HoldMoment {
            let (n, grown) = (self.0, (self.0 * relaxations).exp());
            let slopes = [grown + 0.5, n * grown, n * n * grown];
            HoldMoment::new(Lanes::from(self.time(relaxations)), Lanes::from(relaxations), slopes.map(Lanes::from))
        }

        fn pressure(&self, relaxations: Lanes) -> Lanes {
            (-relaxations).exp() + 1.0
        }
    }

    #[test]
    fn between_two_moments_the_pressure_is_that_of_the_hold() {
        for n in [0.01, 0.3, 1.0, 2.0] {
            for ends in SLOWING_ENDS.windows(2).filter(|ends| ends[1].is_finite()) {
                let hold = Slowing(n);
                let record = Record(&hold);
                let [begin, end] = [ends[0], ends[1]].map(|end| record.knot(end));
                let course = record.course([&begin, &end]);
                for share in [0.1, 0.4, 0.8] {
                    let relaxations = ends[0] + share * (ends[1] - ends[0]);
                    let found = course.at(Lanes::from(hold.time(relaxations)))[0];
                    let expected = (-relaxations).exp() + 1.0;
                    assert!((found - expected).abs() < 1e-7, "{n} {ends:?}: {found} {expected}");
                }
            }
        }
    }
}
