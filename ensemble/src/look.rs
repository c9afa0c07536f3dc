//! Looks into steps of a batch once it is integrated, one step a lane: where its record turns round, when it crosses a
//! value, what it shows at some places.

use crate::advance::Tried;
use crate::general::Observe;
use crate::lanes::Lanes;
use crate::root::{Curve, root};
use crate::samples::POINTS;
use crate::step::{dense, within};
use chamber::real::Real;
use pulp::{Arch, Simd, WithSimd};

/// Share of a step to both sides of a place, to tell there whether the record rises.
const BESIDE: f64 = 1e-5;

/// A step of every lane as a polynomial in the share of its length.
struct Inside<'a, const N: usize, S> {
    system: &'a S,
    from: Lanes,
    length: Lanes,
    terms: [[Lanes; N]; 8],
}

impl<'a, const N: usize, S: Observe<N>> Inside<'a, N, S> {
    #[inline(always)]
    fn of<I: Simd>(system: &'a S, steps: &Tried<N>) -> Self {
        let Tried { from, length, begin, end, slopes, .. } = steps;
        let terms = if I::IS_SCALAR {
            dense::<N, false, S>(system, *from, *length, begin, end, slopes)
        } else {
            dense::<N, true, S>(system, *from, *length, begin, end, slopes)
        };
        Self { system, from: *from, length: *length, terms }
    }

    /// Pressure of the record, Pa, and temperature of the gas, K.
    #[inline(always)]
    fn shown(&self, share: Lanes) -> [Lanes; 2] {
        let mut y = [Lanes::ZERO; N];
        for i in 0..N {
            let mut of_state = [Lanes::ZERO; 8];
            for k in 0..8 {
                of_state[k] = self.terms[k][i];
            }
            y[i] = within(&of_state, share);
        }
        self.system.observe(self.from + share * self.length, &y)
    }
}

/// Where one of the two quantities turns round.
struct Turning<'a, const N: usize, S> {
    inside: Inside<'a, N, S>,
    /// Positive where it is the temperature.
    temperature: Lanes,
    /// 1 for a summit, −1 for a bottom.
    side: Lanes,
}

impl<const N: usize, S: Observe<N>> Turning<'_, N, S> {
    #[inline(always)]
    fn value(&self, share: Lanes) -> Lanes {
        let [pressure, temperature] = self.inside.shown(share);
        self.temperature.where_positive(temperature, pressure)
    }
}

impl<const N: usize, S: Observe<N>> Curve for Turning<'_, N, S> {
    #[inline(always)]
    fn at(&self, share: Lanes) -> Lanes {
        (self.value(share + BESIDE) - self.value(share - BESIDE)) * self.side
    }
}

/// How far the record is from a value, beyond a band around it.
struct Beyond<'a, const N: usize, S> {
    inside: Inside<'a, N, S>,
    value: Lanes,
    band: Lanes,
}

impl<const N: usize, S: Observe<N>> Curve for Beyond<'_, N, S> {
    #[inline(always)]
    fn at(&self, share: Lanes) -> Lanes {
        (self.inside.shown(share)[0] - self.value).abs() - self.band
    }
}

/// What is looked for.
#[derive(Clone, Copy, Debug)]
pub enum Question {
    /// Share of the step at which the quantity turns round, and its value there: the temperature where positive, else
    /// the record's pressure.
    Turn(Lanes),
    /// Share of the step, between two at the first of which it is outside, at which the record comes within a band
    /// around a value.
    Enter { between: [Lanes; 2], value: Lanes, band: Lanes },
    /// Pressures of the record, Pa, at shares of the step.
    Pressures([Lanes; POINTS]),
}

/// Answers a question about a step a lane; `system` holds their constants.
pub fn look<const N: usize, S: Observe<N>>(
    arch: Arch,
    system: &S,
    steps: &Tried<N>,
    question: Question,
) -> [Lanes; POINTS] {
    arch.dispatch(Look { system, steps, question })
}

struct Look<'a, const N: usize, S> {
    system: &'a S,
    steps: &'a Tried<N>,
    question: Question,
}

impl<const N: usize, S: Observe<N>> WithSimd for Look<'_, N, S> {
    type Output = [Lanes; POINTS];

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Self::Output {
        let inside = Inside::of::<I>(self.system, self.steps);
        let mut answer = [Lanes::ZERO; POINTS];
        match self.question {
            Question::Turn(temperature) => {
                let mut turning = Turning { inside, temperature, side: Lanes::ONE };
                turning.side = turning.at(Lanes::from(BESIDE)).where_positive(Lanes::ONE, -Lanes::ONE);
                answer[0] = root(&turning, Lanes::from(BESIDE), Lanes::from(1.0 - BESIDE));
                answer[1] = turning.value(answer[0]);
            }
            Question::Enter { between: [outside, later], value, band } => {
                answer[0] = root(&Beyond { inside, value, band }, outside, later);
            }
            Question::Pressures(shares) => {
                for k in 0..POINTS {
                    answer[k] = inside.shown(shares[k])[0];
                }
            }
        }
        answer
    }
}
