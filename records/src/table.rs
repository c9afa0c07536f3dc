//! One table of a TOML file, read key by key.

use crate::error::Error;
use crate::field::Field;
use crate::key::{Bounds, KeyProblem, kind_of_file};
use crate::names::nearest;
use crate::value::{Entry, Value};
use std::borrow::Cow;
use std::path::Path;

/// A view of one table of a [`Document`](crate::document::Document). Reading a missing key gives `None`; an unsuitable value is
/// refused as by [`Field`].
#[derive(Clone, Debug)]
pub struct Table<'d> {
    path: &'d Path,
    name: Cow<'d, str>,
    line: usize,
    entries: &'d [Entry],
}

impl<'d> Table<'d> {
    pub(crate) fn new(path: &'d Path, name: &'d str, line: usize, entries: &'d [Entry]) -> Self {
        Self { path, name: name.into(), line, entries }
    }

    /// Its keys, in the file's order.
    pub fn keys(&self) -> impl Iterator<Item = &'d str> + use<'d> {
        self.entries.iter().map(|entry| entry.key.as_str())
    }

    /// Its keys with their values, in the file's order.
    pub fn fields(&self) -> impl Iterator<Item = Field<'d>> + use<'d> {
        let path = self.path;
        self.entries.iter().map(move |entry| Field::new(path, entry))
    }

    /// A key with its value; `None` if missing.
    pub fn field(&self, key: &str) -> Option<Field<'d>> {
        self.fields().find(|field| field.key() == key)
    }

    /// Whether the key exists.
    pub fn has(&self, key: &str) -> bool {
        self.field(key).is_some()
    }

    /// Refuses keys that are not in `known`.
    pub fn allow(&self, known: &[&str]) -> Result<(), Error> {
        let Some(field) = self.fields().find(|field| !known.contains(&field.key())) else { return Ok(()) };
        let near = nearest(field.key(), known.iter().copied()).map(str::to_owned);
        let known = known.iter().map(|k| (*k).to_owned()).collect();
        let problem = match kind_of_file(field.key()) {
            Some(kind) if self.name.is_empty() => KeyProblem::OtherFile { kind, known },
            _ => KeyProblem::Unknown { near, known },
        };
        Err(field.refuse(problem))
    }

    /// An error about a key of this table: at its line, or at the table's if it is missing. The empty key denotes the table
    /// itself.
    pub fn refuse(&self, key: &str, problem: KeyProblem) -> Error {
        match self.field(key) {
            Some(field) => field.refuse(problem),
            None => {
                let (path, line, key) = (self.path.to_owned(), self.line, self.dotted(key));
                Error::Key { path, line, key, problem: Box::new(problem) }
            }
        }
    }

    /// An error that a key's value contradicts, or requires, another; `why` is its wording.
    pub fn contradiction(&self, key: &str, why: impl Into<String>) -> Error {
        self.refuse(key, KeyProblem::Contradiction(why.into()))
    }

    /// An error that a key is missing, which should hold `expected`.
    pub fn missing(&self, key: &str, expected: &str) -> Error {
        self.refuse(key, KeyProblem::Missing { expected: expected.to_owned() })
    }

    /// A number; integers are accepted.
    pub fn number(&self, key: &str, bounds: &Bounds) -> Result<Option<f64>, Error> {
        self.field(key).map(|field| field.number(bounds)).transpose()
    }

    /// A required number.
    pub fn required_number(&self, key: &str, bounds: &Bounds) -> Result<f64, Error> {
        self.number(key, bounds)?.ok_or_else(|| self.missing(key, &bounds.description()))
    }

    /// A whole number of zero or above.
    pub fn count(&self, key: &str) -> Result<Option<u64>, Error> {
        self.field(key).map(|field| field.whole(0)).transpose()
    }

    /// A list of numbers.
    pub fn numbers(&self, key: &str, bounds: &Bounds) -> Result<Option<Vec<f64>>, Error> {
        self.field(key).map(|field| field.numbers(bounds)).transpose()
    }

    /// A list of lists of numbers.
    pub fn rows_of_numbers(&self, key: &str, bounds: &Bounds) -> Result<Option<Vec<Vec<f64>>>, Error> {
        self.field(key).map(|field| field.rows_of_numbers(bounds)).transpose()
    }

    /// The text under that key; `None` if missing.
    pub fn text(&self, key: &str) -> Result<Option<&'d str>, Error> {
        self.field(key).map(|field| field.text()).transpose()
    }

    /// One of several words.
    pub fn choice<T: Copy>(&self, key: &str, choices: &[(&str, T)]) -> Result<Option<T>, Error> {
        self.field(key).map(|field| field.choice(choices)).transpose()
    }

    /// `true` or `false`.
    pub fn flag(&self, key: &str) -> Result<Option<bool>, Error> {
        self.field(key).map(|field| field.flag()).transpose()
    }

    /// A list of texts.
    pub fn texts(&self, key: &str) -> Result<Option<Vec<&'d str>>, Error> {
        self.field(key).map(|field| field.texts()).transpose()
    }

    /// The table under that key; `None` if missing.
    pub fn table(&self, key: &str) -> Result<Option<Table<'d>>, Error> {
        self.field(key).map(|field| field.table()).transpose()
    }

    /// The table under that key; empty if missing.
    pub fn table_or_empty(&self, key: &str) -> Result<Table<'d>, Error> {
        let empty = || Table { path: self.path, name: self.dotted(key).into(), line: self.line, entries: &[] };
        Ok(self.table(key)?.unwrap_or_else(empty))
    }

    /// A required table.
    pub fn required_table(&self, key: &str) -> Result<Table<'d>, Error> {
        self.table(key)?.ok_or_else(|| self.missing(key, &format!("a table [{}]", self.dotted(key))))
    }

    /// A list of tables (`[[key]]`); empty where the key is missing.
    pub fn tables(&self, key: &str) -> Result<Vec<Table<'d>>, Error> {
        self.field(key).map_or(Ok(Vec::new()), |field| field.tables())
    }

    fn dotted(&self, key: &str) -> String {
        match (self.name.as_ref(), key) {
            (name, "") => name.to_owned(),
            ("", key) => key.to_owned(),
            (name, key) => format!("{name}.{key}"),
        }
    }
}

impl<'d> Field<'d> {
    /// The value as a table.
    pub fn table(&self) -> Result<Table<'d>, Error> {
        match &self.entry.value {
            Value::Table(entries) => Ok(Table::new(self.path, &self.entry.name, self.entry.line, entries)),
            other => Err(self.wrong_type("a table", other)),
        }
    }

    /// The value as a list of tables (`[[key]]`).
    pub fn tables(&self) -> Result<Vec<Table<'d>>, Error> {
        let expected = format!("a list of tables [[{}]]", self.entry.name);
        let table = |(line, item): &'d (usize, Value)| match item {
            Value::Table(entries) => Ok(Table::new(self.path, &self.entry.name, *line, entries)),
            other => Err(self.wrong_type(&expected, other)),
        };
        self.list(&expected)?.iter().map(table).collect()
    }
}
