//! Which rows of a record are data: a sensor read out more slowly than the rows fills the rows in between with what it
//! showed last, or with straight lines; those rows say nothing new.
//!
//! A held readout repeats each reading, also while the pressure changes by many times its noise; an interpolated one
//! bends at every k-th row only. Rows that are missing in between count, since the sensor does not wait for them. Rows marked
//! as outliers are no data either, nor are those of a move that the position does not show.

use crate::record::bends::{Bends, MOST_OF_USUAL};
use std::ops::Range;

/// How the rows between two readings came to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// Every row is a reading.
    Nothing,
    /// The last reading repeated.
    Held,
    /// Straight lines.
    Interpolated,
}

impl Between {
    /// What the rows between two readings do, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Nothing => "are readings too",
            Self::Held => "repeat the last reading",
            Self::Interpolated => "lie on straight lines",
        }
    }
}

/// Which rows are readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Readout {
    /// What stands between two readings.
    pub between: Between,
    /// Rows from one reading to the next; 1 where every row is one.
    pub period: usize,
    /// The first row that is a reading.
    pub first: usize,
    /// Rows before which one is missing, ascending: one for each that is.
    pub missing: Vec<usize>,
    /// Rows that are no data although they are readings, ascending.
    pub outliers: Vec<usize>,
    /// Rows that are no data since nothing tells where the piston is.
    pub unfollowed: Vec<Range<usize>>,
    /// Rows that are no data since others beside them were lost while the piston moved.
    pub at_gaps: Vec<Range<usize>>,
    /// Rows at the end that are no data since the chamber was opened before: see [`opened_from`](records::opened_from).
    pub opened: Option<Range<usize>>,
    /// Rows that are no data since the sensor was at an end of its range.
    pub saturated: Vec<Range<usize>>,
    /// Standard deviation of the times of the rows, s, where they were read unevenly; else empty.
    pub open_s: Vec<f64>,
}

/// Longest period that is looked for, rows: a gauge read ten times a second beside rows at 2 kHz...
const LONGEST: usize = 250;
/// ...or at 20 kHz where its readings are held, which shows at once.
const LONGEST_HELD: usize = 2000;
/// At least so many readings must be in a record for a period to be believed that its bends show.
const FEWEST_READINGS: usize = 20;

impl Readout {
    /// Every row is a reading.
    pub fn every_row() -> Self {
        Self::new(Between::Nothing, 1, 0)
    }

    fn new(between: Between, period: usize, first: usize) -> Self {
        Self {
            between,
            period,
            first,
            missing: Vec::new(),
            outliers: Vec::new(),
            unfollowed: Vec::new(),
            at_gaps: Vec::new(),
            opened: None,
            saturated: Vec::new(),
            open_s: Vec::new(),
        }
    }

    /// Readouts of the records of one logger, of which each has its times, s, and pressures: at the stated rate, Hz, or as each
    /// record shows it. One with too few readings to show anything was read like that which shows most.
    pub fn of_logger(records: &[(&[f64], &[f64])], stated_hz: Option<f64>) -> Vec<Self> {
        let records: Vec<Rows> = records.iter().map(|(time_s, pressure_pa)| Rows::of(time_s, pressure_pa)).collect();
        if let Some(hz) = stated_hz {
            return records.iter().map(|rows| rows.readout(&|p| Self::stated(p, rows.row_s, hz))).collect();
        }
        let shown: Vec<Self> = records.iter().map(|rows| rows.readout(&Self::detect)).collect();
        let readings = |(r, rows): &(&Self, &Rows)| rows.pressure_pa.len() / r.period;
        let rates = shown.iter().zip(&records).filter(|(r, _)| r.period > 1);
        let Some(rate_hz) = rates.max_by_key(readings).and_then(|(r, rows)| r.rate_hz(rows.row_s)) else {
            return shown;
        };
        let of_record = |(r, rows): (Self, &Rows)| {
            let is_short = rows.pressure_pa.len() as f64 * rate_hz * rows.row_s < FEWEST_READINGS as f64;
            match r.period {
                1 if is_short => rows.readout(&|p| Self::stated(p, rows.row_s, rate_hz)),
                1 => rows.readout(&|p| Self::on_lines(p, (1.0 / (rate_hz * rows.row_s)).round() as usize)),
                _ => r,
            }
        };
        shown.into_iter().zip(&records).map(of_record).collect()
    }

    /// Looks for a slower readout in a pressure's rows, those that are missing not a number.
    pub fn detect(pressure_pa: &[f64]) -> Self {
        held(pressure_pa).or_else(|| interpolated(pressure_pa)).unwrap_or_else(Self::every_row)
    }

