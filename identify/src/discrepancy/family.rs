//! The families of missing terms: the balance that lacks a term, and the variable on which it depends.

use chamber::effects::empirical::{self, Term};

/// Variable on which a missing term may depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// Time from the record's start, s.
    Time,
    /// Time since the last move began, s.
    SinceMove,
    /// Pressure of the gas, Pa.
    Pressure,
    /// Temperature of the gas, K.
    Temperature,
    /// T − Tw, K.
    TemperatureDifference,
    /// |T − Tw|, K.
    TemperatureDistance,
    /// Speed of the piston, m/s.
    Speed,
    /// Absolute speed, m/s.
    SpeedAmount,
    /// dP/dt, Pa/s.
    PressureRate,
    /// Position of the piston, m.
    Position,
    /// Power of the gas on the piston P dV/dt, W.
    PistonPower,
    /// Mass of the gas, kg.
    Mass,
}

impl Variable {
    /// Name and unit for reports.
    pub fn name(self) -> (&'static str, &'static str) {
        match self {
            Variable::Time => ("time from the record's start", "s"),
            Variable::SinceMove => ("time since the last move began", "s"),
            Variable::Pressure => ("pressure", "Pa"),
            Variable::Temperature => ("temperature of the gas", "K"),
            Variable::TemperatureDifference => ("temperature difference gas − wall", "K"),
            Variable::TemperatureDistance => ("absolute temperature difference gas − wall", "K"),
            Variable::Speed => ("piston speed", "m/s"),
            Variable::SpeedAmount => ("absolute piston speed", "m/s"),
            Variable::PressureRate => ("rate of pressure", "Pa/s"),
            Variable::Position => ("piston position", "m"),
            Variable::PistonPower => ("power of the gas on the piston", "W"),
            Variable::Mass => ("mass of the gas", "kg"),
        }
    }

    /// The same in a model; `None` where it does not follow from the chamber's state and stroke at one moment.
    pub fn in_model(self) -> Option<empirical::Variable> {
        match self {
            Variable::Pressure => Some(empirical::Variable::Pressure),
            Variable::Temperature => Some(empirical::Variable::Temperature),
            Variable::TemperatureDifference => Some(empirical::Variable::TemperatureDifference),
            Variable::Position => Some(empirical::Variable::Position),
            Variable::Speed => Some(empirical::Variable::Velocity),
            Variable::PistonPower => Some(empirical::Variable::PistonPower),
            Variable::Mass => Some(empirical::Variable::Mass),
            Variable::Time
            | Variable::SinceMove
            | Variable::TemperatureDistance
            | Variable::SpeedAmount
            | Variable::PressureRate => None,
        }
    }
}

/// Description of a missing term for reports.
pub fn quantity(term: Term) -> &'static str {
    match term {
        Term::MassFlow => "missing mass flow into the gas",
        Term::HeatFlow => "missing heat flow into the gas",
        Term::CoefficientShare => "missing share of the heat transfer coefficient",
        Term::VolumeShare => "missing share of the volume",
        Term::Reading => "missing part of the pressure reading",
    }
}

/// The families tried. A volume that depends on position alone would be a matter of geometry, a reading that depends on pressure
/// alone one of calibration; the model of a closed chamber contains neither, so they belong here.
pub const FAMILIES: [(Term, Variable); 19] = [
    (Term::MassFlow, Variable::Time),
    (Term::MassFlow, Variable::Pressure),
    (Term::MassFlow, Variable::PressureRate),
    (Term::HeatFlow, Variable::TemperatureDifference),
    (Term::HeatFlow, Variable::Time),
    (Term::HeatFlow, Variable::Speed),
    (Term::CoefficientShare, Variable::TemperatureDistance),
    (Term::CoefficientShare, Variable::TemperatureDifference),
    (Term::CoefficientShare, Variable::Pressure),
    (Term::CoefficientShare, Variable::Position),
    (Term::CoefficientShare, Variable::SpeedAmount),
    (Term::CoefficientShare, Variable::SinceMove),
    (Term::VolumeShare, Variable::Pressure),
    (Term::VolumeShare, Variable::Position),
    (Term::VolumeShare, Variable::Speed),
    (Term::Reading, Variable::Time),
    (Term::Reading, Variable::Pressure),
    (Term::Reading, Variable::PressureRate),
    (Term::Reading, Variable::SinceMove),
];

/// The families that a model can hold: the term follows from the chamber's state and stroke at the moment, so that it applies to
/// other motions.
pub const CURVES: [(Term, Variable); 15] = [
    (Term::MassFlow, Variable::Pressure),
    (Term::MassFlow, Variable::Mass),
    (Term::HeatFlow, Variable::TemperatureDifference),
    (Term::HeatFlow, Variable::Pressure),
    (Term::HeatFlow, Variable::Position),
    (Term::HeatFlow, Variable::Speed),
    (Term::HeatFlow, Variable::PistonPower),
    (Term::CoefficientShare, Variable::Temperature),
    (Term::CoefficientShare, Variable::TemperatureDifference),
    (Term::CoefficientShare, Variable::Pressure),
    (Term::CoefficientShare, Variable::Position),
    (Term::CoefficientShare, Variable::Speed),
    (Term::VolumeShare, Variable::Pressure),
    (Term::VolumeShare, Variable::Position),
    (Term::Reading, Variable::Pressure),
];
