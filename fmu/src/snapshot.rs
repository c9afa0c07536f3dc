//! The whole state of a simulation under way: what fmi2GetFMUstate saves and fmi2Reset makes new. Knows the physics, not
//! the protocol.

use crate::inputs::{self, Inputs};
use crate::integration::{self, Gas, Plant};
use crate::present::{self, Present, Sensor};
use crate::record::Record;
use crate::refusal::Refusal;
use crate::variables::{Parameters, REALS, Starts, input, parameter};
use chamber::balance::{self, OWN, STATES};
use chamber::effects::{self, EffectSet};
use chamber::simulate;

/// Relative tolerance of the inner integration where the host announces none: the model description's.
pub const DEFAULT_TOLERANCE: f64 = 1e-8;
/// Tolerances that the integration can keep; the host's is brought into these bounds.
pub const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-13..=1e-2;

/// Phase of the life cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Phase {
    /// After instantiation or reset.
    Instantiated = 0,
    /// In initialization mode.
    Initialization = 1,
    /// Between steps.
    Step = 2,
    /// After fmi2Terminate.
    Terminated = 3,
}

/// What fmi2SetupExperiment announced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// s.
    pub start: f64,
    /// s.
    pub stop: Option<f64>,
    /// Relative.
    pub tolerance: f64,
}

/// The whole state of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Phase of the life cycle.
    pub phase: Phase,
    /// Announced experiment.
    pub experiment: Experiment,
    /// Present time, s.
    pub time: f64,
    /// Parameters as set.
    pub parameters: Parameters,
    /// Inputs as set.
    pub inputs: Inputs,
    /// The gas; of no meaning before the end of initialization.
    pub gas: Gas,
    /// Absolute tolerances of the states, fixed at the end of initialization.
    pub absolute: [f64; STATES],
    /// The sensor's past, where the record is delayed.
    pub record: Option<Record>,
    /// Follows from the parameters.
    pub plant: Plant,
}

impl Snapshot {
    /// As freshly instantiated.
    pub fn new(starts: &Starts) -> Self {
        let experiment = Experiment { start: 0.0, stop: None, tolerance: DEFAULT_TOLERANCE };
        let mut new = Self {
            phase: Phase::Instantiated,
            experiment,
            time: 0.0,
            parameters: starts.parameters,
            inputs: Inputs::new(starts.inputs),
            gas: Gas { states: [0.0; STATES], position: starts.inputs[input::POSITION], inner_step: 0.0 },
            absolute: [0.0; STATES],
            record: None,
            plant: Plant {
                chamber: starts.parameters.chamber(),
                set: EffectSet::NONE,
                tolerance: chamber::integrate::Tolerance { relative: DEFAULT_TOLERANCE, absolute: [0.0; STATES] },
            },
        };
        new.rebuild();
        new
    }

    /// Brings the plant in line with parameters and tolerances.
    pub fn rebuild(&mut self) {
        self.plant.chamber = self.parameters.chamber();
        self.plant.set = self.plant.chamber.active();
        self.plant.tolerance.relative = self.experiment.tolerance;
        self.plant.tolerance.absolute = self.absolute;
    }

    /// Delay of the record, s.
    pub fn delay(&self) -> f64 {
        effects::delay(self.plant.set, &self.plant.chamber.effects)
    }

    /// Checks that the parameters together make a chamber.
    fn checked(&self) -> Result<(), Refusal> {
        let geometry = &self.plant.chamber.geometry;
        if geometry.piston_area <= 0.0 {
            let real = &self.parameters.real;
            return Err(Refusal::NoPistonArea { rod: real[parameter::ROD_DIAMETER], bore: real[parameter::BORE] });
        }
        integration::volume_at(&self.plant.chamber, self.inputs.now[input::POSITION]).map(|_| ())
    }

    /// Ends the initialization: the gas is as the parameters and inputs have it.
    ///
    /// # Errors
    /// When they make no chamber.
    pub fn begin(&mut self) -> Result<(), Refusal> {
        self.checked()?;
        let states = present::initial_states(&self.parameters, &self.plant.chamber, &self.inputs.present());
        self.absolute = simulate::tolerance(1.0, &states).absolute.map(|one| one * self.experiment.tolerance);
        self.gas = Gas { states, position: self.inputs.now[input::POSITION], inner_step: 0.0 };
        self.rebuild();
        self.record = (self.delay() > 0.0).then(|| Record::new(self.reading()));
        Ok(())
    }

