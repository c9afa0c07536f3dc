//! A whole study as one file or in memory, or only its statistics.

use super::shard::Shard;
use super::work::{Destination, Work};
use crate::error::Error;
use crate::part;
use crate::part::new_file::keep_memory;
use crate::part::status_column::{StatusCounts, add_counts};
use crate::progress::Progress;
use crate::row::chunk::{CHUNK, chunks};
use crate::statistics::State;
use crate::store::Local;
use crate::study::Study;
use crate::study::plan::Plan;
use arrow::record_batch::RecordBatch;
use rayon::prelude::*;
use serde_json::Value;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// Runs a whole study into one Parquet file, which appears when complete; returns its rows by status.
///
/// # Errors
/// The file cannot be written; nothing is left behind.
pub fn run_to_file(study: &Study, path: &Path, progress: &dyn Progress) -> Result<StatusCounts, Error> {
    let extra = [("shard", Shard::WHOLE.to_string()), ("part", "0".to_owned())];
    keep_memory();
    let folder = path.parent().unwrap_or(Path::new(""));
    let destination = Destination { path, staging: folder, extra: &extra };
    let written = Work::new(study, progress).write(0..study.rows, Some(&destination))?;
    if let Some(file) = written.file {
        file.publish(&Local::new(folder), &path.file_name().unwrap_or_default().to_string_lossy())?;
    }
    Ok(written.statuses)
}

/// The statistics of a whole study, as in `statistics.json` of a folder; nothing is written.
///
/// # Errors
/// A table of points cannot be read.
pub fn statistics(study: &Study, plan: &Plan, progress: &dyn Progress) -> Result<Value, Error> {
    let (mut total, mut statuses) = (State::new(plan), StatusCounts::new());
    let work = Work { plan: Some(plan), ..Work::new(study, progress) };
    for part in 0..study.parts {
        let written = work.write(study.rows_of(part), None)?;
        written.statistics.iter().for_each(|state| total.merge(state));
        add_counts(&mut statuses, &written.statuses);
    }
    total.summary(study, plan, &statuses)
}

/// The rows of a study, batch by batch, in order: all threads of the current pool compute a wave of chunks when the previous one
/// is used up, so that memory does not grow with the study.
pub fn batches(study: Arc<Study>) -> impl Iterator<Item = Result<RecordBatch, Error>> + Send {
    let wave = CHUNK * 2 * rayon::current_num_threads() as u64;
    let waves = (0..study.rows).step_by(wave as usize);
    waves.flat_map(move |begin| computed(&study, begin..study.rows.min(begin + wave)))
}

/// Runs a whole study in memory.
///
/// # Errors
/// A table of points cannot be read.
pub fn run_in_memory(study: &Study) -> Result<Vec<RecordBatch>, Error> {
    computed(study, 0..study.rows).into_iter().collect()
}

/// Some rows as batches, computed on all threads of the current pool.
fn computed(study: &Study, rows: Range<u64>) -> Vec<Result<RecordBatch, Error>> {
    chunks(rows).into_par_iter().map(|rows| part::batch(study, rows)).collect()
}
