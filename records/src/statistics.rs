//! What is told from a column of a record.

/// Correlation of two series of the same length, -1 to 1; 0 where one of them does not vary.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().max(1) as f64;
    let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        ab += (x - ma) * (y - mb);
        aa += (x - ma).powi(2);
        bb += (y - mb).powi(2);
    }
    ab / (aa * bb).sqrt().max(f64::MIN_POSITIVE)
}

/// Standard deviation of white noise on a signal, from second differences.
pub(crate) fn white_noise(values: &[f64]) -> f64 {
    noise_of_bends(bends(values).collect())
}

/// The sizes of a signal's second differences, which steady change does not enter.
pub fn bends(values: &[f64]) -> impl Iterator<Item = f64> {
    values.windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]).abs())
}

/// Standard deviation of the white noise that makes second differences of these sizes; 0 of none. By their median, so that a
/// few large ones do not count. The variance of a second difference is 1 + 4 + 1 times that of its values.
pub fn noise_of_bends(bends: Vec<f64>) -> f64 {
    DEVIATION_OF_MEDIAN * median(bends) / 6.0_f64.sqrt()
}

/// Share of the changes from value to value that go the other way than the change before: noise turns two of three back, what goes
/// on in one direction none. A value that repeats the one before is no change.
pub fn turned_back(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    let changes: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).filter(|change| *change != 0.0).collect();
    let pairs = changes.windows(2);
    pairs.clone().filter(|w| (w[0] < 0.0) != (w[1] < 0.0)).count() as f64 / pairs.len().max(1) as f64
}

/// Standard deviation of a normal distribution over the median distance from its middle.
pub const DEVIATION_OF_MEDIAN: f64 = 1.4826;

/// The value in the middle; 0 of none. Values that are lent come back in another order.
pub fn median(mut values: impl AsMut<[f64]>) -> f64 {
    let values = values.as_mut();
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// The median step from a time to the next; 0 of fewer than two.
pub(crate) fn interval(times: &[f64]) -> f64 {
    median(times.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<f64>>())
}

/// The least and the greatest value.
pub fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)))
}

#[cfg(test)]
mod tests {
    use super::{correlation, turned_back};

    #[test]
    fn series_on_one_line_correlate_fully_and_a_constant_with_nothing() {
        let a = [1.0, 2.0, 4.0];
        assert!((correlation(&a, &a.map(|x| 3.0 - 2.0 * x)) + 1.0).abs() < 1e-15);
        assert_eq!(correlation(&a, &[5.0; 3]), 0.0);
        assert_eq!(correlation(&[], &[]), 0.0);
    }

    #[test]
    fn what_goes_on_turns_nothing_back_and_what_goes_to_and_fro_all_of_it() {
        assert_eq!(turned_back([1.0, 2.0, 2.0, 3.0, 5.0]), 0.0);
        assert_eq!(turned_back([1.0, 2.0, 2.0, 1.0, 2.0]), 1.0);
        assert_eq!(turned_back([1.0, 2.0, 1.0, 0.0]), 0.5);
        assert_eq!(turned_back([1.0; 5]), 0.0);
        assert_eq!(turned_back([]), 0.0);
    }
}
