//! One column of a trace: how likely it holds a quantity, judging by its name, its unit and its first values.

use crate::statistics::interval;
use crate::trace::{Dialect, Sample, excel};
use crate::units::{CLOCK, Quantity, Unit, VOLT, name_and_unit, says_absolute, says_gauge};

/// The column assigned to a quantity.
#[derive(Clone, Debug)]
pub struct Guessed {
    /// What it holds.
    pub quantity: Quantity,
    /// Its index, from 0.
    pub index: usize,
    /// Its name, or its number where the name is not unique.
    pub name: String,
    /// Unit stated in its name or in the units line, or taken from its values.
    pub unit: &'static Unit,
    /// Whether the unit was inferred from the values.
    pub unit_guessed: bool,
    /// Text in place of a unit that is not recognised.
    pub unknown_unit: Option<String>,
    /// Whether it is in percent of a range that the file does not state.
    pub in_percent: bool,
    /// Whether pressures are relative to the surroundings'.
    pub gauge: bool,
    /// Why the pressure is treated as absolute or gauge.
    pub reference: Reference,
    /// 1 or -1: direction of positions.
    pub sign: f64,
    /// Offset added to positions, m.
    pub offset_m: f64,
}

/// Why a pressure is taken as absolute or gauge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The name, the unit or the units line says so.
    Stated,
    /// The name is the program's own name for an absolute pressure.
    OwnName,
    /// Nothing states it.
    Open,
    /// Many readings are at or below zero.
    Readings,
    /// Many readings are at or below zero although the name is the program's own.
    ReadingsAgainstName,
}

impl Reference {
    /// Remark that tells the user what to check.
    pub fn remark(self) -> Option<&'static str> {
        match self {
            Reference::Stated | Reference::OwnName => None,
            Reference::Open => Some("CHECK: absolute or gauge? the file does not say"),
            Reference::Readings => Some("CHECK: taken as gauge, since many readings are at or below zero"),
            Reference::ReadingsAgainstName => Some(
                "CHECK: taken as gauge, since many readings are at or below zero, although the name is that of absolute pressures",
            ),
        }
    }
}

/// A column's name and first values.
pub struct Described {
    index: usize,
    name: String,
    /// Words of the name without its unit, in lower case.
    words: Vec<String>,
    unit: Option<String>,
    moments: bool,
    numbers: bool,
}

impl Described {
    /// Describes the column at an index.
    pub fn of(dialect: &Dialect, sample: &Sample, index: usize) -> Self {
        let name = dialect.names[index].clone();
        let line = dialect.units.as_ref().and_then(|(_, units)| units.get(index)).filter(|unit| !unit.is_empty());
        let (stem, own) = name_and_unit(&name);
        let suffix = own.and_then(|unit| name[stem.len()..].split_once(unit)).map_or("", |(_, suffix)| suffix);
        Self {
            index,
            words: words(&format!("{stem} {suffix}")),
            unit: line.cloned().or(own.map(str::to_owned)),
            moments: sample.moments.get(index).is_some_and(|moments| *moments),
            numbers: sample.numbers.get(index).is_some_and(|numbers| !numbers.is_empty()),
            name,
        }
    }

    /// Score of how likely it holds a quantity.
    pub fn score(&self, quantity: Quantity) -> i32 {
        if self.moments || !self.numbers {
            return if quantity == Quantity::Time && self.moments { 8 } else { -9 };
        }
        if self.name == quantity.default_name() {
            return 9;
        }
        let of_unit = self.score_of_unit(quantity);
        let of_name = self.score_of_name(quantity, of_unit > 0);
        // A speed or a set value is not the piston's position.
        let other = self
            .begins(&["speed", "veloc", "geschw", "accel", "target", "setp", "soll", "command", "force", "kraft"])
            || self.has(&["set", "cmd", "ref", "demand"]);
        // A supply pressure is used only where there is no other.
        let supply =
            quantity == Quantity::Pressure && self.begins(&["suppl", "versorg", "speise", "tank", "reservoir"]);
        of_unit + of_name - if other { 4 } else { 0 } - if supply { 2 } else { 0 }
    }

