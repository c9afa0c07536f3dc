//! The columns of a trace, matched with the layout.

use super::dialect::Dialect;
use super::problem::TraceProblem;
use super::read::{Need, Reading};
use crate::format::Separator;
use crate::layout::{Column, Quantity};
use crate::nearest;
use crate::units::{CLOCK, VOLT};

/// The header, matched with the layout.
pub struct Header<'a> {
    /// Its line, or that of the first row where there is none.
    pub line: usize,
    /// The quantities that are there, in the order of [`Quantity::ALL`]: which, in which field, how laid out.
    pub found: Vec<(Quantity, usize, &'a Column)>,
}

impl<'a> Header<'a> {
    /// Matches the file's columns with those of `reading`.
    pub fn read(dialect: &Dialect, reading: &Reading<'a>) -> Result<Self, TraceProblem> {
        let line = dialect.header.unwrap_or(dialect.first_row);
        let mut found = Vec::new();
        for quantity in Quantity::ALL {
            let column = reading.layout.column(quantity);
            match dialect.place(&column.name) {
                (_, Some(second)) => {
                    let second = second + 1;
                    return Err(TraceProblem::DoubleColumn { line, column: column.name.clone(), second });
                }
                (Some(place), None) => {
                    check_unit(dialect, quantity, place, column)?;
                    found.push((quantity, place, column));
                }
                (None, _) if needed(quantity, column, reading.need) => {
                    return Err(missing_column(&column.name, dialect, reading.layout.format.separator.is_some()));
                }
                (None, _) => {}
            }
        }
        Ok(Self { line, found })
    }

    /// Which of the found columns holds that quantity.
    pub fn place(&self, quantity: Quantity) -> Option<usize> {
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

/// Refuses a units line that contradicts the layout. A voltage may be scaled to any unit, a clock has none.
fn check_unit(dialect: &Dialect, quantity: Quantity, place: usize, column: &Column) -> Result<(), TraceProblem> {
    let Some((line, units)) = &dialect.units else { return Ok(()) };
    let unit = units.get(place).and_then(|unit| quantity.unit_spelled(unit));
    match unit {
        Some(unit)
            if unit.name != column.unit && ![unit.name, column.unit].iter().any(|u| [VOLT, CLOCK].contains(u)) =>
        {
            let (found, expected) = (unit.name, column.unit);
            Err(TraceProblem::OtherUnit { line: *line, column: column.name.clone(), found, expected })
        }
        _ => Ok(()),
    }
}

/// That a column is not there, with what may help; `stated` says whether the rig file states the separator.
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
        ", other names are told in the rig's [columns]; `pneutherm look` writes them".to_owned()
    };
    let there = dialect.names.iter().map(|name| format!("`{}`", name.chars().take(40).collect::<String>()));
    TraceProblem::MissingColumn { line, column: wanted.to_owned(), there: at_most(there, 12), hint }
}

/// The first so many, and that there are more.
fn at_most(items: impl Iterator<Item = String>, count: usize) -> Vec<String> {
    let mut items: Vec<String> = items.collect();
    if items.len() > count {
        let more = items.len() - count;
        items.truncate(count);
        items.push(format!("and {more} more"));
    }
    items
}

/// Whether a separator splits what the given one leaves in one piece.
fn another_separates(name: &str, separator: Separator) -> bool {
    Separator::ALL.iter().any(|(_, other)| match other {
        _ if *other == separator => false,
        Separator::Byte(byte) => name.as_bytes().contains(byte),
        Separator::Whitespace => name.trim().contains(' '),
    })
}
