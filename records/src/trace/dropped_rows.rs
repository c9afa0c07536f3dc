//! Rows left out of a trace, with the reasons. More than one in fifty is refused.

use crate::error::trace::{RowProblem, TraceProblem};
use std::fmt;

/// At most one row in this many may be left out.
pub const ONE_IN: usize = 50;
/// Number of lines named in a note.
const NAMED: usize = 5;
/// Maximum number of rows stored with their reason while reading: one more than may be left out of the longest file.
const MOST: usize = super::reading::MAX_ROWS / ONE_IN + 1;

/// A row left out of the trace.
#[derive(Clone, Debug, PartialEq)]
pub struct DroppedRow {
    /// Its line in the file, from 1.
    pub line: usize,
    /// Why it is no data.
    pub reason: RowProblem,
}

impl fmt::Display for DroppedRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, {}", self.line, self.reason)
    }
}

/// Rows left out while a file is read.
#[derive(Debug, Default)]
pub struct BadRows {
    found: Vec<DroppedRow>,
    count: usize,
}

impl BadRows {
    pub fn push(&mut self, line: usize, reason: RowProblem) {
        self.count += 1;
        if self.found.len() < MOST {
            self.found.push(DroppedRow { line, reason });
        }
    }

    pub fn len(&self) -> usize {
        self.count
    }

    /// The rows left out, by line, if they are few among `rows`, which includes those kept.
    pub fn few_among(mut self, rows: usize) -> Result<Vec<DroppedRow>, TraceProblem> {
        self.found.sort_by_key(|row| row.line);
        if self.count * ONE_IN <= rows {
            return Ok(self.found);
        }
        let lines = self.found.iter().take(NAMED).map(|row| row.line).collect();
        let first = self.found.swap_remove(0);
        Err(TraceProblem::BadRows { line: first.line, problem: Box::new(first.reason), bad: self.count, rows, lines })
    }
}

/// A note on the rows left out, if any: their number, and the first ones with reasons.
pub fn note(dropped_rows: &[DroppedRow]) -> Option<String> {
    let first: Vec<String> = dropped_rows.iter().take(NAMED).map(DroppedRow::to_string).collect();
    let (count, more) = (dropped_rows.len(), if dropped_rows.len() > NAMED { "; ..." } else { "" });
    let rows = if count == 1 { "row is" } else { "rows are" };
    (count > 0).then(|| format!("{count} {rows} left out: {}{more}", first.join("; ")))
}
