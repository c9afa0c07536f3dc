//! What a study will take: its rows, its time from a short calibration, and its bytes.

use crate::columns;
use crate::error::Error;
use crate::part;
use crate::study::Study;
use parquet::arrow::ArrowWriter;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// How long a calibration goes on at least, if there are rows enough.
const LONG_ENOUGH: Duration = Duration::from_millis(400);
/// Rows of a piece at first; each further time they are twice as many.
const FIRST: u64 = 4;
/// Rows of a piece at most.
const LARGEST: u64 = 1 << 15;
/// Pieces for each thread, from all over the design: an axis may be slow at one of its ends.
const PIECES: u64 = 8;

/// What a study will take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Rows that were computed to find out.
    pub calibrated_rows: u64,
    /// Rows per second with the threads of the current pool.
    pub rows_per_second: f64,
    /// Bytes of Parquet for each row.
    pub bytes_per_row: f64,
}

impl Estimate {
    /// Time for some rows, s.
    pub fn seconds(&self, rows: u64) -> f64 {
        rows as f64 / self.rows_per_second
    }

    /// Bytes for some rows.
    pub fn bytes(&self, rows: u64) -> f64 {
        rows as f64 * self.bytes_per_row
    }
}

/// Computes and encodes pieces of the study from all over its design, in memory, for about a second.
///
/// # Errors
/// A table of points cannot be read.
pub fn calibrate(study: &Study) -> Result<Estimate, Error> {
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
        let rows = length * pieces;
        if elapsed > LONG_ENOUGH || length == study.rows || length >= LARGEST {
            return Ok(Estimate {
                calibrated_rows: rows,
                rows_per_second: rows as f64 / elapsed.as_secs_f64(),
                bytes_per_row: bytes.iter().map(|bytes| bytes - empty).sum::<usize>() as f64 / rows as f64,
            });
        }
        length = (2 * length).min(study.rows);
    }
}

/// Size of some rows as Parquet.
fn encode(study: &Study, start: u64, rows: u64) -> Result<usize, Error> {
    let parquet = |source| Error::Parquet { path: study.path.clone(), source };
    let schema = columns::schema(study);
    let properties = columns::properties(study, &schema, &[]);
    let mut writer = ArrowWriter::try_new(Vec::new(), schema, Some(properties)).map_err(parquet)?;
    let mut at = start;
    while at < start + rows {
        let end = (at + part::CHUNK).min(start + rows);
        writer.write(&part::batch(study, at..end)?).map_err(parquet)?;
        at = end;
    }
    Ok(writer.into_inner().map_err(parquet)?.len())
}
