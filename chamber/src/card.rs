//! An effect's declaration: the FMU's parameters, the axes of a sweep, the candidates of a diagnosis, the model file's table and
//! a page of the book all derive from its [`Card`].

use crate::gas::Gas;
use crate::geometry::Geometry;
use core::fmt;
use core::ops::RangeInclusive;

/// The balance an effect changes, to which a diagnosis attributes the evidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Balance {
    /// Gas enters or leaves.
    Mass,
    /// Heat flows other than by the paper's law.
    Energy,
    /// The gas fills a volume other than the geometry's.
    Volume,
    /// The gas is as modelled; the pressure reading is wrong.
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

/// Whether an effect's parameters belong to the rig or to one record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scope {
    /// The rig: shared by all its records and valid for further ones.
    Rig,
    /// One record: other records of the rig may have other values.
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
    /// The pressure reading, after the gas.
    Reading,
    /// The stroke record: how the true stroke follows from it. Meaningless where the stroke is the true one, as in an FMU or a
    /// sweep.
    RecordedStroke,
}

/// Where a diagnosis tries an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tried {
    /// From the first round on, alone and combined with others.
    Always,
    /// In later rounds, combined with others: alone it would imitate simpler effects.
    BesideOthers,
    /// Never: only a user puts it into a model.
    Never,
}

/// Whether an effect preserves the closed form of the sealed chamber (see [`exact`](crate::exact)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClosedForm {
    /// Preserved: a constant while the piston is held, a changed integrand in a ramp; du/dt stays linear in u = 1/T.
    Kept,
    /// The gas is unaffected: the reading is a filtered known pressure.
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

/// Prior knowledge of a parameter, in its unit.
#[derive(Clone, Copy, Debug)]
pub enum Prior {
    /// Its bounds only.
    Flat,
    /// A normal distribution.
    Normal(Normal),
    /// A normal distribution that depends on the gas.
    OfGas(fn(&Gas) -> Normal),
}

/// Values of a parameter that a real chamber may have, where theory or experience narrows the bounds. Others can be simulated, but a
/// diagnosis that finds one takes the effect for an imitation of something else.
#[derive(Clone, Copy, Debug)]
pub enum Plausible {
    /// All within the bounds.
    WithinBounds,
    /// Those between two values.
    Between(f64, f64),
    /// Those above a value that depends on the geometry.
    From(fn(&Geometry) -> f64),
}

/// Unit of a parameter or state: a power product of SI base units, from which its names follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Dimensionless: a ratio or an exponent.
    One,
    /// Time, s.
    Second,
    /// Length, m.
    Metre,
    /// Volume, m³.
    CubicMetre,
    /// Absolute temperature, K.
    Kelvin,
    /// Temperature difference, K.
    KelvinDifference,
    /// Absolute pressure, Pa.
    Pascal,
    /// Pressure difference, Pa.
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
    /// Relative change per kelvin, 1/K.
    PerKelvin,
    /// Relative change per square kelvin, 1/K².
    PerSquareKelvin,
    /// One over an effusivity, m² K/(W s^½).
    InverseEffusivity,
    /// Unit that depends on the table, as the effect's words say.
    OfTable,
}

impl Unit {
    /// Key suffix of a number in this unit, empty if it has none, and the unit as people and FMI tools write it.
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

    /// Suffix of a data column or key in this unit, as in `conductance_m3_per_s_pa`; `None` if it has none.
    pub fn suffix(self) -> Option<&'static str> {
        Some(self.names().0).filter(|suffix| !suffix.is_empty())
    }

    /// The unit as people and FMI tools write it.
    pub fn symbol(self) -> &'static str {
        self.names().1
    }
}

/// Meaning of a parameter's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A plain number.
    Number,
    /// One of these words, numbered from one; zero for none.
    Word(&'static [&'static str]),
    /// An entry of a list; parameters of the same name form the list.
    ListEntry {
        /// Its index in the list, from zero.
        index: usize,
        /// Whether each entry must exceed the one before it.
        rising: bool,
    },
}

/// When a fit of an effect frees one of its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fitted {
    /// In every fit.
    Always,
    /// Only if freeing it is decisively better: otherwise it keeps its neutral value.
    Secondary,
    /// Never: a convention, such as a reference length, whose choice another parameter absorbs.
    Never,
}

