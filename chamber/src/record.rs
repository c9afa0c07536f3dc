//! Integration of a chamber along its inputs and the sensor's readings on the way: shared by all recordings.
//!
//! A recording supplies its [`Inputs`], calls [`follow`] to integrate along them, and takes the [`Readings`] that fall due during
//! each step. Time in s, pressure in Pa.

use crate::balance::Boundary;
use crate::effects::{self, EffectSet, EffectValues, OWN_STATES};
use crate::integrate::{IntegrationError, Integrator, Step, System};
use crate::kink;
use crate::model::Chamber;
use crate::real::Scalar;
use std::cell::Cell;

/// Inputs imposed on a chamber over time, in consecutive smooth stretches.
pub trait Inputs<R> {
    /// Start of the first stretch, s.
    fn begin(&self) -> f64;

    /// Number of stretches, at least one.
    fn stretches(&self) -> usize;

    /// End of a stretch, s; infinite for the last one.
    fn end(&self, stretch: usize) -> f64;

    /// The boundary at `time`, s, on a stretch.
    fn boundary(&self, stretch: usize, time: f64) -> Boundary<R>;

    /// Changes the state at the end of a stretch, for events that the balances do not describe.
    fn after_stretch<const N: usize>(&self, _stretch: usize, _state: &mut [R; N]) {}

    /// Longest first step and longest step on a stretch, s, whose stages do not step over anything that happens there.
    fn longest_steps(&self, _stretch: usize) -> [f64; 2] {
        [f64::INFINITY; 2]
    }
}

/// The equations of a chamber.
pub trait Equations<R, const N: usize> {
    /// Rates of its states at a time, s.
    fn rates(&self, time: f64, boundary: &Boundary<R>, state: &[R; N]) -> [R; N];

    /// Functions that change sign where the rates have kinks; none by default.
    #[inline(always)]
    fn kink_indicators(&self, _: &Boundary<R>, _: &[R; N]) -> Option<[f64; effects::KINK_INDICATORS]> {
        None
    }
}

impl<R, const N: usize, F: Fn(f64, &Boundary<R>, &[R; N]) -> [R; N]> Equations<R, N> for F {
    #[inline(always)]
    fn rates(&self, time: f64, boundary: &Boundary<R>, state: &[R; N]) -> [R; N] {
        self(time, boundary, state)
    }
}

/// Equations on one stretch of inputs.
struct OnStretch<'a, I, E> {
    inputs: &'a I,
    stretch: usize,
    equations: &'a E,
}

impl<R: Scalar, const N: usize, I: Inputs<R>, E: Equations<R, N>> System<R, N> for OnStretch<'_, I, E> {
    #[inline(always)]
    fn rates(&self, t: f64, y: &[R; N]) -> [R; N] {
        self.equations.rates(t, &self.inputs.boundary(self.stretch, t), y)
    }

    #[inline(always)]
    fn kink(&self, step: &Step<R, N>) -> Option<f64> {
        kink::first(step, |t, y| self.equations.kink_indicators(&self.inputs.boundary(self.stretch, t), y))
    }
}

/// The boundary at `time`, s; derivatives in `time` (those of a delay) carry over to the position.
#[inline]
pub fn boundary_at<R: Scalar>(inputs: &impl Inputs<R>, stretch: usize, time: R) -> Boundary<R> {
    let mut boundary = inputs.boundary(stretch, time.value());
    boundary.position = moved_on(boundary.position, boundary.velocity, time);
    boundary
}

/// Position, m, with the derivatives it gets from those of `time`, s, through its velocity, m/s.
#[inline]
pub fn moved_on<R: Scalar>(position: R, velocity: R, time: R) -> R {
    position + (time - time.value()) * velocity
}

/// The steps of an integration along inputs, for reuse: the error is then a smooth function of the chamber's parameters, which it
/// is not with adaptive steps. H. G. Bock, in: Modelling of Chemical Reaction Systems, Springer (1981) 102.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Ends of the steps as fractions of their stretch; 1 ends a stretch.
    ends: Vec<f64>,
}

