//! Statistics of a record's column.

/// Correlation of two series of the same length, -1 to 1; 0 if one of them is constant.
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
    noise_of_second_differences(second_differences(values).collect())
}

/// Absolute second differences of a signal, which are zero for steady change.
pub fn second_differences(values: &[f64]) -> impl Iterator<Item = f64> {
    values.windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]).abs())
}

/// Standard deviation of white noise with absolute second differences of these sizes; 0 for none. Based on their median, so that
/// a few large ones have no influence. The variance of a second difference is 1 + 4 + 1 times that of the values.
pub fn noise_of_second_differences(second_differences: Vec<f64>) -> f64 {
    DEVIATION_OF_MEDIAN * median(second_differences) / 6.0_f64.sqrt()
}

/// Fraction of the changes between values whose sign differs from that of the previous change: two thirds for noise, zero for
/// monotonic change. Repeated values are skipped.
pub fn reversal_fraction(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    let changes: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).filter(|change| *change != 0.0).collect();
    let pairs = changes.windows(2);
    pairs.clone().filter(|w| (w[0] < 0.0) != (w[1] < 0.0)).count() as f64 / pairs.len().max(1) as f64
}

/// Ratio of a normal distribution's standard deviation to its median absolute deviation.
pub const DEVIATION_OF_MEDIAN: f64 = 1.4826;

/// The middle value; 0 for none. Borrowed values are reordered.
pub fn median(mut values: impl AsMut<[f64]>) -> f64 {
    let values = values.as_mut();
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Median time step; 0 for fewer than two times.
pub(crate) fn interval(times: &[f64]) -> f64 {
    median(times.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<f64>>())
}

/// Minimum and maximum.
pub fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)))
}

#[cfg(test)]
mod tests {
    use super::{correlation, reversal_fraction};

    #[test]
    fn series_on_one_line_correlate_fully_and_a_constant_with_nothing() {
        let a = [1.0, 2.0, 4.0];
        assert!((correlation(&a, &a.map(|x| 3.0 - 2.0 * x)) + 1.0).abs() < 1e-15);
        assert_eq!(correlation(&a, &[5.0; 3]), 0.0);
        assert_eq!(correlation(&[], &[]), 0.0);
    }

    #[test]
    fn monotonic_change_reverses_nowhere_and_alternating_change_everywhere() {
        assert_eq!(reversal_fraction([1.0, 2.0, 2.0, 3.0, 5.0]), 0.0);
        assert_eq!(reversal_fraction([1.0, 2.0, 2.0, 1.0, 2.0]), 1.0);
        assert_eq!(reversal_fraction([1.0, 2.0, 1.0, 0.0]), 0.5);
        assert_eq!(reversal_fraction([1.0; 5]), 0.0);
        assert_eq!(reversal_fraction([]), 0.0);
    }
}
