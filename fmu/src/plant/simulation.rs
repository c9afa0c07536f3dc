//! A running simulation of either kind: integrated here between communication points, or by the host, which sets time and states.

use super::event_indicators::{self, EVENT_INDICATORS, Piston, Rest, Sides};
use super::fault::Fault;
use super::history::{self, Reading, Record, Stretch};
use super::inputs::{self, Inputs};
use super::motion_source::MotionSource;
use super::port::Around;
use super::rates::{Moment, Present, Sensor};
use super::states::{self, ALL, Origin, TRAVEL};
use super::step::{self, Gas, Plant};
use super::tangent::{self, Here};
use super::values::{BASE, INPUTS, Parameters, Starts, StrokeInput, input, output, parameter};
use chamber::balance::{self, ENERGY, MASS, OWN, STATES};
use chamber::effects::{self, OWN_STATES};
use chamber::integrate::Tolerance;
use chamber::simulate;

/// Default relative tolerance of the inner integration, as in the model description.
pub const DEFAULT_TOLERANCE: f64 = 1e-8;
/// Tolerances that the integration can meet; the host's is clamped to these bounds.
pub const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-13..=1e-2;

/// Which side integrates over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// The host: it sets time and states and requests their rates.
    ModelExchange = 0,
    /// The simulation, from one communication point to the next.
    CoSimulation = 1,
}

/// Experiment settings from the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Start time, s.
    pub start: f64,
    /// Stop time, s; `None` if the host announces none.
    pub stop: Option<f64>,
    /// Relative tolerance of the inner integration, within [`TOLERANCES`].
    pub tolerance: f64,
}

/// State at the last completed step of a host that integrates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Completed {
    /// Sensor reading before delay and drift.
    pub reading: Reading,
    /// Position of the piston, m.
    pub position: f64,
    /// Its speed, m/s.
    pub velocity: f64,
}

/// The whole state of a simulation.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// Model Exchange or co-simulation; fixed for the life of an instance.
    pub kind: Kind,
    /// Whether initialization is over.
    pub started: bool,
    /// Start, stop and tolerance, as announced by the host.
    pub experiment: Experiment,
    /// Present time, s.
    pub time: f64,
    /// Parameters as the host set them, SI units.
    pub parameters: Parameters,
    /// What moves the piston.
    pub motion_source: MotionSource,
    /// Inputs as the host set them, SI units, with their derivatives.
    pub inputs: Inputs,
    /// The gas; meaningless before the end of initialization.
    pub gas: Gas,
    /// Reference values of the sums.
    pub origin: Origin,
    /// Absolute tolerances of the states, fixed at the end of initialization.
    pub absolute: [f64; STATES],
    /// Past sensor readings, if the record is delayed.
    pub record: Option<Record>,
    /// Sides of the kinks at the last event.
    pub sides: Sides,
    /// The host's last completed step of Model Exchange.
    pub completed: Completed,
    /// The chamber derived from parameters and tolerance; see [`Simulation::rebuild`].
    pub plant: Plant,
}

impl Simulation {
    /// A newly instantiated simulation.
    pub fn new(starts: &Starts, kind: Kind) -> Self {
        let tolerance = Tolerance { relative: DEFAULT_TOLERANCE, absolute: [0.0; STATES] };
        let position = starts.inputs[input::POSITION];
        Self {
            kind,
            started: false,
            experiment: Experiment { start: 0.0, stop: None, tolerance: DEFAULT_TOLERANCE },
            time: 0.0,
            parameters: starts.parameters,
            motion_source: MotionSource::Push,
            inputs: Inputs::new(starts.inputs),
            gas: Gas { states: [0.0; ALL], position, inner_step: 0.0, port_flows: None },
            origin: Origin { mass: 0.0, energy: 0.0, position },
            absolute: [0.0; STATES],
            record: None,
            sides: Sides::default(),
            completed: Completed { reading: Reading { time: 0.0, value: 0.0, rate: 0.0 }, position, velocity: 0.0 },
            plant: Plant::new(&starts.parameters, tolerance),
        }
    }

    /// Updates the plant from parameters and tolerances.
    pub fn rebuild(&mut self) {
        let tolerance = Tolerance { relative: self.experiment.tolerance, absolute: self.absolute };
        self.plant = Plant::new(&self.parameters, tolerance);
    }

    /// Delay of the record, s.
    pub fn delay(&self) -> f64 {
        self.plant.balance.chamber.effects.delay(self.plant.set)
    }

