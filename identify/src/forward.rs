//! The model's pressure along one record: the gas by adaptive integration, the sensor chain after it in closed form.
//!
//! The same equations as [`chamber::simulate`], arranged for fits: the stroke is the smooth one of [`crate::record::stroke`], the
//! energy is referred to the first volume (`isentrope`), only pressures at the requested times are computed, and a sensor lag
//! costs no integration steps ([`chamber::effects::sensor_lag::follow`]). Generic over the number type, so that dual numbers give
//! exact sensitivities.

use crate::characteristic::Characteristic;
use crate::isentrope::Isentrope;
use crate::rates::{Instructions, Moving, OF_WALL_AND_TURBULENCE, OfAnyGas, OfGas, OfTightGas};
use crate::record::course::Course;
use crate::record::reconstruction::gaps;
use crate::record::reconstruction::true_stroke::{Moment, TrueStroke};
use chamber::Chamber;
use chamber::balance::{self, Balances, Boundary, Contents, ENERGY, FEW_STATES, MASS, OWN, STATES};
use chamber::effects::{self, EffectSet, FEW_OWN_STATES, OWN_STATES, SensorLag, WallHeating, sensor_lag};
use chamber::integrate::{IntegrationError, Integrator, Step};
use chamber::real::{Real, Scalar};
use chamber::record::{self, Inputs, Mesh, Readings};
use chamber::simulate::{Start, tolerance};
use std::cell::Cell;

/// Deviations of ambient temperature and stroke from their recorded or stated values.
#[derive(Clone, Copy, Debug)]
pub struct Correction<R> {
    /// Temperature of the surroundings minus the recorded one, K.
    pub warmer: R,
    /// Initial temperature of a wall that warms minus that of the surroundings, K.
    pub wall_warmer: R,
    /// Factor on recorded positions and speeds.
    pub position_times: R,
    /// Deviation of positions from a straight line, if any.
    pub characteristic: Option<Characteristic<R>>,
    /// Gas temperature behind each gap of the record, relative to that which the stroke assumed in it leads to.
    pub behind_gaps: [R; gaps::MOST],
}

impl<R: Real> Correction<R> {
    /// Everything as recorded.
    pub const NONE: Self = Self {
        warmer: R::ZERO,
        wall_warmer: R::ZERO,
        position_times: R::ONE,
        characteristic: None,
        behind_gaps: [R::ONE; gaps::MOST],
    };
}

/// Maximum rows of a recorded mass flow in one step: the flow changes from row to row.
const ROWS_OF_FLOW: f64 = 8.0;

/// A course being followed, with its true stroke and the last positions in its splines.
struct Passing<'a, R> {
    course: &'a Course,
    chamber: &'a Chamber<R>,
    set: EffectSet,
    stroke: TrueStroke<'a>,
    /// Averaging window and low-pass time constant with which the stroke was recorded, s, minus the values for which `stroke` was
    /// set up: zero except for their derivatives.
    changes: [R; 2],
    correction: Correction<R>,
    near_flow: Cell<usize>,
    /// The last requested stretch and time, s, and the stroke there: the last two stages of a step request the same.
    last: Cell<Option<(usize, f64, Moment)>>,
    /// The longest step along the recorded mass flow, s.
    longest_of_flow: f64,
    /// Stretches that end with a gap.
    gaps: Vec<usize>,
}

impl<'a, R: Scalar> Passing<'a, R> {
    fn new(course: &'a Course, chamber: &'a Chamber<R>, set: EffectSet, correction: Correction<R>) -> Self {
        let numbers = [chamber.effects.stroke_window(set), chamber.effects.stroke_filter(set)];
        let changes = numbers.map(|number| number - number.value());
        let [window_s, filter_s] = numbers.map(|number| number.value().max(0.0));
        let stroke = TrueStroke::new(&course.motion, window_s, filter_s, !changes[0].is_zero());
        let gaps = gaps::of(&course.motion).map(|gap| stroke.stretch_that_ends_at(gap.to_s)).collect();
        let longest_of_flow = course.mass_flow.as_ref().map_or(f64::INFINITY, |_| ROWS_OF_FLOW * course.motion.row_s());
        Self {
            course,
            chamber,
            set,
            stroke,
            changes,
            correction,
            near_flow: Cell::new(0),
            last: Cell::new(None),
            longest_of_flow,
            gaps,
        }
    }