    /// The readout of a pressure whose rows come `row_s` apart and that was read out at a stated rate, Hz: looked for
    /// where the rate does not fit a whole number of rows.
    pub fn stated(pressure_pa: &[f64], row_s: f64, readout_hz: f64) -> Self {
        /// How far a period may be from a whole number of rows.
        const OFF: f64 = 0.02;
        let rows = 1.0 / (readout_hz * row_s);
        let period = rows.round().max(1.0);
        match period as usize {
            _ if rows > 1.0 && (rows / period - 1.0).abs() > OFF => Self::detect(pressure_pa),
            1 => Self::every_row(),
            period => Self::of_period(pressure_pa, period),
        }
    }

    /// Interpolated with that period, if the other rows lie on straight lines, be the readings of a sticking sensor on one line too.
    fn on_lines(pressure_pa: &[f64], period: usize) -> Self {
        let bends = Bends::of(pressure_pa);
        let on_lines = (2..=bends.squares.len() / FEWEST_READINGS).contains(&period).then(|| bends.largest(period));
        let first = on_lines.flatten().filter(|(first, most)| bends.stand_out(period, *first, *most).is_some());
        first.map_or_else(Self::every_row, |(first, _)| Self::new(Between::Interpolated, period, first))
    }

    /// Held where hardly any other row than every `period`-th changes, interpolated where these have most of the bends: begun where
    /// changes, or bends, are largest. Where the rows in between bend as much, each of them is a reading, whatever was stated.
    fn of_period(pressure_pa: &[f64], period: usize) -> Self {
        let sums = |squares: &mut dyn Iterator<Item = (usize, f64)>| {
            let mut sums = vec![0.0; period];
            squares.filter(|(_, square)| !square.is_nan()).for_each(|(row, square)| sums[row % period] += square);
            let first = (0..period).max_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0);
            (first, sums[first], sums.iter().sum::<f64>())
        };
        let changes = pressure_pa.windows(2).enumerate().map(|(i, w)| (i + 1, (w[1] - w[0]).powi(2)));
        let bends = pressure_pa.windows(3).enumerate().map(|(i, w)| (i + 1, (w[0] - 2.0 * w[1] + w[2]).powi(2)));
        let (first, there, all) = sums(&mut { changes });
        if all - there <= 1e-3 * all {
            return Self::new(Between::Held, period, first);
        }
        /// Share of the bends' squares.
        const MOST: f64 = 0.5;
        match sums(&mut { bends }) {
            (first, there, all) if there >= MOST * all => Self::new(Between::Interpolated, period, first),
            _ => Self::every_row(),
        }
    }

    /// Whether a row is data.
    #[inline]
    pub fn is_data(&self, row: usize) -> bool {
        self.is_reading(row)
            && self.outliers.binary_search(&row).is_err()
            && !self.is_open(row)
            && !self.is_saturated(row)
            && !self.unfollowed.iter().chain(&self.at_gaps).any(|rows| rows.contains(&row))
    }

    /// Whether the sensor is at an end of its range at a row.
    pub fn is_saturated(&self, row: usize) -> bool {
        self.saturated.iter().any(|rows| rows.contains(&row))
    }

    /// Whether the chamber is open at a row.
    #[inline]
    pub fn is_open(&self, row: usize) -> bool {
        self.opened.as_ref().is_some_and(|rows| rows.contains(&row))
    }

    /// Whether a row was really read, be it an outlier or not.
    #[inline]
    pub fn is_reading(&self, row: usize) -> bool {
        let row = row + self.missing.partition_point(|before| *before <= row);
        row >= self.first % self.period && (row - self.first % self.period).is_multiple_of(self.period)
    }

    /// Readings in a second where rows come `row_s` apart; `None` where every row is a reading.
    pub fn rate_hz(&self, row_s: f64) -> Option<f64> {
        (self.period > 1).then(|| 1.0 / (self.period as f64 * row_s))
    }
}

/// A record's rows on the grid of their times, which a row that is left out leaves a gap in.
struct Rows {
    row_s: f64,
    pressure_pa: Vec<f64>,
    /// Rows before which one is missing, one for each that is.
    missing: Vec<usize>,
}

impl Rows {
    fn of(time_s: &[f64], pressure_pa: &[f64]) -> Self {
        let mut intervals: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
        intervals.sort_unstable_by(f64::total_cmp);
        let row_s = intervals.get(intervals.len() / 2).copied().unwrap_or(1.0);
        let gap = |(k, w): (usize, &[f64])| {
            vec![k + 1; (((w[1] - w[0]) / row_s).round() - 1.0).clamp(0.0, LONGEST as f64) as usize]
        };
        let missing = time_s.windows(2).enumerate().flat_map(gap).collect();
        Self { row_s, pressure_pa: pressure_pa.to_vec(), missing }
    }

