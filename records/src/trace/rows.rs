//! The rows of a trace: each line is split, read and checked; unusable ones are left out and named.

use super::clock::Clock;
use super::dialect::Dialect;
use super::dropped_rows::{BadRows, DroppedRow, ONE_IN};
use super::fields::{self, is_no_reading, number};
use super::header::Header;
use super::keep::keep_rows;
use super::line_numbers::LineNumbers;
use super::order::{self, Order};
use super::reading::{MAX_ROWS, Reading};
use super::slow_column;
use crate::error::trace::{RowProblem, TraceProblem};
use crate::format::{Decimal, Separator};
use crate::layout::{Column, Quantity};
use crate::limits;
use crate::statistics::{extremes, median};
use std::ops::Range;

/// Plausible temperatures of a gas in a cylinder, K.
const GAS_TEMPERATURE_K: std::ops::RangeInclusive<f64> = 20.0..=5000.0;
/// How far noise may take a position beyond an end, as a fraction of the stroke (or, if unknown, of the travel).
const POSITION_SLACK: f64 = 0.01;
/// Positions further from the sensor's zero are millimetres or inches read as metres, unless a longer stroke is stated: rodless
/// cylinders end at about ten metres.
const LONGEST_STROKE_M: f64 = 20.0;

/// The rows read so far.
pub struct Rows<'a> {
    dialect: &'a Dialect,
    header: &'a Header<'a>,
    reading: &'a Reading<'a>,
    /// One per column found, time first.
    columns: Vec<Vec<f64>>,
    lines: LineNumbers,
    bad: BadRows,
    /// Number of all rows read, inside the window or not, and their earliest and latest time, s.
    seen: usize,
    extent_s: [f64; 2],
    clock: Option<Clock>,
    fields: Vec<Range<usize>>,
}

/// Rows read from a file.
pub struct ReadRows {
    /// One per column found, time first, sorted by time.
    pub columns: Vec<Vec<f64>>,
    /// The lines of its rows in the file.
    pub lines: LineNumbers,
    /// The rows left out.
    pub dropped_rows: Vec<DroppedRow>,
    /// Whether the rows had to be sorted.
    pub sorted: bool,
}

impl<'a> Rows<'a> {
    pub fn new(dialect: &'a Dialect, header: &'a Header<'a>, reading: &'a Reading<'a>) -> Self {
        Self {
            dialect,
            header,
            reading,
            columns: vec![Vec::new(); header.found.len()],
            lines: LineNumbers::default(),
            bad: BadRows::default(),
            seen: 0,
            extent_s: [f64::INFINITY, f64::NEG_INFINITY],
            clock: None,
            fields: Vec::new(),
        }
    }

    /// Processes a line.
    pub fn take(&mut self, line: usize, text: &str) -> Result<(), TraceProblem> {
        self.seen += 1;
        if self.seen > MAX_ROWS {
            let limit = format!("{MAX_ROWS} rows");
            return Err(TraceProblem::TooLarge { found: format!("more than {MAX_ROWS} rows"), limit });
        }
        let mut fields = std::mem::take(&mut self.fields);
        match self.values(text, &mut fields) {
            Ok(Some(values)) => {
                self.lines.push(self.columns[0].len(), line);
                self.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
            }
            Ok(None) => {}
            Err(problem) => self.bad.push(line, problem),
        }
        self.fields = fields;
        Ok(())
    }

    /// The row's numbers, SI; `None` outside the window.
    fn values(&mut self, text: &str, fields: &mut Vec<Range<usize>>) -> Result<Option<[f64; 6]>, RowProblem> {
        if !fields::split(text, self.dialect.separator, fields) {
            return Err(RowProblem::OpenQuote);
        }
        let (found, expected) = (fields.len(), self.dialect.names.len());
        if found < self.dialect.fields || fields.iter().skip(expected).any(|field| !field.is_empty()) {
            let more_by_commas = found > expected && self.dialect.separator == Separator::Byte(b',');
            let hint = if more_by_commas { "; are there decimal commas between the commas?" } else { "" };
            return Err(RowProblem::FieldCount { found, expected, hint });
        }
        let field = |index: usize| fields.get(index).map_or("", |field| &text[field.clone()]);
        let mut values = [0.0; 6];
        for (value, &(quantity, index, column)) in values.iter_mut().zip(&self.header.found) {
            if quantity == Quantity::Time {
                *value = time(&mut self.clock, column, field(index), self.dialect.decimal)?;
                self.extent_s = [self.extent_s[0].min(*value), self.extent_s[1].max(*value)];
                if *value < self.reading.window.from_s || *value > self.reading.window.to_s {
                    return Ok(None);
                }
                continue;
            }
            if field(index).is_empty() {
                *value = slow_column::EMPTY;
                continue;
            }
            *value = column.si(finite(column, field(index), self.dialect.decimal)?);
            check(quantity, *value, column, self.reading.stroke_m)?;
        }
        Ok(Some(values))
    }

