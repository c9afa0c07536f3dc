//! What is asked of curves, one a lane: where they turn round, when they come within a band for good, and values.

use crate::lanes::Lanes;
use crate::numerics::root::{Beyond, Curve, crossing, root};
use crate::regression::samples::POINTS;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Share of a piece to both sides of a place, to tell there whether the record rises.
const BESIDE: f64 = 1e-5;

/// What a curve a lane is made of: often the curve itself.
pub trait Reading {
    /// What events and roots are looked for on.
    type Curve: Curve;
    /// Makes it, with the instructions at hand.
    fn curve(self) -> Self::Curve;
}

impl<C: Curve> Reading for C {
    type Curve = Self;

    #[inline(always)]
    fn curve(self) -> Self {
        self
    }
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

/// Where a curve turns round: its rise.
struct Turning<'a, C> {
    curve: &'a C,
    beside: Lanes,
}

impl<C: Curve> Curve for Turning<'_, C> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        self.curve.rise(time, self.beside)
    }
}

impl<R: Reading> Look<R> {
    /// The answer: time and value of a turn, the time of coming within a band, or the values. One function for all that ask.
    #[inline(never)]
    pub fn answer(self, arch: Arch) -> [Lanes; POINTS] {
        arch.dispatch(self)
    }
}

impl<R: Reading> WithSimd for Look<R> {
    type Output = [Lanes; POINTS];

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Self::Output {
        let Self { reading, times, question } = self;
        let curve = reading.curve();
        // Times at which values are asked for, how many, and where these go.
        let (mut at, mut count, mut to) = ([Lanes::ZERO; POINTS], 0, 0);
        match question {
            Question::Turn => {
                let beside = (times[1] - times[0]) * BESIDE;
                at[0] = crossing(&Turning { curve: &curve, beside }, times[0] + beside, times[1] - beside);
                (count, to) = (1, 1);
            }
            Question::Enter { between: [outside, later], value, band } => {
                at[0] = root(&Beyond { curve: &curve, value, band }, outside, later);
            }
            Question::Pressures(times) => (at, count) = (times, POINTS),
        }
        let mut answer = at;
        for k in 0..black_box(count) {
            answer[to + k] = curve.at(at[k]);
        }
        answer
    }
}
