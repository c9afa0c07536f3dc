//! Adaptive Runge–Kutta integration by the pair of [`crate::tableau`], with dense output. Step control of E. Hairer, S. P. Nørsett and
//! G. Wanner, Solving Ordinary Differential Equations I (1993), section II.4.

use crate::decay::Decay;
use crate::real::{Real, Scalar};
use crate::tableau::{A, C, D, E, STAGES};
use thiserror::Error;

/// A system of N ordinary differential equations.
pub trait System<R, const N: usize> {
    /// dy/dt at time `t`.
    fn rates(&self, t: f64, y: &[R; N]) -> [R; N];

    /// When the rates have a first corner within a step, s: steps are made to end there, as across a corner their error estimates
    /// are blind. Unless told otherwise they have none.
    #[inline(always)]
    fn corner(&self, _: &Step<R, N>) -> Option<f64> {
        None
    }
}

impl<R, const N: usize, F: Fn(f64, &[R; N]) -> [R; N]> System<R, N> for F {
    #[inline(always)]
    fn rates(&self, t: f64, y: &[R; N]) -> [R; N] {
        self(t, y)
    }
}

/// How large the local error of a step may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance<const N: usize> {
    /// Relative to each state.
    pub relative: f64,
    /// Absolute, in each state's unit.
    pub absolute: [f64; N],
}

/// Why an integration could not go on.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum IntegrationError {
    /// No step, however small, keeps the error within the tolerance.
    #[error(
        "no step from t = {at:.6} s keeps the integration error within its tolerance: the state or an input jumps, or is not finite there"
    )]
    StepTooSmall {
        /// Time that was reached, s.
        at: f64,
    },
    /// The step count is exhausted.
    #[error("more than {limit} integration steps before t = {at:.6} s")]
    TooManySteps {
        /// Time that was reached, s.
        at: f64,
        /// The number allowed.
        limit: usize,
    },
}

/// Steps that one call of [`Integrator::advance`] may take unless told otherwise.
pub const MAX_STEPS: usize = 1_000_000;
const SAFETY: f64 = 0.9;
const SHRINK: f64 = 0.2;
const GROW: f64 = 5.0;
/// A planned step may err by so many tolerances before it is cut: numbers that change a little keep the steps.
const PLANNED: f64 = 2.0;

/// One accepted step, and the states within it.
#[derive(Clone, Copy, Debug)]
pub struct Step<R, const N: usize> {
    /// Its start, s.
    pub from: f64,
    /// Its length, s.
    pub length: f64,
    /// States at its start.
    pub start: [R; N],
    /// States at its end.
    pub end: [R; N],
    /// Slopes in its stages; of a state that decays by itself what drives it.
    slopes: [[R; N]; STAGES],
    /// Which states decay by themselves.
    decays: [bool; N],
}

impl<R: Real, const N: usize> Step<R, N> {
    /// The states in between, as polynomials of time: Hairer's continuous extension, fourth order; of a state that decays by itself
    /// the straight line between its ends.
    #[inline]
    pub fn dense(&self) -> Dense<R, N> {
        let mut terms = [[R::ZERO; N]; 5];
        for i in 0..N {
            let difference = self.end[i] - self.start[i];
            (terms[0][i], terms[1][i]) = (self.start[i], difference);
            if self.decays[i] {
                continue;
            }
            let begin = self.slopes[0][i] * self.length - difference;
            let mut fourth = R::ZERO;
            for (slope, weight) in self.slopes.iter().zip(D) {
                if weight != 0.0 {
                    fourth += slope[i] * (weight * self.length);
                }
            }
            terms[2][i] = begin;
            terms[3][i] = difference - self.slopes[STAGES - 1][i] * self.length - begin;
            terms[4][i] = fourth;
        }
        Dense { from: self.from, per_length: 1.0 / self.length, terms }
    }

    /// One of no length, from these states with these slopes. The next is written over it, and so on: with derivatives a step is
    /// too large to be moved about.
    #[inline]
    fn at(start: [R; N], slope: [R; N], decays: &[Decay]) -> Self {
        let slopes = [[R::ZERO; N]; STAGES];
        let mut step = Self { from: 0.0, length: 0.0, start, end: start, slopes, decays: [false; N] };
        step.slopes[0] = slope;
        leave_out_decays(&mut step.slopes[0], &start, decays);
        decays.iter().for_each(|decay| step.decays[decay.state] = true);
        step
    }

