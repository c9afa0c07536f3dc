//! How a trace file is laid out: which column holds which quantity, in which unit, and what separates columns.
//! The `[columns]` and `[format]` tables of a rig file.

use crate::error::Error;
use crate::key::{Bounds, KeyProblem};
use crate::table::Table;

/// What a column of a trace can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Time.
    Time,
    /// Pressure in the chamber.
    Pressure,
    /// Position of the piston face.
    Position,
    /// Temperature of the surroundings.
    AmbientTemperature,
    /// Temperature of the gas.
    GasTemperature,
    /// Mass flow into the chamber.
    MassFlow,
}

/// A unit: its name, and the factor and offset that turn a number of it into SI.
type UnitRow = (&'static str, (f64, f64));

impl Quantity {
    /// All of them.
    pub const ALL: [Quantity; 6] = [
        Quantity::Time,
        Quantity::Pressure,
        Quantity::Position,
        Quantity::AmbientTemperature,
        Quantity::GasTemperature,
        Quantity::MassFlow,
    ];

    /// Its key in `[columns]`.
    pub fn key(self) -> &'static str {
        match self {
            Quantity::Time => "time",
            Quantity::Pressure => "pressure",
            Quantity::Position => "position",
            Quantity::AmbientTemperature => "ambient_temperature",
            Quantity::GasTemperature => "gas_temperature",
            Quantity::MassFlow => "mass_flow",
        }
    }

    /// The column's name where `[columns]` names no other.
    pub fn default_name(self) -> &'static str {
        match self {
            Quantity::Time => "time_s",
            Quantity::Pressure => "pressure_pa",
            Quantity::Position => "position_m",
            Quantity::AmbientTemperature => "ambient_temperature_k",
            Quantity::GasTemperature => "gas_temperature_k",
            Quantity::MassFlow => "mass_flow_kg_per_s",
        }
    }

    /// The SI unit that it is read into.
    pub fn si_unit(self) -> &'static str {
        self.units()[0].0
    }

    /// Names of the units that are read, SI first.
    pub fn unit_names(self) -> impl Iterator<Item = &'static str> {
        self.units().iter().map(|(name, _)| *name)
    }

    /// Known units, SI first.
    fn units(self) -> &'static [UnitRow] {
        match self {
            Quantity::Time => &[("s", (1.0, 0.0)), ("ms", (1e-3, 0.0)), ("us", (1e-6, 0.0)), ("min", (60.0, 0.0))],
            // psi = lbf/in² = 0.45359237 · 9.80665 / 0.0254² Pa
            Quantity::Pressure => &[
                ("Pa", (1.0, 0.0)),
                ("kPa", (1e3, 0.0)),
                ("MPa", (1e6, 0.0)),
                ("bar", (1e5, 0.0)),
                ("mbar", (1e2, 0.0)),
                ("psi", (0.453_592_37 * 9.806_65 / (0.0254 * 0.0254), 0.0)),
            ],
            Quantity::Position => &[("m", (1.0, 0.0)), ("mm", (1e-3, 0.0)), ("in", (0.0254, 0.0))],
            Quantity::AmbientTemperature | Quantity::GasTemperature => &[("K", (1.0, 0.0)), ("degC", (1.0, 273.15))],
            Quantity::MassFlow => &[("kg/s", (1.0, 0.0)), ("g/s", (1e-3, 0.0))],
        }
    }
}

/// One quantity's column. Its SI value is `factor · number + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name in the header.
    pub name: String,
    /// The unit's name.
    pub unit: &'static str,
    /// Factor to SI; negative where the sign is turned.
    pub factor: f64,
    /// Added after the factor, SI.
    pub offset: f64,
    /// Named in `[columns]`, so that it has to be there.
    pub mapped: bool,
    /// Pressure above the surroundings', whose pressure is part of the offset.
    pub gauge: bool,
}

