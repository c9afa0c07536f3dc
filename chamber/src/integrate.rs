//! Adaptive Runge–Kutta integration with the pair of [`crate::tableau`] and dense output. Step control of E. Hairer, S. P.
//! Nørsett and G. Wanner, Solving Ordinary Differential Equations I (1993), section II.4.

use crate::decay::Decay;
use crate::real::{Real, Scalar};
use crate::tableau::{A, C, D, E, STAGES};
use thiserror::Error;

/// A system of N ordinary differential equations.
pub trait System<R, const N: usize> {
    /// dy/dt at time `t`.
    fn rates(&self, t: f64, y: &[R; N]) -> [R; N];

    /// First time, s, at which the rates have a kink within a step; none by default. Steps are made to end there, because error
    /// estimates miss a kink inside a step.
    #[inline(always)]
    fn kink(&self, _: &Step<R, N>) -> Option<f64> {
        None
    }
}

impl<R, const N: usize, F: Fn(f64, &[R; N]) -> [R; N]> System<R, N> for F {
    #[inline(always)]
    fn rates(&self, t: f64, y: &[R; N]) -> [R; N] {
        self(t, y)
    }
}

/// Tolerance on the local error of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance<const N: usize> {
    /// Relative to each state.
    pub relative: f64,
    /// Absolute, in each state's unit.
    pub absolute: [f64; N],
}

/// Why an integration stopped.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum IntegrationError {
    /// No step, however small, meets the tolerance.
    #[error(
        "no step from t = {at:.6} s keeps the integration error within its tolerance: the state or an input jumps, or is not finite there"
    )]
    StepTooSmall {
        /// Time reached, s.
        at: f64,
    },
    /// The step limit is exceeded.
    #[error("more than {limit} integration steps before t = {at:.6} s")]
    TooManySteps {
        /// Time reached, s.
        at: f64,
        /// Most steps allowed in this call, [`MAX_STEPS`] unless set otherwise.
        limit: usize,
    },
}

/// Default limit of steps in one call of [`Integrator::advance`].
pub const MAX_STEPS: usize = 1_000_000;
const SAFETY: f64 = 0.9;
const SHRINK: f64 = 0.2;
const GROW: f64 = 5.0;
/// Error of a planned step, in tolerances, above which it is cut: small changes of the numbers then keep the steps.
const PLANNED: f64 = 2.0;

/// One accepted step and the states within it.
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
    /// Slopes at its stages; for a decaying state, its driving term.
    slopes: [[R; N]; STAGES],
    /// Which states are integrated as decaying.
    decays: [bool; N],
}

impl<R: Real, const N: usize> Step<R, N> {
    /// The states in between, as polynomials of time: Hairer's continuous extension, fourth order; for a decaying state, the
    /// straight line between its ends.
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

    /// A step of zero length from these states and slopes. Later steps overwrite it in place: with derivatives a step is too
    /// large to move.
    #[inline]
    fn at(start: [R; N], slope: [R; N], decays: &[Decay]) -> Self {
        let slopes = [[R::ZERO; N]; STAGES];
        let mut step = Self { from: 0.0, length: 0.0, start, end: start, slopes, decays: [false; N] };
        step.slopes[0] = slope;
        leave_out_decays(&mut step.slopes[0], &start, decays);
        decays.iter().for_each(|decay| step.decays[decay.state] = true);
        step
    }

    /// Attempts the step from its start at a time, s, over a length, s.
    #[inline]
    fn attempt(&mut self, system: &impl System<R, N>, from: f64, length: f64, decays: &mut [Decay]) {
        (self.from, self.length) = (from, length);
        decays.iter_mut().for_each(|decay| decay.prepare(length));
        let Self { start, end, slopes, .. } = self;
        for stage in 1..STAGES {
            // State by state, so that the sum stays in registers, however many derivatives a number has.
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

    /// Makes its end the start of the next step.
    #[inline]
    fn go_on(&mut self) {
        self.start = self.end;
        self.slopes[0] = self.slopes[STAGES - 1];
    }
}

/// Turns the slopes of decaying states into their driving terms.
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

/// A running integration. The caller stops it at discontinuities with [`Integrator::advance`]'s end time.
#[derive(Clone, Debug)]
pub struct Integrator<R, const N: usize> {
    /// Time reached, s.
    pub time: f64,
    /// States at this time.
    pub state: [R; N],
    /// Next step to try, s; zero requests an initial guess.
    pub step: f64,
    /// Longest step it may choose, s, so that its stages do not step over something short.
    pub longest: f64,
    /// Limit of steps in one call of [`Integrator::advance`].
    pub max_steps: usize,
    tolerance: Tolerance<N>,
    decays: Vec<Decay>,
}

impl<R: Scalar, const N: usize> Integrator<R, N> {
    /// Starts at `time` with these states.
    pub fn new(time: f64, state: [R; N], tolerance: Tolerance<N>) -> Self {
        Self { time, state, step: 0.0, longest: f64::INFINITY, max_steps: MAX_STEPS, tolerance, decays: Vec::new() }
    }

    /// With states that decay at these rates, 1/s, zero for states without decay. The decay is integrated exactly
    /// ([`crate::decay`]), so that fast decay does not shorten the steps.
    pub fn with_decays(mut self, rates: [f64; N]) -> Self {
        let decaying = rates.into_iter().enumerate().filter(|(_, rate)| *rate > 0.0);
        self.decays = decaying.map(|(state, rate)| Decay::new(state, rate)).collect();
        self
    }

    /// Integrates to `end`, s, over an interval on which the system is smooth except for its kinks; passes each accepted step
    /// to `on_step`.
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

    /// As [`Integrator::advance`], with planned steps: `planned` returns the end, s, of the step that starts at a time, at most
    /// `end`; `None` leaves the step to the integrator. A planned step whose error exceeds twice the tolerance is cut.
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
            // Two equal steps instead of a full step and a sliver.
            let mut h = if is_last { left } else { length.min(0.5 * left) };
            step.attempt(system, self.time, h, &mut self.decays);
            let mut error = self.error(&step);
            let kink = if error <= most { system.kink(&step) } else { None };
            if let Some(at) = kink {
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
                // A step cut short by the end or a kink is no reason to drop the longer planned one.
                self.step = if is_last || kink.is_some() { self.step.max(h * factor) } else { h * factor };
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

    /// Largest error of a step relative to the tolerance; infinite where a state is not finite.
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

    /// A first step in which no state changes by much more than its fraction tolerance^(1/5).
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

    /// Decay rates, 1/s, of a test system: a gas cools to a surface that its heat warms in two decaying modes, one of them fast.
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
        // Within a step, too, the fast state stays close to its quasi-steady value.
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
