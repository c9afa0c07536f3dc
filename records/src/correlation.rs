//! How far two columns of a record go together.

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

#[cfg(test)]
mod tests {
    use super::correlation;

    #[test]
    fn series_on_one_line_correlate_fully_and_a_constant_with_nothing() {
        let a = [1.0, 2.0, 4.0];
        assert!((correlation(&a, &a.map(|x| 3.0 - 2.0 * x)) + 1.0).abs() < 1e-15);
        assert_eq!(correlation(&a, &[5.0; 3]), 0.0);
        assert_eq!(correlation(&[], &[]), 0.0);
    }
}
