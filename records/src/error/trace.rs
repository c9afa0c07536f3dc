//! Errors in a trace, as sentences that say where and what to do.

/// An error in a trace. Lines are counted from 1, header included; columns are named as in the header; values are SI. `found` is
/// what the file has, `expected` what the rig file states or defaults to; a hint suggests a remedy.
#[allow(missing_docs)]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TraceProblem {
    /// No bytes, or blank lines only.
    #[error("the file is empty; a header line and rows of numbers are expected")]
    Empty,
    /// Only blank lines after those skipped.
    #[error("skip_lines = {skipped} in the rig's [format] leaves no line to read; the file has {lines}")]
    AllSkipped { skipped: usize, lines: usize },
    /// Larger than the limit for a trace.
    #[error("the file has {found}; the limit is {limit}; cut the record, or keep every second row only")]
    TooLarge { found: String, limit: String },
    /// Not a text file.
    #[error("line {line}: {what}; expected a text table{}", if what.contains("XLS") { "; in the spreadsheet program, save the sheet as CSV" } else { "" })]
    NotText { line: usize, what: &'static str },
    /// A missing column.
    #[error("line {line}: there is no column `{column}`{hint}; the columns are {}", there.join(", "))]
    MissingColumn { line: usize, column: String, there: Vec<String>, hint: String },
    /// A column name shared by two columns.
    #[error(
        "line {line}: two columns are named `{column}`; choose one by its number, as in name = \"column {second}\""
    )]
    DoubleColumn { line: usize, column: String, second: usize },
    /// A units line that contradicts the rig file.
    #[error(
        "line {line}, column `{column}`: the unit is {found} here, but {expected} in the [columns] of the rig file; write unit = \"{found}\""
    )]
    OtherUnit { line: usize, column: String, found: &'static str, expected: &'static str },
    /// A column whose name states another unit than the rig file.
    #[error(
        "line {line}, column `{column}`: the unit is {found} by its name, but {expected} in the [columns] of the rig file; write unit = \"{found}\" or, if the name is wrong, name the column by its number: name = \"column {number}\""
    )]
    UnitInName { line: usize, column: String, number: usize, found: &'static str, expected: &'static str },
    /// Volts without a scale to pressure or position.
    #[error(
        "line {line}, column `{column}`: these are volts here, but {expected} in the [columns] of the rig file; write unit = \"V\" and scale, how many {si} a volt is"
    )]
    Volts { line: usize, column: String, expected: &'static str, si: &'static str },
    /// A pressure whose reference differs from the rig file's.
    #[error(
        "line {line}, column `{column}`: the pressure is {found} here (`{spelling}`), but {expected} in the [columns] of the rig file; write reference = \"{found}\""
    )]
    OtherReference { line: usize, column: String, spelling: String, found: &'static str, expected: &'static str },
    /// A record read already.
    #[error("the same rows are the record {} already; a copy is no repeat: leave one of them out, or give each its own from_s and to_s", other.display())]
    Copy { other: std::path::PathBuf },
    /// A header without rows.
    #[error("there is no row of numbers after the header in line {line}")]
    NoRows { line: usize },
    /// Numbers with another decimal sign than stated or detected: decimal commas in quotes between commas.
    #[error(
        "line {line}: the numbers have decimal {}; say decimal = \"{}\" in the rig's [format]",
        decimals(found),
        found
    )]
    OtherDecimal { line: usize, found: &'static str },
    /// A text without a table.
    #[error(
        "one column only; a table with time, pressure and position is expected, with commas, semicolons, tabs or blanks between \
         the columns"
    )]
    OneColumn,
    /// Excel's day numbers, read as seconds.
    #[error(
        "column `{column}`: times from {from:?} to {to:?} are days as Excel counts them, not seconds; write unit = \"d\" for \
         time in the [columns] of the rig file"
    )]
    ExcelDays { column: String, from: f64, to: f64 },
    /// An error that refers to a rig file when there is none yet.
    #[error(
        "{problem} (`look` finds no other way to read the file, and there is no rig file yet: write one by hand that states how to read it)"
    )]
    WithoutRig { problem: Box<TraceProblem> },
    /// Too few rows to be a record.
    #[error("{rows} row{} {part}{} too few for a record; at least 3 are needed", if *rows == 1 { "" } else { "s" }, if *rows == 1 { "is" } else { "are" })]
    FewRows {
        rows: usize,
        /// The part of the file, with a trailing blank.
        part: String,
    },
    /// More unusable rows than may be left out.
    #[error("line {line}, {problem}{}", how_many(*bad, *rows, lines))]
    BadRows { line: usize, problem: Box<RowProblem>, bad: usize, rows: usize, lines: Vec<usize> },
    /// Times written with too few digits.
    #[error(
        "column `{column}`: {rows} rows have only {times} different times, {} s apart; write the times with more digits, or \
         take a column that counts the rows, with scale = the seconds from row to row",
        (step_s * 1e9).round() * 1e-9
    )]
    CoarseTimes { column: String, rows: usize, times: usize, step_s: f64 },
    /// A clock that restarts.
    #[error(
        "line {line}, column `{column}`: the time restarts at {} s after {} s; put each record into a file of its own, or correct the times if the clock was set back",
        seconds(*value), seconds(*before)
    )]
    TimeRestarts { line: usize, column: String, value: f64, before: f64 },
}

