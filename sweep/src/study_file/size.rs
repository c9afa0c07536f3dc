//! How many rows and parts a study may have, and into how many parts its rows are divided.

use super::section::Entry;
use crate::error::Error;
use records::Field;

/// Rows of a part at most, unless the study sets the number of parts.
const ROWS_PER_PART: u64 = 1 << 20;
/// Files that a folder can still be asked to hold.
const MOST_PARTS: u64 = 1 << 20;
/// Rows that so many parts hold: years of work.
const MOST_ROWS: u64 = MOST_PARTS * ROWS_PER_PART;
/// Parts of a study of many rows at least, so that shards have something to share.
const PARTS_OF_A_LARGE_STUDY: u64 = 16;
/// Rows below which a further part is not worth a file.
const ROWS_WORTH_A_PART: u64 = 1 << 10;

/// The number of rows that an entry asks for; `None` where it does not fit.
pub fn checked_rows(entry: Field<'_>, rows: Option<u64>) -> Result<u64, Error> {
    rows.filter(|rows| *rows <= MOST_ROWS).ok_or_else(|| {
        entry.because(format!("asks for more rows than a study may have ({MOST_ROWS}); coarsen the design"))
    })
}

/// Number of parts that follows from a number of rows.
pub fn default_parts(rows: u64) -> u64 {
    let small = rows.div_ceil(ROWS_WORTH_A_PART).clamp(1, PARTS_OF_A_LARGE_STUDY);
    small.max(rows.div_ceil(ROWS_PER_PART))
}

/// The number of files that the study asks for, where so many make sense for its rows.
pub fn checked_parts(entry: Field<'_>, parts: u64, rows: u64) -> Result<u64, Error> {
    if parts > MOST_PARTS {
        return Err(entry.because(format!("is {parts}; at most {MOST_PARTS} files are allowed")));
    }
    if parts > rows {
        return Err(entry.because(format!("is {parts}, but the design has only {rows} rows")));
    }
    Ok(parts)
}
