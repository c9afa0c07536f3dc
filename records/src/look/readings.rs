//! How a record was read: rate, gaps, resolution, and how often the sensor itself was read out.

use crate::statistics::{median, white_noise};

/// A readout is slower than the rows if so large a share of the changes stands at every k-th row ...
const SHARE: f64 = 0.95;
/// ... and there are so many of them.
const CHANGES: usize = 20;
/// The slowest readout that is looked for, rows.
const MOST_ROWS: usize = 100;
/// So many rows tell the resolution.
const RESOLUTION_ROWS: usize = 20_000;

/// What a record's times and pressures show.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// Median interval between rows, s.
    pub interval_s: f64,
    /// Intervals of more than one and a half of that.
    pub gaps: usize,
    /// Spacing of the pressures, Pa, where they lie on a lattice.
    pub step_pa: Option<f64>,
    /// How often the pressure changes, Hz, where that is less often than the rows: held or interpolated between.
    pub readout_hz: Option<f64>,
    /// Standard deviation of the pressure from row to row, Pa, slow changes aside.
    pub noise_pa: f64,
}

impl Readings {
    /// Of a record of at least three rows.
    pub fn of(time_s: &[f64], pressure_pa: &[f64]) -> Self {
        let intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let interval_s = median(intervals.clone());
        Self {
            interval_s,
            gaps: intervals.iter().filter(|interval| **interval > 1.5 * interval_s).count(),
            step_pa: step(&pressure_pa[..pressure_pa.len().min(RESOLUTION_ROWS)]),
            readout_hz: readout_rows(pressure_pa).map(|rows| 1.0 / (interval_s * rows as f64)),
            noise_pa: white_noise(pressure_pa),
        }
    }

    /// Rows from one readout to the next.
    pub fn rows_a_readout(&self) -> usize {
        self.readout_hz.map_or(1, |hz| (self.rate_hz() / hz).round() as usize)
    }

    /// Standard deviation of a pressure, Pa, its rounding included.
    pub fn deviation_pa(&self) -> f64 {
        self.noise_pa.hypot(self.step_pa.unwrap_or(0.0) / 12.0_f64.sqrt())
    }

    /// Rows in a second.
    pub fn rate_hz(&self) -> f64 {
        1.0 / self.interval_s
    }
}

/// Spacing of a lattice that the values lie on: the smallest gaps between different values, if the others are multiples.
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
    // Random gaps are a quarter off on average.
    (near.len() >= 3 && off < 0.08).then_some(step)
}

/// At which multiple of rows the pressure is read out: where it changes (held between), or where it bends (interpolated).
fn readout_rows(pressure: &[f64]) -> Option<usize> {
    let changes = (1..pressure.len()).filter(|&i| pressure[i] != pressure[i - 1]).collect::<Vec<_>>();
    period(&changes).or_else(|| {
        let bend = |i: usize| (pressure[i + 1] - 2.0 * pressure[i] + pressure[i - 1]).abs();
        let bends: Vec<f64> = (1..pressure.len().saturating_sub(1)).map(bend).collect();
        let largest = bends.iter().copied().fold(0.0, f64::max);
        // Straight lines between readings bend by rounding only: far less than the readings' own noise.
        let typical = {
            let mut sorted = bends.clone();
            sorted.sort_by(f64::total_cmp);
            sorted.get(sorted.len() * 97 / 100).copied().unwrap_or(largest)
        };
        let kinks: Vec<usize> = (0..bends.len()).filter(|&i| bends[i] > 0.1 * typical).collect();
        if kinks.len() * 2 > bends.len() { None } else { period(&kinks) }
    })
}

/// The largest k from 2 on for which nearly all indices have the same remainder.
fn period(indices: &[usize]) -> Option<usize> {
    if indices.len() < CHANGES {
        return None;
    }
    (2..=MOST_ROWS).rev().find(|k| {
        let mut counts = vec![0_usize; *k];
        indices.iter().for_each(|index| counts[index % k] += 1);
        counts.iter().max().is_some_and(|most| *most as f64 >= SHARE * indices.len() as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A relaxation with pseudo-random noise of that size, Pa.
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
            let found = Readings::of(&times(3000), &slow).readout_hz.unwrap();
            assert!((found - 10.0).abs() < 1e-6, "{found}");
        }
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
