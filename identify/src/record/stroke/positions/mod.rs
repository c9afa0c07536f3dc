//! Which rows of a record are readings of the position, m.
//!
//! A position sensor that is read less often than the rows come fills the rows in between with its last reading or with straight
//! lines; and single rows stand out from all around them, where a reading was lost or disturbed. Neither shows the piston's
//! position: the stroke goes through the other rows.

mod disturbed;
mod slow;

use crate::record::sampling::readout::Between;
use disturbed::stand_out;
use records::fill_between;
use slow::Slow;
use std::ops::Range;

/// Fewest readings that show a stroke.
const FEWEST_READINGS: usize = 12;

/// Which rows are readings of the position.
#[derive(Clone, Debug, PartialEq)]
pub struct Positions {
    /// Rows that are readings, ascending.
    pub rows: Vec<usize>,
    /// Rows that stand out from those around them.
    pub outliers: Vec<usize>,
    /// What the rows between two readings do.
    pub between: Between,
}

impl Positions {
    /// From the positions of all rows, m.
    pub fn of(position_m: &[f64]) -> Self {
        Self::with(position_m, slow::readings)
    }

    /// For a rig's records. One that does not show its readout was read like the one that shows most, if this fits.
    pub fn of_rig(records: &[&[f64]]) -> Vec<Self> {
        let mut all: Vec<Self> = records.iter().map(|position_m| Self::of(position_m)).collect();
        let slow = all.iter().filter(|positions| positions.between != Between::Nothing);
        if let Some(shown) = slow.max_by_key(|positions| positions.rows.len()) {
            let (between, period) = (shown.between, shown.rows_per_reading());
            let of_all_rows = all.iter_mut().zip(records).filter(|(own, _)| own.between == Between::Nothing);
            for (own, position_m) in of_all_rows {
                *own = Self::with(position_m, |rows| slow::readings_at_every(period, between, rows));
            }
        }
        all
    }

    /// From the positions of all rows, m; `slow` finds the readings among the undisturbed ones.
    fn with(position_m: &[f64], slow: impl Fn(&[f64]) -> Option<Slow>) -> Self {
        let mut kept: Vec<usize> = (0..position_m.len()).collect();
        let mut outliers = stand_out(&kept, position_m);
        let undisturbed = filled(&without(&kept, &outliers), position_m);
        let slow = slow(&undisturbed).filter(|(_, rows)| rows.len() >= FEWEST_READINGS);
        let between = slow.as_ref().map_or(Between::Nothing, |(between, _)| *between);
        if let Some((_, rows)) = slow {
            // A disturbed reading persists in all rows up to the next one.
            outliers.extend(stand_out(&rows, &undisturbed));
            outliers.sort_unstable();
            kept = rows;
        }
        Self { rows: without(&kept, &outliers), outliers, between }
    }

    /// Whether all rows are readings.
    pub fn are_all(&self) -> bool {
        self.between == Between::Nothing && self.outliers.is_empty()
    }

    /// Whether they are held and change in these rows, ascending, and hardly ever in others: both come in the same messages.
    pub fn change_in(&self, rows: &[usize], position_m: &[f64]) -> bool {
        /// Least fraction of the changes.
        const NEARLY_ALL: f64 = 0.9;
        let changes = self.rows.windows(2).filter(|w| position_m[w[0]] != position_m[w[1]]).map(|w| w[1]);
        let (all, there) =
            changes.fold((0, 0), |(all, there), row| (all + 1, there + usize::from(rows.binary_search(&row).is_ok())));
        self.between == Between::Held && there as f64 > NEARLY_ALL * all as f64
    }

    /// Mean number of rows from one reading to the next; 1 where every row is read.
    pub fn rows_per_reading(&self) -> usize {
        match (self.between, self.rows.as_slice()) {
            (Between::Nothing, _) | (_, [] | [_]) => 1,
            (_, [first, .., last]) => ((last - first) as f64 / (self.rows.len() - 1) as f64).round() as usize,
        }
    }

    /// Values of a column of the record in these rows.
    pub fn readings(&self, column: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|&row| column[row]).collect()
    }

    /// The readings among some rows of the record.
    pub fn in_rows(&self, rows: &Range<usize>) -> &[usize] {
        let [first, end] = [rows.start, rows.end].map(|of| self.rows.partition_point(|row| *row < of));
        &self.rows[first..end]
    }

    /// The readings in some rows of the record, counted from the first of these.
    pub fn of_rows(&self, rows: &Range<usize>) -> Self {
        let counted = |of: &[usize]| of.iter().filter(|row| rows.contains(row)).map(|row| row - rows.start).collect();
        Self { rows: counted(&self.rows), outliers: counted(&self.outliers), between: self.between }
    }

    /// The positions of all rows, linear between readings.
    pub fn filled(&self, position_m: &[f64]) -> Vec<f64> {
        filled(&self.rows, position_m)
    }
}

