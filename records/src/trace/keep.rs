//! Removes rows from a column.

/// Keeps the values of a column whose row is `true` in `keep`; rows beyond its end are kept.
pub fn keep_rows(column: &mut Vec<f64>, keep: &[bool]) {
    let mut kept = keep.iter();
    column.retain(|_| *kept.next().unwrap_or(&true));
}