    /// Takes it from its start at a time, s, over a length, s.
    #[inline]
    fn attempt(&mut self, system: &impl System<R, N>, from: f64, length: f64, decays: &mut [Decay]) {
        (self.from, self.length) = (from, length);
        decays.iter_mut().for_each(|decay| decay.prepare(length));
        let Self { start, end, slopes, .. } = self;
        for stage in 1..STAGES {
            // State by state: the sum stays in registers, however many derivatives a number has.
            for i in 0..N {
                let mut sum = slopes[0][i] * A[stage][0];
                for j in 1..stage {
                    sum += slopes[j][i] * A[stage][j];
                }
                end[i] = start[i] + sum * length;
            }
            for decay in decays.iter() {
                let (i, weights) = (decay.state, &decay.weights[stage]);
                let mut sum = slopes[0][i] * weights[0];
                for j in 1..stage {
                    sum += slopes[j][i] * weights[j];
                }
                end[i] = start[i] * decay.kept[stage] + sum * length;
            }
            slopes[stage] = system.rates(from + C[stage] * length, end);
            leave_out_decays(&mut slopes[stage], end, decays);
        }
    }

    /// Makes its end the start of the next one.
    #[inline]
    fn go_on(&mut self) {
        self.start = self.end;
        self.slopes[0] = self.slopes[STAGES - 1];
    }
}

/// What drives states that decay by themselves, from the slopes of all.
#[inline]
fn leave_out_decays<R: Real, const N: usize>(slopes: &mut [R; N], states: &[R; N], decays: &[Decay]) {
    for decay in decays {
        slopes[decay.state] += states[decay.state] * decay.rate;
    }
}

/// The states within one step.
#[derive(Clone, Copy, Debug)]
pub struct Dense<R, const N: usize> {
    from: f64,
    per_length: f64,
    terms: [[R; N]; 5],
}

impl<R: Real, const N: usize> Dense<R, N> {
    /// States at time `t`, s, within the step.
    #[inline]
    pub fn at(&self, t: R) -> [R; N] {
        let theta = (t - self.from) * self.per_length;
        let theta1 = R::ONE - theta;
        let [start, difference, begin, third, fourth] = &self.terms;
        let mut states = *start;
        for i in 0..N {
            states[i] += (difference[i] + (begin[i] + (third[i] + fourth[i] * theta1) * theta) * theta1) * theta;
        }
        states
    }
}

/// An integration under way. The caller breaks it at discontinuities with [`Integrator::advance`]'s end time.
#[derive(Clone, Debug)]
pub struct Integrator<R, const N: usize> {
    /// Time reached, s.
    pub time: f64,
    /// States at that time.
    pub state: [R; N],
    /// Next step to try, s; zero asks for a first guess.
    pub step: f64,
    /// The longest step that it may choose, s: where something short happens that its stages would pass over.
    pub longest: f64,
    /// Steps that one call of [`Integrator::advance`] may take.
    pub max_steps: usize,
    tolerance: Tolerance<N>,
    decays: Vec<Decay>,
}

impl<R: Scalar, const N: usize> Integrator<R, N> {
    /// At `time` with these states.
    pub fn new(time: f64, state: [R; N], tolerance: Tolerance<N>) -> Self {
        Self { time, state, step: 0.0, longest: f64::INFINITY, max_steps: MAX_STEPS, tolerance, decays: Vec::new() }
    }

    /// The same of states that decay at these rates, 1/s, by themselves, zero where they do not: taken exactly ([`crate::decay`]), so
    /// that fast ones do not make the steps short.
    pub fn with_decays(mut self, rates: [f64; N]) -> Self {
        let decaying = rates.into_iter().enumerate().filter(|(_, rate)| *rate > 0.0);
        self.decays = decaying.map(|(state, rate)| Decay::new(state, rate)).collect();
        self
    }