    /// The line of a row.
    fn line(&self, row: usize) -> usize {
        self.lines.of(row).unwrap_or(0)
    }

    /// Number of rows read.
    pub fn seen(&self) -> usize {
        self.seen
    }

    /// Earliest and latest time of all rows, s.
    pub fn extent_s(&self) -> [f64; 2] {
        self.extent_s
    }

    /// The table, after all lines are processed.
    pub fn finish(mut self) -> Result<ReadRows, TraceProblem> {
        let all = self.columns[0].len() + self.bad.len();
        self.settle_empty_cells();
        self.leave_out_negative_positions();
        let column = self.header.found[0].2;
        let times = &self.columns[0];
        let mut sorted = false;
        match order::of(times, all / ONE_IN) {
            Order::Increasing => {}
            Order::But(rows) => {
                let problems = rows.iter().map(|&row| (row, out_of_order(column, times, row))).collect();
                self.leave_out(problems);
            }
            Order::Restarts(row) => {
                let (line, column) = (self.line(row), column.name.clone());
                let (value, before) = (times[row], times[row - 1]);
                return Err(TraceProblem::TimeRestarts { line, column, value, before });
            }
            Order::Sorted(rows) => {
                sorted = true;
                self.lines = rows.iter().map(|row| self.line(*row)).collect();
                for column in &mut self.columns {
                    *column = rows.iter().map(|row| column[*row]).collect();
                }
                let times = &self.columns[0];
                let twice: Vec<usize> = (1..times.len()).filter(|row| times[*row] == times[row - 1]).collect();
                if all >= ONE_IN && twice.len() * ONE_IN > all {
                    return Err(coarse(column, times, twice.len()));
                }
                let problems = twice.iter().map(|&row| (row, out_of_order(column, times, row))).collect();
                self.leave_out(problems);
            }
        }
        Ok(ReadRows { dropped_rows: self.bad.few_among(all)?, columns: self.columns, lines: self.lines, sorted })
    }

    /// Fills columns with a value at every k-th row only; leaves out other rows with an empty cell.
    fn settle_empty_cells(&mut self) {
        self.columns.iter_mut().for_each(|column| slow_column::fill(column));
        for index in 1..self.columns.len() {
            let (column, values) = (self.header.found[index].2, &self.columns[index]);
            let problem = |_| finite(column, "", self.dialect.decimal).err();
            let empty = (0..values.len()).filter(|row| values[*row].is_nan());
            let empty = empty.filter_map(|row| Some((row, problem(row)?))).collect();
            self.leave_out(empty);
        }
    }

    /// Leaves out positions below zero, except for sensor noise at the end.
    fn leave_out_negative_positions(&mut self) {
        let Some(index) = self.header.index_of(Quantity::Position) else { return };
        let (column, values) = (self.header.found[index].2, &self.columns[index]);
        let (low, high) = extremes(values);
        let limit = -POSITION_SLACK * self.reading.stroke_m.unwrap_or(high - low);
        if low >= limit {
            return;
        }
        let problem = |value| RowProblem::NegativePosition { column: column.name.clone(), value };
        let below = values.iter().enumerate().filter(|(_, value)| **value < limit);
        let below = below.map(|(row, value)| (row, problem(*value))).collect();
        self.leave_out(below);
    }

    fn leave_out(&mut self, problems: Vec<(usize, RowProblem)>) {
        let mut keep = vec![true; self.columns[0].len()];
        for (row, problem) in problems {
            keep[row] = false;
            self.bad.push(self.line(row), problem);
        }
        self.columns.iter_mut().for_each(|column| keep_rows(column, &keep));
        self.lines.retain(&keep);
    }
}

/// An error for many rows with the same time: the logger or the export has rounded the times.
fn coarse(column: &Column, sorted_times: &[f64], repeats: usize) -> TraceProblem {
    let steps: Vec<f64> = sorted_times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    let (column, rows) = (column.name.clone(), sorted_times.len());
    TraceProblem::CoarseTimes { column, rows, times: rows - repeats, step_s: median(steps) }
}

