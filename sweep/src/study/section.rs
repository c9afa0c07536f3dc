//! One table of a TOML file, read key by key: whatever was not asked for in the end is an error that names the line.

use crate::error::Error;
use std::cell::RefCell;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The file a section belongs to: for the lines in errors.
#[derive(Clone, Copy)]
pub struct File<'a> {
    /// Its path.
    pub path: &'a Path,
    /// Its text.
    pub text: &'a str,
}

impl File<'_> {
    /// Line of a byte of the text, counted from one.
    pub fn line(&self, byte: usize) -> usize {
        self.text.as_bytes()[..byte.min(self.text.len())].iter().filter(|&&b| b == b'\n').count() + 1
    }

    /// A syntax error as ours.
    pub fn syntax(&self, error: &toml::de::Error) -> Error {
        let line = self.line(error.span().map_or(0, |span| span.start));
        Error::Syntax { path: self.path.to_owned(), line, message: error.message().replace('\n', ", ") }
    }
}

/// A table whose keys are taken one by one.
pub struct Section<'a> {
    file: File<'a>,
    name: String,
    table: Option<&'a DeTable<'a>>,
    known: RefCell<Vec<String>>,
}

/// A key's value and where it stands.
#[derive(Clone, Copy)]
pub struct Entry<'a> {
    file: File<'a>,
    /// The key as written.
    pub key: &'a str,
    /// Line of the key, counted from one.
    pub line: usize,
    /// The value.
    pub value: &'a DeValue<'a>,
}

impl<'a> Section<'a> {
    /// A table of that name; `None` where the file does not have it.
    pub fn new(file: File<'a>, name: impl Into<String>, table: Option<&'a DeTable<'a>>) -> Self {
        Self { file, name: name.into(), table, known: RefCell::default() }
    }

    /// All entries in the order of the file.
    pub fn entries(&self) -> Vec<Entry<'a>> {
        let mut keys: Vec<_> = self.table.into_iter().flat_map(|table| table.iter()).collect();
        keys.sort_by_key(|(key, _)| key.span().start);
        keys.into_iter().map(|(key, value)| self.entry(key, value)).collect()
    }

    fn entry(&self, key: &'a Spanned<std::borrow::Cow<'a, str>>, value: &'a Spanned<DeValue<'a>>) -> Entry<'a> {
        let line = self.file.line(key.span().start);
        Entry { file: self.file, key: key.get_ref(), line, value: value.get_ref() }
    }

    /// The entry of that key, which is known from now on.
    pub fn get(&self, key: &str) -> Option<Entry<'a>> {
        self.known.borrow_mut().push(key.to_owned());
        let (key, value) = self.table?.get_key_value(key)?;
        Some(self.entry(key, value))
    }

    /// The entry of a key that has to be there.
    pub fn require(&self, key: &str, expected: &str) -> Result<Entry<'a>, Error> {
        self.get(key).ok_or_else(|| self.missing(key, expected))
    }

    /// The error of an absent key.
    pub fn missing(&self, key: &str, expected: &str) -> Error {
        Error::MissingKey {
            path: self.file.path.to_owned(),
            section: self.name.clone(),
            key: key.to_owned(),
            expected: expected.to_owned(),
        }
    }

    /// The table under that key, empty where it is absent.
    pub fn section(&self, key: &str) -> Result<Section<'a>, Error> {
        let table = self.get(key).map(|entry| entry.table()).transpose()?;
        Ok(Section::new(self.file, key, table))
    }

    /// Refuses the first key that nobody asked for.
    pub fn finish(&self) -> Result<(), Error> {
        let known = self.known.borrow();
        match self.entries().into_iter().find(|entry| !known.iter().any(|k| k == entry.key)) {
            None => Ok(()),
            Some(entry) => Err(Error::UnknownKey {
                path: self.file.path.to_owned(),
                line: entry.line,
                section: self.name.clone(),
                key: entry.key.to_owned(),
                nearest: records::nearest(entry.key, known.iter().map(String::as_str)).map(str::to_owned),
            }),
        }
    }
}

impl<'a> Entry<'a> {
    /// The error of a value that cannot be: "`key` message".
    pub fn refuse(&self, message: impl Into<String>) -> Error {
        Error::Value {
            path: self.file.path.to_owned(),
            line: self.line,
            key: self.key.to_owned(),
            message: message.into(),
        }
    }

    fn wrong_type(&self, expected: &str) -> Error {
        self.refuse(format!("is {} {}: {expected} was expected", article(self.value), self.value.type_str()))
    }

    /// The value as a table.
    pub fn table(&self) -> Result<&'a DeTable<'a>, Error> {
        self.value.as_table().ok_or_else(|| self.wrong_type("a table"))
    }

    /// The value as a section of its own.
    pub fn section(&self) -> Result<Section<'a>, Error> {
        Ok(Section::new(self.file, self.key, Some(self.table()?)))
    }

    /// The value as text.
    pub fn text(&self) -> Result<&'a str, Error> {
        self.value.as_str().ok_or_else(|| self.wrong_type("a text in quotes"))
    }

    /// The value as yes or no.
    pub fn boolean(&self) -> Result<bool, Error> {
        self.value.as_bool().ok_or_else(|| self.wrong_type("true or false"))
    }

    /// The value as a finite number.
    pub fn number(&self) -> Result<f64, Error> {
        number(self.value).ok_or_else(|| self.wrong_type("a finite number"))
    }

    /// The value as a whole number from `least` on.
    pub fn whole(&self, least: u64) -> Result<u64, Error> {
        let whole = self.value.as_integer().and_then(|i| u64::from_str_radix(i.as_str(), i.radix()).ok());
        whole.filter(|&n| n >= least).ok_or_else(|| self.refuse(format!("has to be a whole number from {least} on")))
    }

    /// The value as a list of finite numbers, at least one.
    pub fn numbers(&self) -> Result<Vec<f64>, Error> {
        let array = self.value.as_array().ok_or_else(|| self.wrong_type("a list of numbers"))?;
        let values: Option<Vec<f64>> = array.iter().map(|item| number(item.get_ref())).collect();
        let values = values.ok_or_else(|| self.refuse("has to be a list of finite numbers"))?;
        if values.is_empty() { Err(self.refuse("is empty: at least one number was expected")) } else { Ok(values) }
    }

    /// The value as one of some names.
    pub fn one_of<T: Copy>(&self, choices: &[(&str, T)]) -> Result<T, Error> {
        let name = self.text()?;
        choices.iter().find(|(n, _)| *n == name).map(|(_, value)| *value).ok_or_else(|| {
            let list: Vec<_> = choices.iter().map(|(n, _)| format!("\"{n}\"")).collect();
            self.refuse(format!("is \"{name}\": one of {} was expected", list.join(", ")))
        })
    }
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    let number = match value {
        DeValue::Float(float) => float.as_str().parse().ok()?,
        DeValue::Integer(whole) => i64::from_str_radix(whole.as_str(), whole.radix()).ok()? as f64,
        _ => return None,
    };
    Some(number).filter(|n: &f64| n.is_finite())
}

fn article(value: &DeValue<'_>) -> &'static str {
    if value.type_str().starts_with(['a', 'i']) { "an" } else { "a" }
}
