//! Checked reading of TOML files: errors name file, line and key; for an unknown key, the nearest known one.
//!
//! A [`Document`] is the parsed file, a [`Table`] a view of one of its tables. A reader first declares the keys that a table may
//! have ([`Table::allow`]), then requests them by type and [`Bounds`](crate::key::Bounds).

use crate::error::Error;
use crate::format::Format;
use crate::table::Table;
use crate::trace::{Dialect, Sample};
use crate::value::{Entry, Value};
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// Larger than any file typed by a person, bytes.
const MAX_BYTES: u64 = 16 << 20;

/// How much of an invalid TOML file is searched for the rows of a trace, bytes ...
const HEAD_BYTES: usize = 1 << 16;
/// ... and lines.
const HEAD_LINES: usize = 200;
/// Rows of numbers from which on a file counts as a trace.
const FEW_ROWS: usize = 3;

/// The kind of TOML file expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A rig file.
    Rig,
    /// A model file.
    Model,
    /// Any kind.
    Any,
}

impl Kind {
    /// What is expected, for an error message.
    fn description(self) -> &'static str {
        match self {
            Kind::Rig => "a rig file (TOML) that names it is expected here, and `pneutherm look` writes one",
            Kind::Model => "a model file (TOML), as `pneutherm identify` writes it, is expected here",
            Kind::Any => "a TOML file is expected here",
        }
    }
}

/// A TOML file.
#[derive(Clone, Debug)]
pub struct Document {
    path: PathBuf,
    text: String,
    root: Vec<Entry>,
}

/// `bore_m = 0,02`
fn has_decimal_comma(line: &str) -> bool {
    let value = line.split('#').next().and_then(|line| line.split_once('=')).map_or("", |(_, value)| value.trim());
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    value
        .split_once(',')
        .is_some_and(|(whole, decimals)| is_digits(whole.trim_start_matches('-')) && is_digits(decimals))
}

impl Document {
    /// Reads and parses a file of any kind.
    ///
    /// # Errors
    /// [`Error::Read`], [`Error::Syntax`] or [`Error::IsTrace`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::read_as(Kind::Any, path)
    }

    /// Reads and parses a file of the given kind.
    ///
    /// # Errors
    /// As [`Document::read`].
    pub fn read_as(kind: Kind, path: &Path) -> Result<Self, Error> {
        let unreadable = |source| Error::Read { path: path.to_owned(), source };
        let bytes = read_bytes(path).map_err(unreadable)?;
        let parsed = text_of(&bytes).map_err(unreadable).and_then(|text| Self::parse(path, text));
        match parsed {
            Err(_) if is_trace(path, &bytes) => {
                Err(Error::IsTrace { path: path.to_owned(), expected: kind.description() })
            }
            parsed => parsed,
        }
    }

    /// Parses `text` as the content of the file at `path`.
    ///
    /// # Errors
    /// [`Error::Syntax`].
    pub fn parse(path: &Path, text: String) -> Result<Self, Error> {
        let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
        let lines = Lines::of(&text);
        let parsed = DeTable::parse(&text).map_err(|error| {
            let (line, column) = lines.line_and_column(&text, error.span().map_or(0, |span| span.start));
            // The parser's message may span lines; an error message is one sentence.
            let mut message = error.message().lines().map(str::trim).collect::<Vec<_>>().join(", ");
            let source = text.lines().nth(line - 1).unwrap_or("");
            if source.split('#').next().unwrap_or("").trim() == "[experiment]" && message.contains("duplicate") {
                message += "; each of several experiments begins with two brackets: [[experiment]]";
            }
            if source.contains('"') && source.contains('\\') {
                message += "; write a path with a backslash in single quotes, or with forward slashes";
            }
            if !source.contains('"') && has_decimal_comma(source) {
                message += "; numbers have a decimal point here, not a comma";
            }
            Error::Syntax { path: path.to_owned(), line, column, message }
        })?;
        let root = entries(parsed.get_ref(), "", &lines);
        Ok(Self { path: path.to_owned(), text, root })
    }

    /// A document whose content comes from a program, not a file: errors name no line. `path` represents it in error messages;
    /// paths in it are relative to the folder of `path`.
    pub fn from_table(path: &Path, table: &toml::Table) -> Self {
        let root = values(table, "");
        Self { path: path.to_owned(), text: table.to_string(), root }
    }

    /// Path of the file, as given; for content without a file, the name that represents it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's text, without a byte order mark.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The outermost table.
    pub fn root(&self) -> Table<'_> {
        let first = self.root.first().map_or(1, |entry| entry.line.min(1));
        Table::new(&self.path, "", first, &self.root)
    }
}