    #[inline]
    fn stroke_at(&self, stretch: usize, time: f64) -> Moment {
        if let Some((_, _, moment)) = self.last.get().filter(|last| (last.0, last.1) == (stretch, time)) {
            return moment;
        }
        let moment = self.stroke.at(stretch, time);
        self.last.set(Some((stretch, time, moment)));
        moment
    }

    /// Position, m, and velocity, m/s, of the piston at a time on a stretch.
    #[inline]
    fn piston(&self, stretch: usize, time: f64) -> [R; 2] {
        let Moment { position: recorded, velocity: speed, by_window, by_filter } = self.stroke_at(stretch, time);
        let (mut position, mut velocity) = (R::from(recorded), R::from(speed));
        for (change, by) in self.changes.into_iter().zip([by_window, by_filter]) {
            position += change * by[0];
            velocity += change * by[1];
        }
        let Correction { position_times, characteristic, .. } = self.correction;
        position = position * position_times;
        velocity = velocity * position_times;
        if let Some([off, slope]) = characteristic.map(|characteristic| characteristic.off(recorded)) {
            position += off;
            velocity += slope * speed;
        }
        [position, velocity]
    }
}

impl<R: Scalar> Inputs<R> for Passing<'_, R> {
    #[inline]
    fn begin(&self) -> f64 {
        self.course.motion.extent().0
    }

    #[inline]
    fn stretches(&self) -> usize {
        self.stroke.stretches()
    }

    #[inline]
    fn end(&self, stretch: usize) -> f64 {
        if stretch + 1 < self.stroke.stretches() { self.stroke.end(stretch) } else { f64::INFINITY }
    }

    #[inline]
    fn boundary(&self, stretch: usize, time: f64) -> Boundary<R> {
        let course = self.course;
        let [position, velocity] = self.piston(stretch, time);
        let (ambient_temperature, _) = course.ambient_temperature.at(time, &self.near_flow);
        let ambient_temperature = self.correction.warmer + ambient_temperature;
        let flow = course.mass_flow.as_ref().map_or(0.0, |f| f.at(time, &self.near_flow).0);
        Boundary {
            position,
            velocity,
            mass_flow_in: R::from(flow.max(0.0)),
            temperature_in: ambient_temperature,
            mass_flow_out: R::from((-flow).max(0.0)),
            ambient_temperature,
            ambient_pressure: R::from(course.ambient_pressure),
        }
    }

    /// Behind a gap, brings the gas to the temperature that is a parameter of the record, by heat from the wall.
    fn after_stretch<const N: usize>(&self, stretch: usize, state: &mut [R; N]) {
        let Some(gap) = self.gaps.iter().position(|gap| *gap == stretch) else { return };
        let balance = Balances::of(*self.chamber);
        let isentrope = Isentrope::through(&balance, &self.boundary(0, self.begin()));
        let boundary = self.boundary(stretch, self.end(stretch));
        let referred = isentrope.at(&balance, &boundary);
        state[ENERGY] = referred.energy(state[ENERGY]);
        let heat = state[ENERGY] * (self.correction.behind_gaps[gap] - R::ONE);
        balance.heat(self.set.without(effects::of_sensor()), &boundary, state, heat);
        state[ENERGY] = referred.referred(state[ENERGY]);
    }

    #[inline]
    fn longest_steps(&self, stretch: usize) -> [f64; 2] {
        self.stroke.longest_steps(stretch).map(|longest| longest.min(self.longest_of_flow))
    }
}

/// A further disturbance of the gas, in the integration's number type: a possible cause of a residual.
pub trait Disturbance<R> {
    /// Mass flow into the gas, kg/s, heat flow into it, W, change of its volume, m³, and the rate of that change, m³/s; `None`
    /// where there is nothing to add.
    fn at(&self, time: f64) -> Option<[R; 4]>;
}

/// No disturbance.
#[derive(Clone, Copy, Debug)]
pub struct Undisturbed;

impl<R: Scalar> Disturbance<R> for Undisturbed {
    #[inline(always)]
    fn at(&self, _: f64) -> Option<[R; 4]> {
        None
    }
}

/// Evaluations of the balances after which a trial of a fit is given up as too stiff: a constant, and a number per row.
const MOST_EVALUATIONS: (usize, usize) = (10_000, 15);

/// The same per step of a reused mesh: parameters that make the model this much stiffer are too far away.
const MOST_BY_MESH: usize = 60;

