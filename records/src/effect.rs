//! An effect's table in a model file: its numbers by key, its choices as words, its lists.
//!
//! An omitted number is neutral. Words and lists of an effect are required, and its lists have the same length. A list shorter
//! than its capacity repeats its last number in the unused entries.

use crate::error::Error;
use crate::key::Bounds;
use crate::table::Table;
use crate::toml_text::{number, quoted};
use chamber::card::{Card, Kind, Parameter};
use std::fmt::Write;

/// Writes the lines of an effect's table.
pub fn write(out: &mut String, card: &Card, values: &[f64]) -> std::fmt::Result {
    for (index, (parameter, value)) in card.parameters.iter().zip(values).enumerate() {
        match parameter.kind {
            Kind::Number => writeln!(out, "{} = {}", parameter.key(), number(*value))?,
            // A number that encodes no word is written as it is, and refused when read back.
            Kind::Word(words) => match words.get((*value as usize).wrapping_sub(1)) {
                Some(word) => writeln!(out, "{} = {}", parameter.name, quoted(word))?,
                None => writeln!(out, "{} = {}", parameter.name, number(*value))?,
            },
            Kind::ListEntry { index: 0, .. } => {
                let entries: Vec<String> =
                    values[index..][..(card.length)(values)].iter().map(|v| number(*v)).collect();
                writeln!(out, "{} = [{}]", parameter.name, entries.join(", "))?;
            }
            Kind::ListEntry { .. } => {}
        }
    }
    Ok(())
}

/// Reads an effect's table.
///
/// # Errors
/// An unknown key or word, a number out of bounds, or inconsistent lists.
pub fn read(table: &Table<'_>, card: &Card, values: &mut [f64]) -> Result<(), Error> {
    let keys: Vec<String> = card.parameters.iter().map(key_of_file).collect();
    table.allow(&keys.iter().map(String::as_str).collect::<Vec<_>>())?;
    let mut first_list: Option<(&str, usize)> = None;
    for (index, (parameter, key)) in card.parameters.iter().zip(&keys).enumerate() {
        match parameter.kind {
            Kind::Number => {
                let bounds = Bounds::Within(parameter.bounds.clone(), "");
                values[index] = table.number(key, &bounds)?.unwrap_or(parameter.neutral);
            }
            Kind::Word(words) => values[index] = word(table, key, words)?,
            Kind::ListEntry { index: 0, rising } => {
                let entries = card.parameters[index..].iter().take_while(|p| p.name == parameter.name).count();
                let list = list(table, parameter, entries, rising)?;
                let (first, length) = *first_list.get_or_insert((parameter.name, list.len()));
                if list.len() != length {
                    let problem = format!("has {} numbers, `{first}` has {length}", list.len());
                    return Err(table.contradiction(key, problem));
                }
                for k in 0..entries {
                    values[index + k] = list[k.min(length - 1)];
                }
            }
            Kind::ListEntry { .. } => {}
        }
    }
    (card.check)(values).map_err(|problem| table.contradiction(&keys[0], problem))
}

/// The key that holds a parameter: for a list entry, that of its list.
fn key_of_file(parameter: &Parameter) -> String {
    match parameter.kind {
        Kind::ListEntry { .. } => parameter.name.to_owned(),
        _ => parameter.key(),
    }
}

/// Index of a word, from one.
fn word(table: &Table<'_>, key: &str, words: &[&str]) -> Result<f64, Error> {
    let numbered: Vec<(&str, f64)> = words.iter().zip(1u8..).map(|(word, n)| (*word, f64::from(n))).collect();
    table.choice(key, &numbered)?.ok_or_else(|| table.missing(key, &format!("one of {}", words.join(", "))))
}

/// A list of one to `entries` numbers.
fn list(table: &Table<'_>, parameter: &Parameter, entries: usize, rising: bool) -> Result<Vec<f64>, Error> {
    let (key, bounds) = (parameter.name, Bounds::Within(parameter.bounds.clone(), ""));
    let expected = format!("a list of 1 to {entries} numbers");
    let list = table.numbers(key, &bounds)?.ok_or_else(|| table.missing(key, &expected))?;
    let refuse = |problem: String| Err(table.contradiction(key, problem));
    if list.is_empty() || list.len() > entries {
        return refuse(format!("has {} numbers; expected {expected}", list.len()));
    }
    match list.windows(2).find(|pair| rising && pair[1] <= pair[0]) {
        Some(pair) => {
            refuse(format!("{:?} follows {:?}; each number must be above the one before it", pair[1], pair[0]))
        }
        None => Ok(list),
    }
}
