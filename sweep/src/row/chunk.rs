//! Chunks in which rows are computed, written and summarised, the same whatever the part, shard or thread.

use std::ops::Range;

/// Rows per Arrow batch.
pub const CHUNK: u64 = 1 << 13;

/// Splits rows into chunks. Chunks are counted from row zero of the study, so that they do not depend on the parts.
pub fn chunks(rows: Range<u64>) -> Vec<Range<u64>> {
    let first = rows.start / CHUNK;
    let last = rows.end.div_ceil(CHUNK);
    (first..last).map(|i| rows.start.max(i * CHUNK)..rows.end.min((i + 1) * CHUNK)).filter(|r| !r.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_their_rows_once_and_in_order() {
        for rows in [0..0, 0..1, 5..CHUNK, CHUNK - 1..3 * CHUNK + 7] {
            let all: Vec<u64> = chunks(rows.clone()).into_iter().flatten().collect();
            assert!(all.into_iter().eq(rows));
        }
    }
}