/// One run of the model along a record.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a, R> {
    /// Gas, geometry, heat transfer and effects' parameters.
    pub chamber: &'a Chamber<R>,
    /// The effects included.
    pub set: EffectSet,
    /// Initial state.
    pub start: Start<R>,
    /// Deviations of ambient temperature and stroke from the course.
    pub correction: Correction<R>,
    /// Stroke and surroundings.
    pub course: &'a Course,
    /// Integration error relative to the states.
    pub relative_tolerance: f64,
}

impl<R: Scalar> Run<'_, R> {
    /// Pressure shown by the sensor, Pa, at `times` (ascending, s).
    ///
    /// # Errors
    /// Where the state leaves the range of the equations.
    pub fn pressures(&self, times: &[f64]) -> Result<Vec<R>, IntegrationError> {
        Ok(self.pressures_along(times, &Mesh::default())?.0)
    }

    /// The same with the steps of `mesh`, as far as it goes; also returns the steps taken.
    ///
    /// # Errors
    /// Where the state leaves the range of the equations.
    pub fn pressures_along(&self, times: &[f64], mesh: &Mesh) -> Result<(Vec<R>, Mesh), IntegrationError> {
        self.along(times, mesh, &Undisturbed, &mut |_, _| ())
    }

    /// The same with a disturbance of the gas; `on_step` receives the time, s, and the mass of gas, kg, after each step.
    ///
    /// # Errors
    /// Where the state leaves the range of the equations.
    pub fn disturbed(
        &self,
        times: &[f64],
        disturbance: &dyn Disturbance<R>,
        mut on_step: impl FnMut(f64, R),
    ) -> Result<Vec<R>, IntegrationError> {
        Ok(self.along(times, &Mesh::default(), disturbance, &mut on_step)?.0)
    }

    fn along(
        &self,
        times: &[f64],
        mesh: &Mesh,
        disturbance: &dyn Disturbance<R>,
        on_step: &mut dyn FnMut(f64, R),
    ) -> Result<(Vec<R>, Mesh), IntegrationError> {
        let is_tight = self.course.mass_flow.is_none();
        if is_tight && OfTightGas::<0>::suits(self.set) {
            self.in_states::<OWN>(OfTightGas::<0>, times, mesh, disturbance, on_step)
        } else if is_tight && OfTightGas::<OF_WALL_AND_TURBULENCE>::suits(self.set) {
            let balances = OfTightGas::<OF_WALL_AND_TURBULENCE>;
            self.in_states::<{ OWN + OF_WALL_AND_TURBULENCE }>(balances, times, mesh, disturbance, on_step)
        } else if balance::moving_states(self.set.without(effects::of_sensor())) <= FEW_STATES {
            self.in_states::<FEW_STATES>(OfAnyGas::<FEW_OWN_STATES>, times, mesh, disturbance, on_step)
        } else {
            self.in_states::<STATES>(OfAnyGas::<OWN_STATES>, times, mesh, disturbance, on_step)
        }
    }

    /// The same with the first `N` states.
    fn in_states<const N: usize>(
        &self,
        balances: impl OfGas<R, N>,
        times: &[f64],
        mesh: &Mesh,
        disturbance: &dyn Disturbance<R>,
        on_step: &mut dyn FnMut(f64, R),
    ) -> Result<(Vec<R>, Mesh), IntegrationError> {
        let Run { chamber, set, start, correction, course, relative_tolerance } = *self;
        let Some(&last) = times.last() else { return Ok(Default::default()) };
        let inputs = &Passing::new(course, chamber, set, correction);
        let begin = inputs.begin();
        let (gas_set, balance) = (set.without(effects::of_sensor()), &Balances::of(*chamber));
        let at_begin = inputs.boundary(0, begin);
        let isentrope = &Isentrope::through(balance, &at_begin);
        let initial = balance.state_at(EffectSet::ALL, &at_begin, start.pressure, start.temperature);
        let mut initial: [R; N] = core::array::from_fn(|i| initial[i]);
        if let Some(wall_temperature) = initial.get_mut(OWN + effects::STATE_OFFSETS[WallHeating::INDEX]) {
            *wall_temperature += correction.wall_warmer;
        }
        on_step(begin, initial[MASS]);
        let mut sensor = Sensor::new(balance, isentrope, set, inputs, times, start.pressure);
        let evaluations = Cell::new(0usize);
        let mut most_evaluations = MOST_EVALUATIONS.0 + MOST_EVALUATIONS.1 * course.motion.rows();
        if mesh.steps() > 0 {
            most_evaluations = most_evaluations.min(MOST_BY_MESH * mesh.steps());
        }
        let instructions = Instructions::new();
        let decays = balance.decays(gas_set, &at_begin, &initial).map(Scalar::value);
        initial[ENERGY] = isentrope.at(balance, &at_begin).referred(initial[ENERGY]);
        let mut integrator =
            Integrator::new(begin, initial, tolerance(relative_tolerance, &initial)).with_decays(decays);
        let rates = |t: f64, boundary: &Boundary<R>, state: &[R; N]| -> [R; N] {
            evaluations.set(evaluations.get() + 1);
            if evaluations.get() > most_evaluations {
                return [R::from(f64::NAN); N];
            }
            let disturbance = disturbance.at(t);
            instructions.rates(Moving { balances, set: gas_set, balance, isentrope, boundary, state, disturbance })
        };
        // A stroke recorded late, relative to the pressure, is followed slightly beyond the last row.
        let late = chamber.effects.stroke_delay(set) - chamber.effects.delay(set);
        let last = last + late.value().max(0.0);
        let taken = record::follow(inputs, &mut integrator, last, mesh, rates, |stretch, until, step| {
            sensor.pass(stretch, until, step, disturbance);
            on_step(until, step.end[MASS]);
        })?;
        Ok((sensor.readings.into_taken(), taken))
    }
}

