//! The pages written by `diagnose --report` and `validate --report`, and shared functions.

pub mod diagnosis;
mod quantities;
mod record_table;
pub mod validation;

/// The last component of a path.
fn file(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}
