//! The model's pressure along one record: the gas by adaptive integration, the sensor's chain behind it in closed form.
//!
//! The same equations as [`chamber::simulate`], arranged for fits: the stroke is the smooth one of [`crate::motion`],
//! only pressures are computed, at the times asked for, and a sensor lag costs no integration steps
//! ([`chamber::effects::sensor_lag::follow`]). Written over the number type, so that dual numbers give exact sensitivities.

use crate::motion::{Motion, Spline};
use chamber::Chamber;
use chamber::balance::{self, Boundary, ENERGY, MASS, STATES};
use chamber::card::Balance;
use chamber::effects::{self, EffectSet, OWN_STATES, sensor_lag};
use chamber::integrate::{Dense, IntegrationError, Integrator};
use chamber::real::Scalar;
use chamber::simulate::{Start, tolerance};
use std::cell::Cell;

/// What the surroundings do along a record.
#[derive(Clone, Debug)]
pub struct Course {
    /// The stroke.
    pub motion: Motion,
    /// Temperature of the surroundings over time, K.
    pub ambient_temperature: Spline,
    /// Pressure of the surroundings, Pa.
    pub ambient_pressure: f64,
    /// Mass flow into the chamber over time, kg/s, if the record has one.
    pub mass_flow: Option<Spline>,
}

impl Course {
    /// The surroundings at time `t`, s, in segment `index`.
    #[inline]
    fn boundary(&self, index: usize, t: f64, near: &Cell<usize>, near_flow: &Cell<usize>) -> Boundary {
        let (position, velocity) = self.motion.segments[index].stroke.at(t, near);
        let (ambient_temperature, _) = self.ambient_temperature.at(t, near_flow);
        let flow = self.mass_flow.as_ref().map_or(0.0, |f| f.at(t, near_flow).0);
        Boundary {
            position,
            velocity,
            mass_flow_in: flow.max(0.0),
            temperature_in: ambient_temperature,
            mass_flow_out: (-flow).max(0.0),
            ambient_temperature,
            ambient_pressure: self.ambient_pressure,
        }
    }
}

/// A further disturbance of the gas, in the integration's number type: what a residual may be the trace of.
pub trait Disturbance<R> {
    /// Mass flow into the gas, kg/s, heat flow into it, W, change of its volume, m³, and the rate of that, m³/s.
    fn at(&self, time: f64) -> [R; 4];
}

/// None.
#[derive(Clone, Copy, Debug)]
pub struct Undisturbed;

impl<R: Scalar> Disturbance<R> for Undisturbed {
    #[inline(always)]
    fn at(&self, _: f64) -> [R; 4] {
        [R::ZERO; 4]
    }
}

/// Evaluations of the balances before a trial of a fit is given up as too stiff: so many, and so many for each row.
const MOST_EVALUATIONS: (usize, usize) = (10_000, 60);

/// Effects that belong to the sensor's chain.
pub fn sensor_effects() -> EffectSet {
    effects::all()
        .filter(|(_, card)| card.balance == Balance::Sensor)
        .fold(EffectSet::NONE, |set, (i, _)| set.union(EffectSet::one(i)))
}

/// The effects of `set` that are not in `other`.
pub fn without(set: EffectSet, other: EffectSet) -> EffectSet {
    set.iter().filter(|&i| !other.has(i)).fold(EffectSet::NONE, |s, i| s.union(EffectSet::one(i)))
}

/// One run of the model along a record.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a, R> {
    /// The chamber.
    pub chamber: &'a Chamber<R>,
    /// The effects that take part.
    pub set: EffectSet,
    /// How it begins.
    pub start: Start<R>,
    /// Stroke and surroundings.
    pub course: &'a Course,
    /// Integration error relative to the states.
    pub relative_tolerance: f64,
}

impl<R: Scalar> Run<'_, R> {
    /// What the sensor shows, Pa, at `times` (ascending, s).
    ///
    /// # Errors
    /// Where the state leaves what the equations can follow.
    pub fn pressures(&self, times: &[f64]) -> Result<Vec<R>, IntegrationError> {
        self.disturbed(times, &Undisturbed, |_, _| ())
    }

    /// The same with a disturbance of the gas; `on_step` is told the states after each step.
    ///
    /// # Errors
    /// Where the state leaves what the equations can follow.
    pub fn disturbed(
        &self,
        times: &[f64],
        disturbance: &impl Disturbance<R>,
        mut on_step: impl FnMut(f64, &[R; STATES]),
    ) -> Result<Vec<R>, IntegrationError> {
        let Run { chamber, set, start, course, relative_tolerance } = *self;
        let Some(&last) = times.last() else { return Ok(Vec::new()) };
        let gas_set = without(set, sensor_effects());
        let (near, near_flow) = (Cell::new(0), Cell::new(0));
        let begin = course.motion.segments[0].from_s;
        let first = course.boundary(0, begin, &near, &near_flow);
        let initial = balance::state_at(chamber, &first.lift(), start.pressure, start.temperature);
        on_step(begin, &initial);
        let mut sensor = Sensor::new(chamber, set, course, times, begin, start.pressure);
        let mut integrator = Integrator::new(begin, initial, tolerance(relative_tolerance, &initial));
        let evaluations = Cell::new(0usize);
        let rows: usize = course.motion.segments.iter().map(|s| s.end - s.first).sum();
        let most_evaluations = MOST_EVALUATIONS.0 + MOST_EVALUATIONS.1 * rows;
        for index in 0..course.motion.segments.len() {
            let end = course.motion.segments[index].to_s.min(last);
            if end <= integrator.time {
                continue;
            }
            // A new part of the stroke begins: the step of the last one means nothing here.
            integrator.step = integrator.step.min(0.02 * (end - integrator.time));
            let system = |t: f64, state: &[R; STATES]| -> [R; STATES] {
                evaluations.set(evaluations.get() + 1);
                if evaluations.get() > most_evaluations {
                    return [R::from(f64::NAN); STATES];
                }
                let boundary = course.boundary(index, t, &near, &near_flow);
                disturbed_rates(gas_set, chamber, &boundary.lift(), state, disturbance.at(t))
            };
            integrator.advance(&system, end, |step| {
                let until = step.from + step.length;
                sensor.pass(index, step.from, until, &step.dense(), disturbance);
                on_step(until, &step.end());
            })?;
        }
        sensor.finish();
        Ok(sensor.readings)
    }
}