fn out_of_order(column: &Column, times: &[f64], row: usize) -> RowProblem {
    let (column, value) = (column.name.clone(), times[row]);
    let before = row.checked_sub(1).map(|before| times[before]);
    match (before, times.get(row + 1)) {
        (before, Some(&after)) if before.is_none_or(|before| before < value) && after < value => {
            RowProblem::TimeJumps { column, value, after }
        }
        (Some(before), _) if before != value => RowProblem::TimeOutOfOrder { column, value, before },
        _ => RowProblem::TimeRepeats { column, value },
    }
}

/// A time in seconds: a number, or a moment if the file's first one is.
fn time(clock: &mut Option<Clock>, column: &Column, text: &str, decimal: Decimal) -> Result<f64, RowProblem> {
    if clock.is_none() && (column.is_clock() || number(text, decimal).is_none()) {
        *clock = Clock::beginning_with(text);
    }
    let seconds = match clock {
        Some(clock) => clock.seconds(text),
        None if column.is_clock() => None,
        None => return Ok(column.si(finite(column, text, decimal)?)),
    };
    let kind = "clock time (12:00:00.5 or 2026-11-22T12:00:00.5)";
    seconds.ok_or_else(|| RowProblem::NotANumber { column: column.name.clone(), value: short(text), kind, hint: "" })
}

fn short(text: &str) -> String {
    text.chars().take(40).collect()
}

#[inline]
fn finite(column: &Column, text: &str, decimal: Decimal) -> Result<f64, RowProblem> {
    match number(text, decimal) {
        Some(number) if number.is_finite() && !is_no_reading(number) => Ok(number),
        Some(number) if number.is_finite() => {
            Err(RowProblem::NoReading { column: column.name.clone(), value: short(text) })
        }
        Some(_) => Err(RowProblem::NotFinite { column: column.name.clone(), value: short(text) }),
        None => {
            let other = if decimal == Decimal::Point { Decimal::Comma } else { Decimal::Point };
            let hint = match (text.is_empty(), number(text, other), other) {
                (true, _, _) => ", the field is empty",
                (_, Some(_), Decimal::Comma) => "; for decimal commas say decimal = \",\" in the rig's [format]",
                (_, Some(_), Decimal::Point) => "; for decimal points say decimal = \".\" in the rig's [format]",
                _ => "",
            };
            Err(RowProblem::NotANumber { column: column.name.clone(), value: short(text), kind: "number", hint })
        }
    }
}

/// Refuses impossible values.
#[inline]
fn check(quantity: Quantity, value: f64, column: &Column, stroke_m: Option<f64>) -> Result<(), RowProblem> {
    let name = || column.name.clone();
    match quantity {
        Quantity::Pressure if value <= 0.0 => {
            let hint = match column.gauge {
                true => "; it is below vacuum even with the ambient pressure added: look at its unit",
                false => "; for a gauge column say reference = \"gauge\" in the rig's [columns] pressure",
            };
            Err(RowProblem::NotAbsolute { column: name(), value, hint })
        }
        Quantity::AmbientTemperature if !limits::TEMPERATURE_K.allow(value) => temperature(value, column),
        Quantity::GasTemperature if !GAS_TEMPERATURE_K.contains(&value) => temperature(value, column),
        Quantity::Position => match stroke_m {
            Some(stroke) if value > stroke * (1.0 + POSITION_SLACK) => {
                Err(RowProblem::BeyondStroke { column: name(), value, stroke })
            }
            None if (value - column.offset).abs() > LONGEST_STROKE_M => {
                let hint = match column.unit {
                    "m" => "; for millimetres say unit = \"mm\" in the rig's [columns] position",
                    _ => "; look at its unit and scale",
                };
                Err(RowProblem::FarPosition { column: name(), value, longest: LONGEST_STROKE_M, hint })
            }
            _ => Ok(()),
        },
        _ => Ok(()),
    }
}

fn temperature(value: f64, column: &Column) -> Result<(), RowProblem> {
    let celsius = column.unit == "K" && (-100.0..150.0).contains(&value);
    let hint = if celsius { "; for degrees Celsius say unit = \"degC\" in the rig's [columns]" } else { "" };
    Err(RowProblem::Temperature { column: column.name.clone(), value, hint })
}
