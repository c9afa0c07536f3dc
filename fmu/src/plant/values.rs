//! Indices of inputs, outputs and parameters in their arrays, and parameters as a chamber. SI units.

use chamber::effects::{self, EffectSet, EffectValues, PARAMETERS};
use chamber::real::Real;
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer, paper};

/// Number of inputs.
pub const INPUTS: usize = 14;
/// Indices of the inputs.
#[allow(missing_docs)]
pub mod input {
    pub const POSITION: usize = 0;
    pub const VELOCITY: usize = 1;
    pub const MASS_FLOW_IN: usize = 2;
    pub const TEMPERATURE_IN: usize = 3;
    pub const MASS_FLOW_OUT: usize = 4;
    pub const AMBIENT_TEMPERATURE: usize = 5;
    pub const AMBIENT_PRESSURE: usize = 6;
    pub const WALL_TEMPERATURE: usize = 7;
    /// Pressure, temperature and conductance of the supply port, then those of the exhaust port.
    pub const SUPPLY_PORT: usize = 8;
    pub const EXHAUST_PORT: usize = 11;
}

/// Number of outputs.
pub const OUTPUTS: usize = 18;
/// Indices of the outputs.
#[allow(missing_docs)]
pub mod output {
    pub const PRESSURE: usize = 0;
    pub const MEASURED_PRESSURE: usize = 1;
    pub const TEMPERATURE: usize = 2;
    pub const MASS: usize = 3;
    pub const VOLUME: usize = 4;
    pub const FORCE: usize = 5;
    pub const HEAT_FLOW: usize = 6;
    pub const COEFFICIENT: usize = 7;
    pub const PISTON_POSITION: usize = 8;
    /// Mass and enthalpy flow through the supply port, then those through the exhaust port.
    pub const SUPPLY_PORT: usize = 9;
    pub const EXHAUST_PORT: usize = 11;
    pub const INTERNAL_ENERGY: usize = 13;
    pub const HEAT_RECEIVED: usize = 14;
    pub const WORK_DONE: usize = 15;
    pub const ENTHALPY_RECEIVED: usize = 16;
    pub const MASS_RECEIVED: usize = 17;
}

/// Number of the chamber's own real parameters.
pub const BASE: usize = 13;
/// Number of real parameters, including the effects'.
pub const REALS: usize = BASE + PARAMETERS;
/// Indices of the real parameters; the effects' follow from [`BASE`] in the order of their cards.
#[allow(missing_docs)]
pub mod parameter {
    pub const BORE: usize = 0;
    pub const ROD_DIAMETER: usize = 1;
    pub const DEAD_VOLUME: usize = 2;
    pub const INITIAL_PRESSURE: usize = 3;
    pub const INITIAL_TEMPERATURE: usize = 4;
    pub const STROKE: usize = 5;
    pub const LAMBDA0: usize = 6;
    pub const REFERENCE_PRESSURE: usize = 7;
    pub const REFERENCE_TEMPERATURE: usize = 8;
    pub const SUPPLY_CRITICAL_RATIO: usize = 9;
    pub const EXHAUST_CRITICAL_RATIO: usize = 10;
    pub const GAS_CONSTANT: usize = 11;
    pub const HEAT_CAPACITY_RATIO: usize = 12;
}

/// What moves the piston.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrokeInput {
    /// Both position and velocity; the volume at a communication point follows from the position.
    PositionAndVelocity,
    /// The velocity alone, from the start value of the position.
    Velocity,
}

/// The non-numerical parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choices {
    /// Which volume's lateral area exchanges heat.
    pub area_law: AreaLaw,
    /// What moves the piston.
    pub stroke_input: StrokeInput,
    /// Whether the wall temperature is an input.
    pub external_wall: bool,
}

/// One of the non-numerical parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// [`Choices::area_law`]: 1 total, 2 swept.
    AreaLaw,
    /// [`Choices::stroke_input`]: 1 position and velocity, 2 velocity.
    StrokeInput,
    /// [`Choices::external_wall`]: 0 or 1.
    ExternalWall,
}

impl Choice {
    /// All choices, in the order of their variables.
    pub const ALL: [Choice; 3] = [Choice::AreaLaw, Choice::StrokeInput, Choice::ExternalWall];
}

impl Choices {
    /// The choice as a number.
    pub fn get(&self, choice: Choice) -> i32 {
        match choice {
            Choice::AreaLaw => match self.area_law {
                AreaLaw::Total => 1,
                AreaLaw::Swept => 2,
            },
            Choice::StrokeInput => match self.stroke_input {
                StrokeInput::PositionAndVelocity => 1,
                StrokeInput::Velocity => 2,
            },
            Choice::ExternalWall => i32::from(self.external_wall),
        }
    }