    /// Integrates to `end`, s, over a stretch on which the system is smooth but for its corners; hands each accepted step to
    /// `on_step`.
    ///
    /// # Errors
    /// When no step meets the tolerance, or [`Integrator::max_steps`] is exceeded; time and states are then those of the last
    /// accepted step.
    #[inline]
    pub fn advance(
        &mut self,
        system: &impl System<R, N>,
        end: f64,
        on_step: impl FnMut(&Step<R, N>),
    ) -> Result<(), IntegrationError> {
        self.advance_by(system, end, |_| None, on_step)
    }

    /// The same by planned steps: `planned` gives the end, s, of the one that leads on from a time, no later than `end`; `None`
    /// leaves the step to the integrator. One that errs by more than twice the tolerance is cut.
    ///
    /// # Errors
    /// As [`Integrator::advance`].
    #[inline]
    pub fn advance_by(
        &mut self,
        system: &impl System<R, N>,
        end: f64,
        planned: impl Fn(f64) -> Option<f64>,
        mut on_step: impl FnMut(&Step<R, N>),
    ) -> Result<(), IntegrationError> {
        if end <= self.time {
            return Ok(());
        }
        let mut step = Step::at(self.state, system.rates(self.time, &self.state), &self.decays);
        if self.step <= 0.0 {
            self.step = self.first_step(&step.slopes[0], end);
        }
        let mut rejected = false;
        for _ in 0..self.max_steps {
            let plan = planned(self.time);
            let (until, most) = plan.map_or((end, 1.0), |until| (until, PLANNED));
            let left = until - self.time;
            let length = if plan.is_some() && !rejected { left } else { self.step.min(self.longest) };
            let mut is_last = length >= left * (1.0 - 1e-12);
            // Two even steps rather than one whole and a sliver.
            let mut h = if is_last { left } else { length.min(0.5 * left) };
            step.attempt(system, self.time, h, &mut self.decays);
            let mut error = self.error(&step);
            let corner = if error <= most { system.corner(&step) } else { None };
            if let Some(at) = corner {
                (is_last, h) = (false, at - self.time);
                step.attempt(system, self.time, h, &mut self.decays);
                error = self.error(&step);
            }
            if error <= most {
                self.time = if is_last { until } else { self.time + h };
                self.state = step.end;
                on_step(&step);
                step.go_on();
                let factor = (SAFETY * error.max(1e-10).powf(-0.2)).clamp(SHRINK, if rejected { 1.0 } else { GROW });
                // A step cut short by the end or a corner says nothing against the longer one that was planned.
                self.step = if is_last || corner.is_some() { self.step.max(h * factor) } else { h * factor };
                rejected = false;
                if is_last && until == end {
                    return Ok(());
                }
            } else {
                let factor = if error.is_finite() { (SAFETY * error.powf(-0.2)).clamp(SHRINK, 0.9) } else { 0.1 };
                self.step = h * factor;
                rejected = true;
                if self.step <= 4.0 * f64::EPSILON * self.time.abs().max(1e-6) {
                    return Err(IntegrationError::StepTooSmall { at: self.time });
                }
            }
        }
        Err(IntegrationError::TooManySteps { at: self.time, limit: self.max_steps })
    }

    /// Error of a step relative to the tolerance (largest component), infinite where a state is not finite.
    #[inline]
    fn error(&self, step: &Step<R, N>) -> f64 {
        let mut sums = [0.0; N];
        for (slope, weight) in step.slopes.iter().zip(E) {
            for i in 0..N {
                sums[i] += weight * slope[i].value();
            }
        }
        self.decays.iter().for_each(|decay| sums[decay.state] *= decay.left);
        let mut worst: f64 = 0.0;
        for (i, sum) in sums.into_iter().enumerate() {
            let size = step.start[i].value().abs().max(step.end[i].value().abs());
            let scale = self.tolerance.absolute[i] + self.tolerance.relative * size;
            let ratio = (sum * step.length).abs() / scale;
            if !ratio.is_finite() {
                return f64::INFINITY;
            }
            worst = worst.max(ratio);
        }
        worst
    }

