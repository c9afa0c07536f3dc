//! One table of a TOML file, asked key by key.

use crate::document::{Entry, Value};
use crate::error::Error;
use crate::key::{Bounds, KeyProblem, kind_of_file};
use std::path::Path;

/// A view on one table of a [`Document`](crate::document::Document).
#[derive(Clone, Debug)]
pub struct Table<'d> {
    path: &'d Path,
    name: String,
    line: usize,
    entries: &'d [Entry],
}

impl<'d> Table<'d> {
    pub(crate) fn new(path: &'d Path, name: String, line: usize, entries: &'d [Entry]) -> Self {
        Self { path, name, line, entries }
    }

    /// Its dotted name, empty for the outermost.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its keys, in the file's order.
    pub fn keys(&self) -> impl Iterator<Item = &'d str> + use<'d> {
        self.entries.iter().map(|entry| entry.key.as_str())
    }

    /// Whether it has that key.
    pub fn has(&self, key: &str) -> bool {
        self.entry(key).is_some()
    }

    /// Refuses keys that are none of `known`.
    ///
    /// # Errors
    /// [`KeyProblem::Unknown`], with the nearest of `known`.
    pub fn allow(&self, known: &[&str]) -> Result<(), Error> {
        let Some(entry) = self.entries.iter().find(|entry| !known.contains(&entry.key.as_str())) else { return Ok(()) };
        let near = crate::nearest(&entry.key, known.iter().copied()).map(str::to_owned);
        let known = known.iter().map(|k| (*k).to_owned()).collect();
        let problem = match kind_of_file(&entry.key) {
            Some(kind) if self.name.is_empty() => KeyProblem::OtherFile { kind, known },
            _ => KeyProblem::Unknown { near, known },
        };
        Err(self.refuse(&entry.key, problem))
    }

    /// A complaint about a key of this table: at its line, or at the table's where it is missing.
    pub fn refuse(&self, key: &str, problem: KeyProblem) -> Error {
        let line = self.entry(key).map_or(self.line, |entry| entry.line);
        Error::Key { path: self.path.to_owned(), line, key: self.dotted(key), problem: Box::new(problem) }
    }

    /// A complaint that a key is missing which should hold `expected`.
    pub fn missing(&self, key: &str, expected: &str) -> Error {
        self.refuse(key, KeyProblem::Missing { expected: expected.to_owned() })
    }