/// The bytes of a settings file, at most one more than [`MAX_BYTES`], as from an endless device.
///
/// # Errors
/// The system's errors, and a folder.
fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    if std::fs::metadata(path)?.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder, a TOML file is expected"));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a settings file.
///
/// # Errors
/// More than [`MAX_BYTES`] bytes, or invalid UTF-8.
fn text_of(bytes: &[u8]) -> io::Result<String> {
    let invalid = |message: String| io::Error::new(io::ErrorKind::InvalidData, message);
    if bytes.len() as u64 > MAX_BYTES {
        return Err(invalid(format!("it has more bytes than settings take ({MAX_BYTES} at most)")));
    }
    std::str::from_utf8(bytes).map(str::to_owned).map_err(|error| {
        let valid = &bytes[..error.valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        invalid(format!("line {line} has bytes that are not UTF-8 text"))
    })
}

/// Whether an invalid TOML file is a trace, by its name or by rows of numbers at its start.
fn is_trace(path: &Path, bytes: &[u8]) -> bool {
    let ends_in = |ending: &str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
    ends_in("csv")
        || (!ends_in("toml") && has_rows_of_numbers(&String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD_BYTES)])))
}

/// Whether at least two columns of a text have a few numbers each.
fn has_rows_of_numbers(head: &str) -> bool {
    let lines = head.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let lines: Vec<(usize, String)> = lines.map(|(nth, line)| (nth + 1, line.to_owned())).take(HEAD_LINES).collect();
    let dialect = Dialect::find(&lines, &Format::default(), &[]);
    let sample = Sample::of(&dialect, &lines);
    sample.numbers.iter().filter(|column| column.len() >= FEW_ROWS).count() >= 2
}

/// A key with the names of its enclosing tables.
fn dotted(prefix: &str, key: &str) -> String {
    if prefix.is_empty() { key.to_owned() } else { format!("{prefix}.{key}") }
}

/// Entries of a table that was not parsed from a file.
fn values(table: &toml::Table, prefix: &str) -> Vec<Entry> {
    let entry = |(key, value): (&String, &toml::Value)| {
        let name = dotted(prefix, key);
        let value = Value::of(value, &name);
        Entry { key: key.clone(), name, line: 0, value }
    };
    table.iter().map(entry).collect()
}

impl Value {
    fn of(value: &toml::Value, name: &str) -> Self {
        match value {
            toml::Value::String(text) => Self::Text(text.clone()),
            toml::Value::Integer(number) => Self::Integer(*number),
            toml::Value::Float(number) => Self::Number(*number),
            toml::Value::Boolean(flag) => Self::Flag(*flag),
            toml::Value::Datetime(date) => Self::Date(date.to_string()),
            toml::Value::Array(items) => Self::List(items.iter().map(|item| (0, Self::of(item, name))).collect()),
            toml::Value::Table(table) => Self::Table(values(table, name)),
        }
    }
}

/// A parsed table's entries, in the order of the file.
fn entries(table: &DeTable<'_>, prefix: &str, lines: &Lines) -> Vec<Entry> {
    let mut pairs: Vec<(&Spanned<Cow<'_, str>>, &Spanned<DeValue<'_>>)> = table.iter().collect();
    pairs.sort_by_key(|(key, _)| key.span().start);
    let entry = |(key, value): (&Spanned<Cow<'_, str>>, &Spanned<DeValue<'_>>)| {
        let name = dotted(prefix, key.get_ref());
        let value = convert(value.get_ref(), &name, lines);
        Entry { key: key.get_ref().clone().into_owned(), name, line: lines.line(key.span().start), value }
    };
    pairs.into_iter().map(entry).collect()
}

fn list(array: &DeArray<'_>, name: &str, lines: &Lines) -> Vec<(usize, Value)> {
    array.iter().map(|item| (lines.line(item.span().start), convert(item.get_ref(), name, lines))).collect()
}

