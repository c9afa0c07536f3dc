//! What can be wrong with a trace, in sentences that say where and what to do.

/// What is wrong with a trace. Lines are counted from 1, the header's included.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TraceProblem {
    /// No bytes, or blank lines only.
    #[error("the file is empty; a header line and rows of numbers are expected")]
    Empty,
    /// Nothing but blank lines after those that are passed over.
    #[error("skip_lines = {skipped} in the rig's [format] leaves no line to read; the file has {lines}")]
    AllSkipped {
        /// How many lines are to be passed over.
        skipped: usize,
        /// How many the file has.
        lines: usize,
    },
    /// More than a trace may have.
    #[error("the file has {found}; the limit is {limit}; cut the record, or keep every second row only")]
    TooLarge {
        /// What there is, with its unit.
        found: String,
        /// What there may be, with its unit.
        limit: String,
    },
    /// Not a text file.
    #[error("line {line}: {what}; expected a text table{}", if what.contains("XLS") { "; in the spreadsheet program, save the sheet as CSV" } else { "" })]
    NotText {
        /// Number of the line, counted from 1.
        line: usize,
        /// What stands there instead.
        what: &'static str,
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
    #[error(
        "line {line}: two columns are named `{column}`; choose one by its number, as in name = \"column {second}\""
    )]
    DoubleColumn {
        /// The header's line.
        line: usize,
        /// Name of the column, as the header has it.
        column: String,
        /// The second one's number, from 1.
        second: usize,
    },
    /// A units line that says something else than the rig file.
    #[error(
        "line {line}, column `{column}`: the unit is {found} here, but {expected} in the [columns] of the rig file; write unit = \"{found}\""
    )]
    OtherUnit {
        /// The units line.
        line: usize,
        /// Name of the column, as the header has it.
        column: String,
        /// The unit in the file.
        found: &'static str,
        /// That of the rig file, or the default.
        expected: &'static str,
    },
    /// A column whose name has another unit than the rig file.
    #[error(
        "line {line}, column `{column}`: the unit is {found} by its name, but {expected} in the [columns] of the rig file; write unit = \"{found}\" or, if the name is wrong, name the column by its number: name = \"column {number}\""
    )]
    UnitInName {
        /// The header's line.
        line: usize,
        /// Name of the column, as the header has it.
        column: String,
        /// Its number, from 1.
        number: usize,
        /// The unit in the name.
        found: &'static str,
        /// That of the rig file, or the default.
        expected: &'static str,
    },
    /// Volts that nothing makes a pressure or position of.
    #[error(
        "line {line}, column `{column}`: these are volts here, but {expected} in the [columns] of the rig file; write unit = \"V\" and scale, how many {si} a volt is"
    )]
    Volts {
        /// The line that says so.
        line: usize,
        /// Name of the column, as the header has it.
        column: String,
        /// The unit of the rig file, or the default.
        expected: &'static str,
        /// The SI unit.
        si: &'static str,
    },
    /// A pressure that counts from elsewhere than the rig file says.
    #[error(
        "line {line}, column `{column}`: the pressure is {found} here (`{spelling}`), but {expected} in the [columns] of the rig file; write reference = \"{found}\""
    )]
    OtherReference {
        /// The line that says so.
        line: usize,
        /// Name of the column, as the header has it.
        column: String,
        /// The unit as it is spelled there.
        spelling: String,
        /// gauge or absolute, in the file.
        found: &'static str,
        /// gauge or absolute, in the rig file or by default.
        expected: &'static str,
    },
    /// A record that is there already.
    #[error("the same rows are the record {} already; a copy is no repeat: leave one of them out, or give each its own from_s and to_s", other.display())]
    Copy {
        /// The record with the same rows.
        other: std::path::PathBuf,
    },
    /// A header without rows.
    #[error("there is no row of numbers after the header in line {line}")]
    NoRows {
        /// The header's line.
        line: usize,
    },
    /// Rows whose numbers have another decimal sign than is stated, or than is found: decimal commas in quotes between commas.
    #[error(
        "line {line}: the numbers have decimal {}; say decimal = \"{}\" in the rig's [format]",
        decimals(found),
        found
    )]
    OtherDecimal {
        /// The first row's line.
        line: usize,
        /// What stands before decimals, as `[format]` says it.
        found: &'static str,
    },
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
    ExcelDays {
        /// Name of the column, as the header has it.
        column: String,
        /// The first time.
        from: f64,
        /// The last time.
        to: f64,
    },
    /// Too few rows to be a record.
    #[error("{rows} row{} {part}{} too few for a record; at least 3 are needed", if *rows == 1 { "" } else { "s" }, if *rows == 1 { "is" } else { "are" })]
    FewRows {
        /// How many there are.
        rows: usize,
        /// Of which part of the file, with a blank at its end.
        part: String,
    },
    /// More rows that cannot be used than may be left out.
    #[error("line {line}, {problem}{}", how_many(*bad, *rows, lines))]
    BadRows {
        /// The first such line.
        line: usize,
        /// What is wrong with it.
        problem: Box<RowProblem>,
        /// How many there are.
        bad: usize,
        /// Among how many.
        rows: usize,
        /// The first few of their lines.
        lines: Vec<usize>,
    },
    /// Times that are written too coarsely.
    #[error(
        "column `{column}`: {rows} rows have only {times} different times, {} s apart; write the times with more digits, or \
         take a column that counts the rows, with scale = the seconds from row to row",
        (step_s * 1e9).round() * 1e-9
    )]
    CoarseTimes {
        /// Name of the column, as the header has it.
        column: String,
        /// Rows in the file.
        rows: usize,
        /// How many of them have a time of their own.
        times: usize,
        /// From one time to the next, s.
        step_s: f64,
    },
    /// A clock that starts again.
    #[error(
        "line {line}, column `{column}`: the time restarts at {} s after {} s; put each record into a file of its own",
        seconds(*value), seconds(*before)
    )]
    TimeRestarts {
        /// Number of the line, counted from 1.
        line: usize,
        /// Name of the column, as the header has it.
        column: String,
        /// The time, s.
        value: f64,
        /// That of the row before, s.
        before: f64,
    },
}

