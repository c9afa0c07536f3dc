//! Rows as a Parquet file: one part of a study, or all of it.
//!
//! | module | holds |
//! |---|---|
//! | [`columns`], `status_column` | the table: its columns, units and statuses |
//! | `encoding` | encoding as Parquet |
//! | `chunk`, `doubles`, `texts` | the columns encoded here rather than by the Parquet library |
//! | `new_file`, `reader` | writing one Parquet file atomically; reading it back |
//! | `pages`, `sink` | page checksums; hashing, and the order of statistics |

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

/// Some rows of a study as an Arrow batch.
pub fn batch(study: &Study, rows: Range<u64>) -> Result<RecordBatch, Error> {
    let rows = RowSolver::new(study).rows(rows)?;
    columns::batch(study, &columns::schema(study), rows, &mut Statuses::new(study))
}
