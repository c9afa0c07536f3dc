//! Sampling of a record: rate, gaps, resolution, and the sensor's actual readout rate.

use crate::statistics::{median, second_differences, white_noise};
use std::ops::Range;

/// The readout is slower than the rows if this fraction of the changes falls on every k-th row ...
const MIN_ALIGNED_FRACTION: f64 = 0.95;
/// ... and there are at least this many changes.
const MIN_CHANGES: usize = 20;
/// Largest fraction of rows with a kink for readings interpolated between readouts: half where every second row is a readout;
/// with noise nearly all rows have one.
const MAX_KINKED_FRACTION: f64 = 0.6;
/// Slowest readout searched for, rows.
const MOST_ROWS: usize = 100;
/// Number of rows used to find the resolution.
const RESOLUTION_ROWS: usize = 20_000;

/// Sampling and noise of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// Median interval between rows, s.
    pub interval_s: f64,
    /// Number of intervals longer than 1.5 times the median.
    pub gaps: usize,
    /// Spacing of the pressures, Pa, if they lie on a grid.
    pub step_pa: Option<f64>,
    /// Readout rate of the pressure, Hz, if lower than the row rate: held or interpolated in between.
    pub readout_hz: Option<f64>,
    /// Rows between readouts, and the first readout.
    readout: Readout,
    /// Standard deviation of the pressure between readouts, Pa, without slow changes.
    pub noise_pa: f64,
}

impl Readings {
    /// Analyses a record of at least three rows.
    pub fn of(time_s: &[f64], pressure_pa: &[f64]) -> Self {
        let intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let interval_s = median(intervals.clone());
        let readout = Readout::of(pressure_pa);
        // Rows between readouts carry no noise of their own.
        let read: Vec<f64> = readout.rows(0..pressure_pa.len()).map(|row| pressure_pa[row]).collect();
        Self {
            interval_s,
            gaps: intervals.iter().filter(|interval| **interval > 1.5 * interval_s).count(),
            step_pa: step(&read[..read.len().min(RESOLUTION_ROWS)]),
            readout_hz: (readout.every > 1).then(|| 1.0 / (interval_s * readout.every as f64)),
            readout,
            noise_pa: white_noise(&read),
        }
    }

    /// The rows in a range at which the sensor was read out.
    pub fn read_out(&self, rows: Range<usize>) -> impl Iterator<Item = usize> + use<> {
        self.readout.rows(rows)
    }

    /// Standard deviation of a pressure, Pa, including its rounding.
    pub fn deviation_pa(&self) -> f64 {
        self.noise_pa.hypot(self.step_pa.unwrap_or(0.0) / 12.0_f64.sqrt())
    }

    /// Rows per second.
    pub fn rate_hz(&self) -> f64 {
        1.0 / self.interval_s
    }
}

/// Which rows are readouts.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Readout {
    every: usize,
    first: usize,
}

impl Readout {
    const EACH_ROW: Self = Self { every: 1, first: 0 };

    /// Finds the readout rows: those where the pressure changes (held in between) or has a kink (interpolated).
    fn of(pressure: &[f64]) -> Self {
        let changes = (1..pressure.len()).filter(|&i| pressure[i] != pressure[i - 1]).collect::<Vec<_>>();
        let differences: Vec<f64> = second_differences(pressure).collect();
        let interpolated = || {
            // Only rounding bends the straight lines between readings: far less than the noise of the readings.
            let mut sorted = differences.clone();
            sorted.sort_by(f64::total_cmp);
            let typical = *sorted.get(sorted.len() * 97 / 100)?;
            let kinks: Vec<usize> =
                (0..differences.len()).filter(|&i| differences[i] > 0.1 * typical).map(|i| i + 1).collect();
            if kinks.len() as f64 > MAX_KINKED_FRACTION * differences.len() as f64 { None } else { period(&kinks) }
        };
        period(&changes).or_else(interpolated).unwrap_or(Self::EACH_ROW)
    }

    /// The readouts in a range of rows.
    fn rows(self, rows: Range<usize>) -> impl Iterator<Item = usize> {
        let Self { every, first } = self;
        let begin = rows.start + (first + every - rows.start % every) % every;
        (begin..rows.end).step_by(every)
    }
}

