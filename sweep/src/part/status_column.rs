//! The status column: the text of each status, and how many rows have it.

use crate::result::status::Status;
use crate::study::Study;
use arrow::array::{DictionaryArray, Int32Array, StringArray};
use arrow::datatypes::Int32Type;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// How many rows ended with each status.
pub type StatusCounts = BTreeMap<String, u64>;

/// Beginnings of the statuses of rows without results.
const FAILED: &str = "failed: ";
const LEFT_OUT: &str = "left_out: ";

/// Why a row failed, from its status as text, if it did.
pub fn failure(status: &str) -> Option<&str> {
    status.strip_prefix(FAILED)
}

/// Whether a row of that status, as text, has results.
pub fn has_results(status: &str) -> bool {
    !status.starts_with(FAILED) && !status.starts_with(LEFT_OUT)
}

/// Adds how many further rows ended with each status.
pub fn add_counts(total: &mut StatusCounts, further: &StatusCounts) {
    for (status, count) in further {
        *total.entry(status.clone()).or_default() += count;
    }
}

/// A status as the column has it.
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

/// Each status that came up, in order, with the number of its rows.
pub struct Statuses<'a> {
    study: &'a Study,
    met: Vec<(Status, u64)>,
}

impl<'a> Statuses<'a> {
    /// Begins without statuses.
    pub fn new(study: &'a Study) -> Self {
        Self { study, met: Vec::new() }
    }

    /// Counts rows that ended alike, and tells the place of their status.
    fn count(&mut self, row: Status, rows: usize) -> usize {
        let met = &mut self.met;
        let place = met.iter().position(|(status, _)| *status == row).unwrap_or_else(|| {
            met.push((row, 0));
            met.len() - 1
        });
        met[place].1 += rows as u64;
        place
    }

    /// Counts some rows: neighbours mostly end alike.
    pub fn count_all(&mut self, rows: &[Status]) {
        rows.chunk_by(|a, b| a == b).for_each(|run| {
            self.count(run[0], run.len());
        });
    }

    /// Counts some rows, and makes their status column.
    pub fn column(&mut self, rows: &[Status]) -> DictionaryArray<Int32Type> {
        let mut keys = Vec::with_capacity(rows.len());
        for run in rows.chunk_by(|a, b| a == b) {
            keys.extend(std::iter::repeat_n(self.count(run[0], run.len()) as i32, run.len()));
        }
        let keys = Int32Array::from(keys);
        let texts = StringArray::from_iter_values(self.met.iter().map(|(status, _)| text(*status, self.study)));
        DictionaryArray::new(keys, Arc::new(texts))
    }

    /// How many rows ended with each status.
    pub fn counts(&self) -> StatusCounts {
        self.met.iter().map(|(status, count)| (text(*status, self.study).into_owned(), *count)).collect()
    }
}
