//! Finds the readings in the rows of one logger's records.

use super::even::{self, Between, Even, FEWEST_READINGS, LONGEST, interpolated, on_lines};
use super::readings::{Readings, Taken, on_grid};
use super::uneven::{self, Uneven};
use super::{held, straight};
use crate::record::sampling::row_time::usual_row_s;

/// Returns the readings of one logger's records, each given by its times, s, and pressures: at the stated rate, Hz, or as each
/// record shows it. A record with too few readings to show a rate is taken to have been read like the one that shows most.
pub fn of_logger(records: &[(&[f64], &[f64])], stated_hz: Option<f64>) -> Vec<Readings> {
    let records: Vec<Rows> = records.iter().map(|(time_s, pressure_pa)| Rows::of(time_s, pressure_pa)).collect();
    if let Some(hz) = stated_hz {
        return records.iter().map(|rows| rows.readings(&|p| stated(p, rows.row_s, hz))).collect();
    }
    let shown: Vec<Readings> = records.iter().map(|rows| rows.readings(&detect)).collect();
    let readings = |(r, rows): &(&Readings, &Rows)| (rows.pressure_pa.len() as f64 / r.period()) as usize;
    let rates = shown.iter().zip(&records).filter(|(r, _)| r.are_slow());
    let Some((most, rows)) = rates.max_by_key(readings) else { return shown };
    let (rate_hz, between) = (1.0 / (most.period() * rows.row_s), most.between());
    let is_even = most.by_own_clock().is_none();
    let of_record = |(r, rows): (&Readings, &Rows)| {
        let period = 1.0 / (rate_hz * rows.row_s);
        let is_short = rows.pressure_pa.len() as f64 * rate_hz * rows.row_s < FEWEST_READINGS as f64;
        match is_even {
            _ if r.are_slow() => r.clone(),
            true if is_short => rows.readings(&|p| stated(p, rows.row_s, rate_hz)),
            true => rows.readings(&|p| on_lines(p, period.round() as usize).map(Found::Even)),
            false => rows.readings(&|p| like(p, between, period)),
        }
    };
    shown.iter().zip(&records).map(of_record).collect()
}

/// A readout slower than the rows.
pub(super) enum Found {
    /// At every k-th row.
    Even(Even),
    /// By the sensor's own clock.
    Uneven(Uneven),
}

impl Found {
    fn period(&self) -> f64 {
        match self {
            Self::Even(even) => even.period as f64,
            Self::Uneven(uneven) => uneven.period,
        }
    }
}

/// Looks for a slower readout in a pressure's rows, with NaN for missing ones.
fn detect(pressure_pa: &[f64]) -> Option<Found> {
    let even = even::held(pressure_pa).or_else(|| interpolated(pressure_pa));
    even.map(Found::Even).or_else(|| by_own_clock(pressure_pa))
}

pub(super) fn by_own_clock(pressure_pa: &[f64]) -> Option<Found> {
    held::held(pressure_pa, None).or_else(|| straight::interpolated(pressure_pa, None)).map(Found::Uneven)
}

/// Looks for the readout of another record of the same sensor, by the sensor's own clock.
pub(super) fn like(pressure_pa: &[f64], between: Between, period: f64) -> Option<Found> {
    let find = if between == Between::Held { held::held } else { straight::interpolated };
    find(pressure_pa, Some(period)).map(Found::Uneven)
}

/// The readout, at a stated rate, Hz, of a pressure whose rows are `row_s` apart. It is searched for where the period is not a
/// whole number of rows, or these rows do not show it.
fn stated(pressure_pa: &[f64], row_s: f64, readout_hz: f64) -> Option<Found> {
    /// Largest relative deviation of a period from a whole number of rows, or from the stated one.
    const OFF: f64 = 0.02;
    /// Most that the readings of a whole-number period may drift from their rows, rows.
    const MOST_DRIFT: f64 = 0.5;
    let rows = 1.0 / (readout_hz * row_s);
    let period = rows.round().max(1.0);
    if rows > 1.0 && (rows / period - 1.0).abs() > OFF {
        return detect(pressure_pa);
    }
    if period < 2.0 {
        return None;
    }
    // Over the record such readings drift relative to the rows.
    let drift = (rows / period - 1.0).abs() * pressure_pa.len() as f64;
    let is_stated = |found: &Found| (found.period() / rows - 1.0).abs() < OFF;
    let shown = || detect(pressure_pa).filter(is_stated);
    let at_rows = || even::of_period(pressure_pa, period as usize).map(Found::Even);
    if drift > MOST_DRIFT { shown().or_else(at_rows) } else { at_rows().or_else(shown) }
}

/// A record's rows on a regular time grid, with gaps where rows are missing.
struct Rows {
    row_s: f64,
    time_s: Vec<f64>,
    pressure_pa: Vec<f64>,
    /// Rows before which one is missing, one entry for each missing row.
    missing: Vec<usize>,
}