    /// Score of its unit for a quantity.
    fn score_of_unit(&self, quantity: Quantity) -> i32 {
        let unit = self.unit.as_deref();
        match unit.map(|unit| quantity.unit_spelled(unit)) {
            Some(Some(unit)) if unit.name == VOLT => 0,
            Some(Some(_)) => 3,
            // A unit of another quantity.
            Some(None) if Quantity::ALL.iter().any(|q| unit.is_some_and(|u| q.unit_spelled(u).is_some())) => -6,
            _ => 0,
        }
    }

    /// Score of its words for a quantity; `is_of_unit`: whether its unit is one of the quantity's.
    fn score_of_name(&self, quantity: Quantity, is_of_unit: bool) -> i32 {
        let temperature = self.begins(&["temp"]) || self.has(&["t", "tamb", "tu", "tgas", "tg"]);
        let ambient = self.begins(&["amb", "room", "umgeb", "raum", "surround"]) || self.has(&["tamb", "tu", "env"]);
        let gas = self.has(&["gas", "air", "luft", "tgas", "tg"]);
        match quantity {
            Quantity::Time if self.begins(&["time", "zeit", "temps", "tiempo", "elapsed"]) => 4,
            Quantity::Time if self.name == "X_Value" => 4,
            Quantity::Time if self.has(&["t", "sec", "seconds", "millis"]) => 2,
            Quantity::Pressure if ambient => -6,
            Quantity::Pressure if self.begins(&["pressure", "druck", "pression", "presion"]) => 4,
            Quantity::Pressure if self.begins(&["absolutdruck", "relativdruck", "überdruck", "ueberdruck"]) => 4,
            Quantity::Pressure if self.begins(&["press"]) => 3,
            Quantity::Pressure if self.has(&["p"]) || self.words.iter().any(|word| is_numbered_p(word)) => 2,
            Quantity::Position if self.begins(&["posi", "displ", "stroke", "hub", "weg", "lvdt", "travel"]) => 4,
            Quantity::Position if self.has(&["pos", "course", "carrera", "distance"]) => 4,
            Quantity::Position if self.begins(&["pot", "kolben", "piston"]) || self.has(&["x", "y", "l"]) => 2,
            Quantity::Position if self.has(&["s"]) && is_of_unit => 2,
            Quantity::AmbientTemperature if ambient && (temperature || is_of_unit) => 4,
            Quantity::GasTemperature if gas && (temperature || is_of_unit) && !ambient => 4,
            Quantity::MassFlow if self.begins(&["mass", "mdot", "flow"]) && is_of_unit => 4,
            // The word temperature alone does not say of what.
            Quantity::AmbientTemperature | Quantity::GasTemperature | Quantity::MassFlow => -9,
            _ => 0,
        }
    }

    /// Whether one of its words is among these.
    fn has(&self, known: &[&str]) -> bool {
        self.words.iter().any(|word| known.contains(&word.as_str()))
    }

    /// Whether one of its words begins with one of these.
    fn begins(&self, known: &[&str]) -> bool {
        self.words.iter().any(|word| known.iter().any(|begin| word.starts_with(begin)))
    }

    /// Text in place of a unit: in the units line, or in the last brackets of the name.
    fn unknown_unit(&self) -> Option<String> {
        const NO_UNITS: [&str; 7] = ["a", "g", "abs", "absolute", "gauge", "rel", "%"];
        let in_brackets = || {
            let open = self.name.rfind(['[', '(', '<'])?;
            self.name[open + 1..].split([']', ')', '>']).next()
        };
        let text = self.unit.as_deref().or_else(in_brackets)?.trim();
        let is_unit = !text.is_empty() && !NO_UNITS.contains(&text.to_lowercase().as_str());
        is_unit.then(|| text.to_owned())
    }

