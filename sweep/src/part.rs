//! One part: rows computed chunk by chunk and written as they come.

use crate::columns::{self, Statuses};
use crate::error::Error;
use crate::new_file::{Ended, NewFile};
use crate::solve::Solver;
use crate::study::Study;
use arrow::record_batch::RecordBatch;
use rayon::prelude::*;
use serde_json::json;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// Rows of one Arrow batch.
pub const CHUNK: u64 = 1 << 13;
/// Chunks of one file that are in memory for each thread.
const CHUNKS_PER_THREAD: usize = 4;

/// How many rows ended with each status.
pub type StatusCounts = BTreeMap<String, u64>;

/// Told how many more rows are done, from any thread.
pub type OnRows<'a> = &'a (dyn Fn(u64) + Sync);

/// Some rows of a study as Arrow.
pub fn batch(study: &Study, rows: Range<u64>) -> Result<RecordBatch, Error> {
    let rows = Solver::new(study).rows(rows)?;
    columns::batch(study, &columns::schema(study), rows, &mut Statuses::default())
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

/// Writes some rows of a study to what will be `path` when it is published; tells how many ended with each status.
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
) -> Result<(Ended, StatusCounts), Error> {
    let schema = columns::schema(study);
    let mut file = NewFile::create(path, schema.clone(), columns::properties(study, &schema, extra))?;
    let mut statuses = Statuses::default();
    let chunks = chunks(rows);
    let wave = if workers == Workers::All { CHUNKS_PER_THREAD * rayon::current_num_threads() } else { 1 };
    let mut solver = Solver::new(study);
    for wave in chunks.chunks(wave) {
        let computed: Vec<_> = match workers {
            Workers::One => wave.iter().map(|rows| solver.rows(rows.clone())).collect(),
            Workers::All => {
                wave.par_iter().map_init(|| Solver::new(study), |solver, rows| solver.rows(rows.clone())).collect()
            }
        };
        for rows in computed {
            let batch = columns::batch(study, &schema, rows?, &mut statuses)?;
            file.write(&batch)?;
            on_rows(batch.num_rows() as u64);
        }
    }
    let counts = statuses.counts();
    file.note("status_counts", json!(counts).to_string());
    Ok((file.end()?, counts))
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
