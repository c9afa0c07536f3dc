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
/// Rows of the first piece; each further one is twice as long.
const FIRST: u64 = 256;

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

/// Computes and encodes pieces of the study from all over its design, in memory, for under a second.
///
/// # Errors
/// A table of points cannot be read.
pub fn calibrate(study: &Study) -> Result<Estimate, Error> {
    let threads = rayon::current_num_threads() as u64;
    let mut piece = FIRST.min(study.rows);
    loop {
        let begun = Instant::now();
        let starts: Vec<u64> = (0..threads).map(|i| (study.rows - piece) / threads.max(1) * i).collect();
        let bytes: Vec<usize> =
            starts.into_par_iter().map(|start| encode(study, start, piece)).collect::<Result<_, _>>()?;
        let elapsed = begun.elapsed();
        let rows = piece * threads;
        if elapsed > LONG_ENOUGH || piece == study.rows || piece >= 1 << 18 {
            return Ok(Estimate {
                calibrated_rows: rows,
                rows_per_second: rows as f64 / elapsed.as_secs_f64(),
                bytes_per_row: bytes.iter().sum::<usize>() as f64 / rows as f64,
            });
        }
        piece = (2 * piece).min(study.rows);
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