    /// Whether the piston is moved by the velocity input alone.
    pub fn is_moved_by_velocity(&self) -> bool {
        self.plant.choices.stroke_input == StrokeInput::Velocity
    }

    /// The piston before its limits: the host's position, or the integral of the velocity since the start.
    pub fn piston(&self) -> Piston {
        let u = self.inputs.present();
        let position = match (self.is_moved_by_velocity() && self.started, self.kind) {
            (false, _) => u[input::POSITION],
            (true, Kind::CoSimulation) => self.gas.position,
            (true, Kind::ModelExchange) => self.origin.position + self.gas.states[TRAVEL],
        };
        Piston { position, velocity: u[input::VELOCITY], limits: self.plant.limits }
    }

    /// Present inputs, with the piston's actual position and speed.
    pub fn here(&self) -> [f64; INPUTS] {
        let mut u = self.inputs.present();
        (u[input::POSITION], u[input::VELOCITY]) = self.actual_motion(&self.piston());
        u
    }

    /// Actual position and speed of the piston.
    fn actual_motion(&self, piston: &Piston) -> (f64, f64) {
        let exchange = self.kind == Kind::ModelExchange && self.is_moved_by_velocity() && self.started;
        match (exchange, self.sides.rest) {
            // The states are the host's: the piston moves on until the event at the end of the stroke is handled.
            (true, Rest::Free) => (piston.position, piston.velocity),
            (true, _) => (piston.position, 0.0),
            (false, _) => piston.limits.apply(piston.position, piston.velocity),
        }
    }

