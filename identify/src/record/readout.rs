//! Which rows of a record are data: a sensor read out more slowly than the rows fills the rows in between with what it
//! showed last, or with straight lines; those rows say nothing new.
//!
//! A held readout repeats each reading, also while the pressure changes by many times its noise; an interpolated one
//! bends at every k-th row only. Rows marked as outliers are no data either.

use crate::record::lattice::lattice;

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
    /// Rows that are no data although they are readings, ascending.
    pub outliers: Vec<usize>,
}

/// Longest period that is looked for, rows: a gauge read ten times a second beside rows at 2 kHz.
const LONGEST: usize = 250;
/// At least so many readings must be in a record for a period to be believed that its bends show.
const FEWEST_READINGS: usize = 20;

impl Readout {
    /// Every row is a reading.
    pub fn every_row() -> Self {
        Self { between: Between::Nothing, period: 1, first: 0, outliers: Vec::new() }
    }

    /// Readouts of the records of one logger, of which each has its pressure and the time from row to row, s: at the stated rate,
    /// Hz, or as each record shows it. One with too few readings to show anything was read like that which shows most.
    pub fn of_logger(records: &[(&[f64], f64)], stated_hz: Option<f64>) -> Vec<Self> {
        if let Some(hz) = stated_hz {
            return records.iter().map(|(pressure_pa, row_s)| Self::stated(pressure_pa, *row_s, hz)).collect();
        }
        let shown: Vec<Self> = records.iter().map(|(pressure_pa, _)| Self::detect(pressure_pa)).collect();
        let readings = |(r, (pressure_pa, _)): &(&Self, &(&[f64], f64))| pressure_pa.len() / r.period;
        let rates = shown.iter().zip(records).filter(|(r, _)| r.period > 1);
        let Some(rate_hz) = rates.max_by_key(readings).and_then(|(r, (_, row_s))| r.rate_hz(*row_s)) else {
            return shown;
        };
        let of_record = |(r, (pressure_pa, row_s)): (Self, &(&[f64], f64))| {
            let is_short = pressure_pa.len() as f64 * rate_hz * row_s < FEWEST_READINGS as f64;
            if r.period == 1 && is_short { Self::stated(pressure_pa, *row_s, rate_hz) } else { r }
        };
        shown.into_iter().zip(records).map(of_record).collect()
    }

    /// Looks for a slower readout in a pressure's rows.
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

    /// Held where hardly any other row than every `period`-th changes, else interpolated: begun where changes, or bends, are
    /// largest.
    fn of_period(pressure_pa: &[f64], period: usize) -> Self {
        let sums = |squares: &mut dyn Iterator<Item = (usize, f64)>| {
            let mut sums = vec![0.0; period];
            squares.for_each(|(row, square)| sums[row % period] += square);
            let first = (0..period).max_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0);
            (first, sums[first], sums.iter().sum::<f64>())
        };
        let changes = pressure_pa.windows(2).enumerate().map(|(i, w)| (i + 1, (w[1] - w[0]).powi(2)));
        let bends = pressure_pa.windows(3).enumerate().map(|(i, w)| (i + 1, (w[0] - 2.0 * w[1] + w[2]).powi(2)));
        let (first, there, all) = sums(&mut { changes });
        let (between, first) = if all - there <= 1e-3 * all {
            (Between::Held, first)
        } else {
            (Between::Interpolated, sums(&mut { bends }).0)
        };
        Self { between, period, first, outliers: Vec::new() }
    }

    /// Whether a row is data.
    #[inline]
    pub fn is_data(&self, row: usize) -> bool {
        self.is_reading(row) && self.outliers.binary_search(&row).is_err()
    }

    /// Whether a row was really read, be it an outlier or not.
    #[inline]
    pub fn is_reading(&self, row: usize) -> bool {
        row >= self.first % self.period && (row - self.first % self.period).is_multiple_of(self.period)
    }

    /// Readings in a second where rows come `row_s` apart; `None` where every row is a reading.
    pub fn rate_hz(&self, row_s: f64) -> Option<f64> {
        (self.period > 1).then(|| 1.0 / (self.period as f64 * row_s))
    }
}

