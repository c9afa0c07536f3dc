//! What is recorded about a part, without its rows: a separate file, written before the part.

use crate::file_names::RECORDS;
use crate::part::new_file::Digest;
use crate::part::status_column::{StatusCounts, add_counts};
use crate::statistics::State;
use crate::store::Store;
use serde::{Deserialize, Serialize};

/// What is recorded about a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// SHA-256 of the study's identity, hexadecimal.
    pub study_sha256: String,
    /// Index of its first row.
    pub first_row: u64,
    /// Number of rows in the part.
    pub rows: u64,
    /// Number of rows with each status.
    pub statuses: StatusCounts,
    /// Its file; `None` if the study's rows are not kept.
    pub file: Option<Digest>,
    /// Its statistics, if requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub statistics: Option<State>,
}

/// Name of the record of a part.
pub fn file_name(part: &str) -> String {
    format!("{}.json", part.trim_end_matches(".parquet"))
}

/// Path of the record of a part.
pub fn file(part: &str) -> String {
    format!("{RECORDS}/{}", file_name(part))
}

/// The record of the part with that name, if it exists and is readable.
pub fn read(store: &dyn Store, part: &str) -> Option<Record> {
    let text = store.read(&file(part)).ok().flatten()?;
    serde_json::from_slice(&text).ok()
}

/// Number of rows by status, summed over the parts.
pub fn statuses_of(parts: &[Record]) -> StatusCounts {
    let mut total = StatusCounts::new();
    parts.iter().for_each(|part| add_counts(&mut total, &part.statuses));
    total
}
