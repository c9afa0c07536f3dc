//! One part: rows computed chunk by chunk and written as they come.

use crate::columns::{self, Statuses};
use crate::earlier::{Earlier, Taker};
use crate::error::Error;
use crate::new_file::{Ended, NewFile};
use crate::solve::Solver;
use crate::statistics::{Plan, State};
use crate::study::Study;
use arrow::array::{Array, Float64Array};
use arrow::record_batch::RecordBatch;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use rayon::prelude::*;
use serde_json::json;
use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;
use std::path::Path;

/// Rows of one Arrow batch.
pub const CHUNK: u64 = 1 << 13;
/// Chunks of one file that are in memory for each thread.
const CHUNKS_PER_THREAD: usize = 4;

/// How many rows ended with each status.
pub type StatusCounts = BTreeMap<String, u64>;

/// Told how a run goes on, from any thread.
pub trait Progress: Sync {
    /// Called with the number of rows solved since the last call.
    fn solved(&self, rows: u64);

    /// Called with the number of rows found in complete parts.
    fn found(&self, _rows: u64) {}
}

impl<F: Fn(u64) + Sync> Progress for F {
    fn solved(&self, rows: u64) {
        self(rows);
    }
}

/// Receives the progress of a run.
pub type OnRows<'a> = &'a dyn Progress;

/// Some rows of a study as Arrow.
pub fn batch(study: &Study, rows: Range<u64>) -> Result<RecordBatch, Error> {
    let rows = Solver::new(study).rows(rows)?;
    columns::batch(study, &columns::schema(study), rows, &mut Statuses::new(study))
}

/// The rows of a part's file after the first `skipped`; of the columns of those names, or all.
///
/// # Errors
/// It cannot be read.
pub fn read(path: &Path, names: Option<&[&str]>, skipped: u64) -> Result<ParquetRecordBatchReader, Error> {
    let file = File::open(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    let parquet = |source| Error::Parquet { path: path.to_owned(), source };
    let mut builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(parquet)?.with_offset(skipped as usize);
    if let Some(names) = names {
        let fields = builder.schema().fields().iter().enumerate();
        let wanted = fields.filter(|(_, field)| names.contains(&field.name().as_str())).map(|(place, _)| place);
        let mask = ProjectionMask::roots(builder.parquet_schema(), wanted);
        builder = builder.with_projection(mask);
    }
    builder.with_batch_size(CHUNK as usize).build().map_err(parquet)
}

/// A column's numbers, NaN for a null.
pub fn numbers(column: &Float64Array) -> Vec<f64> {
    match column.null_count() {
        0 => column.values().to_vec(),
        _ => column.iter().map(|value| value.unwrap_or(f64::NAN)).collect(),
    }
}

/// Cuts rows into chunks. Chunks are counted from row zero of the study, so that they do not depend on the parts.
pub fn chunks(rows: Range<u64>) -> Vec<Range<u64>> {
    let first = rows.start / CHUNK;
    let last = rows.end.div_ceil(CHUNK);
    (first..last).map(|i| rows.start.max(i * CHUNK)..rows.end.min((i + 1) * CHUNK)).filter(|r| !r.is_empty()).collect()
}

/// How the rows of one file are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workers {
    /// By the calling thread: others are busy with other files.
    One,
    /// By all threads of the pool.
    All,
}

/// Where a part's rows go.
pub struct Place<'a> {
    /// Final path of the file, for error messages.
    pub path: &'a Path,
    /// The folder it is written in until it is whole.
    pub workshop: &'a Path,
    /// Further entries of its metadata.
    pub extra: &'a [(&'a str, String)],
}

/// Computes some rows of a study, into a new file where there is a place for one, which is still to be published.
///
/// # Errors
/// The file cannot be written, or a table of points cannot be read; nothing remains then.
pub fn write(
    study: &Study,
    rows: Range<u64>,
    place: Option<&Place<'_>>,
    plan: Option<&Plan>,
    workers: Workers,
    earlier: Option<&Earlier>,
    on_rows: OnRows<'_>,
) -> Result<Written, Error> {
    let schema = columns::schema(study);
    let create = |place: &Place<'_>| {
        let properties = columns::properties(study, &schema, place.extra);
        NewFile::create(place.workshop, place.path, schema.clone(), properties)
    };
    let mut file = place.map(create).transpose()?;
    let mut statuses = Statuses::new(study);
    let mut statistics = plan.map(|plan| (plan, State::new(plan), places(study, plan)));
    let chunks = chunks(rows.clone());
    let wave = if workers == Workers::All { CHUNKS_PER_THREAD * rayon::current_num_threads() } else { 1 };
    let mut solver = Solver::new(study).telling(on_rows);
    let earlier = earlier.filter(|earlier| earlier.count(&rows) > 0);
    let mut taker = earlier.map(|earlier| Taker::new(earlier, study, on_rows));
    for wave in chunks.chunks(wave) {
        let some_taken = earlier.is_some_and(|earlier| wave.iter().any(|rows| earlier.count(rows) > 0));
        let computed: Vec<_> = match (workers, &mut taker) {
            (_, Some(taker)) if some_taken => wave.iter().map(|rows| taker.rows(rows.clone(), &mut solver)).collect(),
            (Workers::One, _) => wave.iter().map(|rows| solver.rows(rows.clone())).collect(),
            (Workers::All, _) => {
                let new = || Solver::new(study).telling(on_rows);
                wave.par_iter().map_init(new, |solver, rows| solver.rows(rows.clone())).collect()
            }
        };
        for rows in computed {
            let rows = rows?;
            if let Some((plan, state, places)) = &mut statistics {
                state.add(plan, rows.first, places.iter().map(|place| rows.outputs[*place].as_slice()));
            }
            match &mut file {
                Some(file) => file.write(&columns::batch(study, &schema, rows, &mut statuses)?)?,
                None => statuses.count_all(&rows.statuses),
            }
        }
    }
    let counts = statuses.counts();
    if let Some(file) = &mut file {
        file.note("status_counts", json!(counts).to_string());
    }
    let statistics = statistics.map(|(_, state, _)| state);
    Ok(Written { file: file.map(NewFile::end).transpose()?, statuses: counts, statistics })
}

/// Places of a plan's columns among the study's computed ones.
fn places(study: &Study, plan: &Plan) -> Vec<usize> {
    let place = |name: &String| columns::outputs(study).position(|output| output.name == name);
    plan.columns.iter().filter_map(place).collect()
}

/// A part whose rows were computed.
pub struct Written {
    /// Their file, still to be published, where there was a place for one.
    pub file: Option<Ended>,
    /// How many ended with each status.
    pub statuses: StatusCounts,
    /// Their statistics, where they were asked for.
    pub statistics: Option<State>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_their_rows_once_and_in_order() {
        for rows in [0..0, 0..1, 5..CHUNK, CHUNK - 1..3 * CHUNK + 7] {
            let all: Vec<u64> = chunks(rows.clone()).into_iter().flatten().collect();
            assert!(all.into_iter().eq(rows));
        }
    }
}
