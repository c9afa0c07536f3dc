//! Excel's moments: days since the end of 1899, with the time of day as their fraction.

use std::ops::Range;

/// Day numbers from 1954 to 2119.
const DAYS: Range<f64> = 20_000.0..80_000.0;
/// Minimum duration of a push-and-hold record, s.
const SHORTEST_RECORD: f64 = 0.05;
/// Minimum interval between rows, s: no logger of cylinders is faster.
const SHORTEST_STEP: f64 = 2e-5;

/// Whether this many times between these two can only be Excel's days: as seconds, the record would be too short and too fast.
pub fn are_days(from: f64, to: f64, rows: usize) -> bool {
    let span = to - from;
    let step = span / rows.saturating_sub(1).max(1) as f64;
    DAYS.contains(&from) && span > 0.0 && span < SHORTEST_RECORD && step < SHORTEST_STEP
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_distinguished_from_seconds_of_a_day() {
        // Ten seconds at 100 Hz; an hour at 1 Hz.
        assert!(are_days(45_000.5, 45_000.5 + 10.0 / 86_400.0, 1001));
        assert!(are_days(45_000.5, 45_000.5 + 3600.0 / 86_400.0, 3601));
        // Seconds since midnight, for ten seconds at 100 Hz and for a second at 100 kHz.
        assert!(!are_days(45_000.5, 45_010.5, 1001));
        assert!(!are_days(45_000.5, 45_001.5, 100_001));
        assert!(!are_days(0.0, 0.01, 1001));
    }
}
