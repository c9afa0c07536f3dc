//! What can be wrong with a trace, in sentences that say where and what to do.

/// What is wrong with a trace. Lines are counted from 1, the header's included; columns are named as in the header; values are SI.
/// `found` is what the file has, `expected` what the rig file says or leaves as usual; a hint says what may help.
#[allow(missing_docs)]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TraceProblem {
    /// No bytes, or blank lines only.
    #[error("the file is empty; a header line and rows of numbers are expected")]
    Empty,
    /// Nothing but blank lines after those that are passed over.
    #[error("skip_lines = {skipped} in the rig's [format] leaves no line to read; the file has {lines}")]
    AllSkipped { skipped: usize, lines: usize },
    /// More than a trace may have.
    #[error("the file has {found}; the limit is {limit}; cut the record, or keep every second row only")]
    TooLarge { found: String, limit: String },
    /// Not a text file.
    #[error("line {line}: {what}; expected a text table{}", if what.contains("XLS") { "; in the spreadsheet program, save the sheet as CSV" } else { "" })]
    NotText { line: usize, what: &'static str },
    /// A column that is not there.
    #[error("line {line}: there is no column `{column}`{hint}; the columns are {}", there.join(", "))]
    MissingColumn { line: usize, column: String, there: Vec<String>, hint: String },
    /// A column name that two columns have.
    #[error(
        "line {line}: two columns are named `{column}`; choose one by its number, as in name = \"column {second}\""
    )]
    DoubleColumn { line: usize, column: String, second: usize },
    /// A units line that says something else than the rig file.
    #[error(
        "line {line}, column `{column}`: the unit is {found} here, but {expected} in the [columns] of the rig file; write unit = \"{found}\""
    )]
    OtherUnit { line: usize, column: String, found: &'static str, expected: &'static str },
    /// A column whose name has another unit than the rig file.
    #[error(
        "line {line}, column `{column}`: the unit is {found} by its name, but {expected} in the [columns] of the rig file; write unit = \"{found}\" or, if the name is wrong, name the column by its number: name = \"column {number}\""
    )]
    UnitInName { line: usize, column: String, number: usize, found: &'static str, expected: &'static str },
    /// Volts that nothing makes a pressure or position of.
    #[error(
        "line {line}, column `{column}`: these are volts here, but {expected} in the [columns] of the rig file; write unit = \"V\" and scale, how many {si} a volt is"
    )]
    Volts { line: usize, column: String, expected: &'static str, si: &'static str },
    /// A pressure that counts from elsewhere than the rig file says.
    #[error(
        "line {line}, column `{column}`: the pressure is {found} here (`{spelling}`), but {expected} in the [columns] of the rig file; write reference = \"{found}\""
    )]
    OtherReference { line: usize, column: String, spelling: String, found: &'static str, expected: &'static str },
    /// A record that is there already.
    #[error("the same rows are the record {} already; a copy is no repeat: leave one of them out, or give each its own from_s and to_s", other.display())]
    Copy { other: std::path::PathBuf },
    /// A header without rows.
    #[error("there is no row of numbers after the header in line {line}")]
    NoRows { line: usize },
    /// Rows whose numbers have another decimal sign than is stated, or than is found: decimal commas in quotes between commas.
    #[error(
        "line {line}: the numbers have decimal {}; say decimal = \"{}\" in the rig's [format]",
        decimals(found),
        found
    )]
    OtherDecimal { line: usize, found: &'static str },
    /// A text that is no table.
    #[error(
        "one column only; a table with time, pressure and position is expected, with commas, semicolons, tabs or blanks between \
         the columns"
    )]
    OneColumn,
    /// Excel's days, taken for seconds.
    #[error(
        "column `{column}`: times from {from:?} to {to:?} are days as Excel counts them, not seconds; write unit = \"d\" for \
         time in the [columns] of the rig file"
    )]
    ExcelDays { column: String, from: f64, to: f64 },
    /// What speaks of a rig file where none is there yet.
    #[error(
        "{problem} (`look` finds no other way to read the file, and there is no rig file yet: write one by hand that states how to read it)"
    )]
    WithoutRig { problem: Box<TraceProblem> },
    /// Too few rows to be a record.
    #[error("{rows} row{} {part}{} too few for a record; at least 3 are needed", if *rows == 1 { "" } else { "s" }, if *rows == 1 { "is" } else { "are" })]
    FewRows {
        rows: usize,
        /// Of which part of the file, with a blank at its end.
        part: String,
    },
    /// More rows that cannot be used than may be left out.
    #[error("line {line}, {problem}{}", how_many(*bad, *rows, lines))]
    BadRows { line: usize, problem: Box<RowProblem>, bad: usize, rows: usize, lines: Vec<usize> },
    /// Times that are written too coarsely.
    #[error(
        "column `{column}`: {rows} rows have only {times} different times, {} s apart; write the times with more digits, or \
         take a column that counts the rows, with scale = the seconds from row to row",
        (step_s * 1e9).round() * 1e-9
    )]
    CoarseTimes { column: String, rows: usize, times: usize, step_s: f64 },
    /// A clock that starts again.
    #[error(
        "line {line}, column `{column}`: the time restarts at {} s after {} s; put each record into a file of its own, or correct the times if the clock was set back",
        seconds(*value), seconds(*before)
    )]
    TimeRestarts { line: usize, column: String, value: f64, before: f64 },
}

