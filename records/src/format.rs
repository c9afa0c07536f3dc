//! The `[format]` table of a rig file: the text format of a trace file. Omitted keys are detected from the file.

use crate::error::Error;
use crate::table::Table;

/// Separator between the columns of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// One byte: a comma, a semicolon or a tab.
    Byte(u8),
    /// Any number of blanks and tabs. A header that contains commas is split at those.
    Whitespace,
}

impl Separator {
    /// All separators with their names, in the order in which they are tried.
    pub const ALL: [(&'static str, Separator); 4] = [
        ("tab", Separator::Byte(b'\t')),
        (";", Separator::Byte(b';')),
        (",", Separator::Byte(b',')),
        ("whitespace", Separator::Whitespace),
    ];

    /// Its name in a rig file.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, separator)| *separator == self).map_or("other", |(name, _)| name)
    }
}

/// Decimal sign of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimal {
    /// `0.5`
    Point,
    /// `0,5`
    Comma,
}

impl Decimal {
    /// Both, with their notation in a rig file.
    pub const ALL: [(&'static str, Decimal); 2] = [(".", Decimal::Point), (",", Decimal::Comma)];

    /// Its notation in a rig file.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }
}

/// Character encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// UTF-8, including ASCII.
    Utf8,
    /// ISO 8859-1 as Windows extends it (code page 1252).
    Latin1,
    /// UTF-16, little-endian.
    Utf16Le,
    /// UTF-16, big-endian.
    Utf16Be,
}

impl Encoding {
    /// All encodings with their names.
    pub const ALL: [(&'static str, Encoding); 4] = [
        ("utf-8", Encoding::Utf8),
        ("latin-1", Encoding::Latin1),
        ("utf-16le", Encoding::Utf16Le),
        ("utf-16be", Encoding::Utf16Be),
    ];

    /// Its name in a rig file.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }
}

/// Text format of trace files as stated in a rig file.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Format {
    /// Separator between columns.
    pub separator: Option<Separator>,
    /// Decimal sign.
    pub decimal: Option<Decimal>,
    /// Number of lines before the header.
    pub skip_lines: Option<usize>,
    /// Prefix of lines to be skipped.
    pub comment: Option<String>,
    /// Character encoding.
    pub encoding: Option<Encoding>,
}

impl Format {
    /// Reads `[format]` under `root`.
    pub(crate) fn read(root: &Table<'_>) -> Result<Self, Error> {
        let Some(table) = root.table("format")? else { return Ok(Self::default()) };
        table.allow(&["separator", "decimal", "skip_lines", "comment", "encoding"])?;
        let mut separators = Separator::ALL.to_vec();
        separators.push(("\t", Separator::Byte(b'\t')));
        let mut encodings = Encoding::ALL.to_vec();
        encodings.extend([("windows-1252", Encoding::Latin1), ("utf-16", Encoding::Utf16Le)]);
        let format = Self {
            separator: table.choice("separator", &separators)?,
            decimal: table.choice("decimal", &Decimal::ALL)?,
            skip_lines: table.count("skip_lines")?.map(|lines| usize::try_from(lines).unwrap_or(usize::MAX)),
            comment: table.text("comment")?.map(|text| text.trim().to_owned()).filter(|text| !text.is_empty()),
            encoding: table.choice("encoding", &encodings)?,
        };
        if (format.separator, format.decimal) == (Some(Separator::Byte(b',')), Some(Decimal::Comma)) {
            let problem = "commas separate the columns already; no file can have them before decimals as well";
            return Err(table.contradiction("decimal", problem));
        }
        Ok(format)
    }
}
