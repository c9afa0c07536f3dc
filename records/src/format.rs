//! The `[format]` table of a rig file: how the text of a trace file is written. What it leaves out is found in the file.

use crate::error::Error;
use crate::table::Table;

/// What stands between the columns of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// This byte between two fields: a comma, a semicolon, a tab.
    Byte(u8),
    /// Any number of blanks and tabs. A header that has commas is split at those.
    Whitespace,
}

impl Separator {
    /// All of them by name, in the order in which they are looked for.
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

/// What stands before a number's decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimal {
    /// `0.5`
    Point,
    /// `0,5`
    Comma,
}

impl Decimal {
    /// Both, by what stands in a rig file.
    pub const ALL: [(&'static str, Decimal); 2] = [(".", Decimal::Point), (",", Decimal::Comma)];

    /// What stands in a rig file.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }
}

/// How characters are written as bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// UTF-8, ASCII among it.
    Utf8,
    /// ISO 8859-1 as Windows extends it (code page 1252).
    Latin1,
    /// UTF-16, the less significant byte first.
    Utf16Le,
    /// UTF-16, the more significant byte first.
    Utf16Be,
}

impl Encoding {
    /// All of them, by name.
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

/// What a rig file says about its trace files' text.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Format {
    /// What stands between columns.
    pub separator: Option<Separator>,
    /// What stands before decimals.
    pub decimal: Option<Decimal>,
    /// How many lines stand before the header.
    pub skip_lines: Option<usize>,
    /// What a line begins with that is to be passed over.
    pub comment: Option<String>,
    /// How characters are written.
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
