//! One table of a study file, read key by key: keys not requested by the end are errors that name the line.

use crate::error::Error;
use records::key::{Bounds, KeyProblem};
use records::{Field, Table};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// A table that records the requested keys.
pub struct Section<'a> {
    table: Table<'a>,
    known: RefCell<Vec<String>>,
}

impl<'a> Section<'a> {
    /// A table of which no key has been requested.
    pub fn new(table: Table<'a>) -> Self {
        Self { table, known: RefCell::default() }
    }

    /// All entries in the order of the file.
    pub fn entries(&self) -> impl Iterator<Item = Field<'a>> + use<'a> {
        self.table.fields()
    }

    /// The entry of that key, which counts as known from now on.
    pub fn get(&self, key: &str) -> Option<Field<'a>> {
        self.known.borrow_mut().push(key.to_owned());
        self.table.field(key)
    }

    /// The entry of a required key.
    pub fn require(&self, key: &str, expected: &str) -> Result<Field<'a>, Error> {
        self.get(key).ok_or_else(|| self.missing(key, expected))
    }

    /// The error for a missing key, which should hold `expected`.
    pub fn missing(&self, key: &str, expected: &str) -> Error {
        self.table.missing(key, expected).into()
    }

    /// An error about the table as a whole; `why` is its wording.
    pub fn because(&self, why: &str) -> Error {
        self.table.refuse("", KeyProblem::Contradiction(why.to_owned())).into()
    }

    /// The table under that key, empty if missing.
    pub fn section(&self, key: &str) -> Result<Section<'a>, Error> {
        self.get(key);
        Ok(Section::new(self.table.table_or_empty(key)?))
    }

    /// Refuses keys that are not in `known`, before any of them is requested.
    pub fn allow(&self, known: &[&str]) -> Result<(), Error> {
        Ok(self.table.allow(known)?)
    }

    /// Refuses the first key that was not requested.
    pub fn finish(&self) -> Result<(), Error> {
        let known = self.known.borrow();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        Ok(self.table.allow(&known)?)
    }
}

/// Further operations of a study file on an entry.
pub trait Entry<'a> {
    /// The error for an invalid value; `why` is its wording.
    fn because(&self, why: impl Into<String>) -> Error;
    /// The value as a finite number.
    fn finite(&self) -> Result<f64, Error>;
    /// The value as a non-empty list of finite numbers.
    fn some_numbers(&self) -> Result<Vec<f64>, Error>;
    /// The value as a path, relative to the folder of the study's `file`.
    fn path_beside(&self, file: &Path) -> Result<PathBuf, Error>;
    /// The value as a section.
    fn section(&self) -> Result<Section<'a>, Error>;
}

impl<'a> Entry<'a> for Field<'a> {
    fn because(&self, why: impl Into<String>) -> Error {
        self.refuse(KeyProblem::Contradiction(why.into())).into()
    }

    fn finite(&self) -> Result<f64, Error> {
        Ok(self.number(&Bounds::Finite)?)
    }

    fn some_numbers(&self) -> Result<Vec<f64>, Error> {
        let values = self.numbers(&Bounds::Finite)?;
        if values.is_empty() { Err(self.because("is empty; at least one number is needed")) } else { Ok(values) }
    }

    fn path_beside(&self, file: &Path) -> Result<PathBuf, Error> {
        Ok(file.parent().unwrap_or(Path::new("")).join(self.text()?))
    }

    fn section(&self) -> Result<Section<'a>, Error> {
        Ok(Section::new(self.table()?))
    }
}