/// Spacing of the grid that the values lie on: the smallest gaps between different values, if the others are multiples.
fn step(values: &[f64]) -> Option<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let size = values.last()?.abs().max(values[0].abs());
    let gaps = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > 1e-9 * size);
    let mut gaps: Vec<f64> = gaps.collect();
    gaps.sort_by(f64::total_cmp);
    let mut step = *gaps.get(gaps.len() / 10)?;
    for _ in 0..3 {
        let (mut above, mut below) = (0.0, 0.0);
        for gap in gaps.iter().filter(|gap| **gap < 20.0 * step) {
            let multiple = (gap / step).round();
            above += gap * multiple;
            below += multiple * multiple;
        }
        step = if below > 0.0 { above / below } else { step };
    }
    let near: Vec<f64> = gaps.iter().filter(|gap| **gap < 20.0 * step).map(|gap| gap / step).collect();
    let off = near.iter().map(|multiple| (multiple - multiple.round()).abs()).sum::<f64>() / near.len().max(1) as f64;
    // Random gaps deviate from multiples by a quarter on average.
    (near.len() >= 3 && off < 0.08).then_some(step)
}

/// The largest k from 2 on for which nearly all indices have the same remainder.
fn period(indices: &[usize]) -> Option<Readout> {
    if indices.len() < MIN_CHANGES {
        return None;
    }
    (2..=MOST_ROWS).rev().find_map(|every| {
        let mut counts = vec![0_usize; every];
        indices.iter().for_each(|index| counts[index % every] += 1);
        let first = counts.iter().position(|count| *count as f64 >= MIN_ALIGNED_FRACTION * indices.len() as f64)?;
        Some(Readout { every, first })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A relaxation with pseudo-random noise of an amplitude, Pa.
    fn relaxation(rows: usize, noise: f64) -> Vec<f64> {
        // The finalizer of SplitMix64.
        let random = |k: usize| {
            let mut z = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        (0..rows).map(|k| 3e5 + 5e4 * (-(k as f64) / 300.0).exp() + noise * random(k)).collect()
    }

    fn times(rows: usize) -> Vec<f64> {
        (0..rows).map(|k| k as f64 * 0.01).collect()
    }

    #[test]
    fn the_step_is_that_of_the_converter_and_not_of_the_printed_digits() {
        let read = |value: f64| ((value / 15.259).round() * 15.259 * 10.0).round() / 10.0;
        let coarse: Vec<f64> = relaxation(2000, 100.0).into_iter().map(read).collect();
        let step = Readings::of(&times(2000), &coarse).step_pa.unwrap();
        assert!((step - 15.259).abs() < 0.05, "{step}");
        assert_eq!(Readings::of(&times(2000), &relaxation(2000, 100.0)).step_pa, None);
    }

    #[test]
    fn a_readout_slower_than_the_rows_is_seen_held_or_interpolated() {
        let fine = relaxation(3000, 60.0);
        assert_eq!(Readings::of(&times(3000), &fine).readout_hz, None);
        let held: Vec<f64> = (0..3000).map(|k| fine[k - k % 10]).collect();
        let straight = |k: usize| {
            let (from, to) = (k - k % 10, (k - k % 10 + 10).min(2999));
            fine[from] + (fine[to] - fine[from]) * (k % 10) as f64 / 10.0
        };
        for slow in [held, (0..3000).map(straight).collect()] {
            let found = Readings::of(&times(3000), &slow);
            assert!((found.readout_hz.unwrap() - 10.0).abs() < 1e-6, "{found:?}");
            assert!(found.read_out(11..45).eq([20, 30, 40]), "{found:?}");
        }
        let every_second = |k: usize| if k.is_multiple_of(2) { fine[k] } else { 0.5 * (fine[k - 1] + fine[k + 1]) };
        let found = Readings::of(&times(2999), &(0..2999).map(every_second).collect::<Vec<f64>>());
        assert!((found.readout_hz.unwrap() - 50.0).abs() < 1e-6, "{found:?}");
        assert!((found.noise_pa / (60.0 / 3.0_f64.sqrt()) - 1.0).abs() < 0.3, "{found:?}");
    }

    #[test]
    fn rate_gaps_and_noise_are_counted() {
        let mut time = times(1000);
        time[500..].iter_mut().for_each(|t| *t += 0.05);
        let found = Readings::of(&time, &relaxation(1000, 100.0));
        assert!((found.rate_hz() - 100.0).abs() < 1e-6 && found.gaps == 1);
        assert!((found.noise_pa / (100.0 / 3.0_f64.sqrt()) - 1.0).abs() < 0.3, "{}", found.noise_pa);
    }
}