impl Mesh {
    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.ends.len()
    }

    fn stretches(&self) -> impl Iterator<Item = &[f64]> {
        self.ends.split_inclusive(|end| *end == 1.0)
    }
}

/// Integrates along the inputs until `last`, s, and passes each accepted step to `on_step` with its stretch and its end, s. Uses
/// the steps of `mesh` as far as they extend, and cuts those whose error is too large. Returns the steps taken.
///
/// # Errors
/// If the state leaves the range of the equations.
#[inline]
pub fn follow<R: Scalar, const N: usize>(
    inputs: &impl Inputs<R>,
    integrator: &mut Integrator<R, N>,
    last: f64,
    mesh: &Mesh,
    equations: impl Equations<R, N>,
    mut on_step: impl FnMut(usize, f64, &Step<R, N>),
) -> Result<Mesh, IntegrationError> {
    let mut taken = Mesh { ends: Vec::with_capacity(mesh.ends.len()) };
    let mut planned = mesh.stretches();
    for stretch in 0..inputs.stretches() {
        let (from, end) = (integrator.time, inputs.end(stretch).min(last));
        if end <= from {
            continue;
        }
        let [first, longest] = inputs.longest_steps(stretch);
        (integrator.step, integrator.longest) = (integrator.step.min(first), longest);
        let fractions = planned.next().unwrap_or(&[]);
        let time_at = |fraction: f64| if fraction == 1.0 { end } else { from + fraction * (end - from) };
        let passed = Cell::new(0);
        let next = |time: f64| {
            passed.set(
                passed.get()
                    + fractions[passed.get()..].iter().take_while(|fraction| time_at(**fraction) <= time).count(),
            );
            fractions.get(passed.get()).map(|fraction| time_at(*fraction))
        };
        let system = OnStretch { inputs, stretch, equations: &equations };
        integrator.advance_by(&system, end, next, |step| {
            let until = step.from + step.length;
            taken.ends.push((until - from) / (end - from));
            on_step(stretch, until, step);
        })?;
        taken.ends.last_mut().into_iter().for_each(|fraction| *fraction = 1.0);
        inputs.after_stretch(stretch, &mut integrator.state);
    }
    Ok(taken)
}

/// A moment just after `until`, s, so that rounding does not delay what is due then.
#[inline]
pub fn reach(until: f64) -> f64 {
    until + 1e-12 * until.abs()
}

/// The sensor's readings for the rows of a record: each shows the gas one delay earlier, but not before the start.
#[derive(Clone, Debug)]
pub struct Readings<'a, R> {
    effects: &'a EffectValues<R>,
    set: EffectSet,
    times: &'a [f64],
    begin: f64,
    delay: R,
    taken: Vec<R>,
}

impl<'a, R: Scalar> Readings<'a, R> {
    /// Readings at `times` (ascending, s) of a record that begins at `begin`, s, none taken yet.
    pub fn new(chamber: &'a Chamber<R>, set: EffectSet, times: &'a [f64], begin: f64) -> Self {
        let delay = chamber.effects.delay(set);
        Self { effects: &chamber.effects, set, times, begin, delay, taken: Vec::with_capacity(times.len()) }
    }

    /// For a stroke recorded late by `lead`, s: relative to that record the gas is ahead.
    pub fn ahead(mut self, lead: R) -> Self {
        self.delay -= lead;
        self
    }

    /// Moment, s, of the gas state shown by the next reading.
    #[inline]
    pub fn next(&self) -> Option<R> {
        let time = *self.times.get(self.taken.len())?;
        Some((R::from(time) - self.delay).max(R::from(self.begin)))
    }

    /// Whether a reading shows the gas at or before `reach`, s.
    #[inline]
    pub fn is_due(&self, reach: f64) -> bool {
        self.next().is_some_and(|shown| shown.value() <= reach)
    }