/// The value of the key with this dotted name.
fn convert(value: &DeValue<'_>, name: &str, lines: &Lines) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.clone().into_owned()),
        DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(integer) => Value::Integer(integer),
            // Beyond 64 bits: the nearest float.
            Err(_) => Value::Number(number.as_str().parse().unwrap_or(f64::INFINITY)),
        },
        // The parser has checked the form; anything Rust cannot parse becomes non-finite and is refused as such.
        DeValue::Float(number) => Value::Number(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Datetime(date) => Value::Date(date.to_string()),
        DeValue::Array(array) => Value::List(list(array, name, lines)),
        DeValue::Table(table) => Value::Table(entries(table, name, lines)),
    }
}

/// Byte offsets of the starts of lines.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    /// The line of a byte offset, from 1.
    fn line(&self, at: usize) -> usize {
        self.0.partition_point(|start| *start <= at).max(1)
    }

    fn line_and_column(&self, text: &str, at: usize) -> (usize, usize) {
        let line = self.line(at);
        let before = text.get(self.0[line - 1]..at).unwrap_or("");
        (line, 1 + before.chars().count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        Document::parse(Path::new("a.toml"), text.to_owned()).unwrap_err().to_string()
    }

    #[test]
    fn broken_toml_is_refused_with_line_and_column() {
        let message = message("[cylinder]\nbore_m = = 2\n");
        assert!(message.starts_with("a.toml: line 2, column "), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }

    #[test]
    fn a_windows_path_in_double_quotes_is_refused_with_what_to_write() {
        for path in ["C:\\Users\\a.csv", "C:\\data\\a.csv", "\\\\server\\runs\\a.csv"] {
            let message = message(&format!("[[experiment]]\ntraces = [\"{path}\"]\n"));
            assert!(message.starts_with("a.toml: line 2, "), "{message}");
            assert!(message.ends_with("in single quotes, or with forward slashes"), "{message}");
        }
        assert!(Document::parse(Path::new("a"), "traces = ['C:\\Users\\a.csv']".into()).is_ok());
    }

    #[test]
    fn a_key_given_twice_is_refused_at_the_second() {
        assert!(message("a = 1\n\na = 2\n").contains("line 3"));
    }

    #[test]
    fn a_second_experiment_in_single_brackets_is_refused_with_what_to_write() {
        let message = message("[experiment]\nname = \"a\"\n\n[experiment]  # later\nname = \"b\"\n");
        assert!(message.contains("line 4") && message.ends_with("with two brackets: [[experiment]]"), "{message}");
    }

    #[test]
    fn a_trace_given_instead_of_a_settings_file_is_named_as_such() {
        let folder = tempfile::tempdir().unwrap();
        let rows: String = (0..9).map(|k| format!("0,{k};1,01;100,0\r\n")).collect();
        let latin: Vec<u8> = format!("Prüfstand\r\nZeit;Druck;Weg\r\n{rows}").chars().map(|c| c as u8).collect();
        for name in ["run.csv", "run.txt", "run"] {
            let path = folder.path().join(name);
            std::fs::write(&path, &latin).unwrap();
            let message = |kind| Document::read_as(kind, &path).unwrap_err().to_string();
            let begin = format!("{}: this looks like a trace; ", path.display());
            assert!(message(Kind::Rig).starts_with(&format!("{begin}a rig file (TOML)")), "{}", message(Kind::Rig));
            assert!(
                message(Kind::Model).starts_with(&format!("{begin}a model file (TOML)")),
                "{}",
                message(Kind::Model)
            );
        }
        for (name, text) in [("rig.toml", &b"bore_m = 0.02 \xb0\n"[..]), ("rig", b"[cylinder\n"), ("rig", b"\0\xff")] {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            let message = Document::read_as(Kind::Rig, &path).unwrap_err().to_string();
            assert!(!message.contains("trace"), "{message}");
        }
    }

    #[test]
    fn a_document_without_a_file_is_complained_about_without_a_line() {
        let table: toml::Table = toml::from_str("[cylinder]\nbore_mm = 32").unwrap();
        let document = Document::from_table(Path::new("rig"), &table);
        let cylinder = document.root().required_table("cylinder").unwrap();
        let message = cylinder.allow(&["bore_m", "rod_m"]).unwrap_err().to_string();
        assert!(message.starts_with("rig: cylinder.bore_mm: unknown key"), "{message}");
        assert!(document.root().allow(&["gas"]).unwrap_err().to_string().starts_with("rig: cylinder: "));
        assert!(document.root().required_table("gas").unwrap_err().to_string().starts_with("rig: gas: "));
    }

    #[test]
    fn a_byte_order_mark_does_not_disturb() {
        assert!(Document::parse(Path::new("a"), "\u{feff}a = 1".into()).is_ok());
    }
}