/// These rows without some of them; both ascending.
fn without(rows: &[usize], gone: &[usize]) -> Vec<usize> {
    rows.iter().copied().filter(|row| gone.binary_search(row).is_err()).collect()
}

/// All rows, linear between these and constant beyond them.
fn filled(rows: &[usize], position_m: &[f64]) -> Vec<f64> {
    let mut out = position_m.to_vec();
    fill_between(rows, &mut out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;
    use std::f64::consts::TAU;

    /// 0.1 m to 0.05 m in 0.3 s from 0.5 s on, then slowly back; noise of some µm, rounded to 1 µm.
    fn stroke(time: f64, noise: f64) -> f64 {
        let u = ((time - 0.5) / 0.3).clamp(0.0, 1.0);
        let back = 0.02 * (time - 2.0).max(0.0);
        ((0.1 - 0.05 * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u) + back + noise) * 1e6).round() * 1e-6
    }

    fn rows(every: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut random = Random::new(3);
        let mut last = 0.0;
        (0..300)
            .map(|i| {
                if i == 0 || every(i) {
                    last = stroke(i as f64 * 0.01, 4e-6 * random.normal());
                }
                last
            })
            .collect()
    }

    #[test]
    fn a_record_that_begins_in_a_fast_swing_begins_with_a_reading_and_a_lost_first_one_is_none() {
        // A swing of 10 mm that fades at 100 Hz.
        let swings = |first: usize| -> Vec<f64> {
            let time_s = |i: usize| 0.01 * (first + i) as f64;
            (0..200).map(time_s).map(|t| 0.2 + 0.02 * (-t / 0.02).exp() * (TAU * t / 0.06).cos()).collect()
        };
        for first in 0..8 {
            let mut position_m = swings(first);
            assert_eq!(Positions::of(&position_m).outliers, [], "{first}");
            position_m[0] = 0.0;
            assert_eq!(Positions::of(&position_m).outliers, [0], "{first}");
            position_m.reverse();
            assert_eq!(Positions::of(&position_m).outliers, [199], "{first}");
        }
    }

    #[test]
    fn a_record_that_begins_at_most_two_rows_before_a_fast_move_begins_with_a_reading() {
        let mut random = Random::new(12);
        // 50 mm in 80 ms at 100 Hz, evenly or smoothly, from a third of a row to two rows after the first one.
        for begin in [0.3, 0.5, 0.8, 1.0, 1.4, 1.9] {
            for is_even in [true, false] {
                let progress = |u: f64| if is_even { u } else { u * u * u * (10.0 - 15.0 * u + 6.0 * u * u) };
                let position = |row: u32| 0.08 - 0.05 * progress(((f64::from(row) - begin) / 8.0).clamp(0.0, 1.0));
                let mut position_m: Vec<f64> = (0..200).map(|row| position(row) + 5e-6 * random.normal()).collect();
                assert_eq!(Positions::of(&position_m).outliers, [], "{begin} {is_even}");
                position_m.reverse();
                assert_eq!(Positions::of(&position_m).outliers, [], "{begin} {is_even}");
            }
        }
    }

    #[test]
    fn every_row_of_a_usual_record_is_a_reading() {
        let exact = |f: fn(f64) -> f64| (0..300).map(|i| f(i as f64 * 0.01)).collect::<Vec<f64>>();
        let ramp = |t: f64| 0.1 - 0.02 * (t - 0.5).clamp(0.0, 2.0);
        // Steps of 0.1 mm, of which a steady move makes one in every fifth or tenth row.
        let coarse = exact(|t| ((0.1 - 0.002 * (t - 0.5).clamp(0.0, 2.0)) * 1e4).round() * 1e-4);
        let finer = exact(|t| ((0.1 - 0.001 * (t - 0.5).clamp(0.0, 2.0)) * 1e5).round() * 1e-5);
        let to_and_fro = exact(|t| 0.1 + 0.05 * (60.0 * t).sin());
        let bouncing = exact(|t| 0.1 - 0.05 * (1.0 - (-8.0 * (t - 0.5).max(0.0)).exp() * (90.0 * t).cos().abs()));
        // Noise that toggles between the steps of a coarse sensor bends here and there.
        let mut random = Random::new(6);
        let toggling = (0..2000).map(|i| stroke(f64::from(i) * 0.002, 3e-5 * random.normal()));
        let toggling: Vec<f64> = toggling.map(|x| (x / 1e-4).round() * 1e-4).collect();
        for position_m in [rows(|_| true), exact(ramp), coarse, finer, to_and_fro, bouncing, toggling] {
            assert!(Positions::of(&position_m).are_all());
        }
    }

    #[test]
    fn a_held_readout_is_found_also_where_its_rate_does_not_divide_that_of_the_rows() {
        let regular = Positions::of(&rows(|i| i % 4 == 1));
        assert_eq!((regular.between, regular.outliers.len()), (Between::Held, 0));
        assert!(regular.rows.iter().skip(1).all(|row| row % 4 == 1), "{:?}", regular.rows);
        let position_m = rows(|i| i * 3 / 10 != (i - 1) * 3 / 10);
        let irregular = Positions::of(&position_m);
        assert_eq!(irregular.between, Between::Held);
        assert!((85..95).contains(&irregular.rows.len()), "{:?}", irregular.rows);
        assert!((1..300).all(|i| position_m[i] == position_m[i - 1] || irregular.rows.contains(&i)));
    }

    #[test]
    fn a_held_readout_without_noise_is_read_as_often_at_rest_as_in_a_move() {
        let position_m: Vec<f64> = (0..300).map(|i| stroke((i / 5 * 5) as f64 * 0.01, 0.0)).collect();
        let found = Positions::of(&position_m);
        assert_eq!(found.rows, (0..60).map(|k| 5 * k).collect::<Vec<_>>());
    }

    #[test]
    fn a_held_readout_is_found_by_its_noise_where_hardly_a_reading_falls_into_the_move() {
        // Read every 20th row; the move is over in 30.
        let mut random = Random::new(5);
        let mut reading = |row: usize| {
            let u = ((row as f64 - 250.0) / 30.0).clamp(0.0, 1.0);
            ((0.1 - 0.05 * u + 1e-6 * random.normal()) * 1e6).round() * 1e-6
        };
        let readings: Vec<f64> = (0..60).map(|k| reading(20 * k + 10)).collect();
        let position_m: Vec<f64> = (0..1190).map(|row| readings[(row + 10) / 20]).collect();
        let found = Positions::of(&position_m);
        assert_eq!((found.between, found.rows_per_reading()), (Between::Held, 20));
        assert!(found.rows.iter().skip(1).all(|row| row % 20 == 10), "{:?}", found.rows);
    }

    #[test]
    fn an_interpolated_readout_is_found() {
        let slow = rows(|_| true);
        let position_m: Vec<f64> = (0..290)
            .map(|i| slow[i / 4 * 4] + (slow[i / 4 * 4 + 4] - slow[i / 4 * 4]) * (i % 4) as f64 / 4.0)
            .map(|x| (x * 1e6).round() * 1e-6)
            .collect();
        let found = Positions::of(&position_m);
        assert_eq!((found.between, &found.rows[..3]), (Between::Interpolated, &[0, 4, 8][..]));
        let filled = found.filled(&position_m);
        assert!(filled[..=288].iter().zip(&position_m).all(|(a, b)| (a - b).abs() < 1e-6));
    }

    #[test]
    fn lost_and_disturbed_readings_are_left_out_and_a_stop_within_a_move_is_not() {
        let mut position_m = rows(|_| true);
        let good = position_m.clone();
        for row in [20, 30, 64, 150, 151, 250] {
            position_m[row] = if row == 64 { 0.0 } else { position_m[row] + 0.02 };
        }
        let found = Positions::of(&position_m);
        assert_eq!(found.outliers, [20, 30, 64, 150, 151, 250]);
        assert!(found.filled(&position_m).iter().zip(&good).all(|(a, b)| (a - b).abs() < 2e-3));
        let mut at_the_ends = good.clone();
        (at_the_ends[0], at_the_ends[299]) = (0.0, 0.0);
        let found = Positions::of(&at_the_ends);
        assert_eq!(found.outliers, [0, 299]);
        assert!((found.filled(&at_the_ends)[0] - good[1]).abs() < 1e-9);
        // In the fastest part of a move, by half of its travel per row.
        let mut position_m = good.clone();
        position_m[65] -= 0.0015;
        assert_eq!(Positions::of(&position_m).outliers, [65]);
        // One after the other, off by different distances.
        let mut position_m = good.clone();
        (position_m[64], position_m[65]) = (0.0, position_m[65] + 0.011);
        assert_eq!(Positions::of(&position_m).outliers, [64, 65]);
        let stop = |i: usize| if (60..63).contains(&i) { 59 } else { i };
        let with_a_stop: Vec<f64> = (0..300).map(|i| good[stop(i)]).collect();
        assert!(Positions::of(&with_a_stop).are_all());
    }

    #[test]
    fn a_lost_reading_of_a_held_readout_is_left_out() {
        let mut position_m = rows(|i| i % 4 == 1);
        position_m[149..153].fill(0.0);
        let found = Positions::of(&position_m);
        assert_eq!((found.between, found.outliers), (Between::Held, vec![149]));
    }
}
