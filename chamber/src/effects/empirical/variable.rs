//! The variable of an empirical curve, and its unit.

use crate::parts::Conditions;
use crate::real::Real;

/// The variable; its parameter value is its index in [`Variable::ALL`], from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// Pressure of the gas, Pa.
    Pressure,
    /// Mean temperature of the gas, K.
    Temperature,
    /// Temperature of the gas at the wall less the wall's, K.
    TemperatureDifference,
    /// Position of the piston, m.
    Position,
    /// Velocity of the piston, positive where the chamber grows, m/s.
    Velocity,
    /// Power of the gas on the piston P dV/dt, W, positive where the chamber grows.
    PistonPower,
    /// Mass of the gas, kg.
    Mass,
}

impl Variable {
    /// All variables of a curve, in the order of their words in files.
    pub const ALL: [Self; 7] = [
        Self::Pressure,
        Self::Temperature,
        Self::TemperatureDifference,
        Self::Position,
        Self::Velocity,
        Self::PistonPower,
        Self::Mass,
    ];
    /// Their words in files.
    pub const WORDS: [&'static str; 7] =
        ["pressure", "temperature", "temperature_difference", "position", "velocity", "piston_power", "mass"];

    /// Unit of the knots.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Pressure => "Pa",
            Self::Temperature | Self::TemperatureDifference => "K",
            Self::Position => "m",
            Self::Velocity => "m/s",
            Self::PistonPower => "W",
            Self::Mass => "kg",
        }
    }

    /// Its value, in its unit.
    #[inline(always)]
    pub fn of<R: Real>(self, at: &Conditions<R>) -> R {
        match self {
            Self::Pressure => at.pressure,
            Self::Temperature => at.temperature,
            Self::TemperatureDifference => at.gas_temperature_at_wall - at.wall_temperature,
            Self::Position => at.swept_volume / at.piston_area,
            Self::Velocity => at.velocity,
            Self::PistonPower => at.pressure * at.piston_area * at.velocity,
            Self::Mass => at.mass,
        }
    }
}
