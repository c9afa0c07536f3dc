//! A chamber followed along what is imposed on it, and what its sensor shows meanwhile: what all recordings share.
//!
//! A recording brings its [`Inputs`], has [`follow`] integrate along them, and takes the [`Readings`] that fall due
//! while the steps pass by. Time in s, pressure in Pa.

use crate::balance::Boundary;
use crate::effects::{self, EffectSet, EffectValues, OWN_STATES};
use crate::integrate::{IntegrationError, Integrator, Step};
use crate::model::Chamber;
use crate::real::Scalar;

/// What is imposed on a chamber over time, in stretches that follow each other, each of them smooth.
pub trait Inputs<R> {
    /// Where the first stretch begins, s.
    fn begin(&self) -> f64;

    /// Number of stretches, at least one.
    fn stretches(&self) -> usize;

    /// Where a stretch ends, s; the last one never does.
    fn end(&self, stretch: usize) -> f64;

    /// The boundary at `time`, s, on a stretch.
    fn boundary(&self, stretch: usize, time: f64) -> Boundary<R>;

    /// The longest first step on a stretch of this length, s.
    fn first_step(&self, _length: f64) -> f64 {
        f64::INFINITY
    }
}

/// The boundary at `time`, s, whose derivatives (those of a delay) move the position on.
#[inline]
pub fn boundary_at<R: Scalar>(inputs: &impl Inputs<R>, stretch: usize, time: R) -> Boundary<R> {
    let mut boundary = inputs.boundary(stretch, time.value());
    boundary.position += (time - time.value()) * boundary.velocity;
    boundary
}

/// Integrates along the inputs until `last`, s, and hands each accepted step to `on_step` with its stretch and its end, s.
///
/// # Errors
/// Where the state leaves what the equations can follow.
#[inline]
pub fn follow<R: Scalar, const N: usize>(
    inputs: &impl Inputs<R>,
    integrator: &mut Integrator<R, N>,
    last: f64,
    rates: impl Fn(f64, &Boundary<R>, &[R; N]) -> [R; N],
    mut on_step: impl FnMut(usize, f64, &Step<R, N>),
) -> Result<(), IntegrationError> {
    for stretch in 0..inputs.stretches() {
        let end = inputs.end(stretch).min(last);
        if end <= integrator.time {
            continue;
        }
        integrator.step = integrator.step.min(inputs.first_step(end - integrator.time));
        let system = |t: f64, state: &[R; N]| rates(t, &inputs.boundary(stretch, t), state);
        integrator.advance(&system, end, |step| on_step(stretch, step.from + step.length, step))?;
    }
    Ok(())
}

/// A moment just behind `until`, s: what rounding puts there is still due.
#[inline]
pub fn reach(until: f64) -> f64 {
    until + 1e-12 * until.abs()
}

/// The sensor's readings for the rows of a record: each shows the gas of a delay earlier, but not of before the begin.
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
    /// None yet of those at `times` (ascending, s) of a record that begins at `begin`, s.
    pub fn new(chamber: &'a Chamber<R>, set: EffectSet, times: &'a [f64], begin: f64) -> Self {
        let delay = effects::delay(set, &chamber.effects);
        Self { effects: &chamber.effects, set, times, begin, delay, taken: Vec::with_capacity(times.len()) }
    }

    /// Readings of a pressure whose stroke was recorded late by `lead`, s: along that record the gas is ahead.
    pub fn ahead(mut self, lead: R) -> Self {
        self.delay -= lead;
        self
    }

    /// The moment, s, whose gas the next reading shows.
    #[inline]
    pub fn next(&self) -> Option<R> {
        let time = *self.times.get(self.taken.len())?;
        Some((R::from(time) - self.delay).max(R::from(self.begin)))
    }

    /// Whether a reading shows the gas of no later than `reach`, s.
    #[inline]
    pub fn is_due(&self, reach: f64) -> bool {
        self.next().is_some_and(|shown| shown.value() <= reach)
    }

    /// Takes every reading that shows the gas of no later than `reach`, s; `gas` gives its pressure at a moment, Pa, and
    /// the effects' own states.
    #[inline]
    pub fn take(&mut self, reach: f64, mut gas: impl FnMut(R) -> (R, [R; OWN_STATES])) {
        while let Some(shown) = self.next().filter(|shown| shown.value() <= reach) {
            let (pressure, own) = gas(shown);
            let elapsed = R::from(self.times[self.taken.len()] - self.begin);
            self.taken.push(effects::reading(self.set, self.effects, &own, pressure, elapsed));
        }
    }

    /// Those taken so far, Pa.
    #[inline]
    pub fn taken(&self) -> &[R] {
        &self.taken
    }

    /// The same, for good.
    pub fn into_taken(self) -> Vec<R> {
        self.taken
    }
}
