//! The pages that `diagnose --report` and `validate --report` write, and what they share.

pub mod diagnosis;
mod quantities;
mod record_table;
pub mod validation;

/// The last part of a path.
fn file(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}