    /// Takes every reading that shows the gas at or before `reach`, s; `gas` returns its pressure, Pa, at a moment, and the
    /// effects' own states.
    #[inline]
    pub fn take(&mut self, reach: f64, mut gas: impl FnMut(R) -> (R, [R; OWN_STATES])) {
        while let Some(shown) = self.next().filter(|shown| shown.value() <= reach) {
            let (pressure, own) = gas(shown);
            let elapsed = R::from(self.times[self.taken.len()] - self.begin);
            self.taken.push(self.effects.reading(self.set, &own, pressure, elapsed));
        }
    }

    /// Readings taken so far, Pa.
    #[inline]
    pub fn taken(&self) -> &[R] {
        &self.taken
    }

    /// Readings taken so far, Pa, by value.
    pub fn into_taken(self) -> Vec<R> {
        self.taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AreaLaw;
    use crate::balance::{self, Balances, FEW_STATES};
    use crate::papers_chamber::section_31;
    use crate::signals::Signals;
    use crate::simulate::tolerance;

    const PRESSURE_PA: f64 = 2e5;

    /// Energy of the gas after pushes, holds and pulls with a given λ0, with the steps of a mesh, and the steps taken.
    fn energy(coefficient: f64, relative: f64, mesh: &Mesh) -> (f64, Mesh) {
        let mut chamber = section_31(AreaLaw::Total);
        chamber.heat_transfer.coefficient = coefficient;
        let moves: Vec<(f64, f64)> =
            (0..16).map(|k| (0.15 * f64::from(k), [0.1, 0.1, 0.05, 0.05][k as usize % 4])).collect();
        let signals = Signals::closed(&moves, 293.0, 1.013e5);
        let initial = balance::state_at(&chamber, &signals.boundary(0, 0.0), PRESSURE_PA, 293.0);
        let initial: [f64; FEW_STATES] = core::array::from_fn(|i| initial[i]);
        let mut integrator = Integrator::new(0.0, initial, tolerance(relative, &initial));
        let balance = Balances::of(chamber);
        let rates = |_: f64, boundary: &Boundary<f64>, state: &[f64; FEW_STATES]| {
            balance.rates_with_own::<FEW_STATES, { effects::FEW_OWN_STATES }>(EffectSet::NONE, boundary, state)
        };
        let taken = follow(&signals, &mut integrator, 2.25, mesh, rates, |_, _, _| ()).unwrap();
        (integrator.state[balance::ENERGY], taken)
    }

    #[test]
    fn the_same_steps_are_taken_again() {
        let (free, mesh) = energy(26.5, 1e-7, &Mesh::default());
        let (again, same) = energy(26.5, 1e-7, &mesh);
        assert!((again / free - 1.0).abs() < 1e-14, "{again} {free}");
        assert_eq!(same.steps(), mesh.steps());
    }

    #[test]
    fn with_the_steps_kept_the_error_is_smooth_in_the_chambers_numbers() {
        let (_, mesh) = energy(26.5, 1e-8, &Mesh::default());
        let exact = Mesh::default();
        let roughness = |mesh: &Mesh| {
            let coefficients = (0..60).map(|k| 26.5 * 1.005f64.powi(k - 30));
            let errors: Vec<f64> =
                coefficients.map(|c| energy(c, 1e-8, mesh).0 / energy(c, 1e-13, &exact).0 - 1.0).collect();
            errors.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).fold(0.0, f64::max)
        };
        let [free, kept] = [&Mesh::default(), &mesh].map(roughness);
        assert!(kept < 0.1 * free, "{kept:e} {free:e}");
    }

    #[test]
    fn planned_steps_that_err_too_much_are_cut() {
        let (_, coarse) = energy(2.0, 1e-7, &Mesh::default());
        let (exact, _) = energy(2000.0, 1e-11, &Mesh::default());
        let (by_mesh, taken) = energy(2000.0, 1e-7, &coarse);
        assert!((by_mesh / exact - 1.0).abs() < 1e-6, "{by_mesh} {exact}");
        assert!(taken.steps() > 2 * coarse.steps(), "{} {}", taken.steps(), coarse.steps());
    }
}