    /// What `find` finds in these rows, with those that are missing; in the rows alone where that is nothing.
    fn readout(&self, find: &dyn Fn(&[f64]) -> Readout) -> Readout {
        let found = (!self.missing.is_empty()).then(|| find(&self.all())).filter(|found| found.period > 1);
        let found = found.map(|found| Readout { missing: self.missing.clone(), ..found });
        found.unwrap_or_else(|| find(&self.pressure_pa))
    }

    /// All rows, those that are missing not a number: what they were shows neither a change nor a bend.
    fn all(&self) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.pressure_pa.len() + self.missing.len()];
        for (row, p) in self.pressure_pa.iter().enumerate() {
            all[row + self.missing.partition_point(|missing| *missing <= row)] = *p;
        }
        all
    }
}

/// Changes fall on every k-th row only, but for few, although nearly every reading differs from the one before it.
fn held(pressure_pa: &[f64]) -> Option<Readout> {
    let changes: Vec<usize> =
        (1..pressure_pa.len()).filter(|&i| (pressure_pa[i] - pressure_pa[i - 1]).abs() > 0.0).collect();
    if 2 * changes.len() > pressure_pa.len() {
        return None;
    }
    let mut distances: Vec<usize> = changes.windows(2).map(|w| w[1] - w[0]).collect();
    distances.sort_unstable();
    let most_frequent = distances.chunk_by(|a, b| a == b).max_by_key(|alike| alike.len())?[0];
    // Where readings stick to a step most changes may be several readings apart; where single rows are disturbed, less than one.
    [distances[0], most_frequent].into_iter().find_map(|period| held_for(&changes, period))
}

/// The readout of that many rows, if the changes are its.
fn held_for(changes: &[usize], period: usize) -> Option<Readout> {
    /// Natural logarithm of the probability with which changes on any rows all fall on a grid: surely no chance.
    const BY_CHANCE: f64 = -16.0;
    /// Share of the changes that disturbances of single rows may be.
    const DISTURBED: f64 = 0.05;
    if !(2..=LONGEST_HELD).contains(&period) {
        return None;
    }
    let mut at = vec![0; period];
    changes.iter().for_each(|row| at[row % period] += 1);
    let (first, on_grid) = at.into_iter().enumerate().max_by_key(|(first, count)| (*count, period - first))?;
    let (all, off) = (changes.len() as f64, (changes.len() - on_grid) as f64);
    // In so many ways are those off the grid chosen from all (Stirling).
    let ways = if off > 0.0 { off * (1.0 + (all / off).ln()) } else { 0.0 };
    let chance = ways - (on_grid - 1) as f64 * (period as f64).ln();
    // A sensor that sticks to its steps changes on any row; a slow one on its own rows only.
    (off <= DISTURBED * all && chance <= BY_CHANCE).then(|| Readout::new(Between::Held, period, first))
}