/// Rates of the states with a disturbance added; its mass enters or leaves at the gas's temperature.
#[inline(always)]
fn disturbed_rates<R: Scalar>(
    set: EffectSet,
    chamber: &Chamber<R>,
    boundary: &Boundary<R>,
    state: &[R; STATES],
    [mass, heat, volume, volume_rate]: [R; 4],
) -> [R; STATES] {
    let area = chamber.geometry.piston_area;
    let mut moved = *boundary;
    moved.position += volume / area;
    moved.velocity += volume_rate / area;
    let mut rates = balance::rates(set, chamber, &moved, state);
    rates[MASS] += mass;
    rates[ENERGY] += heat + mass * chamber.gas.heat_capacity_ratio * state[ENERGY] / state[MASS];
    rates
}

/// The chain behind the gas: lag, delay, drift, in that order.
struct Sensor<'a, R> {
    chamber: &'a Chamber<R>,
    set: EffectSet,
    course: &'a Course,
    times: &'a [f64],
    begin: f64,
    delay: R,
    lag: Option<R>,
    lagged: R,
    readings: Vec<R>,
    near: Cell<usize>,
}

impl<'a, R: Scalar> Sensor<'a, R> {
    fn new(
        chamber: &'a Chamber<R>,
        set: EffectSet,
        course: &'a Course,
        times: &'a [f64],
        begin: f64,
        pressure: R,
    ) -> Self {
        let lag = effects::find("sensor_lag")
            .filter(|(index, _)| set.has(*index))
            .map(|(index, _)| chamber.effects.of(index)[0])
            .filter(|constant| constant.value() > 0.0);
        let mut sensor = Self {
            chamber,
            set,
            course,
            times,
            begin,
            delay: effects::delay(set, &chamber.effects),
            lag,
            lagged: pressure,
            readings: Vec::with_capacity(times.len()),
            near: Cell::new(0),
        };
        // Before the record the chamber is at rest at its first pressure.
        while sensor.next().is_some_and(|shown| shown.value() <= begin) {
            sensor.push(pressure);
        }
        sensor
    }

    fn next(&self) -> Option<R> {
        self.times.get(self.readings.len()).map(|time| R::from(*time) - self.delay)
    }

    fn push(&mut self, shown: R) {
        let elapsed = R::from(self.times[self.readings.len()] - self.begin);
        let mut own = [R::ZERO; OWN_STATES];
        if let (Some(_), Some((index, _))) = (self.lag, effects::find("sensor_lag")) {
            own[effects::STATE_OFFSETS[index]] = shown;
        }
        self.readings.push(effects::reading(self.set, &self.chamber.effects, &own, shown, elapsed));
    }

    /// Takes every reading due while the gas goes from `from` to `until`, s.
    fn pass(&mut self, index: usize, from: f64, until: f64, dense: &Dense<R, STATES>, extra: &impl Disturbance<R>) {
        let reach = until + 1e-12 * until.abs();
        let pressure = |near: &Cell<usize>, t: R| {
            let at = t.value();
            let (position, velocity) = self.course.motion.segments[index].stroke.at(at, near);
            let [_, _, change, _] = extra.at(at);
            let position = (t - at) * velocity + position;
            let volume = self.chamber.geometry.volume(position) + change;
            (self.chamber.gas.heat_capacity_ratio - 1.0) * dense.at(t)[ENERGY] / volume
        };
        let Some(constant) = self.lag else {
            while let Some(shown) = self.next().filter(|shown| shown.value() <= reach) {
                let value = pressure(&self.near, shown);
                self.push(value);
            }
            return;
        };
        const PIECES: usize = 4;
        let length = (until - from) / PIECES as f64;
        let mut at_begin = pressure(&self.near, R::from(from));
        for piece in 0..PIECES {
            let begin = from + length * piece as f64;
            let end = if piece + 1 == PIECES { until } else { begin + length };
            let middle = pressure(&self.near, R::from(0.5 * (begin + end)));
            let at_end = pressure(&self.near, R::from(end));
            let h = end - begin;
            let rise = at_end - at_begin;
            let bow = middle - at_begin;
            let parabola = [at_begin, (bow * 4.0 - rise) * (1.0 / h), (rise - bow * 2.0) * (2.0 / (h * h))];
            let reach = if piece + 1 == PIECES { reach } else { end };
            while let Some(shown) = self.next().filter(|shown| shown.value() <= reach) {
                let value = sensor_lag::follow(constant, self.lagged, parabola, shown - begin);
                self.push(value);
            }
            self.lagged = sensor_lag::follow(constant, self.lagged, parabola, R::from(h));
            at_begin = at_end;
        }
    }

    /// Rounding may leave the last reading just beyond the end: it is the last one again.
    fn finish(&mut self) {
        while self.readings.len() < self.times.len() {
            let Some(&last) = self.readings.last() else { break };
            self.readings.push(last);
        }
    }
}