/// The sensor after the gas: its lag in closed form, delay and drift as for every record.
struct Sensor<'a, R> {
    balance: &'a Balances<R>,
    isentrope: &'a Isentrope,
    set: EffectSet,
    inputs: &'a Passing<'a, R>,
    lag: Option<R>,
    /// Output of the lag; unknown at first for a record that begins in motion.
    lagged: Option<R>,
    readings: Readings<'a, R>,
}

impl<'a, R: Scalar> Sensor<'a, R> {
    /// Before the record the chamber is at rest at its first pressure, or moves as at the record's start, so that a lag has
    /// followed it for a long time.
    fn new(
        balance: &'a Balances<R>,
        isentrope: &'a Isentrope,
        set: EffectSet,
        inputs: &'a Passing<'a, R>,
        times: &'a [f64],
        pressure: R,
    ) -> Self {
        let chamber = &balance.chamber;
        let lag = Some(chamber.effects.lag(set)).filter(|constant| constant.value() > 0.0);
        let behind_lag = set.without(SensorLag::SET);
        let lead = chamber.effects.stroke_delay(set);
        let mut readings = Readings::new(chamber, behind_lag, times, inputs.begin()).ahead(lead);
        let lagged = (lag.is_none() || inputs.course.motion.starts_at_rest()).then_some(pressure);
        if lagged.is_some() {
            readings.take(inputs.begin(), |_| shown(pressure));
        }
        Self { balance, isentrope, set, inputs, lag, lagged, readings }
    }

    /// Takes every reading due in a step that ends at `until`, s.
    fn pass<const N: usize>(&mut self, stretch: usize, until: f64, step: &Step<R, N>, extra: &dyn Disturbance<R>) {
        let reach = record::reach(until);
        if self.lag.is_none() && !self.readings.is_due(reach) {
            return;
        }
        let dense = step.dense();
        let pressure = |t: R| {
            let [position, velocity] = self.inputs.piston(stretch, t.value());
            let mut volume = self.balance.chamber.geometry.volume(record::moved_on(position, velocity, t));
            let state = dense.at(t);
            let energy = state[ENERGY] / self.isentrope.factor(volume, self.balance.expansion);
            if let Some([_, _, change, _]) = extra.at(t.value()) {
                volume += change;
            }
            self.balance.pressure(self.set, &Contents::new(state[MASS], energy, volume))
        };
        let Some(constant) = self.lag else {
            self.readings.take(reach, |t| shown(pressure(t)));
            return;
        };
        const PIECES: usize = 4;
        let length = (until - step.from) / PIECES as f64;
        let mut at_begin = pressure(R::from(step.from));
        for piece in 0..PIECES {
            let begin = step.from + length * piece as f64;
            let end = if piece + 1 == PIECES { until } else { begin + length };
            let middle = pressure(R::from(0.5 * (begin + end)));
            let at_end = pressure(R::from(end));
            let h = end - begin;
            let rise = at_end - at_begin;
            let bow = middle - at_begin;
            let parabola = [at_begin, (bow * 4.0 - rise) * (1.0 / h), (rise - bow * 2.0) * (2.0 / (h * h))];
            // The lag behind a pressure that has always changed at this rate.
            let lagged = self.lagged.unwrap_or_else(|| at_begin - constant * parabola[1]);
            let after = |elapsed: R| sensor_lag::follow(constant, lagged, parabola, elapsed);
            self.readings.take(if piece + 1 == PIECES { reach } else { end }, |t| shown(after(t - begin)));
            self.lagged = Some(after(R::from(h)));
            at_begin = at_end;
        }
    }
}

