//! Time courses of some rows of a study, sampled at a fixed rate: a second table alongside the parts.
//!
//! Integrated by `chamber::simulate`, independently of the batches, with the same samples: the gas, and what the sensor shows. At
//! most `TOGETHER` samples are in memory, or one row's.

use crate::error::Error;
use crate::file_names::TRACES_PATH;
use crate::folder::Folder;
use crate::part::columns;
use crate::part::encoding;
use crate::part::new_file::NewFile;
use crate::part::status_column;
use crate::result::status::Status;
use crate::row;
use crate::store::Store;
use crate::study::Study;
use arrow::array::{ArrayRef, Float64Array, Int64Array};
use arrow::datatypes::{DataType, Schema, SchemaRef};
use arrow::record_batch::RecordBatch;
use chamber::balance::Boundary;
use chamber::integrate::IntegrationError;
use chamber::record::Inputs;
use chamber::simulate::{Sample, Start, simulate};
use ensemble::Scenario;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Default sample rate, Hz: that of the paper's record.
pub const RATE_HZ: f64 = 100.0;
/// Maximum number of samples of one row.
const MOST: f64 = 1e7;
/// Samples computed together, over all threads.
const TOGETHER: usize = 1 << 19;

/// Rows with requested traces, sorted and without duplicates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowNumbers(Vec<Range<u64>>);

impl RowNumbers {
    /// Indices of the rows, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u64> + '_ {
        self.0.iter().cloned().flatten()
    }

    /// Index after the last row.
    fn end(&self) -> u64 {
        self.0.last().map_or(0, |range| range.end)
    }
}

impl std::str::FromStr for RowNumbers {
    type Err = String;

    /// `0,17,100-119`: numbers and ranges, both ends included.
    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || format!("`{text}` is no list of rows; expected numbers and ranges such as 0,17,100-119");
        let mut ranges = Vec::new();
        for piece in text.split(',') {
            let (first, last) = piece.split_once('-').unwrap_or((piece, piece));
            let number = |text: &str| text.trim().parse::<u64>().ok().filter(|n| *n < u64::MAX);
            match (number(first), number(last)) {
                (Some(first), Some(last)) if first <= last => ranges.push(first..last + 1),
                _ => return Err(refused()),
            }
        }
        ranges.sort_by_key(|range| range.start);
        let mut rows: Vec<Range<u64>> = Vec::with_capacity(ranges.len());
        for range in ranges {
            match rows.last_mut() {
                Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
                _ => rows.push(range),
            }
        }
        Ok(Self(rows))
    }
}

/// Summary of `traces/traces.parquet`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Number of rows with a trace.
    pub rows: u64,
    /// Total number of samples.
    pub samples: u64,
    /// Rows without a trace, and why.
    pub without: Vec<(u64, String)>,
}

/// A column of the table.
pub struct Column {
    /// Its name, with the unit's suffix.
    pub name: &'static str,
    /// The unit, for display.
    pub unit: &'static str,
    /// One-line description for people.
    pub doc: &'static str,
    value: fn(&Sample, f64) -> f64,
}

/// All columns after the row's number, in order. Functions of a sample and the piston's position, m.
#[rustfmt::skip]
pub const COLUMNS: [Column; 8] = [
    Column { name: "time_s", unit: "s", doc: "Time from the start of the push", value: |s, _| s.time },
    Column { name: "position_m", unit: "m", doc: "Distance of the piston face from the chamber's end", value: |_, x| x },
    Column { name: "pressure_pa", unit: "Pa", doc: "What the sensor would show, sensor effects included", value: |s, _| s.measured_pressure },
    Column { name: "gas_pressure_pa", unit: "Pa", doc: "Pressure of the gas", value: |s, _| s.gas_pressure },
    Column { name: "temperature_k", unit: "K", doc: "Mean temperature of the gas", value: |s, _| s.temperature },
    Column { name: "mass_kg", unit: "kg", doc: "Mass of the gas", value: |s, _| s.mass },
    Column { name: "volume_m3", unit: "m3", doc: "Volume of the gas", value: |s, _| s.volume },
    Column { name: "heat_flow_w", unit: "W", doc: "Heat flow into the gas", value: |s, _| s.heat_flow },
];