    /// The column as one of this quantity.
    pub fn guessed(&self, quantity: Quantity, dialect: &Dialect, sample: &Sample) -> Guessed {
        let stated = self.unit.as_deref().and_then(|unit| quantity.unit_spelled(unit));
        let by_value = || unit_of_values(quantity, sample.numbers.get(self.index).map_or(&[], Vec::as_slice));
        let clock = || quantity.units().iter().find(|unit| self.moments && unit.name == CLOCK);
        let default = || (self.name == quantity.default_name()).then(|| &quantity.units()[0]);
        let known = clock().or(stated).or_else(default);
        let own_name = dialect.names.iter().filter(|name| **name == self.name).count() == 1 && !self.name.is_empty();
        let gauge_word = ["gauge", "rel", "relative", "relativ", "relativdruck", "ueberdruck", "überdruck"];
        let absolute_word = ["abs", "absolute", "absolut", "absolutdruck"];
        let says = |unit: fn(&str) -> bool, words: &[&str]| {
            self.unit.as_deref().is_some_and(unit) || self.words.iter().any(|word| words.contains(&word.as_str()))
        };
        let gauge = says(says_gauge, &gauge_word) || self.name.contains("(g)");
        // A capital is the letter of a chamber: `p (A)`.
        let absolute = says(says_absolute, &absolute_word) || self.name.contains("(a)");
        let reference = match gauge || absolute {
            true => Reference::Stated,
            false if self.name == quantity.default_name() => Reference::OwnName,
            false => Reference::Open,
        };
        Guessed {
            quantity,
            index: self.index,
            name: if own_name { self.name.clone() } else { format!("column {}", self.index + 1) },
            unit: known.unwrap_or_else(by_value),
            unit_guessed: known.is_none(),
            unknown_unit: if known.is_none() { self.unknown_unit() } else { None },
            in_percent: known.is_none()
                && (self.name.contains('%') || self.unit.as_deref().is_some_and(|unit| unit.contains('%'))),
            gauge: quantity == Quantity::Pressure && gauge,
            reference,
            sign: 1.0,
            offset_m: 0.0,
        }
    }
}

/// `p`, `p1`, `pa`: a pressure's symbol with an index.
fn is_numbered_p(word: &str) -> bool {
    word.strip_prefix('p').is_some_and(|rest| rest.len() <= 1 && rest.chars().all(|c| c.is_ascii_alphanumeric()))
}

/// The unit suggested by the size of the values.
fn unit_of_values(quantity: Quantity, values: &[f64]) -> &'static Unit {
    let size = size(values);
    let name = match quantity {
        Quantity::Time if are_excel_days(values) => "d",
        Quantity::Time if interval(values) >= 1.0 => "ms",
        Quantity::Pressure if size > 2e4 => "Pa",
        Quantity::Pressure if size > 50.0 => "kPa",
        Quantity::Pressure => "bar",
        Quantity::Position if size > 3.0 => "mm",
        Quantity::AmbientTemperature | Quantity::GasTemperature if size < 150.0 => "degC",
        other => other.si_unit(),
    };
    let units = quantity.units();
    units.iter().find(|unit| unit.name == name).unwrap_or(&units[0])
}

/// 95th percentile of the absolute values, which excludes marks of missing readings.
fn size(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.len().checked_sub(1 + sizes.len() / 20).map_or(0.0, |index| sizes[index])
}

fn are_excel_days(values: &[f64]) -> bool {
    matches!(values, [from, .., to] if excel::are_days(*from, *to, values.len()))
}

/// Words in lower case, split at non-alphanumeric characters and before capitals.
fn words(name: &str) -> Vec<String> {
    let (mut all, mut word, mut small_before) = (Vec::new(), String::new(), false);
    for letter in name.chars() {
        if !letter.is_alphanumeric() || (letter.is_uppercase() && small_before) {
            all.push(std::mem::take(&mut word));
        }
        if letter.is_alphanumeric() {
            word.extend(letter.to_lowercase());
        }
        small_before = letter.is_lowercase();
    }
    all.push(word);
    all.retain(|word| !word.is_empty());
    all
}
