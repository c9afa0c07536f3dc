//! The Pareto front of some columns: the rows that no other row betters in one column without being worse in another.
//!
//! Of rows with the same values the first is kept, so that fronts of pieces, merged in order, give the front of the whole.

use serde::{Deserialize, Serialize};

/// Maximum number of points of a front: each part stores them all.
pub const MOST: usize = 10_000;

/// The front of the rows so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Front {
    /// Row and values of each point, with signs such that small is good, sorted by the first column.
    points: Vec<(u64, Vec<f64>)>,
    /// Whether there were more points than [`MOST`].
    overflown: bool,
}

impl Front {
    /// Adds a row, unless another one is at least as good in all columns.
    ///
    /// Only points whose first column is no larger can be as good as the row, and only the others can be dominated by it. With
    /// two columns, the second falls along the front: the nearest points then decide, and an addition takes O(log n).
    pub fn add(&mut self, row: u64, values: &[f64]) {
        let as_good = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a <= b);
        let two_columns = values.len() == 2;
        let end = self.points.partition_point(|(_, point)| point[0] <= values[0]);
        let rivals = if two_columns { end.saturating_sub(1)..end } else { 0..end };
        if self.points[rivals].iter().rev().any(|(_, point)| as_good(point, values)) {
            return;
        }
        let begin = self.points[..end].partition_point(|(_, point)| point[0] < values[0]);
        if two_columns {
            let bettered = self.points[begin..].iter().take_while(|(_, point)| as_good(values, point)).count();
            self.points.drain(begin..begin + bettered);
        } else {
            self.points.extract_if(begin.., |(_, point)| as_good(values, point)).for_each(drop);
        }
        if self.points.len() < MOST {
            self.points.insert(begin, (row, values.to_vec()));
        } else {
            self.overflown = true;
        }
    }

    /// Merges the front of later rows.
    pub fn merge(&mut self, later: &Self) {
        self.overflown |= later.overflown;
        later.points.iter().for_each(|(row, values)| self.add(*row, values));
    }

    /// The points by their first column, then by row.
    pub fn sorted(&self) -> Vec<&(u64, Vec<f64>)> {
        let mut points: Vec<_> = self.points.iter().collect();
        points.sort_by(|(a, of_a), (b, of_b)| of_a[0].total_cmp(&of_b[0]).then(a.cmp(b)));
        points
    }

    /// Whether no point was dropped.
    pub fn is_complete(&self) -> bool {
        !self.overflown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_front_is_what_no_other_row_betters_however_it_was_put_together(
            rows in prop::collection::vec(prop::array::uniform4(0..12u8), 1..120), columns in 2..=4usize, cut in 0..120usize,
        ) {
            let values: Vec<Vec<f64>> = rows.iter().map(|row| row.map(f64::from)[..columns].to_vec()).collect();
            let better = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a <= b) && a != b;
            let expected: Vec<u64> = (0..values.len())
                .filter(|&i| !values.iter().any(|v| better(v, &values[i])) && !values[..i].contains(&values[i]))
                .map(|i| i as u64)
                .collect();
            let front = |range: std::ops::Range<usize>| {
                let mut front = Front::default();
                range.for_each(|i| front.add(i as u64, &values[i]));
                front
            };
            let cut = cut.min(values.len());
            let mut merged = front(0..cut);
            merged.merge(&front(cut..values.len()));
            for front in [merged, front(0..values.len())] {
                let mut found: Vec<u64> = front.sorted().iter().map(|(row, _)| *row).collect();
                found.sort_unstable();
                prop_assert_eq!(&found, &expected);
                prop_assert!(front.is_complete());
            }
        }
    }
}