/// Checks, as far as possible before the study is run, whether the traces of some rows can be written.
///
/// # Errors
/// A row that the study does not have, an invalid rate, or a trace that would be too long.
pub fn check(study: &Study, rows: &RowNumbers, rate_hz: f64) -> Result<(), Error> {
    if rows.end() > study.rows {
        let last = study.rows.saturating_sub(1);
        return Err(Error::Option(format!(
            "a trace of row {} is asked for; the study's rows are 0 to {last}",
            rows.end() - 1
        )));
    }
    if !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err(Error::Option(format!("the trace rate is {rate_hz} Hz; expected a positive number")));
    }
    for row in rows.iter() {
        if let Ok(scenario) = scenario(study, row)? {
            samples_of(row, &scenario, rate_hz)?;
        }
    }
    Ok(())
}

/// Writes the traces of some rows alongside the study's parts. The file appears when complete, replacing an earlier one; the
/// manifest of a finished study then lists it.
///
/// # Errors
/// As [`check`], or if the folder belongs to another study or cannot be written.
pub fn write(study: &Study, store: &dyn Store, rows: &RowNumbers, rate_hz: f64) -> Result<Report, Error> {
    check(study, rows, rate_hz)?;
    let folder = Folder::open(study, store)?;
    folder.prepare()?;
    let path = folder.path(TRACES_PATH);
    let schema = schema();
    let rate = [("sample_rate_hz", rate_hz.to_string())];
    let properties = encoding::properties(study, &schema, &rate);
    let mut file = NewFile::create(&folder.staging()?, &path, schema.clone(), properties)?;
    let mut report = Report::default();
    let mut wave: Vec<(u64, Scenario, usize)> = Vec::new();
    let mut waiting = 0;
    for row in rows.iter() {
        match scenario(study, row)? {
            Ok(scenario) => {
                let samples = samples_of(row, &scenario, rate_hz)?;
                wave.push((row, scenario, samples));
                waiting += samples;
            }
            Err(why) => report.without.push((row, why)),
        }
        if waiting >= TOGETHER {
            flush(study, &schema, rate_hz, &mut wave, &mut file, &mut report)?;
            waiting = 0;
        }
    }
    flush(study, &schema, rate_hz, &mut wave, &mut file, &mut report)?;
    let ended = file.end()?;
    folder.record_result(TRACES_PATH, ended.digest())?;
    ended.publish(store, TRACES_PATH)?;
    folder.renew_manifest()?;
    report.without.sort();
    Ok(report)
}

/// The test of a row, or the reason why there is none.
fn scenario(study: &Study, row: u64) -> Result<Result<Scenario, String>, Error> {
    let mut values = vec![Vec::with_capacity(1); study.varied.len()];
    study.design.fill(row..row + 1, &mut values)?;
    let mut point = study.base;
    study.vary(&mut point, &values, 0);
    Ok(row::scenario(study, &point).map_err(|status| match status {
        Status::Failed(failure) => failure.to_string(),
        other => status_column::text(other, study).into_owned(),
    }))
}

/// Number of samples in a row's trace.
fn samples_of(row: u64, scenario: &Scenario, rate_hz: f64) -> Result<usize, Error> {
    let samples = scenario.duration_s * rate_hz + 2.0;
    if samples > MOST {
        let message =
            format!("the trace of row {row} would have {samples:.0} samples, more than {MOST}: ask for a lower rate");
        return Err(Error::Option(message));
    }
    Ok(samples as usize)
}

