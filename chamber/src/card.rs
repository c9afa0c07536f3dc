//! What an effect declares about itself, once: from a [`Card`] follow the FMU's parameters, the axes a sweep can vary,
//! the candidates of a diagnosis, the model file's table and a page of the book.

use crate::gas::Gas;
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
    /// Any of them: the effect's parameters say which.
    Any,
}

impl Balance {
    /// Lower-case name, as in result files.
    pub fn name(self) -> &'static str {
        match self {
            Balance::Mass => "mass",
            Balance::Energy => "energy",
            Balance::Volume => "volume",
            Balance::Sensor => "sensor",
            Balance::Any => "any",
        }
    }
}

impl fmt::Display for Balance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What an effect's parameters belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scope {
    /// The rig: all records share them, and they carry over to other records.
    Rig,
    /// One record: another record of the same rig may have other values.
    Record,
}

impl Scope {
    /// Name in results and on pages, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Scope::Rig => "rig",
            Scope::Record => "record",
        }
    }
}

/// Which part of a recorded test an effect changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ActsOn {
    /// The gas itself.
    Gas,
    /// The pressure reading, behind the gas.
    Reading,
    /// The record of the stroke: how the true stroke follows from it. Of no meaning where the stroke is the true one, as
    /// in an FMU or a sweep.
    RecordedStroke,
}

/// Where a diagnosis tries an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tried {
    /// From the first round on, by itself and beside others.
    Always,
    /// In later rounds, beside others: by itself it would imitate simpler effects.
    BesideOthers,
    /// Nowhere: it is in a model only where a user puts it there.
    Never,
}

/// Whether the closed form of the sealed chamber (see [`exact`](crate::exact)) survives an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClosedForm {
    /// With the piston held the effect is a constant, in a ramp a changed integrand: du/dt stays linear in u = 1/T.
    Kept,
    /// The gas is untouched: the reading is a filter of a known pressure.
    Filter,
    /// The equations must be integrated.
    Lost,
}

/// A normal distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal {
    /// Mean, in the parameter's unit.
    pub mean: f64,
    /// Standard deviation, in the parameter's unit.
    pub standard_deviation: f64,
}

/// What is known of a parameter before any measurement, in its unit.
#[derive(Clone, Copy, Debug)]
pub enum Prior {
    /// No more than its bounds.
    Flat,
    /// A normal distribution.
    Normal(Normal),
    /// A normal distribution that follows from the gas.
    OfGas(fn(&Gas) -> Normal),
}

/// Unit of a parameter or state. A unit is a power product of SI base units; its names follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// A ratio or an exponent, without unit.
    One,
    /// Time, s.
    Second,
    /// Length, m.
    Metre,
    /// Volume, m³.
    CubicMetre,
    /// Absolute temperature, K.
    Kelvin,
    /// Kelvin, for a difference of temperatures.
    KelvinDifference,
    /// Absolute pressure, Pa.
    Pascal,
    /// Pascal, for a difference of pressures.
    PascalDifference,
    /// Pascal per second.
    PascalPerSecond,
    /// Joule per kelvin.
    JoulePerKelvin,
    /// Watt per kelvin.
    WattPerKelvin,
    /// Sonic conductance of ISO 6358, m³/(s Pa).
    SonicConductance,
    /// Speed, m/s.
    MetrePerSecond,
    /// Coefficient of a speed, s/m.
    SecondPerMetre,
    /// (s/m)^0.8: coefficient of a speed to the power 0.8.
    SpeedPower,
    /// Area, m².
    SquareMetre,
    /// Relative change for each kelvin, 1/K.
    PerKelvin,
    /// Relative change for the square of each kelvin, 1/K².
    PerSquareKelvin,
    /// One over an effusivity, m² K/(W s^½).
    InverseEffusivity,
    /// Another unit with each table: the effect's words say which.
    OfTable,
}

impl Unit {
    /// How the key of a number with this unit ends, empty without a unit of its own; and the unit as people and FMI tools write it.
    fn names(self) -> (&'static str, &'static str) {
        match self {
            Unit::One => ("", "1"),
            Unit::Second => ("s", "s"),
            Unit::Metre => ("m", "m"),
            Unit::MetrePerSecond => ("m_per_s", "m/s"),
            Unit::SecondPerMetre => ("s_per_m", "s/m"),
            Unit::CubicMetre => ("m3", "m3"),
            Unit::Kelvin | Unit::KelvinDifference => ("k", "K"),
            Unit::Pascal | Unit::PascalDifference => ("pa", "Pa"),
            Unit::PascalPerSecond => ("pa_per_s", "Pa/s"),
            Unit::JoulePerKelvin => ("j_per_k", "J/K"),
            Unit::WattPerKelvin => ("w_per_k", "W/K"),
            Unit::SonicConductance => ("m3_per_s_pa", "m3/(s.Pa)"),
            Unit::SquareMetre => ("m2", "m2"),
            Unit::PerKelvin => ("1_per_k", "1/K"),
            Unit::PerSquareKelvin => ("1_per_k2", "1/K2"),
            Unit::InverseEffusivity => ("m2_k_per_w_s05", "m2.K/(W.s0.5)"),
            Unit::SpeedPower => ("", "(s/m)0.8"),
            Unit::OfTable => ("", ""),
        }
    }

