//! A column with a value at every k-th row only, because it is sampled more slowly than the others: linear interpolation, as
//! other loggers do themselves.

use crate::fill::fill_between;

/// Marks an empty cell until all rows are read.
pub const EMPTY: f64 = f64::NAN;

/// Fills the empty cells if exactly every k-th row has a value.
pub fn fill(column: &mut [f64]) {
    let given: Vec<usize> = (0..column.len()).filter(|row| !column[*row].is_nan()).collect();
    let [first, second, .., last] = given[..] else { return };
    let period = second - first;
    let is_regular = given.windows(2).all(|pair| pair[1] - pair[0] == period);
    if !is_regular || first >= period || column.len() - last > period {
        return;
    }
    fill_between(&given, column);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_at_every_third_row_is_joined_to_the_next_by_a_straight_line() {
        let mut column = [EMPTY, 1.0, EMPTY, EMPTY, 4.0, EMPTY, EMPTY, 1.0, EMPTY];
        fill(&mut column);
        assert_eq!(column, [1.0, 1.0, 2.0, 3.0, 4.0, 3.0, 2.0, 1.0, 1.0]);
    }

    #[test]
    fn single_empty_cells_and_values_here_and_there_are_left() {
        for mut column in [
            vec![1.0, EMPTY, 2.0, 3.0, 4.0],
            vec![EMPTY, 1.0, EMPTY, 2.0, EMPTY, EMPTY, 3.0],
            vec![EMPTY, EMPTY, EMPTY, 1.0, EMPTY, 2.0, EMPTY, 3.0],
            vec![1.0, EMPTY, EMPTY],
            vec![EMPTY; 4],
        ] {
            let before = column.clone();
            fill(&mut column);
            assert!(column.iter().zip(&before).all(|(a, b)| a.to_bits() == b.to_bits()), "{column:?}");
        }
    }
}
