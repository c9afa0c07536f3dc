//! The columns of a trace, matched with the layout.

use super::dialect::Dialect;
use super::reading::{Need, Reading};
use crate::error::trace::TraceProblem;
use crate::format::Separator;
use crate::layout::{Column, Quantity};
use crate::names::nearest;
use crate::units::{CLOCK, Unit, VOLT, says_absolute, says_gauge, sure_unit};

/// The header, matched with the layout.
pub struct Header<'a> {
    /// Its line, or that of the first row if there is none.
    pub line: usize,
    /// The quantities found, in the order of [`Quantity::ALL`]: quantity, field index, layout.
    pub found: Vec<(Quantity, usize, &'a Column)>,
}

impl<'a> Header<'a> {
    /// Matches the file's columns with those of `reading`.
    pub fn read(dialect: &Dialect, reading: &Reading<'a>) -> Result<Self, TraceProblem> {
        let line = dialect.header.unwrap_or(dialect.first_row);
        let mut found = Vec::new();
        for quantity in Quantity::ALL {
            let column = reading.layout.column(quantity);
            match dialect.find_column(&column.name) {
                (_, Some(second)) => {
                    let second = second + 1;
                    return Err(TraceProblem::DoubleColumn { line, column: column.name.clone(), second });
                }
                (Some(field), None) => {
                    check_unit(dialect, quantity, field, column)?;
                    found.push((quantity, field, column));
                }
                (None, _) if needed(quantity, column, reading.need) => {
                    return Err(missing_column(&column.name, dialect, reading.layout.format.separator.is_some()));
                }
                (None, _) => {}
            }
        }
        Ok(Self { line, found })
    }

    /// Index of a quantity among the found columns.
    pub fn index_of(&self, quantity: Quantity) -> Option<usize> {
        self.found.iter().position(|(found, _, _)| *found == quantity)
    }
}

fn needed(quantity: Quantity, column: &Column, need: Need) -> bool {
    match (quantity, need) {
        (Quantity::Time | Quantity::Position, _) | (Quantity::Pressure, Need::Measurement) => true,
        (_, Need::Measurement) => column.mapped,
        (_, Need::Motion) => false,
    }
}

/// Refuses a units line, or a unit in the column's name, that contradicts the layout: one in brackets (`p (psi)`), or one at the
/// name's end (`p_psi`) where the rig file states none. Exempt are a voltage, which may be scaled to any unit, a clock, which has
/// none, and a scale that converts between the units.
fn check_unit(dialect: &Dialect, quantity: Quantity, field: usize, column: &Column) -> Result<(), TraceProblem> {
    let Some(stated_unit) = StatedUnit::of(dialect, quantity, field, column) else { return Ok(()) };
    let StatedUnit { line, spelling, unit, in_name } = stated_unit;
    let name = || column.name.clone();
    let stated = quantity.units().iter().find(|unit| unit.name == column.unit);
    if unit.name == VOLT && column.unit != VOLT && !column.stated.scale {
        return Err(TraceProblem::Volts { line, column: name(), expected: column.unit, si: quantity.si_unit() });
    }
    if [unit.name, column.unit].iter().any(|u| [VOLT, CLOCK].contains(u)) {
        return Ok(());
    }
    let is_scaled_to_it =
        (column.factor.abs() / unit.factor - 1.0).abs() < 0.01 && stated.is_some_and(|s| s.offset == unit.offset);
    if unit.name != column.unit && !is_scaled_to_it {
        let (found, expected) = (unit.name, column.unit);
        return Err(match in_name {
            true => TraceProblem::UnitInName { line, column: name(), number: field + 1, found, expected },
            false => TraceProblem::OtherUnit { line, column: name(), found, expected },
        });
    }
    let reference = |gauge| if gauge { "gauge" } else { "absolute" };
    // The column's offset may be the ambient pressure.
    let is_other = if column.gauge { says_absolute(spelling) } else { says_gauge(spelling) && !column.stated.scale };
    if quantity == Quantity::Pressure && is_other {
        let [found, expected] = [reference(!column.gauge), reference(column.gauge)];
        let spelling = spelling.to_owned();
        return Err(TraceProblem::OtherReference { line, column: name(), spelling, found, expected });
    }
    Ok(())
}

/// The unit of a column according to the file itself.
struct StatedUnit<'d> {
    /// The line that states it.
    line: usize,
    /// Its spelling there.
    spelling: &'d str,
    unit: &'static Unit,
    /// Whether the column's name states it, rather than a units line.
    in_name: bool,
}

impl<'d> StatedUnit<'d> {
    /// From the units line or, if that states nothing, from the column's name.
    fn of(dialect: &'d Dialect, quantity: Quantity, field: usize, column: &Column) -> Option<Self> {
        let of = |line, spelling, in_name| {
            let unit = quantity.unit_spelled(spelling)?;
            Some(Self { line, spelling, unit, in_name })
        };
        let by_line = dialect.units.as_ref().and_then(|(line, units)| of(*line, units.get(field)?.as_str(), false));
        by_line.or_else(|| {
            let name = dialect.names.get(field).filter(|name| **name == column.name.trim_start_matches('#').trim())?;
            of(dialect.header?, sure_unit(name, column.stated.unit)?, true)
        })
    }
}

/// An error for a missing column, with a hint; `stated`: whether the rig file states the separator.
pub fn missing_column(wanted: &str, dialect: &Dialect, stated: bool) -> TraceProblem {
    let line = dialect.header.unwrap_or(dialect.first_row);
    let near = nearest(wanted, dialect.names.iter().map(String::as_str));
    let hint = if dialect.header.is_none() {
        ", as there is no header line: name the columns by number in the rig's [columns]".to_owned()
    } else if stated && dialect.names.len() == 1 && another_separates(&dialect.names[0], dialect.separator) {
        format!(
            ", the line is not separated by {:?}: leave out separator in the rig's [format]",
            dialect.separator.name()
        )
    } else if let Some(near) = near {
        format!(", did you mean `{near}`? Say so in the rig's [columns]")
    } else {
        ", if it has another name, give that in the rig's [columns]; `pneutherm look` proposes it".to_owned()
    };
    let there = dialect.names.iter().map(|name| format!("`{}`", name.chars().take(40).collect::<String>()));
    TraceProblem::MissingColumn { line, column: wanted.to_owned(), there: at_most(there, 12), hint }
}

/// The first `count` items, and how many more there are.
fn at_most(items: impl Iterator<Item = String>, count: usize) -> Vec<String> {
    let mut items: Vec<String> = items.collect();
    if items.len() > count {
        let more = items.len() - count;
        items.truncate(count);
        items.push(format!("and {more} more"));
    }
    items
}

/// Whether another separator would split the name.
fn another_separates(name: &str, separator: Separator) -> bool {
    Separator::ALL.iter().any(|(_, other)| match other {
        _ if *other == separator => false,
        Separator::Byte(byte) => name.as_bytes().contains(byte),
        Separator::Whitespace => name.trim().contains(' '),
    })
}
