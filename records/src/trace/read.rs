//! Reading a trace: the header is matched with the layout, each row checked where it stands.

use super::Trace;
use super::header::Header;
use super::lines::{self, Lines, Stop};
use super::problem::TraceProblem;
use crate::error::Error;
use crate::layout::{Column, Layout, Quantity, Separator};
use crate::limits;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::Path;

/// The most rows a trace may have.
pub const MAX_ROWS: usize = 20_000_000;
/// The least rows that are a record.
const MIN_ROWS: usize = 3;
/// What a gas in a cylinder can have, K.
const GAS_TEMPERATURE_K: std::ops::RangeInclusive<f64> = 20.0..=5000.0;
/// How far a measured position may be beyond an end, as a share of the stroke (or, unknown, of the travel): noise.
const POSITION_SLACK: f64 = 0.01;

/// What a trace is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A measurement: pressure, and every column that the rig maps.
    Measurement,
    /// A motion to simulate along: time and position; the rest where it is there.
    Motion,
}

/// The part of a trace that counts. Rows outside are not looked at, but for their time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// First time, s.
    pub from_s: f64,
    /// Last time, s.
    pub to_s: f64,
}

impl Window {
    /// All of it.
    pub const ALL: Window = Window { from_s: f64::NEG_INFINITY, to_s: f64::INFINITY };
}

/// How a trace is to be read.
#[derive(Clone, Copy, Debug)]
pub struct Reading<'a> {
    /// Its columns.
    pub layout: &'a Layout,
    /// The cylinder's stroke, m: a position beyond it is refused.
    pub stroke_m: Option<f64>,
    /// The part that counts.
    pub window: Window,
    /// What for.
    pub need: Need,
}

pub(super) fn read(path: &Path, reading: &Reading<'_>) -> Result<Trace, Error> {
    let unreadable = |source| Error::Read { path: path.to_owned(), source };
    let facts = std::fs::metadata(path).map_err(unreadable)?;
    if facts.is_dir() {
        let reason = "it is a folder, a trace file is expected";
        return Err(unreadable(io::Error::new(io::ErrorKind::IsADirectory, reason)));
    }
    let refused = |problem| Error::Trace { path: path.to_owned(), problem };
    if facts.len() > lines::MAX_BYTES {
        return Err(refused(lines::too_large(&format!("{} MB", facts.len() >> 20))));
    }
    let mut lines = Lines::new(File::open(path).map_err(unreadable)?);
    let (header, columns) = read_rows(&mut lines, reading).map_err(|stop| match stop {
        Stop::Io(source) => unreadable(source),
        Stop::Problem(problem) => refused(problem),
    })?;
    let mut vectors = columns.into_iter();
    let mut next = |quantity| header.place(quantity).map(|_| vectors.next().unwrap_or_default());
    Ok(Trace {
        path: path.to_owned(),
        sha256: lines.sha256(),
        time_s: next(Quantity::Time).unwrap_or_default(),
        pressure_pa: next(Quantity::Pressure),
        position_m: next(Quantity::Position).unwrap_or_default(),
        ambient_temperature_k: next(Quantity::AmbientTemperature),
        gas_temperature_k: next(Quantity::GasTemperature),
        mass_flow_kg_per_s: next(Quantity::MassFlow),
    })
}

fn read_rows<'a, R: io::Read>(
    lines: &mut Lines<R>,
    reading: &Reading<'a>,
) -> Result<(Header<'a>, Vec<Vec<f64>>), Stop> {
    let (line, first) = lines.next_filled()?.ok_or(TraceProblem::Empty)?;
    let header = Header::read(line, first, reading)?;
    let mut columns = vec![Vec::new(); header.found.len()];
    let mut positions = PositionCheck::new(reading.stroke_m);
    let mut fields = Vec::new();
    let (mut rows, mut before) = (0_usize, f64::NEG_INFINITY);
    while let Some((line, text)) = lines.next_filled()? {
        let row = Row::split(line, text, &mut fields, &header, reading.layout.separator)?;
        rows += 1;
        if rows > MAX_ROWS {
            let limit = format!("{MAX_ROWS} rows");
            return Err(TraceProblem::TooLarge { found: format!("more than {MAX_ROWS} rows"), limit }.into());
        }
        let time = row.time(&header, before)?;
        before = time;
        if time < reading.window.from_s || time > reading.window.to_s {
            continue;
        }
        columns[0].push(time);
        for (&(quantity, field, column), values) in header.found.iter().zip(&mut columns).skip(1) {
            let value = column.si(row.number(field, column)?);
            check(quantity, value, column, line)?;
            if quantity == Quantity::Position {
                positions.take(value, column, line)?;
            }
            values.push(value);
        }
    }
    positions.finish()?;
    enough(rows, columns[0].len(), header.line)?;
    Ok((header, columns))
}

