//! The header line of a trace, matched with the layout.

use super::lines;
use super::problem::TraceProblem;
use super::read::{Need, Reading};
use crate::layout::{Column, Quantity, Separator};
use crate::nearest;

/// The header's line, matched with the layout.
pub struct Header<'a> {
    /// Its line.
    pub line: usize,
    /// How many columns it names.
    pub names: usize,
    /// The quantities that are there, in the order of [`Quantity::ALL`]: which, in which field, how laid out.
    pub found: Vec<(Quantity, usize, &'a Column)>,
}

impl<'a> Header<'a> {
    /// Matches the header `text` with the columns of `reading`.
    pub fn read(line: usize, text: &str, reading: &Reading<'a>) -> Result<Self, TraceProblem> {
        let names = names(line, text, reading.layout.separator)?;
        if names.iter().all(|name| name.parse::<f64>().is_ok()) {
            return Err(TraceProblem::NoHeader { line });
        }
        let mut found = Vec::new();
        for quantity in Quantity::ALL {
            let column = reading.layout.column(quantity);
            // A `#` before the header is not part of the first name, whichever way the rig writes it.
            let wanted = column.name.trim_start_matches('#').trim();
            let mut places = names.iter().enumerate().filter(|(_, name)| *name == wanted);
            match (places.next(), places.next()) {
                (Some(_), Some(_)) => return Err(TraceProblem::DoubleColumn { line, column: wanted.to_owned() }),
                (Some((place, _)), None) => found.push((quantity, place, column)),
                (None, _) if needed(quantity, column, reading.need) => {
                    return Err(missing(line, text, wanted, &names, reading.layout.separator));
                }
                (None, _) => {}
            }
        }
        Ok(Self { line, names: names.len(), found })
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

fn names(line: usize, text: &str, separator: Separator) -> Result<Vec<String>, TraceProblem> {
    let text = text.trim();
    let text = text.strip_prefix('#').unwrap_or(text);
    let separator = match separator {
        // Some loggers separate their header by commas and their rows by blanks.
        Separator::Whitespace if text.contains(',') => Separator::Byte(b','),
        other => other,
    };
    let mut fields = Vec::new();
    if !lines::split(text, separator, &mut fields) {
        return Err(TraceProblem::OpenQuote { line });
    }
    // A comma at the end of the header names no column.
    while fields.last().is_some_and(|field| field.is_empty()) {
        fields.pop();
    }
    Ok(fields
        .into_iter()
        .map(|field| text[field].replace("\"\"", "\"").trim_start_matches('#').trim().to_owned())
        .collect())
}

fn missing(line: usize, text: &str, wanted: &str, names: &[String], separator: Separator) -> TraceProblem {
    let hint = match (nearest(wanted, names.iter().map(String::as_str)), other_separator(text, names, separator)) {
        (_, Some(other)) => {
            format!(", the line looks separated otherwise: say separator = \"{other}\" in the rig's [format]")
        }
        (Some(near), None) => format!(", did you mean `{near}`? Say so in the rig's [columns]"),
        (None, None) => ", other names are told in the rig's [columns]".to_owned(),
    };
    let there = names.iter().map(|name| format!("`{name}`")).collect();
    TraceProblem::MissingColumn { line, column: wanted.to_owned(), there, hint }
}

/// A separator that splits what the given one leaves in one piece.
fn other_separator(text: &str, names: &[String], separator: Separator) -> Option<&'static str> {
    if names.len() > 1 {
        return None;
    }
    let all =
        [(";", ";", Separator::Byte(b';')), (",", ",", Separator::Byte(b',')), ("\t", "tab", Separator::Byte(b'\t'))];
    all.into_iter()
        .find(|(sign, _, other)| *other != separator && text.contains(sign))
        .map(|(_, name, _)| name)
        .or_else(|| text.trim().contains(' ').then_some("whitespace"))
}
