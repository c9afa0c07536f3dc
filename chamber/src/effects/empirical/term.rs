//! The term of an empirical curve: the balance it enters, and its unit.

use super::variable::Variable;
use crate::card;

/// The term; its parameter value is its index in [`Term::ALL`], from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// Heat flow into the gas, W.
    HeatFlow,
    /// Mass flow into the gas, kg/s.
    MassFlow,
    /// Relative change of the heat transfer coefficient.
    CoefficientShare,
    /// Relative change of the gas's volume.
    VolumeShare,
    /// Error of the pressure reading, Pa.
    Reading,
}

impl Term {
    /// All terms, in the order of their words in files.
    pub const ALL: [Self; 5] =
        [Self::HeatFlow, Self::MassFlow, Self::CoefficientShare, Self::VolumeShare, Self::Reading];
    /// Their words in files.
    pub const WORDS: [&'static str; 5] = ["heat_flow", "mass_flow", "coefficient_share", "volume_share", "reading"];

    /// Its word in model files.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }

    /// Unit of the term.
    pub fn unit(self) -> &'static str {
        match self {
            Self::HeatFlow => "W",
            Self::MassFlow => "kg/s",
            Self::CoefficientShare | Self::VolumeShare => "1",
            Self::Reading => "Pa",
        }
    }

    /// The balance it changes.
    pub fn balance(self) -> card::Balance {
        match self {
            Self::MassFlow => card::Balance::Mass,
            Self::HeatFlow | Self::CoefficientShare => card::Balance::Energy,
            Self::VolumeShare => card::Balance::Volume,
            Self::Reading => card::Balance::Sensor,
        }
    }

    /// Whether it can follow this variable.
    pub fn follows(self, variable: Variable) -> bool {
        match self {
            Self::VolumeShare => matches!(variable, Variable::Pressure | Variable::Position),
            Self::Reading => variable == Variable::Pressure,
            _ => true,
        }
    }
}