impl Column {
    fn default_of(quantity: Quantity) -> Self {
        let (unit, (factor, offset)) = quantity.units()[0];
        Self { name: quantity.default_name().to_owned(), unit, factor, offset, mapped: false, gauge: false }
    }

    /// The SI value of a number in this column.
    #[inline]
    pub fn si(&self, number: f64) -> f64 {
        self.factor * number + self.offset
    }
}

/// What stands between the columns of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// That byte.
    Byte(u8),
    /// Any number of blanks and tabs. A header that has commas is split at those.
    Whitespace,
}

/// How a trace file is laid out.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// One for each of [`Quantity::ALL`].
    pub columns: [Column; 6],
    /// What stands between columns.
    pub separator: Separator,
}

impl Default for Layout {
    /// SI columns under their default names, separated by commas.
    fn default() -> Self {
        Self { columns: Quantity::ALL.map(Column::default_of), separator: Separator::Byte(b',') }
    }
}

impl Layout {
    /// That quantity's column.
    pub fn column(&self, quantity: Quantity) -> &Column {
        &self.columns[quantity as usize]
    }

    /// Reads `[columns]` and `[format]` under `root`; gauge pressures count from `ambient_pressure_pa`, where it is given.
    pub(crate) fn read(root: &Table<'_>, ambient_pressure_pa: Option<f64>) -> Result<Self, Error> {
        let mut layout = Self::default();
        if let Some(columns) = root.table("columns")? {
            columns.allow(&Quantity::ALL.map(Quantity::key))?;
            for (quantity, column) in Quantity::ALL.iter().zip(&mut layout.columns) {
                if let Some(table) = columns.table(quantity.key())? {
                    *column = read_column(&table, *quantity, ambient_pressure_pa)?;
                }
            }
        }
        if let Some(format) = root.table("format")? {
            format.allow(&["separator"])?;
            let separators = [
                (",", Separator::Byte(b',')),
                (";", Separator::Byte(b';')),
                ("tab", Separator::Byte(b'\t')),
                ("whitespace", Separator::Whitespace),
                ("\t", Separator::Byte(b'\t')),
            ];
            layout.separator = format.choice("separator", &separators)?.unwrap_or(layout.separator);
        }
        Ok(layout)
    }
}

fn read_column(table: &Table<'_>, quantity: Quantity, ambient_pressure_pa: Option<f64>) -> Result<Column, Error> {
    match quantity {
        Quantity::Pressure => table.allow(&["name", "unit", "reference"])?,
        Quantity::Position => table.allow(&["name", "unit", "sign", "offset_m"])?,
        _ => table.allow(&["name", "unit"])?,
    }
    let name = table.text("name")?.ok_or_else(|| table.missing("name", "the column's name in the header"))?;
    let units = quantity.units();
    let (factor, offset) = table.choice("unit", units)?.unwrap_or(units[0].1);
    let unit = units.iter().find(|row| row.1 == (factor, offset)).map_or(quantity.si_unit(), |row| row.0);
    let mut column = Column { name: name.trim().to_owned(), unit, factor, offset, mapped: true, gauge: false };
    if table.choice("reference", &[("absolute", false), ("gauge", true)])?.unwrap_or(false) {
        column.gauge = true;
        column.offset += ambient_pressure_pa.ok_or_else(|| {
            let problem = "gauge pressures count from the surroundings': say [ambient] pressure_pa as well";
            table.refuse("reference", KeyProblem::Contradiction(problem.to_owned()))
        })?;
    }
    if let Some(sign) = table.number("sign", &Bounds::Within(-1.0..=1.0, "1 or -1"))? {
        if sign.abs() != 1.0 {
            let problem = KeyProblem::OutOfBounds { value: sign, expected: "1 or -1".to_owned() };
            return Err(table.refuse("sign", problem));
        }
        column.factor *= sign;
    }
    column.offset += table.number("offset_m", &Bounds::Finite)?.unwrap_or(0.0);
    Ok(column)
}
