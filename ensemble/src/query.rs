//! Queries on curves, one per lane: where they turn, when they enter a band, and their values.

use crate::lanes::Lanes;
use crate::numerics::root::{Beyond, Curve, crossing, root};
use crate::regression::samples::POINTS;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Half the distance over which the rise of a curve is measured, relative to the piece.
const BESIDE: f64 = 1e-5;

/// The data that a curve is made of; often the curve itself.
pub trait Reading {
    /// A function of time that can be evaluated in all lanes.
    type Curve: Curve;
    /// Makes the curve; inlined into the code of the instruction set in use.
    fn curve(self) -> Self::Curve;
}

impl<C: Curve> Reading for C {
    type Curve = Self;

    #[inline(always)]
    fn curve(self) -> Self {
        self
    }
}

/// What is asked of a curve.
#[derive(Clone, Copy, Debug)]
pub enum Question {
    /// The time at which the curve turns, and its value there.
    Turn,
    /// The time at which the curve enters a band around a value, between two times at the first of which it is outside.
    Enter { between: [Lanes; 2], value: Lanes, band: Lanes },
    /// The values at given times.
    Pressures([Lanes; POINTS]),
}

/// A query on a part of one curve per lane.
pub struct Query<R> {
    /// Data of the curve.
    pub reading: R,
    /// Begin and end of the part.
    pub times: [Lanes; 2],
    /// What is asked of that part, the same in all lanes.
    pub question: Question,
}

/// The rise of a curve, which is zero where the curve turns.
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

impl<R: Reading> Query<R> {
    /// The answer: time and value of a turn, time of entry into a band, or values. Not inlined, to keep one copy of the code.
    #[inline(never)]
    pub fn answer(self, arch: Arch) -> [Lanes; POINTS] {
        arch.dispatch(self)
    }
}

impl<R: Reading> WithSimd for Query<R> {
    type Output = [Lanes; POINTS];

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Self::Output {
        let Self { reading, times, question } = self;
        let curve = reading.curve();
        // Times at which to evaluate the curve, their number, and where the values go in the answer.
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