    /// What the sensor shows now before delay and drift, Pa.
    fn reading(&self) -> f64 {
        let mut u = self.inputs.present();
        u[input::POSITION] = self.gas.position;
        integration::reading(&self.plant, &inputs::boundary(&u), &self.gas.states)
    }

    /// Takes parameters over between steps. Effects that were off begin in equilibrium with the gas as it is.
    pub fn tune(&mut self, parameters: Parameters) {
        let delayed = self.delay() > 0.0;
        let old = std::mem::replace(&mut self.parameters, parameters);
        self.rebuild();
        self.start_own_states(&old);
        match (delayed, self.delay() > 0.0) {
            (false, true) => self.record = Some(Record::new(self.reading())),
            (true, false) => self.record = None,
            _ => {}
        }
    }

    /// An effect is off while its first parameter is neutral; its states start when it is switched on.
    fn start_own_states(&mut self, old: &Parameters) {
        let mut u = self.inputs.present();
        u[input::POSITION] = self.gas.position;
        let (chamber, states) = (&self.plant.chamber, &mut self.gas.states);
        let at = balance::conditions(chamber, &inputs::boundary(&u), states[0], states[1]);
        let mut fresh = [0.0; effects::OWN_STATES];
        effects::initial(&at, &mut fresh);
        for (index, card) in effects::all() {
            let first = crate::variables::BASE + effects::PARAMETER_OFFSETS[index];
            let neutral = card.parameters[0].neutral;
            if old.real[first] == neutral && self.parameters.real[first] != neutral {
                let own = effects::STATE_OFFSETS[index]..effects::STATE_OFFSETS[index + 1];
                states[OWN..][own.clone()].copy_from_slice(&fresh[own]);
            }
        }
    }

    /// One communication step of `h` seconds. On refusal nothing has changed.
    ///
    /// # Errors
    /// Where no accurate step exists.
    pub fn step(&mut self, h: f64) -> Result<(), Refusal> {
        let (time, delay) = (self.time, self.delay());
        let mark = self.record.as_ref().map(Record::mark);
        let record = self.record.as_mut().map(|record| (record, delay));
        match self.gas.after(&self.plant, &self.inputs, time, h, record) {
            Ok(gas) => {
                self.gas = gas;
                self.inputs = self.inputs.after(h);
                self.inputs.now[input::POSITION] = self.gas.position;
                self.time = time + h;
                if let Some(record) = &mut self.record {
                    record.forget(self.time - delay);
                }
                Ok(())
            }
            Err(refusal) => {
                if let (Some(record), Some(mark)) = (&mut self.record, mark) {
                    record.rewind(&mark);
                }
                Err(refusal)
            }
        }
    }

    /// Outputs, states and rates at the present time.
    ///
    /// # Errors
    /// When the present inputs leave the gas no room.
    pub fn present(&self) -> Result<Present, Refusal> {
        let u = self.inputs.present();
        let boundary = inputs::boundary(&u);
        let Plant { chamber, set, .. } = &self.plant;
        if matches!(self.phase, Phase::Instantiated | Phase::Initialization) {
            self.checked()?;
            let states = present::initial_states(&self.parameters, chamber, &u);
            let sensor = Sensor { elapsed: 0.0, delayed: None };
            return Ok(present::evaluate(chamber, *set, &boundary, &states, &sensor));
        }
        integration::volume_at(chamber, boundary.position)?;
        let mut states = self.gas.states;
        if boundary.position != self.gas.position {
            states = present::jump(chamber, *set, &boundary, &states, self.gas.position)
                .map_err(|e| Refusal::NoStep { step: 0.0, time: self.time, cause: e.to_string() })?;
        }
        let sensor = Sensor {
            elapsed: self.time - self.experiment.start,
            delayed: self.record.as_ref().map(|record| record.at(self.time - self.delay()).0),
        };
        Ok(present::evaluate(chamber, *set, &boundary, &states, &sensor))
    }

    /// Real parameter by place.
    pub fn parameter(&self, index: usize) -> f64 {
        debug_assert!(index < REALS);
        self.parameters.real[index]
    }
}
