//! The gas temperature inside the steps of a hold: d is a polynomial over a step ([`crate::conduction`]), and so is its integral. It
//! gives the settling time and the samples of the record. A hold is monotone while every mode has the sign of the gas temperature less
//! that of the surface: if T met the surface it would not move, but the surface would return towards Tw.

use crate::conduction::Keep;
use crate::conduction::rule::{NODES, RULE};
use crate::conduction::step::GasAndWall;
use crate::lanes::{Lanes, multiply_add};
use crate::numerics::root::{Beyond, Curve, root};
use crate::outcome::SETTLED;
use crate::regression::{Guess, Records};
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Largest last Legendre terms of T' over a step, times its length, relative to the change over the whole hold, for which T is accurate
/// inside the step: its error there is about a hundredth of this fraction, and a test settles at a hundredth of the change.
const INSIDE: f64 = 1e-5;

/// A step of all lanes; lanes that do not take it stay in place.
#[derive(Clone, Copy)]
pub struct Passed {
    /// Time at its end, s from the start of the hold, and its length, s, which is zero for lanes that stay.
    end: Lanes,
    length: Lanes,
    /// T at its start.
    temperature: Lanes,
    /// T' at the nodes, times the length.
    slopes: [Lanes; NODES],
}

/// Keeps every step.
impl Keep for Vec<Passed> {
    #[inline(always)]
    fn keep(&mut self, end: Lanes, goes: Lanes, temperature: Lanes, gas: &GasAndWall) {
        let length = goes.where_positive(gas.since, Lanes::ZERO);
        let warming = -(gas.cooling * length);
        let mut slopes = gas.drives;
        for node in 0..NODES {
            slopes[node] = slopes[node] * warming;
        }
        self.push(Passed { end, length, temperature, slopes });
    }
}

/// Coefficients of T in powers of the place in a step.
struct Inside([Lanes; NODES + 1]);

impl Passed {
    #[inline(always)]
    fn inside(&self) -> Inside {
        let rule = &*RULE;
        let mut terms = [self.temperature; NODES + 1];
        for power in 0..black_box(NODES) {
            let mut term = Lanes::ZERO;
            for node in 0..NODES {
                term = multiply_add::<true>(self.slopes[node], Lanes::from(rule.integrated[node][power]), term);
            }
            terms[1 + power] = term;
        }
        Inside(terms)
    }
}

impl Curve for Inside {
    #[inline(always)]
    fn at(&self, share: Lanes) -> Lanes {
        let mut sum = self.0[NODES];
        for power in (0..NODES).rev() {
            sum = multiply_add::<true>(sum, share, self.0[power]);
        }
        sum
    }
}

/// Computes the time from the start of holds between two temperatures until they stay within 1 % of the change of its end, s; and a
/// number that is 1 if T is accurate inside all steps.
pub struct Settle<'a> {
    pub steps: &'a [Passed],
    pub ends: [Lanes; 2],
}

impl WithSimd for Settle<'_> {
    type Output = [Lanes; 2];

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> [Lanes; 2] {
        let (Self { steps, ends: [begin, end] }, rule) = (self, &*RULE);
        let way = (begin - end).abs();
        let (band, mut good) = (way * SETTLED, Lanes::ONE);
        let mut last = Passed { length: Lanes::ZERO, end: Lanes::ZERO, ..steps[0] };
        for step in steps {
            let outside = ((step.temperature - end).abs() - band).min(step.length);
            last.end = outside.where_positive(step.end, last.end);
            last.length = outside.where_positive(step.length, last.length);
            last.temperature = outside.where_positive(step.temperature, last.temperature);
            for node in 0..NODES {
                last.slopes[node] = outside.where_positive(step.slopes[node], last.slopes[node]);
            }
            let mut terms = [Lanes::ZERO; 2];
            for node in 0..NODES {
                for of in 0..2 {
                    terms[of] = multiply_add::<true>(step.slopes[node], Lanes::from(rule.last[of][node]), terms[of]);
                }
            }
            let spare = way * INSIDE + f64::MIN_POSITIVE - (terms[0].abs() + terms[1].abs());
            good = spare.where_positive(good, Lanes::ZERO);
        }
        let curve = black_box(&last).inside();
        let share = root(&Beyond { curve: &curve, value: end, band }, Lanes::ZERO, Lanes::ONE);
        [last.end - last.length * (Lanes::ONE - share), good]
    }
}

/// Lays out the records, one part per step; returns a guess of τ.
pub struct Record<'a> {
    pub steps: &'a [Passed],
    /// Length of the push, s.
    pub push: Lanes,
    /// P/T, Pa/K.
    pub per_temperature: Lanes,
    /// 1/τ for a wall that does not warm, 1/s, and 1 − Tw/T at the start.
    pub relaxation: [Lanes; 2],
    /// Receives the records.
    pub records: &'a mut Records,
}

impl WithSimd for Record<'_> {
    type Output = Guess;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Guess {
        let Self { steps, push, per_temperature, relaxation: [rate, excess], records } = self;
        records.begin_at(push);
        for step in steps {
            // Passes through memory: otherwise the compiler computes lane by lane.
            let step = black_box(step);
            let end = black_box(push + step.end);
            if let Some(nodes) = records.nodes_up_to(end) {
                let inside = black_box(step.inside());
                let begin = black_box(end - step.length);
                records.push(&nodes, &nodes.values(&inside, begin, step.length, per_temperature));
            }
        }
        Guess::Relaxation { rate, excess, from: push }
    }
}
