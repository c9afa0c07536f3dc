//! Limits on the numbers of rows and parts of a study, and the default number of parts.

use super::section::Entry;
use crate::error::Error;
use records::Field;

/// Maximum number of rows per part, unless the study sets the number of parts.
const ROWS_PER_PART: u64 = 1 << 20;
/// Number of files that a folder can reasonably hold.
const MOST_PARTS: u64 = 1 << 20;
/// Rows of that many parts: years of work.
const MOST_ROWS: u64 = MOST_PARTS * ROWS_PER_PART;
/// Minimum number of parts of a large study, so that shards can share the work.
const PARTS_OF_A_LARGE_STUDY: u64 = 16;
/// Number of rows below which a further part is not worthwhile.
const ROWS_WORTH_A_PART: u64 = 1 << 10;

/// The number of rows requested by an entry; `rows` is `None` on overflow.
pub fn checked_rows(entry: Field<'_>, rows: Option<u64>) -> Result<u64, Error> {
    rows.filter(|rows| *rows <= MOST_ROWS).ok_or_else(|| {
        entry.because(format!("asks for more rows than a study may have ({MOST_ROWS}); coarsen the design"))
    })
}

/// Default number of parts for a number of rows.
pub fn default_parts(rows: u64) -> u64 {
    let small = rows.div_ceil(ROWS_WORTH_A_PART).clamp(1, PARTS_OF_A_LARGE_STUDY);
    small.max(rows.div_ceil(ROWS_PER_PART))
}

/// The number of files requested by the study, if reasonable for its rows.
pub fn checked_parts(entry: Field<'_>, parts: u64, rows: u64) -> Result<u64, Error> {
    if parts > MOST_PARTS {
        return Err(entry.because(format!("is {parts}; at most {MOST_PARTS} files are allowed")));
    }
    if parts > rows {
        return Err(entry.because(format!("is {parts}, but the design has only {rows} rows")));
    }
    Ok(parts)
}
