//! Which column of a trace holds what, and in which unit: by what people call them, and by units lines.
//!
//! What the names leave open is taken from the values and said to be a guess.

use crate::error::Error;
use crate::layout::{Column, Layout, Stated};
use crate::limits::STANDARD_ATMOSPHERE_PA;
use crate::statistics::{correlation, extremes, median};
use crate::trace::{Dialect, RowProblem, Sample, Trace, TraceProblem, excel};
use crate::units::{CLOCK, Quantity, Unit, VOLT, name_and_unit, says_absolute, says_gauge};

/// Positions that count from anywhere are first read with so much added, m.
const FAR_M: f64 = 1e3;

/// Columns that the user has named.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Name of the time column, where the user gives it.
    pub time: Option<String>,
    /// Name of the pressure column, where the user gives it.
    pub pressure: Option<String>,
    /// Name of the position column, where the user gives it.
    pub position: Option<String>,
}

/// One quantity's column.
#[derive(Clone, Debug)]
pub struct Guessed {
    /// What it holds.
    pub quantity: Quantity,
    /// Its place, from 0.
    pub place: usize,
    /// Its name, or its number where the name is not its own.
    pub name: String,
    /// Unit that its name or the line of units states.
    pub unit: &'static Unit,
    /// Whether the unit was taken from the values.
    pub unit_guessed: bool,
    /// Whether pressures count from the surroundings'.
    pub gauge: bool,
    /// Whether a pressure's header leaves open from where it counts.
    pub reference_guessed: bool,
    /// 1 or -1: which way positions count.
    pub sign: f64,
    /// What is added to positions, m.
    pub offset_m: f64,
}

/// Which column holds what.
#[derive(Clone, Debug)]
pub struct Guess {
    /// The quantities found, in the order of [`Quantity::ALL`].
    pub columns: Vec<Guessed>,
    /// Names of columns that could be a quantity's as well.
    pub others: Vec<(Quantity, String)>,
}

impl Guess {
    /// From the names of the columns, the units line and the first rows.
    pub fn from_names(dialect: &Dialect, sample: &Sample, stated: &Names) -> Self {
        let described: Vec<Described> = (0..dialect.names.len()).map(|k| Described::of(dialect, sample, k)).collect();
        let (mut columns, mut others) = (Vec::<Guessed>::new(), Vec::new());
        for quantity in Quantity::ALL {
            let named = match quantity {
                Quantity::Time => &stated.time,
                Quantity::Pressure => &stated.pressure,
                Quantity::Position => &stated.position,
                _ => &None,
            };
            let free = |place: &usize| columns.iter().all(|column| column.place != *place);
            let places: Vec<usize> = (0..described.len()).filter(free).collect();
            let score = |place: usize| described[place].score(quantity);
            let likely: Vec<usize> = places.iter().copied().filter(|place| score(*place) >= 2).collect();
            // The first of the most likely.
            let best = likely.iter().copied().rev().max_by_key(|place| score(*place));
            let place = match named {
                Some(name) => dialect.place(name).0,
                None => best,
            };
            let Some(place) = place else { continue };
            let rest = likely.iter().filter(|other| **other != place && score(**other) >= 3);
            others.extend(rest.map(|other| (quantity, dialect.names[*other].clone())));
            columns.push(described[place].guessed(quantity, dialect, sample));
        }
        // A column that found its own quantity is nobody's second choice.
        others.retain(|(_, name)| columns.iter().all(|column| column.name != *name));
        Self { columns, others }
    }

    /// That quantity's column.
    pub fn of(&self, quantity: Quantity) -> Option<&Guessed> {
        self.columns.iter().find(|column| column.quantity == quantity)
    }

    fn of_mut(&mut self, quantity: Quantity) -> Option<&mut Guessed> {
        self.columns.iter_mut().find(|column| column.quantity == quantity)
    }

    /// Which of time, pressure and position are not there.
    pub fn missing(&self) -> Vec<Quantity> {
        let needed = [Quantity::Time, Quantity::Pressure, Quantity::Position];
        needed.into_iter().filter(|quantity| self.of(*quantity).is_none()).collect()
    }

    /// The layout of a rig file that says so.
    pub fn layout(&self) -> Layout {
        let mut layout = Layout::default();
        for column in &self.columns {
            layout.columns[column.quantity as usize] = Column {
                name: column.name.clone(),
                unit: column.unit.name,
                factor: column.sign * column.unit.factor,
                offset: column.unit.offset + column.offset_m + if column.gauge { STANDARD_ATMOSPHERE_PA } else { 0.0 },
                mapped: true,
                gauge: column.gauge,
                stated: Stated::default(),
            };
        }
        layout
    }