impl Rows {
    fn of(time_s: &[f64], pressure_pa: &[f64]) -> Self {
        let row_s = usual_row_s(time_s);
        let gap = |(k, w): (usize, &[f64])| {
            vec![k + 1; (((w[1] - w[0]) / row_s).round() - 1.0).clamp(0.0, LONGEST as f64) as usize]
        };
        let missing = time_s.windows(2).enumerate().flat_map(gap).collect();
        Self { row_s, time_s: time_s.to_vec(), pressure_pa: pressure_pa.to_vec(), missing }
    }

    /// Applies `find` to these rows with the missing ones, and to the rows alone if that finds nothing.
    fn readings(&self, find: &dyn Fn(&[f64]) -> Option<Found>) -> Readings {
        let with_missing = (!self.missing.is_empty()).then(|| find(&self.all())).flatten();
        let (found, missing) = match with_missing {
            Some(found) => (Some(found), &self.missing[..]),
            None => (find(&self.pressure_pa), &[][..]),
        };
        match found {
            Some(Found::Even(even)) => Readings::AtRows(even, missing.to_vec()),
            Some(Found::Uneven(uneven)) => self.taken(uneven, missing),
            None => Readings::EveryRow,
        }
    }

    /// Assigns times to these readings, found in rows of which `missing` are missing.
    fn taken(&self, uneven: Uneven, missing: &[usize]) -> Readings {
        let places: Vec<usize> = (0..self.time_s.len()).map(|row| on_grid(row, missing)).collect();
        let taken = |reading: &uneven::Reading| {
            let row = places.binary_search(&reading.row).ok()?;
            let before = row.saturating_sub(1);
            // Fraction of the way from the row before to this one.
            let share = match places[row] - places[before] {
                0 => 1.0,
                rows => 1.0 - (reading.row as f64 - reading.at) / rows as f64,
            };
            let time_s = self.time_s[before] + share * (self.time_s[row] - self.time_s[before]);
            Some(Taken { row, time_s, pressure_pa: reading.pressure_pa })
        };
        let Uneven { between, period, readings } = uneven;
        Readings::ByOwnClock { between, period, taken: readings.iter().filter_map(taken).collect() }
    }