impl TraceProblem {
    /// Whether its sentence says what to change in the rig file.
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

/// A time in as many digits as tell it, with an exponent where zeros would lead or follow.
fn seconds(value: f64) -> String {
    // What counts from a first row has round-off behind its nanoseconds.
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

/// What is wrong with one row of a trace. Columns are named as in the header; values are SI, texts shortened.
#[allow(missing_docs)]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RowProblem {
    /// A quoted field that does not end.
    #[error("a quote is opened but not closed")]
    OpenQuote,
    /// A row with other fields than the header has names.
    #[error("{found} fields where the header names {expected} columns{hint}")]
    FieldCount { found: usize, expected: usize, hint: &'static str },
    /// Something else than a number.
    #[error("column `{column}`: `{value}` is not a {kind}{hint}")]
    NotANumber { column: String, value: String, kind: &'static str, hint: &'static str },
    /// Not-a-number or infinity.
    #[error("column `{column}`: `{value}` is not a finite number")]
    NotFinite { column: String, value: String },
    /// A number by which an instrument says that it has none.
    #[error("column `{column}`: `{value}` is an instrument's mark of no reading")]
    NoReading { column: String, value: String },
    /// A time that another row has already.
    #[error("column `{column}`: time does not increase, {} s occurs twice", seconds(*value))]
    TimeRepeats { column: String, value: f64 },
    /// A time that is after those of the rows that follow.
    #[error("column `{column}`: the time jumps to {} s, and the next row has {} s", seconds(*value), seconds(*after))]
    TimeJumps { column: String, value: f64, after: f64 },
    /// A time that is not after that of the row before.
    #[error("column `{column}`: time does not increase, {} s after {} s", seconds(*value), seconds(*before))]
    TimeOutOfOrder { column: String, value: f64, before: f64 },
    /// A pressure at or below vacuum.
    #[error("column `{column}`: {value:?} Pa cannot be an absolute pressure{hint}")]
    NotAbsolute { column: String, value: f64, hint: &'static str },
    /// A temperature that no chamber has.
    #[error("column `{column}`: a temperature of {value:?} K is not plausible{hint}")]
    Temperature { column: String, value: f64, hint: &'static str },
    /// A piston beyond the cylinder's end.
    #[error("column `{column}`: position {value:?} m is beyond the stroke of {stroke:?} m")]
    BeyondStroke { column: String, value: f64, stroke: f64 },
    /// A position that no cylinder has, where the rig states no stroke.
    #[error(
        "column `{column}`: a position of {value:.2} m is not plausible, no cylinder is longer than {longest} m{hint}"
    )]
    FarPosition { column: String, value: f64, longest: f64, hint: &'static str },
    /// A piston on the wrong side of the chamber's end.
    #[error(
        "column `{column}`: position {value:?} m is below zero; positions count from the end of the chamber: set sign and \
         offset_m of position in the [columns] of the rig file"
    )]
    NegativePosition { column: String, value: f64 },
}

impl RowProblem {
    /// Whether its sentence says what to change in the rig file: where it has a hint, that is one.
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
