//! Readings by the sensor's own clock, whose period is no whole number of rows.

use super::even::Between;

/// A reading of the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The first row that shows it.
    pub row: usize,
    /// When it was read, in rows: at that row, or less than one row before.
    pub at: f64,
    /// Pa.
    pub pressure_pa: f64,
}

/// All of these readings, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Uneven {
    /// What the rows between two readings do.
    pub between: Between,
    /// Rows from one reading to the next.
    pub period: f64,
    /// The readings, each in a different row.
    pub readings: Vec<Reading>,
}

#[cfg(test)]
mod tests {
    use super::super::Readings;
    use super::super::find::{by_own_clock, like, of_logger};
    use super::*;
    use crate::synthetic::Random;

    const ROW_S: f64 = 0.004;

    /// A sensor whose readings come `period` rows apart.
    #[derive(Clone, Copy, Debug)]
    struct Sensor {
        period: f64,
        noise_pa: f64,
        step_pa: f64,
    }

    const FINE: Sensor = Sensor { period: 4.07, noise_pa: 60.0, step_pa: 0.1 };
    const STICKS: Sensor = Sensor { noise_pa: 40.0, step_pa: 390.6, ..FINE };

    /// Two pushes with their relaxations, Pa, at a time in rows.
    fn gas(row: f64) -> f64 {
        let push = |at: f64, by: f64| {
            let u = ((row - at) / 60.0).clamp(0.0, 1.0);
            by * (u * u * (3.0 - 2.0 * u) - 0.4 * (1.0 - (-(row - at - 60.0).max(0.0) / 300.0).exp()))
        };
        2e5 + push(400.0, 3e5) + push(1600.0, -1.5e5)
    }

    struct Record {
        time_s: Vec<f64>,
        pressure_pa: Vec<f64>,
        /// When each reading was taken, in rows, and what it was, Pa.
        readings: Vec<[f64; 2]>,
    }

    impl Record {
        /// With `rows` rows, of which those kept are in the file.
        fn of(sensor: Sensor, between: Between, seed: u64, rows: usize, is_kept: impl Fn(usize) -> bool) -> Self {
            let Sensor { period, noise_pa, step_pa } = sensor;
            let mut random = Random::new(seed);
            let begin = -period * random.uniform();
            let readings: Vec<[f64; 2]> = (0..(rows as f64 / period) as usize + 3)
                .map(|k| begin + k as f64 * period)
                .map(|at| [at, ((gas(at) + noise_pa * random.normal()) / step_pa).round() * step_pa])
                .collect();
            let shown = |row: usize| {
                let last = readings.partition_point(|[at, _]| *at <= row as f64) - 1;
                let [[from, a], [to, b]] = [readings[last], readings[last + 1]];
                let share = (row as f64 - from) / (to - from);
                let p = if between == Between::Held { a } else { a + (b - a) * share };
                (p * 1e3).round() * 1e-3
            };
            let kept: Vec<usize> = (0..rows).filter(|row| is_kept(*row)).collect();
            let time_s = kept.iter().map(|row| *row as f64 * ROW_S).collect();
            Self { time_s, pressure_pa: kept.into_iter().map(shown).collect(), readings }
        }

        fn readout(&self) -> Readings {
            of_logger(&[(&self.time_s, &self.pressure_pa)], None).remove(0)
        }

        /// Checks that at least this fraction of its readings is found, no others, and their times, rows, and pressures, Pa.
        fn assert_read(&self, found: &Readings, share: f64, within: [f64; 2], what: &str) {
            let count = self.pressure_pa.len() as f64 / found.period();
            let taken = found.by_own_clock().unwrap();
            assert!(taken.len() as f64 > share * count, "{what}: {}", taken.len());
            for taken in taken {
                let at = taken.time_s / ROW_S;
                let off = |[true_at, p]: &[f64; 2]| [true_at - at, p - taken.pressure_pa].map(f64::abs);
                let nearest = self.readings.iter().map(off).min_by(|a, b| a[0].total_cmp(&b[0])).unwrap();
                assert!(nearest[0] < within[0] && nearest[1] < within[1], "{what}, row {}: {nearest:?}", taken.row);
                assert!(found.are_at(taken.row));
            }
            let (time_s, _) = found.at_their_times(&self.time_s, &self.pressure_pa).unwrap();
            assert!(time_s.windows(2).all(|w| w[1] > w[0]), "{what}");
        }
    }

    #[test]
    fn readings_by_a_clock_of_the_sensors_own_are_found_with_the_times_at_which_they_were_taken() {
        for period in [2.37, 4.07, 7.77, 10.24, 40.96] {
            for sensor in [FINE, STICKS].map(|sensor| Sensor { period, ..sensor }) {
                for (between, seed) in
                    [(Between::Held, 1), (Between::Held, 2), (Between::Interpolated, 3), (Between::Interpolated, 4)]
                {
                    let what = format!("{sensor:?} {between:?} {seed}");
                    let rows = if period < 20.0 { 3000 } else { 6000 };
                    let whole = Record::of(sensor, between, seed, rows, |_| true);
                    let found = whole.readout();
                    assert_eq!(found.between(), between, "{what}");
                    assert!((found.period() / period - 1.0).abs() < 2e-4, "{what}: {}", found.period());
                    whole.assert_read(&found, 0.98, [0.1, 1.0], &what);
                    let with_gaps =
                        Record::of(sensor, between, seed, rows, |row| row % 97 != 5 && !(900..950).contains(&row));
                    let found = with_gaps.readout();
                    assert_eq!(found.between(), between, "{what}");
                    with_gaps.assert_read(&found, 0.9, [0.2, 1.0], &what);
                }
            }
        }
    }

