//! The status column: the text of each status, and its number of rows.

use crate::result::status::Status;
use crate::study::Study;
use arrow::array::{DictionaryArray, Int32Array, StringArray};
use arrow::datatypes::Int32Type;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Number of rows with each status.
pub type StatusCounts = BTreeMap<String, u64>;

/// Prefixes of the statuses of rows without results.
const FAILED: &str = "failed: ";
const LEFT_OUT: &str = "left_out: ";

/// Why a row failed, from the text of its status; `None` if it did not.
pub fn failure(status: &str) -> Option<&str> {
    status.strip_prefix(FAILED)
}

/// Whether a row has results, from the text of its status.
pub fn has_results(status: &str) -> bool {
    !status.starts_with(FAILED) && !status.starts_with(LEFT_OUT)
}

/// Adds further counts of rows by status.
pub fn add_counts(total: &mut StatusCounts, further: &StatusCounts) {
    for (status, count) in further {
        *total.entry(status.clone()).or_default() += count;
    }
}

/// Text of a status in the column.
pub fn text(status: Status, study: &Study) -> Cow<'static, str> {
    match status {
        Status::Ok => "ok".into(),
        Status::NotSettled => "not_settled".into(),
        Status::NoTimeConstant => "no_time_constant".into(),
        Status::LeftOut(number) => {
            let constraint = study.constraints.get(usize::from(number));
            format!("{LEFT_OUT}{}", constraint.map_or("", |constraint| &constraint.text)).into()
        }
        Status::Failed(failure) => format!("{FAILED}{failure}").into(),
    }
}

/// The status of a row with results, from its text.
pub fn of_text(study: &Study, found: &str) -> Option<Status> {
    [Status::Ok, Status::NotSettled, Status::NoTimeConstant].into_iter().find(|status| text(*status, study) == found)
}

/// The statuses encountered, in order, with their numbers of rows.
pub struct Statuses<'a> {
    study: &'a Study,
    met: Vec<(Status, u64)>,
}

impl<'a> Statuses<'a> {
    /// Without statuses yet.
    pub fn new(study: &'a Study) -> Self {
        Self { study, met: Vec::new() }
    }

    /// Counts rows with the same status, and returns its index.
    fn count(&mut self, row: Status, rows: usize) -> usize {
        let met = &mut self.met;
        let index = met.iter().position(|(status, _)| *status == row).unwrap_or_else(|| {
            met.push((row, 0));
            met.len() - 1
        });
        met[index].1 += rows as u64;
        index
    }

    /// Counts rows; adjacent ones mostly have the same status.
    pub fn count_all(&mut self, rows: &[Status]) {
        rows.chunk_by(|a, b| a == b).for_each(|run| {
            self.count(run[0], run.len());
        });
    }

    /// Counts rows, and makes their status column.
    pub fn column(&mut self, rows: &[Status]) -> DictionaryArray<Int32Type> {
        let mut keys = Vec::with_capacity(rows.len());
        for run in rows.chunk_by(|a, b| a == b) {
            keys.extend(std::iter::repeat_n(self.count(run[0], run.len()) as i32, run.len()));
        }
        let keys = Int32Array::from(keys);
        let texts = StringArray::from_iter_values(self.met.iter().map(|(status, _)| text(*status, self.study)));
        DictionaryArray::new(keys, Arc::new(texts))
    }

    /// Number of rows with each status.
    pub fn counts(&self) -> StatusCounts {
        self.met.iter().map(|(status, count)| (text(*status, self.study).into_owned(), *count)).collect()
    }
}