    /// A number, an integer included.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`] or [`KeyProblem::OutOfBounds`].
    pub fn number(&self, key: &str, bounds: &Bounds) -> Result<Option<f64>, Error> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        self.checked(key, &entry.value, bounds).map(Some)
    }

    /// A number that must be there.
    ///
    /// # Errors
    /// As [`Table::number`], or [`KeyProblem::Missing`].
    pub fn required_number(&self, key: &str, bounds: &Bounds) -> Result<f64, Error> {
        self.number(key, bounds)?.ok_or_else(|| self.missing(key, &bounds.words()))
    }

    /// A whole number of zero or above.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`] or [`KeyProblem::OutOfBounds`].
    pub fn count(&self, key: &str) -> Result<Option<u64>, Error> {
        let expected = "a whole number, zero or above";
        match self.entry(key).map(|entry| &entry.value) {
            None => Ok(None),
            Some(Value::Integer(value)) => u64::try_from(*value).map(Some).map_err(|_| {
                self.refuse(key, KeyProblem::OutOfBounds { value: *value as f64, expected: expected.to_owned() })
            }),
            Some(other) => Err(self.wrong_type(key, expected, other)),
        }
    }

    /// A list of numbers.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`] or [`KeyProblem::OutOfBounds`].
    pub fn numbers(&self, key: &str, bounds: &Bounds) -> Result<Option<Vec<f64>>, Error> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        let Value::List(items) = &entry.value else {
            return Err(self.wrong_type(key, "a list of numbers", &entry.value));
        };
        items.iter().map(|(_, item)| self.checked(key, item, bounds)).collect::<Result<_, _>>().map(Some)
    }

    /// A list of lists of numbers.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`] or [`KeyProblem::OutOfBounds`].
    pub fn rows_of_numbers(&self, key: &str, bounds: &Bounds) -> Result<Option<Vec<Vec<f64>>>, Error> {
        let expected = "a list of lists of numbers";
        let Some(entry) = self.entry(key) else { return Ok(None) };
        let Value::List(rows) = &entry.value else { return Err(self.wrong_type(key, expected, &entry.value)) };
        let row = |(_, row): &'d (usize, Value)| match row {
            Value::List(items) => items.iter().map(|(_, item)| self.checked(key, item, bounds)).collect(),
            other => Err(self.wrong_type(key, expected, other)),
        };
        rows.iter().map(row).collect::<Result<_, _>>().map(Some)
    }

    /// A text.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`].
    pub fn text(&self, key: &str) -> Result<Option<&'d str>, Error> {
        match self.entry(key).map(|entry| &entry.value) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text)),
            Some(other) => Err(self.wrong_type(key, "a text in quotes", other)),
        }
    }

    /// One of several words.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`], or [`KeyProblem::UnknownName`] with the nearest word.
    pub fn choice<T: Copy>(&self, key: &str, choices: &[(&str, T)]) -> Result<Option<T>, Error> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        match choices.iter().find(|(word, _)| *word == text) {
            Some((_, value)) => Ok(Some(*value)),
            None => Err(self.refuse(key, KeyProblem::unknown_name(text, choices.iter().map(|(word, _)| *word)))),
        }
    }

    /// `true` or `false`.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`].
    pub fn flag(&self, key: &str) -> Result<Option<bool>, Error> {
        match self.entry(key).map(|entry| &entry.value) {
            None => Ok(None),
            Some(Value::Flag(flag)) => Ok(Some(*flag)),
            Some(other) => Err(self.wrong_type(key, "true or false", other)),
        }
    }

    /// A list of texts.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`].
    pub fn texts(&self, key: &str) -> Result<Option<Vec<&'d str>>, Error> {
        let expected = "a list of texts in quotes";
        let Some(entry) = self.entry(key) else { return Ok(None) };
        let Value::List(items) = &entry.value else { return Err(self.wrong_type(key, expected, &entry.value)) };
        let text = |(_, item): &'d (usize, Value)| match item {
            Value::Text(text) => Ok(text.as_str()),
            other => Err(self.wrong_type(key, expected, other)),
        };
        items.iter().map(text).collect::<Result<_, _>>().map(Some)
    }

    /// A table.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`].
    pub fn table(&self, key: &str) -> Result<Option<Table<'d>>, Error> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        match &entry.value {
            Value::Table(entries) => Ok(Some(Table::new(self.path, self.dotted(key), entry.line, entries))),
            other => Err(self.wrong_type(key, "a table", other)),
        }
    }

    /// A table that must be there.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`] or [`KeyProblem::Missing`].
    pub fn required_table(&self, key: &str) -> Result<Table<'d>, Error> {
        self.table(key)?.ok_or_else(|| self.missing(key, &format!("a table [{}]", self.dotted(key))))
    }

    /// A list of tables (`[[key]]`); empty where the key is missing.
    ///
    /// # Errors
    /// [`KeyProblem::WrongType`].
    pub fn tables(&self, key: &str) -> Result<Vec<Table<'d>>, Error> {
        let expected = format!("a list of tables [[{}]]", self.dotted(key));
        let Some(entry) = self.entry(key) else { return Ok(Vec::new()) };
        let Value::List(items) = &entry.value else { return Err(self.wrong_type(key, &expected, &entry.value)) };
        let table = |(line, item): &'d (usize, Value)| match item {
            Value::Table(entries) => Ok(Table::new(self.path, self.dotted(key), *line, entries)),
            other => Err(self.wrong_type(key, &expected, other)),
        };
        items.iter().map(table).collect()
    }

    fn entry(&self, key: &str) -> Option<&'d Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    fn dotted(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) }
    }

    fn checked(&self, key: &str, value: &Value, bounds: &Bounds) -> Result<f64, Error> {
        let number = match value {
            Value::Integer(integer) => *integer as f64,
            Value::Number(number) => *number,
            other => return Err(self.wrong_type(key, &bounds.words(), other)),
        };
        if bounds.allow(number) {
            return Ok(number);
        }
        Err(self.refuse(key, KeyProblem::OutOfBounds { value: number, expected: bounds.words() }))
    }

    fn wrong_type(&self, key: &str, expected: &str, found: &Value) -> Error {
        let found = match found {
            Value::Text(text) => format!("the text \"{text}\""),
            Value::Integer(value) => format!("the number {value}"),
            Value::Number(value) => format!("the number {value:?}"),
            Value::Flag(flag) => format!("{flag}"),
            Value::Date(date) => format!("the date {date}"),
            Value::List(_) => "a list".to_owned(),
            Value::Table(_) => "a table".to_owned(),
        };
        self.refuse(key, KeyProblem::WrongType { expected: expected.to_owned(), found })
    }
}