fn decimals(sign: &str) -> &'static str {
    if sign == "," { "commas" } else { "points" }
}

/// A time in as many digits as tell it, with an exponent where zeros would lead or follow.
fn seconds(value: f64) -> String {
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

/// What is wrong with one row of a trace.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RowProblem {
    /// A quoted field that does not end.
    #[error("a quote is opened but not closed")]
    OpenQuote,
    /// A row with other fields than the header has names.
    #[error("{found} fields where the header names {expected} columns{hint}")]
    FieldCount {
        /// Number of fields that the line has.
        found: usize,
        /// Number of fields that the header has.
        expected: usize,
        /// What may help.
        hint: &'static str,
    },
    /// Something else than a number.
    #[error("column `{column}`: `{value}` is not a {kind}{hint}")]
    NotANumber {
        /// Name of the column, as the header has it.
        column: String,
        /// What stands there, shortened.
        value: String,
        /// What is expected.
        kind: &'static str,
        /// What may help.
        hint: &'static str,
    },
    /// Not-a-number or infinity.
    #[error("column `{column}`: `{value}` is not a finite number")]
    NotFinite {
        /// Name of the column, as the header has it.
        column: String,
        /// What stands there.
        value: String,
    },
    /// A time that another row has already.
    #[error("column `{column}`: time does not increase, {} s occurs twice", seconds(*value))]
    TimeRepeats {
        /// Name of the column, as the header has it.
        column: String,
        /// The time, s.
        value: f64,
    },
    /// A time that is after those of the rows that follow.
    #[error("column `{column}`: the time jumps to {} s, and the next row has {} s", seconds(*value), seconds(*after))]
    TimeJumps {
        /// Name of the column, as the header has it.
        column: String,
        /// The time, s.
        value: f64,
        /// That of the row after, s.
        after: f64,
    },
    /// A time that is not after that of the row before.
    #[error("column `{column}`: time does not increase, {} s after {} s", seconds(*value), seconds(*before))]
    TimeOutOfOrder {
        /// Name of the column, as the header has it.
        column: String,
        /// The time, s.
        value: f64,
        /// That of the row before, s.
        before: f64,
    },
    /// A pressure at or below vacuum.
    #[error("column `{column}`: {value:?} Pa cannot be an absolute pressure{hint}")]
    NotAbsolute {
        /// Name of the column, as the header has it.
        column: String,
        /// The pressure, Pa.
        value: f64,
        /// What may help.
        hint: &'static str,
    },
    /// A temperature that no chamber has.
    #[error("column `{column}`: a temperature of {value:?} K is not plausible{hint}")]
    Temperature {
        /// Name of the column, as the header has it.
        column: String,
        /// The temperature, K.
        value: f64,
        /// What may help.
        hint: &'static str,
    },
    /// A piston beyond the cylinder's end.
    #[error("column `{column}`: position {value:?} m is beyond the stroke of {stroke:?} m")]
    BeyondStroke {
        /// Name of the column, as the header has it.
        column: String,
        /// The position, m.
        value: f64,
        /// Stroke of the cylinder, m, within which positions lie.
        stroke: f64,
    },
    /// A position that no cylinder has, where the rig states no stroke.
    #[error(
        "column `{column}`: a position of {value:.2} m is not plausible, no cylinder is longer than {longest} m{hint}"
    )]
    FarPosition {
        /// Name of the column, as the header has it.
        column: String,
        /// The position, m.
        value: f64,
        /// Stroke that no cylinder exceeds, m.
        longest: f64,
        /// What may help.
        hint: &'static str,
    },
    /// A piston on the wrong side of the chamber's end.
    #[error(
        "column `{column}`: position {value:?} m is below zero; positions count from the end of the chamber: set sign and \
         offset_m of position in the [columns] of the rig file"
    )]
    NegativePosition {
        /// Name of the column, as the header has it.
        column: String,
        /// The position, m.
        value: f64,
    },
}