    /// The plant with these inputs.
    pub fn moment(&self, u: &[f64; INPUTS]) -> Moment<'_> {
        let Plant { balance, set, choices, critical_ratios, .. } = &self.plant;
        let around = Around::of(u, choices.external_wall, *critical_ratios);
        Moment { balance, set: *set, boundary: inputs::boundary(u), around }
    }

    /// Checks that the parameters make a consistent chamber.
    fn checked(&self) -> Result<(), Fault> {
        if self.plant.balance.chamber.geometry.piston_area <= 0.0 {
            let real = &self.parameters.real;
            return Err(Fault::NoPistonArea { rod: real[parameter::ROD_DIAMETER], bore: real[parameter::BORE] });
        }
        self.plant.volume_at(self.here()[input::POSITION]).map(|_| ())
    }

    /// Ends the initialization: the gas gets its state from parameters and inputs. On refusal nothing has changed.
    ///
    /// # Errors
    /// If they are inconsistent, or the gas state is not finite.
    pub fn begin(&mut self) -> Result<(), Fault> {
        let before = self.clone();
        let outcome = self.begin_with_gas();
        if outcome.is_err() {
            *self = before;
        }
        outcome
    }

    fn begin_with_gas(&mut self) -> Result<(), Fault> {
        self.checked()?;
        let u = self.here();
        let states = states::initial(&self.parameters, &self.plant.balance.chamber, &inputs::boundary(&u));
        let position = u[input::POSITION];
        self.absolute =
            simulate::tolerance(1.0, &states::of_gas(&states)).absolute.map(|one| one * self.experiment.tolerance);
        self.gas = Gas { states, position, inner_step: 0.0, port_flows: None };
        self.origin = Origin { mass: states[MASS], energy: states[ENERGY], position };
        self.rebuild();
        self.record = (self.delay() > 0.0).then(|| Record::new(self.reading()));
        self.started = true;
        self.sides = Sides::default();
        if self.kind == Kind::ModelExchange {
            self.completed = self.now_completed()?;
            self.settle()?;
        }
        Ok(())
    }

    /// Present sensor reading before delay and drift, Pa.
    fn reading(&self) -> f64 {
        let mut u = self.here();
        if self.kind == Kind::CoSimulation {
            u[input::POSITION] = self.gas.position;
        }
        step::reading(&self.plant, &inputs::boundary(&u), &states::of_gas(&self.gas.states))
    }

    /// Applies parameters between steps. Effects that were off start in equilibrium with the present gas. On refusal nothing has
    /// changed.
    ///
    /// # Errors
    /// If the host's states are impossible for starting them.
    pub fn tune(&mut self, parameters: Parameters) -> Result<(), Fault> {
        let delayed = self.delay() > 0.0;
        let (old, states) = (std::mem::replace(&mut self.parameters, parameters), self.gas.states);
        self.rebuild();
        self.start_own_states(&old);
        let is_delayed = self.delay() > 0.0;
        let first = (is_delayed && !delayed).then(|| self.reading());
        if !self.gas.states.iter().all(|state| state.is_finite()) || !history::can_keep(first.as_slice()) {
            (self.parameters, self.gas.states) = (old, states);
            self.rebuild();
            return Err(self.present().err().unwrap_or(Fault::Overflow));
        }
        match first {
            Some(reading) => self.record = Some(Record::new(reading)),
            None if !is_delayed => self.record = None,
            None => {}
        }
        Ok(())
    }

    /// An effect is off while its first parameter is neutral; its states are initialised when it is switched on.
    fn start_own_states(&mut self, old: &Parameters) {
        let mut u = self.here();
        if self.kind == Kind::CoSimulation {
            u[input::POSITION] = self.gas.position;
        }
        let (chamber, states) = (&self.plant.balance.chamber, &mut self.gas.states);
        let at = balance::conditions(chamber, &inputs::boundary(&u), states[MASS], states[ENERGY]);
        let mut fresh = [0.0; OWN_STATES];
        effects::initial(&at, &mut fresh);
        for (index, card) in effects::all().filter(|(_, card)| !card.states.is_empty()) {
            let first = BASE + effects::PARAMETER_OFFSETS[index];
            let neutral = card.parameters[0].neutral;
            if old.real[first] == neutral && self.parameters.real[first] != neutral {
                let own = effects::STATE_OFFSETS[index]..effects::STATE_OFFSETS[index + 1];
                states[OWN..STATES][own.clone()].copy_from_slice(&fresh[own]);
            }
        }
    }

    /// From now on the host moves the piston. After the default experiment, it rests until the host sets more.
    pub fn hand_over(&mut self) {
        if self.motion_source != MotionSource::Host {
            if self.started {
                self.inputs.set(input::VELOCITY, 0.0);
            }
            self.motion_source = MotionSource::Host;
        }
    }

    /// Sets position and velocity to those of the default experiment at the present time, while it is active.
    pub fn apply_default_motion(&mut self) {
        let elapsed = self.time - self.experiment.start;
        if let Some((position, velocity)) = self.motion_source.stroke(self.origin.position, elapsed) {
            let position = if self.kind == Kind::CoSimulation { self.gas.position } else { position };
            self.inputs.set(input::POSITION, position);
            self.inputs.set(input::VELOCITY, velocity);
        }
    }

    /// Time at which the default experiment changes next, s.
    pub fn default_motion_change(&self) -> Option<f64> {
        self.motion_source.until().map(|until| self.experiment.start + until)
    }

    /// One communication step of `h` seconds. On refusal nothing has changed.
    ///
    /// # Errors
    /// If no accurate step exists.
    pub fn step(&mut self, h: f64) -> Result<(), Fault> {
        if self.motion_source == MotionSource::Host {
            return self.step_with_inputs(h);
        }
        let before = self.clone();
        let outcome = self.step_with_default_motion(h);
        if outcome.is_err() {
            *self = before;
        }
        outcome
    }

    /// A step of the default experiment, split where it changes within the step.
    fn step_with_default_motion(&mut self, h: f64) -> Result<(), Fault> {
        let end = self.time + h;
        if let Some(change) = self.default_motion_change().filter(|change| *change < end) {
            if change > self.time {
                self.apply_default_motion();
                self.step_with_inputs(change - self.time)?;
            }
            self.motion_source = MotionSource::Hold;
        }
        self.apply_default_motion();
        self.step_with_inputs(end - self.time)?;
        self.time = end;
        self.apply_default_motion();
        Ok(())
    }

    fn step_with_inputs(&mut self, h: f64) -> Result<(), Fault> {
        if self.gas.hold(&self.plant, &self.inputs, h) {
            self.inputs.advance(h);
            self.inputs.now[input::POSITION] = self.gas.position;
            self.time += h;
            return Ok(());
        }
        let (time, delay) = (self.time, self.delay());
        let record = self.record.as_mut().map(|record| {
            record.mark();
            (record, delay)
        });
        match self.gas.after(&self.plant, &self.inputs, time, h, record) {
            Ok(gas) => {
                self.gas = gas;
                self.inputs.advance(h);
                self.inputs.now[input::POSITION] = self.gas.position;
                self.time = time + h;
                if let Some(record) = &mut self.record {
                    record.forget(self.time - delay);
                }
                Ok(())
            }
            Err(fault) => {
                if let Some(record) = &mut self.record {
                    record.rewind();
                }
                Err(fault)
            }
        }
    }

    /// Outputs, states and rates at the present time.
    ///
    /// # Errors
    /// If the present inputs leave the gas no room, or the host's states are impossible for a gas.
    pub fn present(&self) -> Result<Present, Fault> {
        let u = self.here();
        let moment = self.moment(&u);
        if !self.started {
            self.checked()?;
            let states = states::initial(&self.parameters, &self.plant.balance.chamber, &moment.boundary);
            let origin = Origin { mass: states[MASS], energy: states[ENERGY], position: u[input::POSITION] };
            return Ok(moment.evaluate(&states, &Sensor { elapsed: 0.0, delayed: None }, &origin));
        }
        let states = self.states_at(&moment)?;
        let sensor = Sensor { elapsed: self.time - self.experiment.start, delayed: self.delayed().map(|d| d.0) };
        let mut present = moment.evaluate(&states, &sensor, &self.origin);
        if let Some(flows) = self.gas.port_flows {
            present.outputs[output::SUPPLY_PORT..][..4].copy_from_slice(&flows);
        }
        if !present.is_finite() {
            return Err(Fault::Overflow);
        }
        Ok(present)
    }

    /// The states at this moment's position: set by a host that integrates; otherwise a jump of the stroke may have to be
    /// applied.
    fn states_at(&self, moment: &Moment<'_>) -> Result<[f64; ALL], Fault> {
        let position = moment.boundary.position;
        self.plant.volume_at(position)?;
        let states = &self.gas.states;
        if !(states[MASS] > 0.0 && states[ENERGY] > 0.0 && states.iter().all(|s| s.is_finite())) {
            return Err(Fault::NoGas { mass: states[MASS], energy: states[ENERGY] });
        }
        if self.kind == Kind::ModelExchange || position == self.gas.position {
            return Ok(*states);
        }
        states::instantaneous_stroke(
            &self.plant.balance.chamber, self.plant.set, &moment.boundary, states, self.gas.position,
        )
        .map_err(|e| Fault::no_stroke(self.time, e))
    }

    /// The sensor's reading one delay earlier, Pa, and its rate, Pa/s, if the record is delayed.
    pub fn delayed(&self) -> Option<(f64, f64)> {
        let record = self.record.as_ref()?;
        let then = self.time - self.delay();
        let last = &self.completed.reading;
        if self.kind == Kind::ModelExchange && then > last.time && self.time > last.time {
            // A step longer than the delay: the reading within it, as far as known.
            return Some(Stretch::between(last, &self.reading_now()).at(then));
        }
        Some(record.at(then))
    }

    /// Present values of [`event_indicators::kink_indicators`].
    fn kink_indicators(&self) -> Result<[f64; EVENT_INDICATORS], Fault> {
        let u = self.here();
        let moment = self.moment(&u);
        let states = match self.started {
            true => self.states_at(&moment)?,
            false => {
                self.checked()?;
                states::initial(&self.parameters, &self.plant.balance.chamber, &moment.boundary)
            }
        };
        Ok(event_indicators::kink_indicators(&moment, &u, &states, &self.piston(), self.sides.rest))
    }

    /// The side of each kink that the chamber is on; `None` where it rests at one, since leaving it is no event.
    ///
    /// # Errors
    /// If the present inputs leave the gas no room.
    pub fn clear_sides(&self) -> Result<[Option<bool>; EVENT_INDICATORS], Fault> {
        Ok(Sides::clear(&self.kink_indicators()?, self.experiment.tolerance))
    }

    /// Whether a kink was crossed between these sides and the present state.
    ///
    /// # Errors
    /// If the present inputs leave the gas no room.
    pub fn has_changed(&self, sides: &[Option<bool>; EVENT_INDICATORS]) -> Result<bool, Fault> {
        let now = self.kink_indicators()?;
        Ok(sides.iter().zip(now).any(|(side, value)| side.is_some_and(|above| above != (value > 0.0))))
    }

    /// The event indicators.
    ///
    /// # Errors
    /// If the present inputs leave the gas no room, or the host's states are impossible for a gas.
    pub fn indicators(&self) -> Result<[f64; EVENT_INDICATORS], Fault> {
        Ok(self.sides.indicators(&self.kink_indicators()?, self.experiment.tolerance))
    }

    /// Handles an event for a host that integrates: applies a jump of the position to the gas, and updates the sides of all
    /// kinks. Returns whether states changed.
    ///
    /// # Errors
    /// If the present inputs leave the gas no room, or the host's states are impossible for a gas.
    pub fn handle_event(&mut self) -> Result<bool, Fault> {
        let before = (self.motion_source, self.inputs.clone(), self.gas.states, self.sides);
        let outcome = self.event();
        if outcome.is_err() {
            (self.motion_source, self.inputs, self.gas.states, self.sides) = before;
        }
        outcome
    }

    fn event(&mut self) -> Result<bool, Fault> {
        let mut changed = false;
        // The host reaches a time event only to within its clock's rounding. Some, such as fmusim, restart the integration only
        // if states have changed: the change of the experiment is reported as that.
        if self.default_motion_change().is_some_and(|change| self.time >= change - 1e-12 * change.abs()) {
            self.motion_source = MotionSource::Hold;
            changed = true;
        }
        self.apply_default_motion();
        if !self.is_moved_by_velocity() {
            let u = self.here();
            let (from, to) = (self.completed.position, u[input::POSITION]);
            if from != to {
                let moment = self.moment(&u);
                self.states_at(&moment)?;
                let after = states::instantaneous_stroke(
                    &self.plant.balance.chamber, self.plant.set, &moment.boundary, &self.gas.states, from,
                )
                .map_err(|e| Fault::no_stroke(self.time, e))?;
                self.gas.states = after;
                changed = true;
            }
        }
        self.settle()?;
        self.completed = self.now_completed()?;
        Ok(changed)
    }

    /// Updates the sides of all kinks, and the piston's rest position.
    fn settle(&mut self) -> Result<(), Fault> {
        if self.is_moved_by_velocity() {
            let piston = self.piston();
            self.sides.settle_rest(&piston);
        }
        let indicators = self.kink_indicators()?;
        self.sides.settle(&indicators);
        Ok(())
    }

    /// Records the start of an event: any change of position until it is handled is a jump.
    ///
    /// # Errors
    /// If the present inputs leave the gas no room, or the host's states are impossible for a gas.
    pub fn enter_event(&mut self) -> Result<(), Fault> {
        self.present()?;
        self.completed = self.now_completed()?;
        Ok(())
    }

    /// Completes a step of a host that integrates: the record stores the sensor's readings within it.
    ///
    /// # Errors
    /// If the present inputs leave the gas no room, or the host's states are impossible for a gas.
    pub fn complete_step(&mut self) -> Result<(), Fault> {
        let u = self.here();
        self.states_at(&self.moment(&u))?;
        let now = self.now_completed()?;
        let (last, delay) = (self.completed.reading, self.delay());
        if let Some(record) = &mut self.record
            && now.reading.time > last.time
        {
            let stretch = Stretch::between(&last, &now.reading);
            if !history::can_keep(&stretch.reading) {
                return Err(Fault::Overflow);
            }
            record.push(stretch, delay);
            record.forget(now.reading.time - delay);
        }
        self.completed = now;
        Ok(())
    }

    /// Present sensor reading before delay and drift, with its rate if a record is kept.
    fn reading_now(&self) -> Reading {
        let rate = if self.record.is_some() { self.reading_rate() } else { 0.0 };
        Reading { time: self.time, value: self.reading(), rate }
    }

    /// Rate of the present reading, Pa/s, for the states of a host that integrates.
    fn reading_rate(&self) -> f64 {
        let Self { parameters, plant, origin, gas, .. } = self;
        let here = Here { parameters, set: plant.set, origin, inputs: self.here() };
        let sensor = Sensor { elapsed: 0.0, delayed: None };
        let rates = self.moment(&here.inputs).evaluate(&gas.states, &sensor, origin).rates;
        tangent::reading_rate(&here, &gas.states, rates)
    }

    /// The present moment as a completed step.
    ///
    /// # Errors
    /// If the host's states give no finite sensor reading.
    fn now_completed(&self) -> Result<Completed, Fault> {
        let (u, reading) = (self.here(), self.reading_now());
        if !history::can_keep(&[reading.value, reading.rate]) {
            return Err(Fault::Overflow);
        }
        Ok(Completed { reading, position: u[input::POSITION], velocity: u[input::VELOCITY] })
    }
}
