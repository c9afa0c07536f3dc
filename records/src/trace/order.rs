//! Order of a trace's times: which rows break it, and whether the rows need sorting.

/// What the times of a file require.
#[derive(Debug, PartialEq)]
pub enum Order {
    /// Each time is greater than the one before.
    Increasing,
    /// They increase except at these rows, which can be left out.
    But(Vec<usize>),
    /// The rows are in another order; all of them, sorted by time.
    Sorted(Vec<usize>),
    /// From this row on, time repeats the same values or is far from the previous ones: another record, or a clock that was set.
    Restarts(usize),
}

/// Examines the times; up to `few` rows may be left out.
pub fn of(times: &[f64], few: usize) -> Order {
    if times.windows(2).all(|pair| pair[0] < pair[1]) {
        return Order::Increasing;
    }
    let odd = odd_rows(times);
    if odd.len() <= few {
        return Order::But(odd);
    }
    let falls: Vec<usize> = (1..times.len()).filter(|&i| times[i] < times[i - 1]).collect();
    // Rows shuffled one by one have many falls; few falls mean runs, which must not overlap.
    if falls.len() <= few.max(1) && times.len() > 2 * falls.len() + 2 {
        let begins = [&[0], &falls[..]].concat();
        let ends = falls.iter().copied().chain([times.len()]);
        let mut runs: Vec<(usize, usize)> = begins.into_iter().zip(ends).collect();
        runs.sort_by(|a, b| times[a.0].total_cmp(&times[b.0]));
        // Nor be farther apart than their lengths: then they are not parts of one record.
        let are_apart = |pair: &&[(usize, usize)]| {
            let [a, b] = [pair[0], pair[1]].map(|(first, end)| [times[first], times[end - 1]]);
            let between = b[0] - a[1];
            between <= 0.0 || between > (a[1] - a[0]) + (b[1] - b[0])
        };
        if let Some(pair) = runs.windows(2).find(are_apart) {
            return Order::Restarts(pair[0].0.max(pair[1].0));
        }
    }
    let mut rows: Vec<usize> = (0..times.len()).collect();
    rows.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
    Order::Sorted(rows)
}

/// The smallest set of rows without which times increase: all but those of a longest increasing subsequence (patience sorting).
fn odd_rows(times: &[f64]) -> Vec<usize> {
    // For each length, the row that ends such a subsequence at the earliest time; for each row, its predecessor.
    let mut ends: Vec<usize> = Vec::new();
    let mut before = vec![usize::MAX; times.len()];
    for (row, time) in times.iter().enumerate() {
        let length = ends.partition_point(|end| times[*end] < *time);
        if length > 0 {
            before[row] = ends[length - 1];
        }
        // Of two rows with the same time, the first is kept.
        match ends.get_mut(length) {
            Some(end) if times[*end] == *time => {}
            Some(end) => *end = row,
            None => ends.push(row),
        }
    }
    let mut kept = vec![false; times.len()];
    let mut row = ends.last().copied().unwrap_or(usize::MAX);
    while row != usize::MAX {
        kept[row] = true;
        row = before[row];
    }
    (0..times.len()).filter(|row| !kept[*row]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_that_repeats_or_jumps_is_the_odd_one() {
        assert_eq!(of(&[0.0, 1.0, 2.0], 0), Order::Increasing);
        assert_eq!(of(&[0.0, 1.0, 1.0, 2.0], 1), Order::But(vec![2]));
        assert_eq!(of(&[0.0, 1.0, 1e9, 2.0, 3.0], 1), Order::But(vec![2]));
        assert_eq!(of(&[0.0, 1.0, 2.0, 0.0, 3.0, 4.0], 1), Order::But(vec![3]));
    }

    #[test]
    fn shuffled_rows_are_sorted() {
        assert_eq!(of(&[0.0, 2.0, 1.0, 4.0, 3.0], 0), Order::Sorted(vec![0, 2, 1, 4, 3]));
        assert_eq!(of(&[3.0, 2.0, 1.0], 0), Order::Sorted(vec![2, 1, 0]));
    }

    #[test]
    fn runs_in_another_order_are_sorted_but_a_clock_that_restarts_is_reported() {
        assert_eq!(of(&[4.0, 5.0, 6.0, 7.0, 0.0, 1.0, 2.0, 3.0], 0), Order::Sorted(vec![4, 5, 6, 7, 0, 1, 2, 3]));
        assert_eq!(of(&[0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0], 0), Order::Restarts(4));
        assert_eq!(of(&[0.0, 1.0, 2.0, 3.0, 0.5, 1.5, 2.5, 3.5], 0), Order::Restarts(4));
        // Set back by an hour.
        assert_eq!(of(&[3600.0, 3601.0, 3602.0, 3.0, 4.0, 5.0, 6.0], 0), Order::Restarts(3));
        assert_eq!(of(&[16.0, 17.0, 18.0, 19.0, 0.0, 1.0, 2.0, 10.0], 0), Order::Sorted(vec![4, 5, 6, 7, 0, 1, 2, 3]));
    }
}
