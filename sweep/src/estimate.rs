//! Cost of a study: its rows, its time from a short calibration and a disk test, and its bytes.

use crate::error::Error;
use crate::part;
use crate::part::columns;
use crate::part::encoding;
use crate::row::chunk::CHUNK;
use crate::store::existing;
use crate::study::Study;
use parquet::arrow::ArrowWriter;
use rayon::prelude::*;
use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// Minimum duration of a calibration, if there are enough rows.
const LONG_ENOUGH: Duration = Duration::from_millis(400);
/// Initial number of rows per piece, doubled each round.
const FIRST: u64 = 4;
/// Maximum number of rows per piece.
const LARGEST: u64 = 1 << 15;
/// Pieces per thread, spread over the design: an axis may be slow at one of its ends.
const PIECES: u64 = 8;

/// Upper bound on the bytes of this many rows of a study, without computing any: its numbers uncompressed.
pub fn most_bytes(study: &Study, rows: u64) -> u64 {
    let columns = columns::schema(study).fields().len() as u64;
    rows.saturating_mul(columns * size_of::<f64>() as u64)
}

/// Time and disk space of a study, measured on a few of its rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Number of rows computed in the calibration.
    pub calibrated_rows: u64,
    /// Rows per second with the threads of the current pool, without waiting for a disk.
    pub rows_per_second: f64,
    /// Time to write a part and its record to disk, s; zero where the disk could not be tested.
    pub seconds_per_part: f64,
    /// Bytes of Parquet for each row; zero where no rows are kept.
    pub bytes_per_row: f64,
}

impl Estimate {
    /// Time for some rows in some parts, s: parts are written one after the other, while the next ones are computed.
    pub fn seconds(&self, rows: u64, parts: u64) -> f64 {
        let (computing, writing) = (rows as f64 / self.rows_per_second, parts as f64 * self.seconds_per_part);
        computing.max(writing) + self.seconds_per_part
    }

    /// Disk space for this many rows, bytes.
    pub fn bytes(&self, rows: u64) -> f64 {
        rows as f64 * self.bytes_per_row
    }
}

/// Computes and encodes pieces from all over the study's design, in memory, for about a second, and tests the disk of `folder`,
/// which need not exist. Leaves nothing there. `rows` says whether rows are kept or only their statistics.
///
/// # Errors
/// A table of points cannot be read.
pub fn calibrate(study: &Study, folder: &Path, rows: bool) -> Result<Estimate, Error> {
    let pieces = (rayon::current_num_threads() as u64 * PIECES).min(study.rows);
    let empty = encode(study, 0, 0)?;
    let mut length = FIRST.min(study.rows);
    loop {
        let begun = Instant::now();
        let start = |i: u64| (u128::from(study.rows - length) * u128::from(i) / u128::from(pieces.max(2) - 1)) as u64;
        let starts: Vec<u64> = (0..pieces).map(start).collect();
        let bytes: Vec<usize> = starts
            .into_par_iter()
            .with_max_len(1)
            .map(|start| encode(study, start, length))
            .collect::<Result<_, _>>()?;
        let elapsed = begun.elapsed();
        let solved = length * pieces;
        if elapsed > LONG_ENOUGH || length == study.rows || length >= LARGEST {
            let bytes_per_row = bytes.iter().map(|bytes| bytes - empty).sum::<usize>() as f64 / solved as f64;
            let bytes_per_part = empty as f64 + study.rows as f64 / study.parts as f64 * bytes_per_row;
            let kept = |bytes: f64| if rows { bytes } else { 0.0 };
            return Ok(Estimate {
                calibrated_rows: solved,
                rows_per_second: solved as f64 / elapsed.as_secs_f64(),
                seconds_per_part: seconds_per_part(folder, kept(bytes_per_part)),
                bytes_per_row: kept(bytes_per_row),
            });
        }
        length = (2 * length).min(study.rows);
    }
}

/// Maximum number of bytes written to test a disk.
const PROBE: usize = 8 << 20;

/// Time to write a part of this many bytes and its record to disk, s.
fn seconds_per_part(folder: &Path, bytes: f64) -> f64 {
    let Some(folder) = existing(folder) else { return 0.0 };
    let probe = (bytes as usize).min(PROBE);
    let record = synced(folder, 1 << 10);
    let part = match probe {
        0 => Ok(0.0),
        _ => synced(folder, probe).map(|seconds| seconds * (bytes / probe as f64).max(1.0)),
    };
    record.and_then(|record| Ok(record + part?)).unwrap_or(0.0)
}

/// Time to write and sync a nameless file, s.
fn synced(folder: &Path, bytes: usize) -> io::Result<f64> {
    let mut file = tempfile::tempfile_in(folder)?;
    let begun = Instant::now();
    file.write_all(&vec![0x5a; bytes])?;
    file.sync_all()?;
    Ok(begun.elapsed().as_secs_f64())
}

/// Size of some rows as Parquet, bytes.
fn encode(study: &Study, start: u64, rows: u64) -> Result<usize, Error> {
    let parquet = Error::parquet(&study.path);
    let schema = columns::schema(study);
    let properties = encoding::properties(study, &schema, &[]);
    let mut writer = ArrowWriter::try_new(Vec::new(), schema, Some(properties)).map_err(&parquet)?;
    let mut at = start;
    while at < start + rows {
        let end = (at + CHUNK).min(start + rows);
        writer.write(&part::batch(study, at..end)?).map_err(&parquet)?;
        at = end;
    }
    Ok(writer.into_inner().map_err(&parquet)?.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    const ESTIMATE: Estimate =
        Estimate { calibrated_rows: 1, rows_per_second: 1e3, seconds_per_part: 0.5, bytes_per_row: 80.0 };

    #[test]
    fn the_slower_of_processor_and_disk_decides() {
        assert_eq!(ESTIMATE.seconds(10_000, 4), 10.5);
        assert_eq!(ESTIMATE.seconds(10_000, 100), 50.5);
    }

    #[test]
    fn a_disk_is_tried_where_the_folder_will_be_and_nothing_stays_there() {
        let folder = tempfile::tempdir().unwrap();
        assert!(seconds_per_part(&folder.path().join("not/yet"), 1e6) > 0.0);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