impl TraceProblem {
    /// Whether its sentence suggests a change to the rig file.
    pub fn is_of_a_rig_file(&self) -> bool {
        match self {
            Self::AllSkipped { .. }
            | Self::OtherUnit { .. }
            | Self::UnitInName { .. }
            | Self::Volts { .. }
            | Self::OtherReference { .. }
            | Self::OtherDecimal { .. }
            | Self::ExcelDays { .. } => true,
            Self::BadRows { problem, .. } => problem.is_of_a_rig_file(),
            _ => false,
        }
    }
}

fn decimals(sign: &str) -> &'static str {
    if sign == "," { "commas" } else { "points" }
}

/// A time with as many digits as needed, with an exponent where there would be leading or trailing zeros.
fn seconds(value: f64) -> String {
    // Times relative to a first row have rounding errors below a nanosecond.
    let value = if (1.0..1e6).contains(&value.abs()) { (value * 1e9).round() / 1e9 } else { value };
    if value != 0.0 && !(1e-4..1e9).contains(&value.abs()) { format!("{value:e}") } else { format!("{value}") }
}

fn how_many(bad: usize, rows: usize, lines: &[usize]) -> String {
    if bad == 1 {
        return format!("; this is one of only {rows} rows, and at most one in fifty may be left out");
    }
    let more = if bad > lines.len() { ", ..." } else { "" };
    let lines: Vec<String> = lines.iter().map(usize::to_string).collect();
    format!(
        "; {bad} of {rows} rows cannot be used (lines {}{more}), and at most one in fifty may be left out",
        lines.join(", ")
    )
}

/// An error in one row of a trace. Columns are named as in the header; values are SI, texts shortened.
#[allow(missing_docs)]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RowProblem {
    /// An unterminated quoted field.
    #[error("a quote is opened but not closed")]
    OpenQuote,
    /// A row with another number of fields than the header has names.
    #[error("{found} fields where the header names {expected} columns{hint}")]
    FieldCount { found: usize, expected: usize, hint: &'static str },
    /// A field that is not a number.
    #[error("column `{column}`: `{value}` is not a {kind}{hint}")]
    NotANumber { column: String, value: String, kind: &'static str, hint: &'static str },
    /// Not-a-number or infinity.
    #[error("column `{column}`: `{value}` is not a finite number")]
    NotFinite { column: String, value: String },
    /// A number by which an instrument marks a missing reading.
    #[error("column `{column}`: `{value}` is an instrument's mark of no reading")]
    NoReading { column: String, value: String },
    /// A time that another row already has.
    #[error("column `{column}`: time does not increase, {} s occurs twice", seconds(*value))]
    TimeRepeats { column: String, value: f64 },
    /// A time later than those of the following rows.
    #[error("column `{column}`: the time jumps to {} s, and the next row has {} s", seconds(*value), seconds(*after))]
    TimeJumps { column: String, value: f64, after: f64 },
    /// A time not later than that of the row before.
    #[error("column `{column}`: time does not increase, {} s after {} s", seconds(*value), seconds(*before))]
    TimeOutOfOrder { column: String, value: f64, before: f64 },
    /// A pressure at or below vacuum.
    #[error("column `{column}`: {value:?} Pa cannot be an absolute pressure{hint}")]
    NotAbsolute { column: String, value: f64, hint: &'static str },
    /// A temperature implausible for a chamber.
    #[error("column `{column}`: a temperature of {value:?} K is not plausible{hint}")]
    Temperature { column: String, value: f64, hint: &'static str },
    /// A piston position beyond the stroke.
    #[error("column `{column}`: position {value:?} m is beyond the stroke of {stroke:?} m")]
    BeyondStroke { column: String, value: f64, stroke: f64 },
    /// A position beyond any cylinder's length, where the rig states no stroke.
    #[error(
        "column `{column}`: a position of {value:.2} m is not plausible, no cylinder is longer than {longest} m{hint}"
    )]
    FarPosition { column: String, value: f64, longest: f64, hint: &'static str },
    /// A piston position below zero.
    #[error(
        "column `{column}`: position {value:?} m is below zero; positions count from the end of the chamber: set sign and \
         offset_m of position in the [columns] of the rig file"
    )]
    NegativePosition { column: String, value: f64 },
}

impl RowProblem {
    /// Whether its sentence suggests a change to the rig file, as every hint does.
    fn is_of_a_rig_file(&self) -> bool {
        match self {
            Self::NegativePosition { .. } => true,
            Self::NotANumber { hint, .. }
            | Self::NotAbsolute { hint, .. }
            | Self::Temperature { hint, .. }
            | Self::FarPosition { hint, .. } => !hint.is_empty(),
            _ => false,
        }
    }
}