    /// A first step in which no state changes by much more than tolerance^(1/5) of itself.
    fn first_step(&self, first: &[R; N], end: f64) -> f64 {
        let mut step = end - self.time;
        for (i, slope) in first.iter().enumerate() {
            let scale = self.state[i].value().abs() + self.tolerance.absolute[i] / self.tolerance.relative;
            let rate = slope.value().abs();
            if rate > 0.0 && scale > 0.0 {
                step = step.min(self.tolerance.relative.powf(0.2) * scale / rate);
            }
        }
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIGHT: Tolerance<2> = Tolerance { relative: 1e-11, absolute: [1e-12; 2] };

    fn oscillator(_: f64, y: &[f64; 2]) -> [f64; 2] {
        [y[1], -y[0]]
    }

    #[test]
    fn the_oscillator_is_followed_at_its_ends_and_in_between() {
        let mut run = Integrator::new(0.0, [0.0, 1.0], TIGHT);
        let mut worst_inside: f64 = 0.0;
        run.advance(&oscillator, 10.0, |step| {
            for k in 0..=4 {
                let t = step.from + step.length * f64::from(k) / 4.0;
                worst_inside = worst_inside.max((step.dense().at(t)[0] - t.sin()).abs());
            }
        })
        .unwrap();
        assert_eq!(run.time, 10.0);
        assert!((run.state[0] - 10.0f64.sin()).abs() < 1e-9);
        assert!(worst_inside < 1e-7, "{worst_inside}");
    }

    #[test]
    fn a_time_dependent_system_is_of_fifth_order() {
        // y' = 5 t^4 is integrated without error by a method of order five; y' = t^9 is not.
        let mut run = Integrator::new(0.0, [0.0], Tolerance { relative: 1e-3, absolute: [1e-3] });
        run.advance(&|t: f64, _: &[f64; 1]| [5.0 * t.powi(4)], 2.0, |_| ()).unwrap();
        assert!((run.state[0] - 32.0).abs() < 1e-13 * 32.0, "{}", run.state[0]);
    }

    /// A gas that cools to a surface which its heat warms, and which forgets that at two rates, 1/s, one of them fast.
    const FORGETS: [f64; 3] = [0.0, 0.02, 400.0];

    fn cooling(_: f64, y: &[f64; 3]) -> [f64; 3] {
        let flux = 0.1 * (y[0] - y[1] - y[2]);
        [-flux, 0.3 * flux - FORGETS[1] * y[1], 9.0 * flux - FORGETS[2] * y[2]]
    }

    #[test]
    fn states_that_decay_by_themselves_are_followed_in_steps_longer_than_they_remember() {
        let run = |relative: f64, rates: [f64; 3]| {
            let tolerance = Tolerance { relative, absolute: [10.0 * relative; 3] };
            let mut integrator = Integrator::new(0.0, [50.0, 0.0, 0.0], tolerance).with_decays(rates);
            let (mut steps, mut within) = (0, Vec::new());
            integrator
                .advance(&cooling, 60.0, |step| {
                    steps += 1;
                    within.push((step.from + 0.4 * step.length, step.dense().at(step.from + 0.4 * step.length)));
                })
                .unwrap();
            (integrator.state, steps, within)
        };
        let (exact, many, _) = run(1e-11, [0.0; 3]);
        let (state, few, within) = run(3e-7, FORGETS);
        let off = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off(&state, &exact) < 3e-5 && 100 * few < many, "{state:?} {exact:?} {few} {many}");
        // Between the ends of a step, too, the forgetful state is next to what drives it.
        for (time, state) in within.into_iter().filter(|(time, _)| *time > 1.0) {
            let flux = 0.1 * (state[0] - state[1] - state[2]);
            assert!((state[2] - 9.0 * flux / FORGETS[2]).abs() < 3e-3, "{time} {state:?}");
        }
    }

    #[test]
    fn a_system_that_blows_up_ends_in_an_error_that_names_the_time() {
        let mut run = Integrator::new(0.0, [1.0], Tolerance { relative: 1e-8, absolute: [1e-8] });
        let error = run.advance(&|_: f64, y: &[f64; 1]| [y[0] * y[0]], 2.0, |_| ()).unwrap_err();
        assert!(matches!(error, IntegrationError::StepTooSmall { at } if (at - 1.0).abs() < 1e-3), "{error}");
    }
}