/// Changes fall on every k-th row only, but for few, although nearly every reading differs from the one before it.
fn held(pressure_pa: &[f64]) -> Option<Readout> {
    let changes: Vec<usize> = (1..pressure_pa.len()).filter(|&i| pressure_pa[i] != pressure_pa[i - 1]).collect();
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
    if !(2..=LONGEST).contains(&period) {
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
    (off <= DISTURBED * all && chance <= BY_CHANCE).then(|| Readout {
        between: Between::Held,
        period,
        first,
        outliers: Vec::new(),
    })
}

/// Second differences vanish, to the rounding of the readings, but at every k-th row.
pub(super) fn interpolated(pressure_pa: &[f64]) -> Option<Readout> {
    /// Mean square at the other rows over that at the k-th rows, where rows are not rounded.
    const SMALL: f64 = 0.01;
    /// The same at the least, where rounding hides part of it.
    const CLEAR: f64 = 0.6;
    /// Bends below this are rounding of the arithmetic, Pa.
    const NOTHING: f64 = 1e-6;
    /// A bend's square over the usual one of a reading, at the most.
    const MOST: f64 = 25.0;
    let rows = &pressure_pa[..pressure_pa.len().min(20_000)];
    let bends = rows.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs());
    let squares: Vec<f64> = bends.map(|bend| if bend > NOTHING { bend * bend } else { 0.0 }).collect();
    // On straight lines the rounding is all that bends; the slopes themselves need not differ by single steps.
    let mut largest: Vec<f64> = squares.iter().copied().filter(|s| *s > 0.0).collect();
    let step = lattice(&mut largest.iter().map(|s| s.sqrt()).collect::<Vec<f64>>());
    // Rounding passes a second difference with variance 6 step²/12.
    let rounding = 1.5 * 0.5 * step * step;
    largest.sort_by(|a, b| b.total_cmp(a));
    let candidates = (2..=LONGEST.min(squares.len() / FEWEST_READINGS)).filter_map(|period| {
        // A few large bends, as of a push, are not to stand for a period: limited by what a reading's bend would be.
        let most = MOST * largest.get(squares.len() / (2 * period)).or(largest.last())?;
        let mut sums = vec![0.0; period];
        for (i, square) in squares.iter().enumerate() {
            sums[(i + 1) % period] += square.min(most);
        }
        let first = (0..period).max_by(|a, b| sums[*a].total_cmp(&sums[*b]))?;
        let others = (sums.iter().sum::<f64>() - sums[first]) / (period - 1) as f64;
        let readings = squares.len() as f64 / period as f64;
        let straight = others < SMALL * sums[first] || (others / readings < rounding && others < CLEAR * sums[first]);
        // A sensor that sticks to its steps bends here and there; an interpolated one at nearly every reading.
        let places = (0..squares.len()).filter(|i| (i + 1) % period == first);
        let bends = places.clone().filter(|&i| squares[i] > 0.0).count();
        let readout = Readout { between: Between::Interpolated, period, first, outliers: Vec::new() };
        (straight && 2 * bends > places.count()).then(|| ((sums[first] - others) / readings.sqrt(), readout))
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
        assert_eq!(Readout::stated(&held, 0.01, 30.0), Readout::detect(&held));
    }

    #[test]
    fn a_record_with_few_readings_was_read_like_the_others_of_its_logger() {
        let slow = readings(101);
        let straight: Vec<f64> =
            (0..1000).map(|i| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0).collect();
        let short = &straight[3..150];
        assert_eq!(Readout::of_logger(&[(short, 0.01)], None), [Readout::every_row()]);
        let both = Readout::of_logger(&[(short, 0.01), (&straight, 0.01)], None);
        assert_eq!(both.iter().map(|r| (r.period, r.first)).collect::<Vec<_>>(), [(10, 7), (10, 0)]);
        // Read by another logger, and long enough to show it.
        let every_row = readings(1000);
        assert_eq!(Readout::of_logger(&[(&every_row, 0.01), (&straight, 0.01)], None)[0], Readout::every_row());
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
