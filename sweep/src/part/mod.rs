//! Rows as a Parquet file: one part of a study, or all of it.
//!
//! | module | holds |
//! |---|---|
//! | [`columns`], `status_column` | the table: its columns, units and statuses |
//! | `encoding` | how it is encoded as Parquet |
//! | `chunk`, `doubles`, `texts` | the columns that are encoded here rather than by the Parquet library |
//! | `new_file`, `reader` | one Parquet file, whole or not there; read back |
//! | `pages`, `sink` | its pages' checksums; its hash, and the order of its statistics |

pub(crate) mod chunk;
pub mod columns;
pub(crate) mod doubles;
pub(crate) mod encoding;
pub(crate) mod new_file;
pub(crate) mod pages;
pub(crate) mod reader;
pub(crate) mod sink;
pub(crate) mod status_column;
pub(crate) mod texts;

use crate::error::Error;
use crate::row::solve::RowSolver;
use crate::study::Study;
use arrow::record_batch::RecordBatch;
use status_column::Statuses;
use std::ops::Range;

/// Some rows of a study as Arrow.
pub fn batch(study: &Study, rows: Range<u64>) -> Result<RecordBatch, Error> {
    let rows = RowSolver::new(study).rows(rows)?;
    columns::batch(study, &columns::schema(study), rows, &mut Statuses::new(study))
}