/// Second differences vanish, to the rounding of the readings, but at every k-th row.
pub(super) fn interpolated(pressure_pa: &[f64]) -> Option<Readout> {
    let bends = Bends::of(&pressure_pa[..pressure_pa.len().min(20_000)]);
    let candidates = (2..=LONGEST.min(bends.squares.len() / FEWEST_READINGS)).filter_map(|period| {
        let (first, most) = bends.largest(period)?;
        bends.stand_out(period, first, most)?;
        // Spikes and a push bend few rows much: what stands for a period is the usual bend of its readings.
        let stands_out = bends.stand_out(period, first, MOST_OF_USUAL * bends.usual(period, first))?;
        Some((stands_out, Readout::new(Between::Interpolated, period, first)))
    });
    // Where several periods pass, as divisors of the true one do, that which stands out most.
    candidates.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, readout)| readout)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    fn readings(n: usize) -> Vec<f64> {
        let mut random = Random::new(11);
        (0..n).map(|i| 3e5 - 8e4 * (-(i as f64) / 30.0).exp() + 60.0 * random.normal()).collect()
    }

    #[test]
    fn a_held_readout_is_found_with_its_period_and_begin() {
        let slow = readings(100);
        let rows: Vec<f64> = (0..960).map(|i| slow[(i + 7) / 10]).collect();
        let found = Readout::detect(&rows);
        assert_eq!((found.between, found.period, found.first), (Between::Held, 10, 3));
        assert!(found.is_data(3) && found.is_data(13) && !found.is_data(4));
    }

    #[test]
    fn a_held_readout_is_found_though_single_rows_are_disturbed() {
        let slow = readings(100);
        let mut rows: Vec<f64> = (0..960).map(|i| slow[(i + 7) / 10]).collect();
        // Amid a run, at a reading's own row, and right before the next one's.
        for (row, by) in [(88, 2e4), (203, -1e4), (402, 3e4)] {
            rows[row] += by;
        }
        let found = Readout::detect(&rows);
        assert_eq!((found.between, found.period, found.first), (Between::Held, 10, 3));
    }

    #[test]
    fn a_held_readout_is_found_where_most_readings_stick_to_a_step() {
        let slow: Vec<f64> = readings(200).iter().map(|p| (p / 2000.0).round() * 2000.0).collect();
        assert!(slow.windows(2).filter(|w| w[0] != w[1]).count() < 80);
        let rows: Vec<f64> = (0..1592).map(|i| slow[(i + 5) / 8]).collect();
        let found = Readout::detect(&rows);
        assert_eq!((found.between, found.period, found.first), (Between::Held, 8, 3));
    }

    #[test]
    fn an_interpolated_readout_is_found() {
        let slow = readings(101);
        let rows: Vec<f64> = (0..1000)
            .map(|i| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0)
            .map(|p| (p / 15.25).round() * 15.25)
            .collect();
        let found = Readout::detect(&rows);
        assert_eq!((found.between, found.period, found.first), (Between::Interpolated, 10, 0));
    }

    #[test]
    fn a_readout_that_is_hundreds_of_rows_slow_is_found() {
        let slow = readings(61);
        let held: Vec<f64> = (0..12_000).map(|i| slow[i / 200]).collect();
        let straight: Vec<f64> = (0..12_000)
            .map(|i| slow[i / 200] + (slow[i / 200 + 1] - slow[i / 200]) * (i % 200) as f64 / 200.0)
            .map(|p| (p * 10.0).round() / 10.0)
            .collect();
        for (rows, between) in [(held, Between::Held), (straight, Between::Interpolated)] {
            let found = Readout::detect(&rows);
            assert_eq!((found.between, found.period, found.first), (between, 200, 0));
        }
    }

    #[test]
    fn a_stated_readout_is_taken_where_the_rows_alone_do_not_show_it() {
        // Too few readings for a period to be believed.
        let slow = readings(12);
        let held: Vec<f64> = (0..70).map(|i| slow[(i + 7) / 10]).collect();
        let straight: Vec<f64> =
            (0..100).map(|i| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0).collect();
        for rows in [&held, &straight] {
            assert_eq!(Readout::detect(rows).period, 1);
        }
        let found = Readout::stated(&held, 0.01, 10.0);
        assert_eq!((found.between, found.period, found.first), (Between::Held, 10, 3));
        let found = Readout::stated(&straight, 0.01, 10.0);
        assert_eq!((found.between, found.period, found.first), (Between::Interpolated, 10, 0));
        assert_eq!(Readout::stated(&held, 0.01, 200.0), Readout::every_row());
        // Rows that bend all over are readings, whatever the rig states.
        let every_row = readings(100);
        assert_eq!(Readout::stated(&every_row, 0.01, 10.0), Readout::every_row());
        assert_eq!(Readout::stated(&held, 0.01, 30.0), Readout::detect(&held));
    }

    #[test]
    fn a_record_with_few_readings_was_read_like_the_others_of_its_logger() {
        let slow = readings(101);
        let straight: Vec<f64> =
            (0..1000).map(|i| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0).collect();
        let short = &straight[3..150];
        let times: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
        assert_eq!(Readout::of_logger(&[(&times[..147], short)], None), [Readout::every_row()]);
        let both = Readout::of_logger(&[(&times[..147], short), (&times, &straight)], None);
        assert_eq!(both.iter().map(|r| (r.period, r.first)).collect::<Vec<_>>(), [(10, 7), (10, 0)]);
        // Read by another logger, and long enough to show it.
        let every_row = readings(1000);
        assert_eq!(Readout::of_logger(&[(&times, &every_row), (&times, &straight)], None)[0], Readout::every_row());
    }

    #[test]
    fn a_record_whose_slow_readings_stick_was_read_like_the_others_of_its_logger() {
        let joined = |slow: &[f64]| -> Vec<f64> {
            (0..1000).map(|i| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0).collect()
        };
        let clear = joined(&readings(101));
        let sticks = joined(&readings(101).iter().map(|p| (p / 2e4).round() * 2e4).collect::<Vec<f64>>());
        assert_eq!(Readout::detect(&sticks), Readout::every_row());
        let times: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
        let both = Readout::of_logger(&[(&times, &sticks), (&times, &clear)], None);
        assert_eq!(
            both.iter().map(|r| (r.between, r.period, r.first)).collect::<Vec<_>>(),
            [(Between::Interpolated, 10, 0); 2]
        );
    }

    /// Asserts that the readings in every tenth row, from the fourth on, are found in those of 1000 rows that were kept.
    fn assert_found(slow: &[f64], is_kept: impl Fn(&usize) -> bool) {
        let kept: Vec<usize> = (0..1000).filter(is_kept).collect();
        let times: Vec<f64> = kept.iter().map(|i| *i as f64 * 0.01).collect();
        let held: Vec<f64> = kept.iter().map(|i| slow[(i + 7) / 10]).collect();
        let between = |i: usize| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0;
        let joined: Vec<f64> = kept.iter().map(|i| between(i + 7)).collect();
        for (rows, between) in [(held, Between::Held), (joined, Between::Interpolated)] {
            let found = &Readout::of_logger(&[(&times, &rows)], None)[0];
            assert_eq!((found.between, found.period, found.first), (between, 10, 3));
            for (row, i) in kept.iter().enumerate() {
                assert_eq!(found.is_reading(row), i % 10 == 3, "{i}");
            }
        }
        let every_row: Vec<f64> = readings(1000)[..times.len()].to_vec();
        assert_eq!(Readout::of_logger(&[(&times, &every_row)], None)[0], Readout::every_row());
    }

    #[test]
    fn a_slow_readout_is_found_though_single_rows_are_missing() {
        assert_found(&readings(102), |i| ![37, 204, 205, 310, 555, 702, 871].contains(i));
    }

    #[test]
    fn a_slow_readout_is_found_though_a_reading_of_a_push_is_missing_and_many_rows_in_a_row() {
        let mut slow = readings(102);
        slow.iter_mut().skip(30).for_each(|p| *p += 1e5);
        slow[30] -= 3e4;
        // The reading at row 303, by which the push is over, and a long stretch while the gas relaxes.
        assert_found(&slow, |i| *i != 303 && !(400..480).contains(i));
    }

    #[test]
    fn an_interpolated_readout_is_found_in_a_file_with_fewer_digits_than_the_sensors_steps() {
        let slow = readings(251);
        let rows: Vec<f64> = (0..1000)
            .map(|i| slow[i / 4] + (slow[i / 4 + 1] - slow[i / 4]) * (i % 4) as f64 / 4.0)
            .map(|p| ((p / 24.414).round() * 24.414 * 10.0).round() / 10.0)
            .collect();
        let found = Readout::detect(&rows);
        assert_eq!((found.between, found.period, found.first), (Between::Interpolated, 4, 0));
    }

    #[test]
    fn spikes_are_no_slow_readout() {
        for seed in 0..10 {
            let mut random = Random::new(200 + seed);
            let mut rows: Vec<f64> = (0..4200).map(|_| 2e5 + 200.0 * random.normal()).collect();
            for k in 0..9 {
                rows[(173 + 467 * k + 13 * seed as usize) % 4200] += 2e4 * random.normal();
            }
            rows.iter_mut().for_each(|p| *p = (*p / 390.6).round() * 390.6);
            assert_eq!(Readout::detect(&rows).period, 1, "{seed}");
        }
    }

    #[test]
    fn noise_that_toggles_between_coarse_steps_is_no_slow_readout() {
        for seed in 0..10 {
            let mut random = Random::new(100 + seed);
            let rows: Vec<f64> = (0..4200)
                .map(|i| 2e5 + 250.0 * (f64::from(i) / 20.0).sin() + 200.0 * random.normal())
                .map(|p| (p / 390.6).round() * 390.6)
                .collect();
            assert_eq!(Readout::detect(&rows).period, 1, "{seed}");
        }
    }

    #[test]
    fn a_fast_push_is_no_slow_readout() {
        let mut random = Random::new(12);
        let push = |i: usize| if i < 300 { 1e5 } else { 3e5 - 9e4 * (1.0 - (-((i - 300) as f64) / 80.0).exp()) };
        let rows: Vec<f64> = (0..1400).map(|i| push(i) + 40.0 * random.normal()).collect();
        assert_eq!(Readout::detect(&rows), Readout::every_row());
    }

    #[test]
    fn readings_of_every_row_and_readings_that_stick_to_a_step_are_left_whole() {
        assert_eq!(Readout::detect(&readings(1000)), Readout::every_row());
        let stuck: Vec<f64> = readings(1000).iter().map(|p| (p / 390.0).round() * 390.0).collect();
        assert_eq!(Readout::detect(&stuck).period, 1);
    }
}
