//! Parts and rows of a shard.

use sweep::{Shard, Study};

/// Parts of a shard.
pub fn parts_of(study: &Study, shard: Shard) -> impl Iterator<Item = u64> {
    (0..study.parts).filter(move |part| shard.has(*part))
}

/// Rows of a shard.
pub fn rows_of(study: &Study, shard: Shard) -> u64 {
    parts_of(study, shard).map(|part| study.rows_of(part)).map(|rows| rows.end - rows.start).sum()
}
