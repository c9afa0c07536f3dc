//! Layout of a trace file: which column holds which quantity, in which unit, and the text format. The `[columns]` and `[format]`
//! tables of a rig file.

use crate::error::Error;
use crate::format::Format;
use crate::key::{Bounds, KeyProblem};
use crate::table::Table;
use crate::units::{CLOCK, Unit, VOLT};

pub use crate::format::Separator;
pub use crate::units::Quantity;

/// One quantity's column. Its SI value is `factor · number + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name in the header.
    pub name: String,
    /// The unit's name.
    pub unit: &'static str,
    /// Factor to SI; negative where the sign is reversed.
    pub factor: f64,
    /// Added after the factor, SI.
    pub offset: f64,
    /// Named in `[columns]`, so it must exist.
    pub mapped: bool,
    /// Pressure relative to the surroundings', which the offset adds.
    pub gauge: bool,
    /// What the rig file states explicitly.
    pub stated: Stated,
}

/// What the rig file states explicitly of a column.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stated {
    /// The unit; otherwise it is the SI unit, whatever the column's name says.
    pub unit: bool,
    /// A scale or an offset: the unit then does not follow from the file alone.
    pub scale: bool,
}

impl Column {
    fn default_of(quantity: Quantity) -> Self {
        let name = quantity.default_name().to_owned();
        let (unit, stated) = (quantity.si_unit(), Stated::default());
        Self { name, unit, factor: 1.0, offset: 0.0, mapped: false, gauge: false, stated }
    }

    /// The SI value of a number in this column.
    #[inline]
    pub fn si(&self, number: f64) -> f64 {
        self.factor * number + self.offset
    }

    /// The unit of its numbers for that quantity, where no scale or offset changes them.
    pub fn plain_unit(&self, quantity: Quantity) -> Option<&'static Unit> {
        quantity.units().iter().find(|unit| unit.name == self.unit && !self.stated.scale && unit.name != VOLT)
    }

    /// Whether it holds clock times.
    pub fn is_clock(&self) -> bool {
        self.unit == CLOCK
    }
}

/// Layout of a trace file.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// One column per entry of [`Quantity::ALL`].
    pub columns: [Column; 6],
    /// Its text format, as far as stated.
    pub format: Format,
}

impl Default for Layout {
    /// SI columns under their default names.
    fn default() -> Self {
        Self { columns: Quantity::ALL.map(Column::default_of), format: Format::default() }
    }
}

impl Layout {
    /// The column of a quantity.
    pub fn column(&self, quantity: Quantity) -> &Column {
        &self.columns[quantity as usize]
    }

    /// Reads `[columns]` and `[format]` under `root`; gauge pressures are relative to `ambient_pressure_pa`, where it is given.
    pub(crate) fn read(root: &Table<'_>, ambient_pressure_pa: Option<f64>) -> Result<Self, Error> {
        let mut layout = Self { format: Format::read(root)?, ..Self::default() };
        let Some(columns) = root.table("columns")? else { return Ok(layout) };
        columns.allow(&Quantity::ALL.map(Quantity::key))?;
        for (quantity, column) in Quantity::ALL.iter().zip(&mut layout.columns) {
            if let Some(table) = columns.table(quantity.key())? {
                *column = read_column(&table, *quantity, ambient_pressure_pa)?;
            }
        }
        Ok(layout)
    }
}

fn read_column(table: &Table<'_>, quantity: Quantity, ambient_pressure_pa: Option<f64>) -> Result<Column, Error> {
    match quantity {
        Quantity::Pressure => table.allow(&["name", "unit", "scale", "offset", "reference"])?,
        Quantity::Position => table.allow(&["name", "unit", "scale", "offset", "sign", "offset_m"])?,
        _ => table.allow(&["name", "unit", "scale", "offset"])?,
    }
    let name = table.text("name")?.ok_or_else(|| table.missing("name", "the column's name in the header"))?;
    let units: Vec<_> = quantity.units().iter().map(|unit| (unit.name, unit)).collect();
    let unit = table.choice("unit", &units)?.unwrap_or(units[0].1);
    let scale = read_scale(table, quantity, unit.name)?;
    let added = table.number("offset", &Bounds::Finite)?.unwrap_or(0.0);
    let stated = Stated { unit: table.has("unit"), scale: table.has("scale") || table.has("offset") };
    let mut column = Column {
        name: name.trim().to_owned(),
        unit: unit.name,
        factor: unit.factor * scale,
        offset: unit.factor * added + unit.offset,
        mapped: true,
        gauge: table.choice("reference", &[("absolute", false), ("gauge", true)])?.unwrap_or(false),
        stated,
    };
    if column.gauge {
        column.offset += ambient_pressure_pa.ok_or_else(|| {
            let problem = "gauge pressures count from the surroundings': say [ambient] pressure_pa as well";
            table.contradiction("reference", problem)
        })?;
    }
    if let Some(sign) = table.number("sign", &Bounds::Within(-1.0..=1.0, "1 or -1"))? {
        if sign.abs() != 1.0 {
            let problem = KeyProblem::OutOfBounds { value: sign, expected: "1 or -1".to_owned() };
            return Err(table.refuse("sign", problem));
        }
        column.factor *= sign;
        column.offset *= sign;
    }
    column.offset += table.number("offset_m", &Bounds::Finite)?.unwrap_or(0.0);
    Ok(column)
}

/// Units per number in the column: 1 unless stated.
fn read_scale(table: &Table<'_>, quantity: Quantity, unit: &str) -> Result<f64, Error> {
    let scale = table.number("scale", &Bounds::Finite)?;
    if scale == Some(0.0) {
        let problem = KeyProblem::OutOfBounds { value: 0.0, expected: "a number other than zero".to_owned() };
        return Err(table.refuse("scale", problem));
    }
    if scale.is_none() && unit == VOLT {
        let si = quantity.si_unit();
        return Err(table.missing("scale", &format!("how many {si} a volt is (and in offset, {si} at zero volts)")));
    }
    Ok(scale.unwrap_or(1.0))
}
