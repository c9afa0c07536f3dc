//! What can be wrong with a trace, in sentences that say where and what to do.

/// What is wrong with a trace. Lines are counted from 1, the header's included.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TraceProblem {
    /// No bytes, or blank lines only.
    #[error("the file is empty; a header line and rows of numbers are expected")]
    Empty,
    /// More than a trace may have.
    #[error("{found} are more than a trace may have ({limit}); cut it, or thin it out")]
    TooLarge {
        /// What there is, with its unit.
        found: String,
        /// What there may be, with its unit.
        limit: String,
    },
    /// Not a text file.
    #[error("line {line}: {what}; a table in UTF-8 text is expected")]
    NotText {
        /// The line.
        line: usize,
        /// What stands there instead.
        what: &'static str,
    },
    /// A quoted field that does not end.
    #[error("line {line}: a quote is opened but not closed")]
    OpenQuote {
        /// The line.
        line: usize,
    },
    /// A first line of numbers.
    #[error("line {line}: the first line holds numbers; a header line with the columns' names is expected before them")]
    NoHeader {
        /// The line.
        line: usize,
    },
    /// A column that is not there.
    #[error("line {line}: there is no column `{column}`{hint}; the columns are {}", there.join(", "))]
    MissingColumn {
        /// The header's line.
        line: usize,
        /// The wanted column.
        column: String,
        /// Those that are there.
        there: Vec<String>,
        /// What may help: the nearest name, the separator.
        hint: String,
    },
    /// A column name that two columns have.
    #[error("line {line}: two columns are named `{column}`")]
    DoubleColumn {
        /// The header's line.
        line: usize,
        /// The name.
        column: String,
    },
    /// A header without rows.
    #[error("there is no row after the header in line {line}")]
    NoRows {
        /// The header's line.
        line: usize,
    },
    /// Too few rows to be a record.
    #[error("{rows} row{} {part}{} too few for a record; 3 are the least", if *rows == 1 { "" } else { "s" }, if *rows == 1 { "is" } else { "are" })]
    FewRows {
        /// How many there are.
        rows: usize,
        /// Of which part of the file, with a blank at its end.
        part: String,
    },
    /// A row with other fields than the header has names.
    #[error("line {line}: {found} fields where the header names {expected} columns{hint}")]
    FieldCount {
        /// The line.
        line: usize,
        /// Its fields.
        found: usize,
        /// The header's.
        expected: usize,
        /// What may help.
        hint: &'static str,
    },
    /// Something else than a number.
    #[error("line {line}, column `{column}`: `{value}` is not a number{hint}")]
    NotANumber {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// What stands there, shortened.
        value: String,
        /// What may help.
        hint: &'static str,
    },
    /// Not-a-number or infinity.
    #[error("line {line}, column `{column}`: `{value}` is not a finite number; drop the row or mend it")]
    NotFinite {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// What stands there.
        value: String,
    },
    /// Time that stands still or runs backward.
    #[error("line {line}, column `{column}`: time does not increase: {value:?} s after {before:?} s")]
    TimeNotIncreasing {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// The time, s.
        value: f64,
        /// That of the row before, s.
        before: f64,
    },
    /// A pressure at or below vacuum.
    #[error("line {line}, column `{column}`: {value:?} Pa cannot be an absolute pressure{hint}")]
    NotAbsolute {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// The pressure, Pa.
        value: f64,
        /// What may help.
        hint: &'static str,
    },
    /// A temperature that no chamber has.
    #[error("line {line}, column `{column}`: {value:?} K cannot be{hint}")]
    Temperature {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// The temperature, K.
        value: f64,
        /// What may help.
        hint: &'static str,
    },
    /// A piston beyond the cylinder's end.
    #[error("line {line}, column `{column}`: position {value:?} m is beyond the stroke of {stroke:?} m")]
    BeyondStroke {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// The position, m.
        value: f64,
        /// The stroke, m.
        stroke: f64,
    },
    /// A piston on the wrong side of the chamber's end.
    #[error(
        "line {line}, column `{column}`: position {value:?} m is below zero; it counts from the chamber's end: \
         say sign and offset_m in the rig's [columns] position"
    )]
    NegativePosition {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// The position, m.
        value: f64,
    },
}