    /// The ending of a data column or key with this unit, `None` for a dimensionless one: `conductance_m3_per_s_pa`.
    pub fn suffix(self) -> Option<&'static str> {
        Some(self.names().0).filter(|suffix| !suffix.is_empty())
    }

    /// The unit as people and FMI tools write it.
    pub fn symbol(self) -> &'static str {
        self.names().1
    }
}

/// What a parameter's number stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number, which stands for itself.
    Number,
    /// One of these words, numbered from one; zero for none.
    Word(&'static [&'static str]),
    /// An entry of the list that is made of the parameters of this name.
    Place {
        /// Its place in the list, from zero.
        index: usize,
        /// Whether each entry must be above the one before it.
        rising: bool,
    },
}

/// When a fit of an effect frees one of its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fitted {
    /// In every fit.
    Always,
    /// Secondary: it keeps its neutral value unless freeing it is decisively better.
    Secondary,
    /// Not at all: a convention, such as a reference length, whose choice another number has in it.
    Never,
}

/// One number of an effect.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name without unit, snake case; all places of a list have the same.
    pub name: &'static str,
    /// What its number stands for.
    pub kind: Kind,
    /// Unit of its number, of its bounds and of its column.
    pub unit: Unit,
    /// Values that make sense; others are refused.
    pub bounds: RangeInclusive<f64>,
    /// The value at which the parameter changes nothing, and its start value.
    pub neutral: f64,
    /// A typical value, to begin a fit from and to scale it by; never neutral.
    pub typical: f64,
    /// When a fit of the effect frees it.
    pub fitted: Fitted,
    /// What is known of it beforehand.
    pub prior: Prior,
    /// One line for people.
    pub doc: &'static str,
}

impl Parameter {
    /// What most parameters have in common: fitted, dimensionless, with a flat prior.
    pub const DEFAULT: Parameter = Parameter {
        name: "",
        kind: Kind::Number,
        unit: Unit::One,
        bounds: f64::NEG_INFINITY..=f64::INFINITY,
        neutral: 0.0,
        typical: 1.0,
        fitted: Fitted::Always,
        prior: Prior::Flat,
        doc: "",
    };

    /// What is known of it beforehand in a chamber with that gas, if more than its bounds.
    pub fn prior(&self, gas: &Gas) -> Option<Normal> {
        match self.prior {
            Prior::Flat => None,
            Prior::Normal(normal) => Some(normal),
            Prior::OfGas(of) => Some(of(gas)),
        }
    }

    /// Name as a key of files and columns, with the unit's suffix: `conductance_m3_per_s_pa`; a place of a list: `values[1]`.
    pub fn key(&self) -> String {
        match (self.kind, self.unit.suffix()) {
            (Kind::Place { index, .. }, _) => format!("{}[{}]", self.name, index + 1),
            (_, Some(suffix)) => format!("{}_{suffix}", self.name),
            (_, None) => self.name.to_owned(),
        }
    }

    /// Whether it is a plain number of its own, that a study can vary or a host can set; words and the knots of a table
    /// belong together.
    pub fn is_variable(&self) -> bool {
        match self.kind {
            Kind::Number => true,
            Kind::Word(_) => false,
            Kind::Place { rising, .. } => !rising,
        }
    }
}

/// A state of its own that an effect integrates.
#[derive(Clone, Debug)]
pub struct OwnState {
    /// Name without unit, snake case.
    pub name: &'static str,
    /// Unit of the state and of its nominal size.
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
    /// Which part of a recorded test it changes.
    pub acts_on: ActsOn,
    /// What its parameters belong to.
    pub scope: Scope,
    /// Whether the closed form of the sealed chamber survives it.
    pub closed_form: ClosedForm,
    /// Where a diagnosis tries it.
    pub tried: Tried,
    /// Its parameters. The effect is off when each is neutral.
    pub parameters: &'static [Parameter],
    /// Its own states.
    pub states: &'static [OwnState],
    /// How many places of its lists are in use at these parameters.
    pub length: fn(&[f64]) -> usize,
    /// What is wrong with these parameters together, as the end of a sentence.
    pub check: fn(&[f64]) -> Result<(), String>,
}

impl Card {
    /// Whether a diagnosis tries it at all.
    pub const fn is_candidate(&self) -> bool {
        !matches!(self.tried, Tried::Never)
    }

    /// Its parameters that a fit frees like that, with their places.
    pub fn fitted(&self, fitted: Fitted) -> impl Iterator<Item = (usize, &'static Parameter)> + use<> {
        self.parameters.iter().enumerate().filter(move |(_, p)| p.fitted == fitted)
    }

    /// What most effects have in common: they change the gas, belong to the rig, have no state of their own, leave no
    /// closed form, and a diagnosis tries them.
    pub const DEFAULT: Card = Card {
        name: "",
        doc: "",
        equation: "",
        source: "",
        balance: Balance::Energy,
        acts_on: ActsOn::Gas,
        scope: Scope::Rig,
        closed_form: ClosedForm::Lost,
        tried: Tried::Always,
        parameters: &[],
        states: &[],
        length: |_| 0,
        check: |_| Ok(()),
    };
}
