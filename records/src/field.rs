//! One key of a TOML file and its value, read by type and [`Bounds`]; every error names file, line and key.

use crate::error::Error;
use crate::key::{Bounds, KeyProblem};
use crate::value::{Entry, Value};
use std::path::Path;

/// A view of one key of a [`Document`](crate::document::Document). Its methods refuse a value of another type, a number out of
/// bounds, or an unknown word.
#[derive(Clone, Copy, Debug)]
pub struct Field<'d> {
    pub(crate) path: &'d Path,
    pub(crate) entry: &'d Entry,
}

impl<'d> Field<'d> {
    pub(crate) fn new(path: &'d Path, entry: &'d Entry) -> Self {
        Self { path, entry }
    }

    /// The key, without its enclosing tables.
    pub fn key(&self) -> &'d str {
        &self.entry.key
    }

    /// Line of the key, counted from 1; 0 for content without a file.
    pub fn line(&self) -> usize {
        self.entry.line
    }

    /// An error about the key, at its line.
    pub fn refuse(&self, problem: KeyProblem) -> Error {
        let (path, line, key) = (self.path.to_owned(), self.entry.line, self.entry.name.clone());
        Error::Key { path, line, key, problem: Box::new(problem) }
    }

    /// The value as a number; integers are accepted.
    pub fn number(&self, bounds: &Bounds) -> Result<f64, Error> {
        self.checked(&self.entry.value, bounds)
    }

    /// The value as a whole number of at least `least`.
    pub fn whole(&self, least: u64) -> Result<u64, Error> {
        let expected = match least {
            0 => "a whole number, zero or above".to_owned(),
            _ => format!("a whole number, {least} or above"),
        };
        match &self.entry.value {
            Value::Integer(value) => u64::try_from(*value)
                .ok()
                .filter(|whole| *whole >= least)
                .ok_or_else(|| self.refuse(KeyProblem::WholeOutOfBounds { value: *value, expected })),
            other => Err(self.wrong_type(&expected, other)),
        }
    }

    /// The value as a list of numbers.
    pub fn numbers(&self, bounds: &Bounds) -> Result<Vec<f64>, Error> {
        self.list("a list of numbers")?.iter().map(|(_, item)| self.checked(item, bounds)).collect()
    }

    /// The value as a list of lists of numbers.
    pub fn rows_of_numbers(&self, bounds: &Bounds) -> Result<Vec<Vec<f64>>, Error> {
        let expected = "a list of lists of numbers";
        let row = |(_, row): &(usize, Value)| match row {
            Value::List(items) => items.iter().map(|(_, item)| self.checked(item, bounds)).collect(),
            other => Err(self.wrong_type(expected, other)),
        };
        self.list(expected)?.iter().map(row).collect()
    }

    /// The value as a text.
    pub fn text(&self) -> Result<&'d str, Error> {
        match &self.entry.value {
            Value::Text(text) => Ok(text),
            other => Err(self.wrong_type("a text in quotes", other)),
        }
    }

    /// Whether the value is a text.
    pub fn is_text(&self) -> bool {
        matches!(self.entry.value, Value::Text(_))
    }

    /// The value as a list of texts.
    pub fn texts(&self) -> Result<Vec<&'d str>, Error> {
        let expected = "a list of texts in quotes";
        let text = |(_, item): &'d (usize, Value)| match item {
            Value::Text(text) => Ok(text.as_str()),
            other => Err(self.wrong_type(expected, other)),
        };
        self.list(expected)?.iter().map(text).collect()
    }

    /// The value as one of several words.
    pub fn choice<T: Copy>(&self, choices: &[(&str, T)]) -> Result<T, Error> {
        self.chosen(self.text()?, choices)
    }

    /// The value as a list of such words.
    pub fn choices<T: Copy>(&self, choices: &[(&str, T)]) -> Result<Vec<T>, Error> {
        self.texts()?.into_iter().map(|text| self.chosen(text, choices)).collect()
    }

    fn chosen<T: Copy>(&self, text: &str, choices: &[(&str, T)]) -> Result<T, Error> {
        let found = choices.iter().find(|(word, _)| *word == text).map(|(_, value)| *value);
        found.ok_or_else(|| self.refuse(KeyProblem::unknown_name(text, choices.iter().map(|(word, _)| *word))))
    }

    /// The value as `true` or `false`.
    pub fn flag(&self) -> Result<bool, Error> {
        match &self.entry.value {
            Value::Flag(flag) => Ok(*flag),
            other => Err(self.wrong_type("true or false", other)),
        }
    }

    /// An error that the value is not what is `expected`.
    pub fn not(&self, expected: &str) -> Error {
        self.wrong_type(expected, &self.entry.value)
    }

    pub(crate) fn list(&self, expected: &str) -> Result<&'d [(usize, Value)], Error> {
        match &self.entry.value {
            Value::List(items) => Ok(items),
            other => Err(self.wrong_type(expected, other)),
        }
    }

    fn checked(&self, value: &Value, bounds: &Bounds) -> Result<f64, Error> {
        let number = match value {
            Value::Integer(integer) => *integer as f64,
            Value::Number(number) => *number,
            other => return Err(self.wrong_type(&bounds.description(), other)),
        };
        if bounds.allow(number) {
            return Ok(number);
        }
        Err(self.refuse(KeyProblem::OutOfBounds { value: number, expected: bounds.description() }))
    }

    pub(crate) fn wrong_type(&self, expected: &str, found: &Value) -> Error {
        let found = match found {
            Value::Text(text) => format!("the text \"{text}\""),
            Value::Integer(value) => format!("the number {value}"),
            Value::Number(value) => format!("the number {value:?}"),
            Value::Flag(flag) => format!("{flag}"),
            Value::Date(date) => format!("the date {date}"),
            Value::List(_) => "a list".to_owned(),
            Value::Table(_) => "a table".to_owned(),
        };
        self.refuse(KeyProblem::WrongType { expected: expected.to_owned(), found })
    }
}
