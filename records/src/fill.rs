//! Fills rows of a column between those with known values.

/// Interpolates linearly between the given rows, ascending, and extends the first and last value to the rows beyond; leaves the
/// column unchanged if no row is given.
pub fn fill_between(given: &[usize], column: &mut [f64]) {
    let (Some(&first), Some(&last)) = (given.first(), given.last()) else { return };
    for pair in given.windows(2) {
        let [from, to] = [column[pair[0]], column[pair[1]]];
        let rows = (pair[1] - pair[0]) as f64;
        for (step, value) in column[pair[0]..pair[1]].iter_mut().enumerate() {
            *value = from + (to - from) * step as f64 / rows;
        }
    }
    let ends = [column[first], column[last]];
    column[..first].fill(ends[0]);
    column[last..].fill(ends[1]);
}
