//! The time from one row of a record to the next, s.

use records::median;

/// Mean time between successive rows, s, where no row is lost.
pub fn usual_row_s(time_s: &[f64]) -> f64 {
    /// A step of this multiple of the median one or more has lost a row; one that only the clock lengthens has not.
    const LOST: f64 = 1.5;
    let mut steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    if steps.is_empty() {
        return 1.0;
    }
    let longest = LOST * median(&mut steps);
    let whole: Vec<f64> = steps.into_iter().filter(|step| *step < longest).collect();
    whole.iter().sum::<f64>() / whole.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lost_rows_do_not_lengthen_the_time_from_row_to_row() {
        let rows = (0..300).filter(|i| i % 50 != 7 && !(100..140).contains(i));
        let time_s: Vec<f64> = rows.map(|i| 0.01 * f64::from(i)).collect();
        assert!((usual_row_s(&time_s) - 0.01).abs() < 1e-12);
        // A clock of whole milliseconds at 150 rows a second.
        let time_s: Vec<f64> = (0..300).map(|i| (1e3 * f64::from(i) / 150.0).round() * 1e-3).collect();
        assert!((usual_row_s(&time_s) * 150.0 - 1.0).abs() < 1e-3);
    }
}
