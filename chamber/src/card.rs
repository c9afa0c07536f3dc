//! What an effect declares about itself, once: from a [`Card`] follow the FMU's parameters, the axes a sweep can vary,
//! the candidates of a diagnosis, the model file's table and a page of the book.

use core::fmt;
use core::ops::RangeInclusive;

/// The balance an effect changes: where a diagnosis says the evidence points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Balance {
    /// Gas enters or leaves.
    Mass,
    /// Heat flows otherwise than by the paper's law.
    Energy,
    /// The gas fills another volume.
    Volume,
    /// The gas is as modelled, the recorded pressure is not the gas's.
    Sensor,
}

impl Balance {
    /// Lower-case name, as in result files.
    pub fn name(self) -> &'static str {
        match self {
            Balance::Mass => "mass",
            Balance::Energy => "energy",
            Balance::Volume => "volume",
            Balance::Sensor => "sensor",
        }
    }
}

impl fmt::Display for Balance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Unit of a parameter or state. A unit is a power product of SI base units; its names follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Dimensionless.
    One,
    /// Seconds.
    Second,
    /// Metres.
    Metre,
    /// Cubic metres.
    CubicMetre,
    /// Kelvin.
    Kelvin,
    /// Pascal.
    Pascal,
    /// Pascal per second.
    PascalPerSecond,
    /// Joule per kelvin.
    JoulePerKelvin,
    /// Watt per kelvin.
    WattPerKelvin,
    /// Sonic conductance of ISO 6358, m³/(s Pa).
    SonicConductance,
    /// (s/m)^0.8: coefficient of a speed to the power 0.8.
    SpeedPower,
}

impl Unit {
    /// The ending of a data column or key with this unit, `None` for a dimensionless one: `conductance_m3_per_s_pa`.
    pub fn suffix(self) -> Option<&'static str> {
        match self {
            Unit::One | Unit::SpeedPower => None,
            Unit::Second => Some("s"),
            Unit::Metre => Some("m"),
            Unit::CubicMetre => Some("m3"),
            Unit::Kelvin => Some("k"),
            Unit::Pascal => Some("pa"),
            Unit::PascalPerSecond => Some("pa_per_s"),
            Unit::JoulePerKelvin => Some("j_per_k"),
            Unit::WattPerKelvin => Some("w_per_k"),
            Unit::SonicConductance => Some("m3_per_s_pa"),
        }
    }

    /// The unit as people and FMI tools write it.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::One => "1",
            Unit::Second => "s",
            Unit::Metre => "m",
            Unit::CubicMetre => "m3",
            Unit::Kelvin => "K",
            Unit::Pascal => "Pa",
            Unit::PascalPerSecond => "Pa/s",
            Unit::JoulePerKelvin => "J/K",
            Unit::WattPerKelvin => "W/K",
            Unit::SonicConductance => "m3/(s.Pa)",
            Unit::SpeedPower => "(s/m)0.8",
        }
    }
}

/// One number of an effect.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name without unit, snake case.
    pub name: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Values that make sense; others are refused.
    pub bounds: RangeInclusive<f64>,
    /// The value at which the parameter changes nothing, and its start value.
    pub neutral: f64,
    /// A typical value, to begin a fit from and to scale it by; never neutral.
    pub typical: f64,
    /// Free in a fit of the effect; a secondary parameter stays at its start unless asked for.
    pub fitted: bool,
    /// One line for people.
    pub doc: &'static str,
}

impl Parameter {
    /// Name as a key of files and columns, with the unit's suffix: `conductance_m3_per_s_pa`.
    pub fn key(&self) -> String {
        match self.unit.suffix() {
            Some(suffix) => format!("{}_{suffix}", self.name),
            None => self.name.to_owned(),
        }
    }
}

/// A state of its own that an effect integrates.
#[derive(Clone, Debug)]
pub struct OwnState {
    /// Name without unit, snake case.
    pub name: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Its order of magnitude, the scale of its integration error.
    pub nominal: f64,
    /// One line for people.
    pub doc: &'static str,
}

/// What an effect declares about itself.
#[derive(Clone, Debug)]
pub struct Card {
    /// Name in files, snake case.
    pub name: &'static str,
    /// One line for people.
    pub doc: &'static str,
    /// The equation, one line of plain text.
    pub equation: &'static str,
    /// Where the form comes from.
    pub source: &'static str,
    /// The balance it changes.
    pub balance: Balance,
    /// Its parameters. The effect is off when each is neutral.
    pub parameters: &'static [Parameter],
    /// Its own states.
    pub states: &'static [OwnState],
}