/// One parameter of an effect.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name without unit, in snake case; all entries of a list share it.
    pub name: &'static str,
    /// Meaning of its number.
    pub kind: Kind,
    /// Unit of its value, bounds and column.
    pub unit: Unit,
    /// Admissible values; others are refused.
    pub bounds: RangeInclusive<f64>,
    /// Values that a real chamber may have.
    pub plausible: Plausible,
    /// The value without effect, which is also the start value.
    pub neutral: f64,
    /// A typical value, used to start and scale a fit; never neutral.
    pub typical: f64,
    /// When a fit of the effect frees it.
    pub fitted: Fitted,
    /// Prior knowledge of it.
    pub prior: Prior,
    /// One-line description for people.
    pub doc: &'static str,
}

impl Parameter {
    /// Defaults for most parameters: fitted, dimensionless, flat prior.
    pub const DEFAULT: Parameter = Parameter {
        name: "",
        kind: Kind::Number,
        unit: Unit::One,
        bounds: f64::NEG_INFINITY..=f64::INFINITY,
        plausible: Plausible::WithinBounds,
        neutral: 0.0,
        typical: 1.0,
        fitted: Fitted::Always,
        prior: Prior::Flat,
        doc: "",
    };

    /// Values that a real chamber of this geometry may have.
    pub fn plausible_values(&self, geometry: &Geometry) -> RangeInclusive<f64> {
        match self.plausible {
            Plausible::WithinBounds => self.bounds.clone(),
            Plausible::Between(low, high) => low..=high,
            Plausible::From(lowest) => lowest(geometry)..=*self.bounds.end(),
        }
    }

    /// The normal prior for a chamber with that gas, if it has one.
    pub fn prior(&self, gas: &Gas) -> Option<Normal> {
        match self.prior {
            Prior::Flat => None,
            Prior::Normal(normal) => Some(normal),
            Prior::OfGas(of) => Some(of(gas)),
        }
    }

    /// Key in files and columns, with the unit's suffix: `conductance_m3_per_s_pa`; for a list entry, `values[1]`.
    pub fn key(&self) -> String {
        match (self.kind, self.unit.suffix()) {
            (Kind::ListEntry { index, .. }, _) => format!("{}[{}]", self.name, index + 1),
            (_, Some(suffix)) => format!("{}_{suffix}", self.name),
            (_, None) => self.name.to_owned(),
        }
    }

    /// Whether it is a single number that a study can vary and a host can set; words and a table's knots form a unit with others.
    pub fn is_variable(&self) -> bool {
        match self.kind {
            Kind::Number => true,
            Kind::Word(_) => false,
            Kind::ListEntry { rising, .. } => !rising,
        }
    }
}

/// An own state: one that an effect integrates.
#[derive(Clone, Debug)]
pub struct OwnState {
    /// Name without unit, snake case.
    pub name: &'static str,
    /// Unit of the state and of its nominal size.
    pub unit: Unit,
    /// Its order of magnitude, which scales its integration error.
    pub nominal: f64,
    /// One-line description for people.
    pub doc: &'static str,
}

/// What an effect declares about itself.
#[derive(Clone, Debug)]
pub struct Card {
    /// Name in files, snake case.
    pub name: &'static str,
    /// One-line description for people.
    pub doc: &'static str,
    /// The equation, one line of plain text.
    pub equation: &'static str,
    /// Source of the law.
    pub source: &'static str,
    /// The balance it changes.
    pub balance: Balance,
    /// Which part of a recorded test it changes.
    pub acts_on: ActsOn,
    /// Whether its parameters belong to the rig or to one record.
    pub scope: Scope,
    /// Whether it preserves the closed form of the sealed chamber.
    pub closed_form: ClosedForm,
    /// Where a diagnosis tries it.
    pub tried: Tried,
    /// Its parameters. The effect is off when all are neutral.
    pub parameters: &'static [Parameter],
    /// Its own states.
    pub states: &'static [OwnState],
    /// Number of list entries in use at these parameters.
    pub length: fn(&[f64]) -> usize,
    /// Checks the parameters jointly; the error is worded as the end of a sentence.
    pub check: fn(&[f64]) -> Result<(), String>,
}

impl Card {
    /// Whether a diagnosis tries it at all.
    pub const fn is_candidate(&self) -> bool {
        !matches!(self.tried, Tried::Never)
    }

    /// Its parameters with this fitting rule, with their indices.
    pub fn fitted(&self, fitted: Fitted) -> impl Iterator<Item = (usize, &'static Parameter)> + use<> {
        self.parameters.iter().enumerate().filter(move |(_, p)| p.fitted == fitted)
    }

    /// Defaults for most effects: they change the gas, belong to the rig, have no own state, leave no closed form, and are tried
    /// in a diagnosis.
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