fn enough(rows: usize, used: usize, line: usize) -> Result<(), TraceProblem> {
    match (rows, used) {
        (0, _) => Err(TraceProblem::NoRows { line }),
        (_, used) if used >= MIN_ROWS => Ok(()),
        (rows, used) if rows == used => Err(TraceProblem::FewRows { rows, part: String::new() }),
        (_, used) => Err(TraceProblem::FewRows { rows: used, part: "between from_s and to_s ".to_owned() }),
    }
}

/// One row of the table.
struct Row<'a> {
    line: usize,
    text: &'a str,
    fields: &'a [Range<usize>],
}

impl<'a> Row<'a> {
    fn split(
        line: usize,
        text: &'a str,
        fields: &'a mut Vec<Range<usize>>,
        header: &Header<'_>,
        separator: Separator,
    ) -> Result<Self, TraceProblem> {
        if !lines::split(text, separator, fields) {
            return Err(TraceProblem::OpenQuote { line });
        }
        let (found, expected) = (fields.len(), header.names);
        let surplus_is_blank = fields.iter().skip(expected).all(|field| field.is_empty());
        if found < expected || !surplus_is_blank {
            let more_by_commas = found > expected && separator == Separator::Byte(b',');
            let hint = if more_by_commas { "; are there decimal commas? Numbers are read with points" } else { "" };
            return Err(TraceProblem::FieldCount { line, found, expected, hint });
        }
        Ok(Self { line, text, fields })
    }

    fn time(&self, header: &Header<'_>, before: f64) -> Result<f64, TraceProblem> {
        let (_, field, column) = header.found[0];
        let value = column.si(self.number(field, column)?);
        if value > before {
            return Ok(value);
        }
        Err(TraceProblem::TimeNotIncreasing { line: self.line, column: column.name.clone(), value, before })
    }

    fn number(&self, field: usize, column: &Column) -> Result<f64, TraceProblem> {
        let text = &self.text[self.fields[field].clone()];
        let (line, value) = (self.line, || text.chars().take(40).collect());
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            Ok(_) => Err(TraceProblem::NotFinite { line, column: column.name.clone(), value: value() }),
            Err(_) => Err(TraceProblem::NotANumber {
                line,
                column: column.name.clone(),
                value: value(),
                hint: if text.is_empty() {
                    ", the field is empty"
                } else if text.replacen(',', ".", 1).parse::<f64>().is_ok() {
                    "; numbers are read with a decimal point, not a comma"
                } else {
                    ""
                },
            }),
        }
    }
}

/// Refuses values that cannot be, whatever the cylinder.
fn check(quantity: Quantity, value: f64, column: &Column, line: usize) -> Result<(), TraceProblem> {
    let name = || column.name.clone();
    match quantity {
        Quantity::Pressure if value <= 0.0 => {
            let hint = match column.gauge {
                true => "; it is below vacuum even with the ambient pressure added: look at its unit",
                false => "; for a gauge column say reference = \"gauge\" in the rig's [columns] pressure",
            };
            Err(TraceProblem::NotAbsolute { line, column: name(), value, hint })
        }
        Quantity::AmbientTemperature if !limits::TEMPERATURE_K.allow(value) => temperature(value, column, line),
        Quantity::GasTemperature if !GAS_TEMPERATURE_K.contains(&value) => temperature(value, column, line),
        _ => Ok(()),
    }
}

fn temperature(value: f64, column: &Column, line: usize) -> Result<(), TraceProblem> {
    let celsius = column.unit == "K" && (-100.0..150.0).contains(&value);
    let hint = if celsius { "; for degrees Celsius say unit = \"degC\" in the rig's [columns]" } else { "" };
    Err(TraceProblem::Temperature { line, column: column.name.clone(), value, hint })
}

/// Refuses positions beyond the cylinder's ends, but for a sensor's noise at an end.
struct PositionCheck {
    stroke: Option<f64>,
    low: f64,
    high: f64,
    /// Line and column of the lowest position.
    lowest: Option<(usize, String)>,
}

impl PositionCheck {
    fn new(stroke: Option<f64>) -> Self {
        Self { stroke, low: f64::INFINITY, high: f64::NEG_INFINITY, lowest: None }
    }

    fn take(&mut self, value: f64, column: &Column, line: usize) -> Result<(), TraceProblem> {
        if let Some(stroke) = self.stroke
            && value > stroke * (1.0 + POSITION_SLACK)
        {
            return Err(TraceProblem::BeyondStroke { line, column: column.name.clone(), value, stroke });
        }
        self.high = self.high.max(value);
        if value < self.low {
            self.low = value;
            if value < 0.0 {
                self.lowest = Some((line, column.name.clone()));
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<(), TraceProblem> {
        let slack = POSITION_SLACK * self.stroke.unwrap_or(self.high - self.low);
        match self.lowest {
            Some((line, column)) if self.low < -slack => {
                Err(TraceProblem::NegativePosition { line, column, value: self.low })
            }
            _ => Ok(()),
        }
    }
}