    /// All rows, with NaN for missing ones: these show neither a change nor a bend.
    fn all(&self) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.pressure_pa.len() + self.missing.len()];
        for (row, p) in self.pressure_pa.iter().enumerate() {
            all[on_grid(row, &self.missing)] = *p;
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    /// Readings found in these rows, 0.01 s apart.
    fn found(pressure_pa: &[f64], find: &dyn Fn(&[f64]) -> Option<Found>) -> Readings {
        let time_s: Vec<f64> = (0..pressure_pa.len()).map(|i| i as f64 * 0.01).collect();
        Rows::of(&time_s, pressure_pa).readings(find)
    }

    fn alone(pressure_pa: &[f64]) -> Readings {
        found(pressure_pa, &detect)
    }

    fn at_rate(pressure_pa: &[f64], row_s: f64, readout_hz: f64) -> Readings {
        found(pressure_pa, &|p| stated(p, row_s, readout_hz))
    }

    /// Asserts that the readings are every `period`-th row from `first` on.
    fn assert_at_rows(found: &Readings, between: Between, period: usize, first: usize) {
        let Readings::AtRows(even, _) = found else { panic!("{found:?}") };
        assert_eq!(*even, Even { between, period, first });
    }

    fn readings(n: usize) -> Vec<f64> {
        let mut random = Random::new(11);
        (0..n).map(|i| 3e5 - 8e4 * (-(i as f64) / 30.0).exp() + 60.0 * random.normal()).collect()
    }

    #[test]
    fn a_held_readout_is_found_with_its_period_and_begin() {
        let slow = readings(100);
        let rows: Vec<f64> = (0..960).map(|i| slow[(i + 7) / 10]).collect();
        let found = alone(&rows);
        assert_at_rows(&found, Between::Held, 10, 3);
        assert!(found.are_at(3) && found.are_at(13) && !found.are_at(4));
    }

    #[test]
    fn a_held_readout_is_found_though_single_rows_are_disturbed() {
        let slow = readings(100);
        let mut rows: Vec<f64> = (0..960).map(|i| slow[(i + 7) / 10]).collect();
        // Within a run, at a reading's own row, and right before the next reading's row.
        for (row, by) in [(88, 2e4), (203, -1e4), (402, 3e4)] {
            rows[row] += by;
        }
        let found = alone(&rows);
        assert_at_rows(&found, Between::Held, 10, 3);
    }

    #[test]
    fn a_held_readout_is_found_where_most_readings_stick_to_a_step() {
        let slow: Vec<f64> = readings(200).iter().map(|p| (p / 2000.0).round() * 2000.0).collect();
        assert!(slow.windows(2).filter(|w| w[0] != w[1]).count() < 80);
        let rows: Vec<f64> = (0..1592).map(|i| slow[(i + 5) / 8]).collect();
        let found = alone(&rows);
        assert_at_rows(&found, Between::Held, 8, 3);
    }

    #[test]
    fn an_interpolated_readout_is_found() {
        let slow = readings(101);
        let rows: Vec<f64> = (0..1000)
            .map(|i| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0)
            .map(|p| (p / 15.25).round() * 15.25)
            .collect();
        let found = alone(&rows);
        assert_at_rows(&found, Between::Interpolated, 10, 0);
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
            let found = alone(&rows);
            assert_at_rows(&found, between, 200, 0);
        }
    }

    #[test]
    fn a_stated_readout_is_taken_where_the_rows_alone_do_not_show_it() {
        // Too few readings to establish a period.
        let slow = readings(12);
        let held: Vec<f64> = (0..70).map(|i| slow[(i + 7) / 10]).collect();
        let straight: Vec<f64> =
            (0..100).map(|i| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0).collect();
        for rows in [&held, &straight] {
            assert_eq!(alone(rows), Readings::EveryRow);
        }
        let found = at_rate(&held, 0.01, 10.0);
        assert_at_rows(&found, Between::Held, 10, 3);
        let found = at_rate(&straight, 0.01, 10.0);
        assert_at_rows(&found, Between::Interpolated, 10, 0);
        assert_eq!(at_rate(&held, 0.01, 200.0), Readings::EveryRow);
        // Rows that bend everywhere are readings, whatever the rig states.
        let every_row = readings(100);
        assert_eq!(at_rate(&every_row, 0.01, 10.0), Readings::EveryRow);
        assert_eq!(at_rate(&held, 0.01, 30.0), alone(&held));
    }

    #[test]
    fn a_record_with_few_readings_was_read_like_the_others_of_its_logger() {
        let slow = readings(101);
        let straight: Vec<f64> =
            (0..1000).map(|i| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0).collect();
        let short = &straight[3..150];
        let times: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
        assert_eq!(of_logger(&[(&times[..147], short)], None), [Readings::EveryRow]);
        let both = of_logger(&[(&times[..147], short), (&times, &straight)], None);
        assert_at_rows(&both[0], Between::Interpolated, 10, 7);
        assert_at_rows(&both[1], Between::Interpolated, 10, 0);
        // Read by another logger, and long enough to show it.
        let every_row = readings(1000);
        assert_eq!(of_logger(&[(&times, &every_row), (&times, &straight)], None)[0], Readings::EveryRow);
    }

    #[test]
    fn a_record_whose_slow_readings_stick_was_read_like_the_others_of_its_logger() {
        let joined = |slow: &[f64]| -> Vec<f64> {
            (0..1000).map(|i| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0).collect()
        };
        let clear = joined(&readings(101));
        let sticks = joined(&readings(101).iter().map(|p| (p / 2e4).round() * 2e4).collect::<Vec<f64>>());
        assert_eq!(alone(&sticks), Readings::EveryRow);
        let times: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
        let both = of_logger(&[(&times, &sticks), (&times, &clear)], None);
        both.iter().for_each(|found| assert_at_rows(found, Between::Interpolated, 10, 0));
    }

    /// Asserts that the readings at every tenth row, from the fourth on, are found in the kept ones of 1000 rows.
    fn assert_found(slow: &[f64], is_kept: impl Fn(&usize) -> bool) {
        let kept: Vec<usize> = (0..1000).filter(is_kept).collect();
        let times: Vec<f64> = kept.iter().map(|i| *i as f64 * 0.01).collect();
        let held: Vec<f64> = kept.iter().map(|i| slow[(i + 7) / 10]).collect();
        let between = |i: usize| slow[i / 10] + (slow[i / 10 + 1] - slow[i / 10]) * (i % 10) as f64 / 10.0;
        let joined: Vec<f64> = kept.iter().map(|i| between(i + 7)).collect();
        for (rows, between) in [(held, Between::Held), (joined, Between::Interpolated)] {
            let found = &of_logger(&[(&times, &rows)], None)[0];
            assert_at_rows(found, between, 10, 3);
            for (row, i) in kept.iter().enumerate() {
                assert_eq!(found.are_at(row), i % 10 == 3, "{i}");
            }
        }
        let every_row: Vec<f64> = readings(1000)[..times.len()].to_vec();
        assert_eq!(of_logger(&[(&times, &every_row)], None)[0], Readings::EveryRow);
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
        let found = alone(&rows);
        assert_at_rows(&found, Between::Interpolated, 4, 0);
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
            assert_eq!(alone(&rows), Readings::EveryRow, "{seed}");
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
            assert_eq!(alone(&rows), Readings::EveryRow, "{seed}");
        }
    }

    #[test]
    fn a_fast_push_is_no_slow_readout() {
        let mut random = Random::new(12);
        let push = |i: usize| if i < 300 { 1e5 } else { 3e5 - 9e4 * (1.0 - (-((i - 300) as f64) / 80.0).exp()) };
        let rows: Vec<f64> = (0..1400).map(|i| push(i) + 40.0 * random.normal()).collect();
        assert_eq!(alone(&rows), Readings::EveryRow);
    }

    #[test]
    fn readings_of_every_row_and_readings_that_stick_to_a_step_are_left_whole() {
        assert_eq!(alone(&readings(1000)), Readings::EveryRow);
        let stuck: Vec<f64> = readings(1000).iter().map(|p| (p / 390.0).round() * 390.0).collect();
        assert_eq!(alone(&stuck), Readings::EveryRow);
    }
}
