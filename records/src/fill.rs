//! Rows of a column between those that have a value of their own.

/// Joins the rows given, ascending, by straight lines and gives those beyond them the nearest one's value; leaves a column as it
/// is where none is given.
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
