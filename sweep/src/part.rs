//! One part: rows computed chunk by chunk and written as they come.

use crate::columns;
use crate::error::Error;
use crate::new_file::NewFile;
use crate::row::{Outputs, Status};
use crate::solve;
use crate::study::Study;
use arrow::record_batch::RecordBatch;
use rayon::prelude::*;
use serde_json::json;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::path::Path;

/// Rows of one Arrow batch.
pub const CHUNK: u64 = 1 << 13;
/// Rows that are simulated in one go: what they need stays in a core's cache and comes from memory already at hand.
const PIECE: usize = 1 << 8;
/// Chunks of one file that are in memory for each thread.
const CHUNKS_PER_THREAD: usize = 4;

/// How many rows ended with each status.
pub type StatusCounts = BTreeMap<String, u64>;

/// Told how many more rows are done, from any thread.
pub type OnRows<'a> = &'a (dyn Fn(u64) + Sync);

/// Points and results of some rows, without Arrow around them.
pub fn compute(study: &Study, rows: Range<u64>) -> Result<(Vec<Vec<f64>>, Vec<Outputs>), Error> {
    let count = (rows.end - rows.start) as usize;
    let mut points = vec![Vec::with_capacity(count); study.varied.len()];
    study.design.fill(rows, &mut points)?;
    let mut outputs = Vec::with_capacity(count);
    let mut piece = vec![Vec::with_capacity(PIECE); study.varied.len()];
    for start in (0..count).step_by(PIECE) {
        for (piece, column) in piece.iter_mut().zip(&points) {
            piece.clear();
            piece.extend_from_slice(&column[start..count.min(start + PIECE)]);
        }
        outputs.extend(solve::rows(study, &piece));
    }
    Ok((points, outputs))
}

/// Some rows of a study as Arrow.
pub fn batch(study: &Study, rows: Range<u64>) -> Result<RecordBatch, Error> {
    let (points, outputs) = compute(study, rows.clone())?;
    columns::batch(study, &columns::schema(study), rows.start, points, &outputs)
}

/// Cuts rows into chunks. Chunks are counted from row zero of the study, so that they do not depend on the parts.
fn chunks(rows: Range<u64>) -> Vec<Range<u64>> {
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

/// Writes some rows of a study to `path`, which appears when it is whole; returns how many ended with each status.
///
/// # Errors
/// The file cannot be written, or a table of points cannot be read; nothing remains then.
pub fn write(
    study: &Study,
    rows: Range<u64>,
    path: &Path,
    extra: &[(&str, String)],
    workers: Workers,
    on_rows: OnRows<'_>,
) -> Result<StatusCounts, Error> {
    let schema = columns::schema(study);
    let mut file = NewFile::create(path, schema.clone(), columns::properties(study, &schema, extra))?;
    let mut counts: HashMap<Status, u64> = HashMap::new();
    let chunks = chunks(rows);
    let wave = if workers == Workers::All { CHUNKS_PER_THREAD * rayon::current_num_threads() } else { 1 };
    for wave in chunks.chunks(wave) {
        let one = |rows: &Range<u64>| compute(study, rows.clone());
        let computed: Vec<_> = match workers {
            Workers::One => wave.iter().map(one).collect(),
            Workers::All => wave.par_iter().map(one).collect(),
        };
        for (rows, computed) in wave.iter().zip(computed) {
            let (points, outputs) = computed?;
            for alike in outputs.chunk_by(|a, b| a.status == b.status) {
                *counts.entry(alike[0].status).or_default() += alike.len() as u64;
            }
            let batch = columns::batch(study, &schema, rows.start, points, &outputs)?;
            file.write(&batch)?;
            on_rows(rows.end - rows.start);
        }
    }
    let counts: StatusCounts = counts.into_iter().map(|(status, count)| (status.text().into_owned(), count)).collect();
    file.note("status_counts", json!(counts).to_string());
    file.finish()?;
    Ok(counts)
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
