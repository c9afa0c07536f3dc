//! A column of which some rows are left out.

/// Keeps the values of a column for which `keep` says so, by row; those of rows beyond it stay.
pub fn keep_rows(column: &mut Vec<f64>, keep: &[bool]) {
    let mut kept = keep.iter();
    column.retain(|_| *kept.next().unwrap_or(&true));
}