    /// Sets a choice by its number; `None` for an invalid number.
    pub fn with(mut self, choice: Choice, number: i32) -> Option<Self> {
        match (choice, number) {
            (Choice::AreaLaw, 1) => self.area_law = AreaLaw::Total,
            (Choice::AreaLaw, 2) => self.area_law = AreaLaw::Swept,
            (Choice::StrokeInput, 1) => self.stroke_input = StrokeInput::PositionAndVelocity,
            (Choice::StrokeInput, 2) => self.stroke_input = StrokeInput::Velocity,
            (Choice::ExternalWall, 0) => self.external_wall = false,
            (Choice::ExternalWall, 1) => self.external_wall = true,
            _ => return None,
        }
        Some(self)
    }

    /// The effects of a set that may be active: with an external wall temperature, none that sets the wall temperature.
    pub fn admitted(self, set: EffectSet) -> EffectSet {
        if self.external_wall { set.without(effects::OF_WALL) } else { set }
    }
}

/// Values that a host sets once or between steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<R = f64> {
    /// Real parameters, SI units; indices in [`parameter`].
    pub real: [R; REALS],
    /// Parameters that are enumerations or Booleans.
    pub choices: Choices,
}

impl<R: Real> Parameters<R> {
    /// The chamber with these parameters.
    pub fn chamber(&self) -> Chamber<R> {
        let p = &self.real;
        Chamber {
            gas: Gas {
                gas_constant: p[parameter::GAS_CONSTANT],
                heat_capacity_ratio: p[parameter::HEAT_CAPACITY_RATIO],
            },
            geometry: Geometry::new(
                p[parameter::BORE],
                p[parameter::ROD_DIAMETER],
                p[parameter::DEAD_VOLUME],
                self.choices.area_law,
            ),
            heat_transfer: HeatTransfer {
                coefficient: p[parameter::LAMBDA0],
                reference_pressure: p[parameter::REFERENCE_PRESSURE],
                reference_temperature: p[parameter::REFERENCE_TEMPERATURE],
            },
            effects: EffectValues(core::array::from_fn(|i| p[BASE + i])),
        }
    }

    /// Critical pressure ratios of both ports.
    pub fn critical_ratios(&self) -> [R; 2] {
        [self.real[parameter::SUPPLY_CRITICAL_RATIO], self.real[parameter::EXHAUST_CRITICAL_RATIO]]
    }

    /// The same parameters in another number type.
    pub fn lift<S: Real + From<R>>(&self) -> Parameters<S> {
        Parameters { real: self.real.map(S::from), choices: self.choices }
    }
}

/// Start values of all settable variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Starts {
    /// Start values of the parameters, SI units.
    pub parameters: Parameters,
    /// Start values of the inputs, SI units; indices in [`input`].
    pub inputs: [f64; INPUTS],
}

impl Default for Starts {
    /// The reference chamber: a small cylinder (bore 20 mm) at ambient state, with the paper's coefficient.
    fn default() -> Self {
        let mut real = [0.0; REALS];
        real[parameter::BORE] = 0.02;
        real[parameter::DEAD_VOLUME] = 2e-6;
        real[parameter::INITIAL_PRESSURE] = 101_325.0;
        real[parameter::INITIAL_TEMPERATURE] = 293.15;
        real[parameter::LAMBDA0] = 26.5;
        real[parameter::REFERENCE_PRESSURE] = paper::REFERENCE_PRESSURE_PA;
        real[parameter::REFERENCE_TEMPERATURE] = paper::REFERENCE_TEMPERATURE_K;
        real[parameter::SUPPLY_CRITICAL_RATIO] = CRITICAL_RATIO;
        real[parameter::EXHAUST_CRITICAL_RATIO] = CRITICAL_RATIO;
        real[parameter::GAS_CONSTANT] = Gas::AIR.gas_constant;
        real[parameter::HEAT_CAPACITY_RATIO] = Gas::AIR.heat_capacity_ratio;
        real[BASE..].copy_from_slice(&EffectValues::NEUTRAL.0);
        let choices =
            Choices { area_law: AreaLaw::Total, stroke_input: StrokeInput::PositionAndVelocity, external_wall: false };
        Self { parameters: Parameters { real, choices }, inputs: start_inputs(0.1, 293.15, 101_325.0) }
    }
}

/// Default critical pressure ratio of a valve: typical of spool valves, ISO 6358 data sheets.
pub const CRITICAL_RATIO: f64 = 0.3;

/// Start values of the inputs: piston at rest at a position, m, chamber closed, in these surroundings, K and Pa.
pub fn start_inputs(position: f64, ambient_temperature: f64, ambient_pressure: f64) -> [f64; INPUTS] {
    let mut inputs = [0.0; INPUTS];
    inputs[input::POSITION] = position;
    inputs[input::AMBIENT_PRESSURE] = ambient_pressure;
    for index in [input::TEMPERATURE_IN, input::AMBIENT_TEMPERATURE, input::WALL_TEMPERATURE] {
        inputs[index] = ambient_temperature;
    }
    for port in [input::SUPPLY_PORT, input::EXHAUST_PORT] {
        inputs[port] = ambient_pressure;
        inputs[port + 1] = ambient_temperature;
    }
    inputs
}