    /// Takes in why a file was refused: a gauge column, positions that count from elsewhere. Whether that may help.
    pub fn learns_from(&mut self, error: &Error) -> bool {
        let Error::Trace { problem, .. } = error else { return false };
        let TraceProblem::BadRows { problem, .. } = &**problem else { return false };
        match **problem {
            RowProblem::NotAbsolute { value, .. } => can_be_gauge(value) && self.takes_for_gauge(),
            RowProblem::NegativePosition { .. } => match self.of_mut(Quantity::Position) {
                Some(position) if position.offset_m == 0.0 => {
                    position.offset_m = FAR_M;
                    true
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Takes the pressure to count from the surroundings'; whether it was not taken so before.
    fn takes_for_gauge(&mut self) -> bool {
        match self.of_mut(Quantity::Pressure) {
            Some(pressure) if !pressure.gauge => {
                pressure.gauge = true;
                pressure.reference_guessed = false;
                true
            }
            _ => false,
        }
    }

    /// Takes in a record: readings below vacuum, a piston that compresses as its position grows, positions that count
    /// from anywhere. Whether it has to be read again.
    pub fn learns_from_record(&mut self, trace: &Trace) -> bool {
        let is_gauge = |row: &RowProblem| matches!(*row, RowProblem::NotAbsolute { value, .. } if can_be_gauge(value));
        let gauge = trace.left_out.iter().any(|row| is_gauge(&row.reason)) && self.takes_for_gauge();
        let pressure = trace.pressure_pa.as_deref().unwrap_or_default();
        let wrong_way = correlation(&trace.position_m, pressure) > 0.5;
        let (lowest, highest) = extremes(&trace.position_m);
        let Some(position) = self.of_mut(Quantity::Position) else { return gauge };
        if !wrong_way && position.offset_m < FAR_M {
            return gauge;
        }
        // What the sensor shows, in metres and the way it counts.
        let shown = [lowest, highest].map(|x| position.sign * (x - position.offset_m));
        let (low, high) = (shown[0].min(shown[1]), shown[0].max(shown[1]));
        position.sign = if wrong_way { -position.sign } else { position.sign };
        // Mirrored within where it moves; from zero on where that would be below.
        position.offset_m = if position.sign < 0.0 { high + low.max(0.0) } else { -low.min(0.0) };
        true
    }
}

/// Whether a reading that cannot be absolute, Pa, can be a gauge's: a logger's code for a fault (-9999) is neither.
fn can_be_gauge(pressure_pa: f64) -> bool {
    pressure_pa + STANDARD_ATMOSPHERE_PA > 0.0
}

/// What a column is called and what its first values are.
struct Described {
    place: usize,
    name: String,
    /// Words of the name without its unit, in lower case.
    words: Vec<String>,
    unit: Option<String>,
    moments: bool,
    numbers: bool,
}

impl Described {
    fn of(dialect: &Dialect, sample: &Sample, place: usize) -> Self {
        let name = dialect.names[place].clone();
        let line = dialect.units.as_ref().and_then(|(_, units)| units.get(place)).filter(|unit| !unit.is_empty());
        let (stem, own) = name_and_unit(&name);
        Self {
            place,
            words: words(stem),
            unit: line.cloned().or(own.map(str::to_owned)),
            moments: sample.moments.get(place).is_some_and(|moments| *moments),
            numbers: sample.numbers.get(place).is_some_and(|numbers| !numbers.is_empty()),
            name,
        }
    }

    /// How likely it holds that quantity.
    fn score(&self, quantity: Quantity) -> i32 {
        if self.moments || !self.numbers {
            return if quantity == Quantity::Time && self.moments { 8 } else { -9 };
        }
        if self.name == quantity.default_name() {
            return 9;
        }
        let unit = self.unit.as_deref();
        let of_unit = match unit.map(|unit| quantity.unit_spelled(unit)) {
            Some(Some(unit)) if unit.name == VOLT => 0,
            Some(Some(_)) => 3,
            // Of a unit that another quantity has.
            Some(None) if Quantity::ALL.iter().any(|q| unit.is_some_and(|u| q.unit_spelled(u).is_some())) => -6,
            _ => 0,
        };
        let has = |known: &[&str]| self.words.iter().any(|word| known.contains(&word.as_str()));
        let begins = |known: &[&str]| self.words.iter().any(|word| known.iter().any(|begin| word.starts_with(begin)));
        let temperature = begins(&["temp"]) || has(&["t", "tamb", "tu", "tgas", "tg"]);
        let ambient = begins(&["amb", "room", "umgeb", "raum", "surround"]) || has(&["tamb", "tu", "env"]);
        let gas = has(&["gas", "air", "luft", "tgas", "tg"]);
        let of_name = match quantity {
            Quantity::Time if begins(&["time", "zeit", "temps", "tiempo", "elapsed"]) => 4,
            Quantity::Time if self.name == "X_Value" => 4,
            Quantity::Time if has(&["t", "sec", "seconds", "millis"]) => 2,
            Quantity::Pressure if ambient => -6,
            Quantity::Pressure if begins(&["pressure", "druck", "pression", "presion"]) => 4,
            Quantity::Pressure if begins(&["press"]) => 3,
            Quantity::Pressure if has(&["p"]) || self.words.iter().any(|word| is_numbered_p(word)) => 2,
            Quantity::Position if begins(&["posi", "displ", "stroke", "hub", "weg", "lvdt", "travel"]) => 4,
            Quantity::Position if has(&["pos", "course", "carrera", "distance"]) => 4,
            Quantity::Position if begins(&["pot", "kolben", "piston"]) || has(&["x", "y", "l"]) => 2,
            Quantity::Position if has(&["s"]) && of_unit > 0 => 2,
            Quantity::AmbientTemperature if ambient && (temperature || of_unit > 0) => 4,
            Quantity::GasTemperature if gas && (temperature || of_unit > 0) && !ambient => 4,
            Quantity::MassFlow if begins(&["mass", "mdot", "flow"]) && of_unit > 0 => 4,
            // A temperature says nothing of what it is that of.
            Quantity::AmbientTemperature | Quantity::GasTemperature | Quantity::MassFlow => -9,
            _ => 0,
        };
        // What changes with time is not the piston's position: a speed, a set value.
        let other =
            begins(&["speed", "veloc", "geschw", "accel", "target", "setp", "soll", "command", "force", "kraft"])
                || has(&["set", "cmd", "ref", "demand"]);
        // A pressure of the supply is the chamber's only where there is no other.
        let supply = quantity == Quantity::Pressure && begins(&["suppl", "versorg", "speise", "tank", "reservoir"]);
        of_unit + of_name - if other { 4 } else { 0 } - if supply { 2 } else { 0 }
    }

    fn guessed(&self, quantity: Quantity, dialect: &Dialect, sample: &Sample) -> Guessed {
        let stated = self.unit.as_deref().and_then(|unit| quantity.unit_spelled(unit));
        let by_value = || unit_of_values(quantity, sample.numbers.get(self.place).map_or(&[], Vec::as_slice));
        let clock = || quantity.units().iter().find(|unit| self.moments && unit.name == CLOCK);
        let default = || (self.name == quantity.default_name()).then(|| &quantity.units()[0]);
        let known = clock().or(stated).or_else(default);
        let own_name = dialect.names.iter().filter(|name| **name == self.name).count() == 1 && !self.name.is_empty();
        let gauge_word = ["gauge", "rel", "relative", "ueberdruck", "überdruck"];
        let absolute_word = ["abs", "absolute", "absolut", "absolutdruck"];
        let says = |unit: fn(&str) -> bool, words: &[&str]| {
            self.unit.as_deref().is_some_and(unit) || self.words.iter().any(|word| words.contains(&word.as_str()))
        };
        let gauge = says(says_gauge, &gauge_word);
        let absolute = says(says_absolute, &absolute_word) || self.name == quantity.default_name();
        Guessed {
            quantity,
            place: self.place,
            name: if own_name { self.name.clone() } else { format!("column {}", self.place + 1) },
            unit: known.unwrap_or_else(by_value),
            unit_guessed: known.is_none(),
            gauge: quantity == Quantity::Pressure && gauge,
            reference_guessed: quantity == Quantity::Pressure && !gauge && !absolute,
            sign: 1.0,
            offset_m: 0.0,
        }
    }
}

/// `p`, `p1`, `pa`: a pressure's symbol with a place's.
fn is_numbered_p(word: &str) -> bool {
    word.strip_prefix('p').is_some_and(|rest| rest.len() <= 1 && rest.chars().all(|c| c.is_ascii_alphanumeric()))
}

/// The unit that the values' size speaks for.
fn unit_of_values(quantity: Quantity, values: &[f64]) -> &'static Unit {
    let size = values.iter().map(|value| value.abs()).fold(0.0, f64::max);
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let name = match quantity {
        Quantity::Time if are_excel_days(values) => "d",
        Quantity::Time if median(steps) >= 1.0 => "ms",
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

fn are_excel_days(values: &[f64]) -> bool {
    matches!(values, [from, .., to] if excel::are_days(*from, *to, values.len()))
}

/// Words in lower case, parted where letters are no letters or become capital.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Format;

    fn guess(text: &str) -> Guess {
        let lines: Vec<(usize, String)> = text.lines().enumerate().map(|(i, line)| (i + 1, line.to_owned())).collect();
        let dialect = Dialect::find(&lines, &Format::default(), &[]);
        Guess::from_names(&dialect, &Sample::of(&dialect, &lines), &Names::default())
    }

    #[track_caller]
    fn assert_finds(header: &str, time: (&str, &str), pressure: (&str, &str, bool), position: (&str, &str)) {
        let guess = guess(header);
        let of = |quantity| guess.of(quantity).unwrap_or_else(|| panic!("{header}: no {quantity:?}"));
        let found = |quantity| (of(quantity).name.as_str(), of(quantity).unit.name);
        assert_eq!(found(Quantity::Time), time, "{header}");
        let gauge = of(Quantity::Pressure).gauge;
        assert_eq!((found(Quantity::Pressure), gauge), ((pressure.0, pressure.1), pressure.2), "{header}");
        assert_eq!(found(Quantity::Position), position, "{header}");
    }

    #[test]
    fn columns_are_known_by_what_people_call_them() {
        assert_finds(
            "Time (s),P (bar),Pos (mm)\n0,1,2\n1,1,2\n",
            ("Time (s)", "s"),
            ("P (bar)", "bar", false),
            ("Pos (mm)", "mm"),
        );
        assert_finds("t;s;p\n[ms];[mm];[kPa]\n0;1;2\n1;1;2\n", ("t", "ms"), ("p", "kPa", false), ("s", "mm"));
        assert_finds(
            "Zeit in ms;Druck Kammer A [bar(g)];Weg/mm;Solldruck [bar]\n0;1;2;3\n1;1;2;3\n",
            ("Zeit in ms", "ms"),
            ("Druck Kammer A [bar(g)]", "bar", true),
            ("Weg/mm", "mm"),
        );
        assert_finds(
            "#time(s),Pos(in),Spd(in/s),LowerHydPress(psig),LowerSpringPressure(psia)\n0 1 2 3 4\n1 1 2 3 4\n",
            ("time(s)", "s"),
            ("LowerSpringPressure(psia)", "psi", false),
            ("Pos(in)", "in"),
        );
        assert_finds(
            "X_Value\tPressure\tPosition\tComment\n0.0\t1.5\t100\n0.1\t1.5\t100\n",
            ("X_Value", "s"),
            ("Pressure", "bar", false),
            ("Position", "mm"),
        );
        assert_finds(
            "Timestamp,chamber_pressure_kPa,stroke_cm,T_amb_C\n2026-11-22T12:00:00Z,1,2,20\n2026-11-22T12:00:01Z,1,2,20\n",
            ("Timestamp", "clock"),
            ("chamber_pressure_kPa", "kPa", false),
            ("stroke_cm", "cm"),
        );
    }

    #[test]
    fn the_chamber_s_pressure_and_the_measured_position_come_before_those_of_the_supply_and_the_set_point() {
        assert_finds(
            "Time (s),p_supply [bar],p_A [bar],x_set [mm],x_ist [mm]\n0,7,1,80,150\n1,7,1,80,150\n",
            ("Time (s)", "s"),
            ("p_A [bar]", "bar", false),
            ("x_ist [mm]", "mm"),
        );
        assert_finds(
            "t [s],p_supply [bar],x [mm]\n0,7,1\n1,7,1\n",
            ("t [s]", "s"),
            ("p_supply [bar]", "bar", false),
            ("x [mm]", "mm"),
        );
    }

    #[test]
    fn a_code_for_a_fault_does_not_make_a_gauge_pressure_of_the_readings() {
        assert!(can_be_gauge(-200.0) && can_be_gauge(-9e4));
        assert!(!can_be_gauge(-9999e5) && !can_be_gauge(-9999e3));
    }

    #[test]
    fn the_program_s_own_names_are_known_with_their_units() {
        let guess = guess("time_s,pressure_pa,position_m,ambient_temperature_k\n0,1,2,293\n1,1,2,293\n");
        assert_eq!(guess.columns.len(), 4);
        assert!(
            guess.columns.iter().all(|column| column.name == column.quantity.default_name() && !column.unit_guessed)
        );
    }

    #[test]
    fn units_that_only_values_tell_are_guesses_and_what_no_name_tells_is_not_guessed() {
        let guess1 = guess("t,p,x\n0,101325,0.1\n1,101325,0.1\n");
        assert!(guess1.columns.iter().all(|column| column.unit_guessed));
        let guess2 = guess("a,b,c\n0,1,2\n1,1,2\n");
        assert!(guess2.columns.is_empty() && guess2.missing().len() == 3);
    }
}
