//! One Parquet file: rows computed chunk by chunk and written as they come, under a temporary name until it is whole.
//!
//! A temporary file is locked while its writer lives. One that is not locked was left by a run that was killed.

use crate::columns;
use crate::error::Error;
use crate::row::{Outputs, Status};
use crate::solve;
use crate::study::Study;
use arrow::record_batch::RecordBatch;
use parquet::arrow::ArrowWriter;
use parquet::file::metadata::KeyValue;
use rayon::prelude::*;
use serde_json::json;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::BufWriter;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Rows that are computed in one go.
pub const CHUNK: u64 = 1 << 13;
/// Chunks of one file that are in memory for each thread.
const CHUNKS_PER_THREAD: usize = 4;

/// How many rows ended with each status.
pub type StatusCounts = BTreeMap<String, u64>;

/// Told how many more rows are done, from any thread.
pub type OnRows<'a> = &'a (dyn Fn(u64) + Sync);

/// Points and results of some rows, without Arrow around them.
pub fn compute(study: &Study, rows: Range<u64>) -> Result<(Vec<Vec<f64>>, Vec<Outputs>), Error> {
    let mut points = vec![Vec::with_capacity((rows.end - rows.start) as usize); study.varied.len()];
    study.design.fill(rows, &mut points)?;
    let outputs = solve::rows(study, &points);
    Ok((points, outputs))
}

/// Some rows of a study as Arrow.
pub fn batch(study: &Study, rows: Range<u64>) -> Result<RecordBatch, Error> {
    let (points, outputs) = compute(study, rows.clone())?;
    columns::batch(study, &columns::schema(study), rows.start, &points, &outputs)
}

/// Cuts rows into chunks. Chunks are counted from row zero of the study, so that they do not depend on the parts.
fn chunks(rows: Range<u64>) -> Vec<Range<u64>> {
    let first = rows.start / CHUNK;
    let last = rows.end.div_ceil(CHUNK);
    (first..last).map(|i| rows.start.max(i * CHUNK)..rows.end.min((i + 1) * CHUNK)).filter(|r| !r.is_empty()).collect()
}

/// A file under its temporary name; removed when dropped, unless it got its own.
struct Temporary {
    path: PathBuf,
    finished: bool,
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.finished {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Ending of temporary files; they begin with a dot and the name they are meant to have.
pub const TEMPORARY: &str = ".tmp";

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
    let failed = |source| Error::Write { path: path.to_owned(), source };
    let parquet = |error| Error::writing(path, error);
    let mut temporary = Temporary { path: temporary_beside(path), finished: false };
    let file = File::create_new(&temporary.path).map_err(failed)?;
    file.lock().map_err(failed)?;
    let schema = columns::schema(study);
    let properties = columns::properties(study, &schema, extra);
    let mut writer = ArrowWriter::try_new(BufWriter::with_capacity(1 << 20, file), schema.clone(), Some(properties))
        .map_err(parquet)?;
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
            for row in &outputs {
                *counts.entry(row.status).or_default() += 1;
            }
            let batch = columns::batch(study, &schema, rows.start, &points, &outputs)?;
            writer.write(&batch).map_err(parquet)?;
            on_rows(rows.end - rows.start);
        }
    }
    let counts: StatusCounts = counts.into_iter().map(|(status, count)| (status.text().into_owned(), count)).collect();
    writer.append_key_value_metadata(KeyValue::new("status_counts".to_owned(), json!(counts).to_string()));
    let file = writer.into_inner().map_err(parquet)?.into_inner().map_err(|e| failed(e.into_error()))?;
    file.sync_all().map_err(failed)?;
    std::fs::rename(&temporary.path, path).map_err(failed)?;
    temporary.finished = true;
    sync_folder_of(path).map_err(failed)?;
    Ok(counts)
}

/// Makes a new name in a folder last; a system whose folders cannot be synced needs no such thing.
fn sync_folder_of(path: &Path) -> std::io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

/// A name that no other file has, in the folder of `path`.
fn temporary_beside(path: &Path) -> PathBuf {
    use std::sync::atomic::{AtomicU64, Ordering};
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    // The clock tells apart processes of the same number on different machines.
    let clock = std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.subsec_nanos());
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{clock:x}-{count}{TEMPORARY}", std::process::id()))
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