/// A pressure as input of the rest of the sensor chain, without own states.
fn shown<R: Scalar>(pressure: R) -> (R, [R; OWN_STATES]) {
    (pressure, [R::ZERO; OWN_STATES])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::stroke::{Motion, Spline};
    use chamber::dual::Dual;
    use chamber::{AreaLaw, Gas, Geometry, HeatTransfer};

    fn chamber() -> Chamber {
        let geometry = Geometry::new(0.02, 0.0, 1.57e-6, AreaLaw::Total);
        Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(26.5))
    }

    /// Position, m, in a push with a gentle start and end, at a fraction of its duration.
    fn push(share: f64) -> f64 {
        let u = share.clamp(0.0, 1.0);
        0.1 - 0.05 * (u * u * u * (10.0 - 15.0 * u + 6.0 * u * u))
    }

    /// `rows` rows at 100 Hz of a position, m, over time, s.
    fn recorded(rows: u32, mut position: impl FnMut(f64) -> f64) -> (Vec<f64>, Course) {
        let (times, positions): (Vec<f64>, Vec<f64>) =
            (0..rows).map(|i| f64::from(i) * 0.01).map(|t| (t, position(t))).unzip();
        let course = Course {
            motion: Motion::detect(&times, &positions),
            ambient_temperature: Spline::through(vec![0.0, 6.0], vec![293.0, 293.0], [None, None]),
            ambient_pressure: 1.013e5,
            mass_flow: None,
        };
        (times, course)
    }

    /// Largest relative deviation of the pressures with the first tolerance from those with the second, and the number of steps
    /// with the first.
    fn coarse_from_fine(
        chamber: &Chamber,
        set: EffectSet,
        times: &[f64],
        course: &Course,
        tolerances: [f64; 2],
    ) -> (f64, usize) {
        let start = Start { pressure: 2e5, temperature: 293.0 };
        let [(coarse, mesh), (fine, _)] = tolerances.map(|relative_tolerance| {
            Run { chamber, set, start, correction: Correction::NONE, course, relative_tolerance }
                .pressures_along(times, &Mesh::default())
                .unwrap()
        });
        (coarse.iter().zip(&fine).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max), mesh.steps())
    }

    #[test]
    fn no_step_passes_over_a_push_however_long_the_hold_before_it() {
        let chamber = chamber();
        let mut random = crate::synthetic::Random::new(11);
        for number in 0..60 {
            // A push of few rows, widened by rows of rest beside it, each time at another phase of the rows.
            let (begin, duration) = (3.0 + 0.0021 * f64::from(number), 0.02 + 0.01 * f64::from(number % 4));
            let (times, course) = recorded(600, |t| push((t - begin) / duration) + 2e-6 * random.normal());
            let (off, _) = coarse_from_fine(&chamber, EffectSet::NONE, &times, &course, [3e-7, 1e-11]);
            assert!(off < 1e-3, "{begin} {duration}: {off:e}");
        }
    }

    #[test]
    fn steps_along_a_stroke_recorded_as_an_average_keep_their_tolerance() {
        // Pushes with a gentle start and end and at constant speed, with and without a low-pass after the average.
        let ramp = |share: f64| 0.1 - 0.05 * share.clamp(0.0, 1.0);
        for (position, duration) in [(push as fn(f64) -> f64, 0.2), (push, 0.8), (ramp, 0.3)] {
            let (times, course) = recorded(400, |t| position((t - 0.5) / duration));
            for (window, filter) in [(0.05, 0.0), (0.3, 0.0), (0.05, 0.02)] {
                let mut chamber = chamber();
                let mut set = EffectSet::NONE;
                for (name, values) in [("position_averaging", vec![window]), ("position_delay", vec![0.0, filter])] {
                    let effect = effects::find(name).unwrap().0;
                    chamber.effects.of_mut(effect)[..values.len()].copy_from_slice(&values);
                    set = set.union(EffectSet::one(effect));
                }
                let (off, _) = coarse_from_fine(&chamber, set, &times, &course, [1e-6, 1e-12]);
                assert!(off < 3e-5, "{duration} {window} {filter}: {off:e}");
            }
        }
    }

    #[test]
    fn a_long_hold_takes_few_steps_however_fast_the_gas_meets_what_it_exchanges_heat_with() {
        let (times, course) = recorded(6000, |t| push((t - 0.5) / 0.2));
        // An explicit method would need steps shorter than 0.08, 0.01 and 0.07 s.
        for (name, values) in
            [("wall_conduction", vec![1e-3]), ("gas_zones", vec![0.2, 0.5]), ("decaying_turbulence", vec![2.0, 0.02])]
        {
            let mut chamber = chamber();
            let effect = effects::find(name).unwrap().0;
            chamber.effects.of_mut(effect)[..values.len()].copy_from_slice(&values);
            let (off, steps) = coarse_from_fine(&chamber, EffectSet::one(effect), &times, &course, [3e-7, 1e-11]);
            assert!(off < 3e-6 && steps < 200, "{name}: {off:e} in {steps} steps");
        }
    }

    #[test]
    fn a_lag_is_in_steady_state_at_the_start_of_a_record_that_begins_in_motion() {
        let swing = |t: f64| 0.1 - 0.02 * (1.0 - (std::f64::consts::TAU * 0.5 * t).cos());
        let lag = SensorLag::INDEX;
        let along = |chamber: &Chamber, set: EffectSet, start: Start<f64>, times: &[f64], course: &Course| {
            let correction = Correction::NONE;
            Run { chamber, set, start, correction, course, relative_tolerance: 1e-10 }.pressures(times).unwrap()
        };
        let mut chamber = chamber();
        chamber.effects.of_mut(lag)[0] = 0.02;
        let start = Start { pressure: 2e5, temperature: 293.0 };
        let (times, course) = recorded(600, swing);
        let gas = along(&chamber, EffectSet::NONE, start, &times, &course);
        let whole = along(&chamber, EffectSet::one(lag), start, &times, &course);
        // The same starting at its 130th row.
        const LATER: usize = 130;
        let (times, course) = recorded(470, |t| swing(t + 0.01 * LATER as f64));
        assert!(!course.motion.starts_at_rest());
        let volume = |x: f64| chamber.geometry.volume(x);
        let temperature = 293.0 * gas[LATER] * volume(swing(0.01 * LATER as f64)) / (2e5 * volume(swing(0.0)));
        let start = Start { pressure: gas[LATER], temperature };
        let part = along(&chamber, EffectSet::one(lag), start, &times, &course);
        let off = part.iter().zip(&whole[LATER..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let behind = (gas[LATER] - whole[LATER]).abs();
        assert!(behind > 3e3 && off < 0.06 * behind, "{behind} {off}");
    }

    #[test]
    fn sensitivities_are_those_of_finite_differences() {
        let (times, course) = recorded(300, |t| push((t - 0.5) / 0.2));
        fn along<R: Scalar>(x: [R; 3], course: &Course, times: &[f64]) -> Vec<R> {
            let mut chamber: Chamber<R> = chamber().lift();
            (chamber.heat_transfer.coefficient, chamber.geometry.dead_volume) = (x[0], x[1]);
            let start = Start { pressure: x[2], temperature: R::from(293.0) };
            let (set, correction) = (EffectSet::NONE, Correction::NONE);
            Run { chamber: &chamber, set, start, correction, course, relative_tolerance: 1e-11 }
                .pressures(times)
                .unwrap()
        }
        let at = [26.5, 1.57e-6, 2e5];
        let exact = along::<Dual<3>>(core::array::from_fn(|i| Dual::variable(at[i], i)), &course, &times);
        for i in 0..3 {
            let moved = |by: f64| {
                let x: [f64; 3] = core::array::from_fn(|k| at[k] * if k == i { 1.0 + by } else { 1.0 });
                along(x, &course, &times)
            };
            let (more, less) = (moved(1e-4), moved(-1e-4));
            let differences: Vec<f64> = more.iter().zip(&less).map(|(a, b)| (a - b) / (2e-4 * at[i])).collect();
            let largest = differences.iter().fold(0.0, |a: f64, d| a.max(d.abs()));
            for (k, (difference, exact)) in differences.iter().zip(&exact).enumerate() {
                assert!((difference - exact.tangent[i]).abs() < 1e-5 * largest, "{i} {k}: {difference} {exact:?}");
            }
        }
    }
}