/// Computes the pending rows and writes them in order.
fn flush(
    study: &Study,
    schema: &SchemaRef,
    rate_hz: f64,
    wave: &mut Vec<(u64, Scenario, usize)>,
    file: &mut NewFile,
    report: &mut Report,
) -> Result<(), Error> {
    let one = |(row, scenario, _): &(u64, Scenario, usize)| (*row, trace(scenario, rate_hz, study.tolerance));
    let traces: Vec<_> = wave.par_iter().map(one).collect();
    for ((row, samples), (_, scenario, _)) in traces.into_iter().zip(wave.iter()) {
        match samples {
            Ok(samples) => {
                file.write(&batch(study, schema, row, scenario, &samples)?)?;
                report.rows += 1;
                report.samples += samples.len() as u64;
            }
            Err(error) => report.without.push((row, error.to_string())),
        }
    }
    wave.clear();
    Ok(())
}

fn schema() -> SchemaRef {
    let mut fields = vec![columns::row_number()];
    fields.extend(COLUMNS.iter().map(|c| columns::field(c.name, DataType::Float64, false, c.unit, c.doc)));
    Arc::new(Schema::new(fields))
}

fn batch(
    study: &Study,
    schema: &SchemaRef,
    row: u64,
    scenario: &Scenario,
    samples: &[Sample],
) -> Result<RecordBatch, Error> {
    // The end of the push counts as part of the hold.
    let position = |time: f64| Motion(scenario).boundary(usize::from(time >= scenario.push_time_s), time).position;
    let positions: Vec<f64> = samples.iter().map(|s| position(s.time)).collect();
    let mut arrays: Vec<ArrayRef> = vec![Arc::new(Int64Array::from_value(row as i64, samples.len()))];
    for column in &COLUMNS {
        let values = samples.iter().zip(&positions).map(|(sample, position)| (column.value)(sample, *position));
        arrays.push(Arc::new(Float64Array::from_iter_values(values)));
    }
    RecordBatch::try_new(schema.clone(), arrays).map_err(|error| Error::arrow(&study.path, error))
}

/// The chamber's inputs in a test: the push, then the hold.
struct Motion<'a>(&'a Scenario);

impl Inputs<f64> for Motion<'_> {
    fn begin(&self) -> f64 {
        0.0
    }

    fn stretches(&self) -> usize {
        2
    }

    fn end(&self, stretch: usize) -> f64 {
        if stretch == 0 { self.0.push_time_s } else { f64::INFINITY }
    }

    fn boundary(&self, stretch: usize, time: f64) -> Boundary {
        let s = self.0;
        let speed = (s.final_position_m - s.initial_position_m) / s.push_time_s;
        let (position, velocity) =
            if stretch == 0 { (s.initial_position_m + speed * time, speed) } else { (s.final_position_m, 0.0) };
        s.boundary(position, velocity)
    }
}

/// The time course of a test: samples at multiples of 1/rate from the start of the push, and one at the end.
///
/// # Errors
/// The integration cannot reach the end.
pub fn trace(scenario: &Scenario, rate_hz: f64, relative_tolerance: f64) -> Result<Vec<Sample>, IntegrationError> {
    let (chamber, end) = (&scenario.chamber, scenario.duration_s);
    let count = (end * rate_hz * (1.0 - 1e-12)) as usize;
    let times: Vec<f64> = (0..=count).map(|k| k as f64 / rate_hz).chain([end]).collect();
    let start = Start { pressure: scenario.initial_pressure_pa, temperature: scenario.initial_temperature_k };
    simulate(chamber, chamber.active(), start, &Motion(scenario), &times, relative_tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_as_numbers_and_ranges_in_order_and_once() {
        let rows = |text: &str| text.parse::<RowNumbers>().map(|rows| rows.iter().collect::<Vec<_>>());
        assert_eq!(rows("7"), Ok(vec![7]));
        assert_eq!(rows("5-7, 1,6-8"), Ok(vec![1, 5, 6, 7, 8]));
        for wrong in ["", "a", "3-1", "1,,2", "-1", "18446744073709551615"] {
            assert!(rows(wrong).unwrap_err().contains("0,17,100-119"), "{wrong}");
        }
    }
}
