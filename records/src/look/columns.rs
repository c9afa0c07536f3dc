//! Quantity and unit of each column of a trace: from customary names and units lines.
//!
//! What the names leave open is inferred from the values and marked as a guess.

use super::described::{Described, Guessed, Reference};
use crate::error::Error;
use crate::error::trace::{RowProblem, TraceProblem};
use crate::layout::{Column, Layout, Stated};
use crate::limits::STANDARD_ATMOSPHERE_PA;
use crate::statistics::{correlation, extremes};
use crate::trace::{Dialect, Sample, Trace};
use crate::units::Quantity;

/// Offset, m, with which positions of unknown zero are first read.
const FAR_M: f64 = 1e3;

/// Pressures of an open chamber differ from the surroundings' by less than this, Pa.
const NEAR_PA: f64 = 2e4;

/// Column names given by the user.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Name of the time column, if given.
    pub time: Option<String>,
    /// Name of the pressure column, if given.
    pub pressure: Option<String>,
    /// Name of the position column, if given.
    pub position: Option<String>,
}

/// Assignment of columns to quantities.
#[derive(Clone, Debug)]
pub struct Guess {
    /// The quantities found, in the order of [`Quantity::ALL`].
    pub columns: Vec<Guessed>,
    /// Other columns that could hold a quantity, by name.
    pub others: Vec<(Quantity, String)>,
}

impl Guess {
    /// Infers the assignment from the column names, the units line and the first rows.
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
            let free = |index: &usize| columns.iter().all(|column| column.index != *index);
            let indices: Vec<usize> = (0..described.len()).filter(free).collect();
            let score = |index: usize| described[index].score(quantity);
            let likely: Vec<usize> = indices.iter().copied().filter(|index| score(*index) >= 2).collect();
            // The first among equally likely ones.
            let best = likely.iter().copied().rev().max_by_key(|index| score(*index));
            let index = match named {
                Some(name) => dialect.find_column(name).0,
                None => best,
            };
            let Some(index) = index else { continue };
            let rest = likely.iter().filter(|other| **other != index && score(**other) >= 3);
            others.extend(rest.map(|other| (quantity, dialect.names[*other].clone())));
            columns.push(described[index].guessed(quantity, dialect, sample));
        }
        // A column assigned to its own quantity is no alternative for another.
        others.retain(|(_, name)| columns.iter().all(|column| column.name != *name));
        Self { columns, others }
    }

    /// The column of a quantity.
    pub fn of(&self, quantity: Quantity) -> Option<&Guessed> {
        self.columns.iter().find(|column| column.quantity == quantity)
    }

    fn of_mut(&mut self, quantity: Quantity) -> Option<&mut Guessed> {
        self.columns.iter_mut().find(|column| column.quantity == quantity)
    }

    /// Those of time, pressure and position that were not found.
    pub fn missing(&self) -> Vec<Quantity> {
        let needed = [Quantity::Time, Quantity::Pressure, Quantity::Position];
        needed.into_iter().filter(|quantity| self.of(*quantity).is_none()).collect()
    }

    /// The layout for a rig file with this assignment.
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

    /// Adapts the assignment to the reason why a file was refused: a gauge column, or positions with another zero. Returns
    /// whether reading again may help.
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

    /// Treats the pressure as gauge, unless names say otherwise; returns whether that is a change.
    fn takes_for_gauge(&mut self) -> bool {
        match self.of_mut(Quantity::Pressure) {
            Some(pressure) if !pressure.gauge && pressure.reference != Reference::Stated => {
                pressure.gauge = true;
                pressure.reference = match pressure.reference {
                    Reference::OwnName => Reference::ReadingsAgainstName,
                    _ => Reference::Readings,
                };
                true
            }
            _ => false,
        }
    }

    /// Adapts the assignment to a record: readings around zero, a piston that compresses as its position grows, positions with an
    /// arbitrary zero. Returns whether the record must be read again.
    pub fn learns_from_record(&mut self, trace: &Trace) -> bool {
        let is_gauge = |row: &RowProblem| matches!(*row, RowProblem::NotAbsolute { value, .. } if can_be_gauge(value));
        let pressure = trace.pressure_pa.as_deref().unwrap_or_default();
        let below = trace.dropped_rows.iter().filter(|row| is_gauge(&row.reason)).count();
        // At ambient pressure a gauge sensor reads just above zero as often as below; a sensor that drops out does not.
        let just_above = pressure.iter().filter(|pressure| **pressure < NEAR_PA).count();
        let gauge = below > 0 && just_above >= below && self.takes_for_gauge();
        let wrong_way = correlation(&trace.position_m, pressure) > 0.5;
        let (lowest, highest) = extremes(&trace.position_m);
        let Some(position) = self.of_mut(Quantity::Position) else { return gauge };
        if !wrong_way && position.offset_m < FAR_M {
            return gauge;
        }
        // Sensor positions, in metres and with the sensor's own sign.
        let shown = [lowest, highest].map(|x| position.sign * (x - position.offset_m));
        let (low, high) = (shown[0].min(shown[1]), shown[0].max(shown[1]));
        position.sign = if wrong_way { -position.sign } else { position.sign };
        // Mirrored within its range of motion; shifted to start at zero where it would be negative.
        position.offset_m = if position.sign < 0.0 { high + low.max(0.0) } else { -low.min(0.0) };
        true
    }
}

/// Whether a reading that cannot be absolute, Pa, can be gauge: a logger's fault code (-9999) is neither.
fn can_be_gauge(pressure_pa: f64) -> bool {
    pressure_pa + STANDARD_ATMOSPHERE_PA > 0.0
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
    fn gauge_bars_are_known_by_a_letter_behind_a_blank_and_in_german() {
        for pressure in ["Druck (bar g)", "Druck (bar Ü)", "Druck [barü]"] {
            assert_finds(
                &format!("Zeit [s];{pressure};Weg [mm]\n0;1;2\n1;1;2\n"),
                ("Zeit [s]", "s"),
                (pressure, "bar", true),
                ("Weg [mm]", "mm"),
            );
        }
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
