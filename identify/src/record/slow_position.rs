//! Strokes whose position was read less often than the rows come: the logger repeats each reading, or joins them by straight
//! lines. Only the rows that were really read say where the piston is; a curve through all rows would follow a staircase.

use crate::record::readout::{Between, Readout};
use crate::record::stroke::{Motion, Phase};

/// In this unit a position's rounding in arithmetic is nothing to a readout, which looks for that of pressures in Pa.
const PER_METRE: f64 = 1e6;
/// Fewer readings show no stroke.
const FEWEST_READINGS: usize = 12;

/// How the positions of the records of one logger were read; each has its positions, m, and the time from row to row, s.
pub fn readouts(records: &[(&[f64], f64)]) -> Vec<Readout> {
    let scaled: Vec<(Vec<f64>, f64)> = records
        .iter()
        .map(|(position_m, row_s)| (position_m.iter().map(|x| x * PER_METRE).collect(), *row_s))
        .collect();
    let records: Vec<(&[f64], f64)> = scaled.iter().map(|(position, row_s)| (&position[..], *row_s)).collect();
    Readout::of_logger(&records, None)
}

/// The stroke through the rows that were read, in segments of all rows.
pub fn motion(time_s: &[f64], position_m: &[f64], readout: &Readout) -> Motion {
    let n = time_s.len();
    let rows: Vec<usize> = (0..n).filter(|row| readout.is_reading(*row)).collect();
    if readout.period == 1 || rows.len() < FEWEST_READINGS || !is_made_of(position_m, &rows, readout) {
        return Motion::detect(time_s, position_m);
    }
    let of = |column: &[f64]| rows.iter().map(|&row| column[row]).collect::<Vec<f64>>();
    let mut motion = Motion::detect(&of(time_s), &of(position_m));
    motion.rows_per_reading = readout.period;
    let last = motion.segments.len() - 1;
    let mut first = 0;
    for (k, segment) in motion.segments.iter_mut().enumerate() {
        // A hold is over with its last reading: from there on the piston may move.
        let end = match segment.phase {
            _ if k == last => n,
            Phase::Move => rows[segment.end],
            Phase::Rest | Phase::Hold => rows[segment.end - 1] + 1,
        };
        (segment.first, segment.end) = (first, end);
        first = end;
    }
    motion.segments[0].from_s = time_s[0];
    motion.segments[last].to_s = time_s[n - 1];
    motion
}

/// Whether the rows between readings are what the logger makes of these, rounded. A sensor that sticks to its steps toggles at
/// any row, which may look like bends of straight lines, but not while the piston moves.
fn is_made_of(position_m: &[f64], readings: &[usize], readout: &Readout) -> bool {
    /// Share of the rows that may be disturbed.
    const DISTURBED: f64 = 0.01;
    /// Steps that the rounding of a row and of the readings about it may come to.
    const ROUNDING: f64 = 1.01;
    let changes = position_m.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|change| *change > 0.0);
    let step_m = changes.fold(f64::INFINITY, f64::min);
    let is_off = |row: usize, pair: &[usize]| {
        let [from, to] = [position_m[pair[0]], position_m[pair[1]]];
        let share = (row - pair[0]) as f64 / (pair[1] - pair[0]) as f64;
        match readout.between {
            Between::Interpolated => (position_m[row] - from - share * (to - from)).abs() > ROUNDING * step_m,
            _ => position_m[row] != from,
        }
    };
    let off: usize = readings.windows(2).map(|pair| (pair[0]..pair[1]).filter(|row| is_off(*row, pair)).count()).sum();
    off as f64 <= DISTURBED * position_m.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;
    use std::cell::Cell;

    const SLOW: usize = 10;

    fn stroke(t: f64) -> f64 {
        let u = ((t - 0.5) / 0.4).clamp(0.0, 1.0);
        0.15 - 0.07 * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
    }

    /// Times of rows at 500 Hz, and readings of the position at 50 Hz.
    fn read() -> (Vec<f64>, Vec<f64>) {
        let mut random = Random::new(4);
        let time_s: Vec<f64> = (0..2000).map(|i| 0.002 * f64::from(i)).collect();
        let readings =
            time_s.iter().step_by(SLOW).map(|t| (1e6 * (stroke(*t) + 5e-6 * random.normal())).round() * 1e-6);
        let readings = readings.collect();
        (time_s, readings)
    }

    fn assert_is_followed(time_s: &[f64], position_m: &[f64]) {
        let readout = &readouts(&[(position_m, 0.002)])[0];
        assert_eq!((readout.period, readout.first), (SLOW, 0));
        let motion = motion(time_s, position_m, readout);
        assert_eq!(
            motion.segments.iter().map(|s| s.phase).collect::<Vec<_>>(),
            [Phase::Rest, Phase::Move, Phase::Hold]
        );
        assert_eq!((motion.extent(), motion.rows()), ((time_s[0], time_s[1999]), 2000));
        for pair in motion.segments.windows(2) {
            assert_eq!((pair[0].end, pair[0].to_s), (pair[1].first, pair[1].from_s));
        }
        let near = Cell::new(0);
        for t in time_s {
            let off = motion.segments[motion.segment_at(*t)].stroke.at(*t, &near).0 - stroke(*t);
            assert!(off.abs() < 3e-5, "{t}: {off}");
        }
        assert!((3e-6..1e-5).contains(&motion.noise_m), "{}", motion.noise_m);
    }

    #[test]
    fn a_position_that_is_held_between_its_readings_is_followed_through_them() {
        let (time_s, readings) = read();
        let held: Vec<f64> = (0..2000).map(|i| readings[i / SLOW]).collect();
        assert_is_followed(&time_s, &held);
    }

    #[test]
    fn a_position_that_straight_lines_join_is_followed_through_its_readings() {
        let (time_s, mut readings) = read();
        readings.push(readings[199]);
        let share = |i: usize| (i % SLOW) as f64 / SLOW as f64;
        let joined: Vec<f64> = (0..2000)
            .map(|i| readings[i / SLOW] * (1.0 - share(i)) + readings[i / SLOW + 1] * share(i))
            .map(|x| (1e6 * x).round() * 1e-6)
            .collect();
        assert_is_followed(&time_s, &joined);
    }

    #[test]
    fn a_period_that_the_rows_of_a_move_do_not_show_is_none() {
        let mut random = Random::new(6);
        let time_s: Vec<f64> = (0..2000).map(|i| 0.002 * f64::from(i)).collect();
        let coarse: Vec<f64> =
            time_s.iter().map(|t| ((stroke(*t) + 3e-5 * random.normal()) / 1e-4).round() * 1e-4).collect();
        for between in [Between::Interpolated, Between::Held] {
            let readout = Readout { between, period: 100, ..Readout::every_row() };
            assert_eq!(motion(&time_s, &coarse, &readout), Motion::detect(&time_s, &coarse));
        }
    }

    #[test]
    fn every_row_is_a_reading_of_a_ramp_in_steps_and_of_a_piston_that_rests() {
        let ramp = |i: usize| 0.15 - 0.07 * ((i as f64 - 200.0) / 100.0).clamp(0.0, 1.0);
        let steps: Vec<f64> = (0..1000).map(|i| (ramp(i) / 5e-4).round() * 5e-4).collect();
        let mut random = Random::new(9);
        let noisy: Vec<f64> = (0..1000).map(|i| (1e6 * (ramp(i) + 5e-6 * random.normal())).round() * 1e-6).collect();
        for position_m in [steps, noisy] {
            assert_eq!(readouts(&[(&position_m, 0.01)])[0].period, 1);
        }
    }
}