    #[test]
    fn a_clock_that_is_a_little_slow_against_the_rows_is_followed() {
        // Read at every third row, but one row later after each 50 readings.
        let sensor = Sensor { period: 3.02, ..FINE };
        let record = Record::of(sensor, Between::Held, 1, 9000, |_| true);
        let found = record.readout();
        assert!((found.period() - 3.02).abs() < 1e-4, "{}", found.period());
        record.assert_read(&found, 0.99, [0.05, 1e-3], "slow clock");
    }

    #[test]
    fn a_clock_that_is_not_quite_steady_is_followed() {
        // A message is late by up to a quarter of a row.
        for seed in 0..4 {
            let mut late = Random::new(20 + seed);
            let mut record = Record::of(FINE, Between::Held, seed, 3000, |_| true);
            record.readings.iter_mut().for_each(|[at, _]| *at += 0.25 * late.uniform());
            let shown = |row: usize| {
                record.readings[record.readings.partition_point(|[at, _]| *at <= row as f64).max(1) - 1][1]
            };
            record.pressure_pa = (0..3000).map(shown).collect();
            let found = record.readout();
            assert_eq!(found.between(), Between::Held, "{seed}");
            record.assert_read(&found, 0.98, [0.35, 1e-3], "not steady");
        }
    }

    #[test]
    fn disturbed_rows_are_no_readings_of_a_clock_of_the_sensors_own() {
        let mut record = Record::of(FINE, Between::Held, 5, 3000, |_| true);
        for row in (40..3000).step_by(173) {
            record.pressure_pa[row] += 2e4;
        }
        let found = record.readout();
        assert_eq!(found.between(), Between::Held);
        let readings = found.by_own_clock().unwrap();
        let spoilt = readings.iter().filter(|taken| (taken.row + 3000 - 40).is_multiple_of(173)).count();
        assert!((730..740).contains(&readings.len()) && spoilt < 10, "{} {spoilt}", readings.len());
    }

    #[test]
    fn a_record_with_few_readings_was_read_by_the_clock_of_the_others() {
        for between in [Between::Held, Between::Interpolated] {
            let long = Record::of(FINE, between, 8, 3000, |_| true);
            let short = Record::of(FINE, between, 9, 72, |_| true);
            assert!(!short.readout().are_slow());
            let [long, short_too] = [&long, &short].map(|r| (&r.time_s[..], &r.pressure_pa[..]));
            let both = of_logger(&[long, short_too], None);
            assert_eq!(both[1].between(), between);
            short.assert_read(&both[1], 0.9, [0.3, 1.0], "short");
        }
    }

    #[test]
    fn a_stated_rate_that_does_not_divide_that_of_the_rows_is_found_where_the_rows_show_it() {
        for between in [Between::Held, Between::Interpolated] {
            for stated_hz in [1.0 / (4.07 * ROW_S), 60.0, 100.0] {
                let record = Record::of(FINE, between, 12, 3000, |_| true);
                let found = of_logger(&[(&record.time_s, &record.pressure_pa)], Some(stated_hz)).remove(0);
                assert_eq!(found.between(), between, "{stated_hz}");
                record.assert_read(&found, 0.98, [0.05, 1.0], "stated");
            }
        }
    }

    #[test]
    fn readings_of_every_row_are_by_no_slower_clock() {
        type Course = fn(f64) -> f64;
        let courses: [(&str, Course); 6] = [
            ("pushes", gas),
            ("relaxation", |row| 2e5 + 1e5 * (-row / 700.0).exp()),
            ("leak", |row| 3e5 - 13.7 * row),
            ("slow leak", |row| 3e5 - 1.37 * row),
            ("hum", |row| 2e5 + 150.0 * (row * 0.1234).sin()),
            ("rest", |_| 2e5),
        ];
        for (name, course) in courses {
            // 16, 14, 12 and 8 bit over 16 bar, with noise of zero to three steps.
            for (step_pa, noise) in
                [0.1, 97.7, 390.6, 6250.0].iter().flat_map(|s| [0.0, 0.1, 0.2, 0.3, 0.5, 3.0].map(|n| (*s, n * s)))
            {
                for (seed, spikes) in [(0, 0), (1, 0), (2, 9), (3, 9)] {
                    let mut random = Random::new(seed + 7);
                    let at = |row: u32| course(f64::from(row) + 0.1 * seed as f64);
                    let mut rows: Vec<f64> = (0..2000).map(|row| at(row) + noise * random.normal()).collect();
                    for _ in 0..spikes {
                        let row = random.below(rows.len());
                        rows[row] += 2e4 * random.normal();
                    }
                    rows.iter_mut().for_each(|p| *p = ((*p / step_pa).round() * step_pa * 10.0).round() * 0.1);
                    let what = format!("{name}, step {step_pa} Pa, noise {noise} Pa, seed {seed}");
                    assert!(by_own_clock(&rows).is_none(), "{what}");
                    for between in [Between::Held, Between::Interpolated] {
                        assert!(like(&rows, between, 4.07).is_none(), "{what}, like {between:?}");
                    }
                }
            }
        }
    }
}
