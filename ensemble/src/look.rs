//! What is asked of curves, one a lane: where they turn round, when they come within a band for good, and values.

use crate::lanes::Lanes;
use crate::root::{Curve, root};
use crate::samples::POINTS;
use chamber::real::Real;
use pulp::{Simd, WithSimd};

/// Share of a piece to both sides of a place, to tell there whether the record rises.
const BESIDE: f64 = 1e-5;

/// What a curve a lane is made of.
pub trait Reading {
    /// What events and roots are looked for on.
    type Curve: Curve;
    /// Makes it, with the instructions at hand.
    fn curve(self) -> Self::Curve;
}

/// What is looked for.
#[derive(Clone, Copy, Debug)]
pub enum Question {
    /// The time at which the curve turns round, and its value there.
    Turn,
    /// The time, between two at the first of which it is outside, at which the curve comes within a band around a value.
    Enter { between: [Lanes; 2], value: Lanes, band: Lanes },
    /// Values at some times.
    Pressures([Lanes; POINTS]),
}

/// A question about a part of a curve a lane.
pub struct Look<R> {
    /// What makes the curve.
    pub reading: R,
    /// Begin and end of the part of the curve that is looked at.
    pub times: [Lanes; 2],
    /// What is looked for there.
    pub question: Question,
}

/// Where a curve turns round: its rise, positive before a summit or after a bottom.
struct Turning<'a, C> {
    curve: &'a C,
    beside: Lanes,
    /// 1 for a summit, −1 for a bottom.
    side: Lanes,
}

impl<C: Curve> Curve for Turning<'_, C> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        self.curve.rise(time, self.beside) * self.side
    }
}

/// How far a curve is from a value, beyond a band around it.
struct Beyond<'a, C> {
    curve: &'a C,
    value: Lanes,
    band: Lanes,
}

impl<C: Curve> Curve for Beyond<'_, C> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        (self.curve.at(time) - self.value).abs() - self.band
    }
}

impl<R: Reading> WithSimd for Look<R> {
    type Output = [Lanes; POINTS];

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Self::Output {
        let Self { reading, times, question } = self;
        let curve = reading.curve();
        let mut answer = [Lanes::ZERO; POINTS];
        match question {
            Question::Turn => {
                let beside = (times[1] - times[0]) * BESIDE;
                let [low, high] = [times[0] + beside, times[1] - beside];
                let mut turning = Turning { curve: &curve, beside, side: Lanes::ONE };
                turning.side = turning.at(low).where_positive(Lanes::ONE, -Lanes::ONE);
                answer[0] = root(&turning, low, high);
                answer[1] = curve.at(answer[0]);
            }
            Question::Enter { between: [outside, later], value, band } => {
                answer[0] = root(&Beyond { curve: &curve, value, band }, outside, later);
            }
            Question::Pressures(at) => {
                for k in 0..POINTS {
                    answer[k] = curve.at(at[k]);
                }
            }
        }
        answer
    }
}
