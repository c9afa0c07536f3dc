//! Detects that a chamber was opened while its piston is held: the pressure departs abruptly from its trend.
//!
//! In a closed chamber with a held piston the pressure relaxes smoothly: a few readings lie on the straight line through those
//! before them, except for noise. The earlier part of the hold shows how far they usually deviate, whatever the colour of the
//! noise. From where they deviate by a large multiple of that and do not return, the readings are those of an open chamber: the
//! port was opened to let the piston return or to end the test.

use crate::line::Line;
use crate::statistics::{DEVIATION_OF_MEDIAN, median};
use std::ops::Range;

/// Smallest window, in readings; each further window width is half as large again.
const MIN_WIDTH: usize = 8;
/// The line is fitted to the readings of this many window widths before the window.
const LINE_WINDOWS: usize = 2;
/// Number of earlier windows, in the later half of the hold so far, where the gas has mostly relaxed, that show the usual
/// deviation: at least this many...
const MIN_EARLIER_WINDOWS: usize = 8;
/// ...and at most this many, the last ones.
const MAX_EARLIER_WINDOWS: usize = 64;
/// Readings of an open chamber deviate by more than this multiple of the usual deviation: chance does not reach ten standard
/// deviations in any record, and an opened port goes far beyond...
const USUAL_DEVIATION_MULTIPLE: f64 = 10.0;
/// ...and by this multiple of the largest deviation in those windows, because few windows show the usual deviation poorly.
const LARGEST_DEVIATION_MULTIPLE: f64 = 4.0;
/// If the hold continues after the window, far more readings could be mistaken for those of an open chamber: both multiples are
/// larger by this factor.
const INNER_WINDOW_FACTOR: f64 = 2.0;
/// Readings before a window belong to the open chamber if they deviate by more than this many standard deviations of a single
/// reading...
const NOISE_DEVIATIONS: f64 = 3.0;
/// ...and by more than this fraction of the window's deviation.
const WINDOW_DEVIATION_FRACTION: f64 = 0.1;
/// An opened port changes the slope by this multiple of its earlier value: a seal that shuts, or a move that ends later than in
/// the position record, reduces it.
const MIN_SLOPE_RATIO: f64 = 2.0;

/// Index of the first reading of a hold from which on the chamber is open. Each reading has its time, s, and pressure, Pa.
/// `noise_pa`: standard deviation of a reading, including rounding, Pa.
pub fn opened_from(time_s: &[f64], pressure_pa: &[f64], noise_pa: f64) -> Option<usize> {
    let most = time_s.len() / 2 / (MIN_EARLIER_WINDOWS + 1);
    let widths =
        std::iter::successors(Some(MIN_WIDTH), |width| Some(width + width / 2)).take_while(|width| *width <= most);
    widths.filter_map(|width| Hold { time_s, pressure_pa, noise_pa, width }.opened_from()).min()
}

/// A hold examined in windows of readings.
struct Hold<'a> {
    time_s: &'a [f64],
    pressure_pa: &'a [f64],
    noise_pa: f64,
    /// Readings per window.
    width: usize,
}

impl Hold<'_> {
    /// First reading of the open chamber according to windows of this width, aligned with the end of the hold.
    fn opened_from(&self) -> Option<usize> {
        let (rows, width) = (self.time_s.len(), self.width);
        let most = (rows - LINE_WINDOWS * width) / width;
        let windows: Vec<usize> = (1..=most).rev().map(|k| rows - k * width).collect();
        let deviations_pa: Vec<f64> = windows.iter().map(|first| self.deviation_pa(*first).abs()).collect();
        let noticeable = USUAL_DEVIATION_MULTIPLE * self.error_pa();
        let is_open = |k: &usize| {
            let later_half = windows[..*k].partition_point(|first| *first < windows[*k] / 2);
            let earlier = later_half.max(k.saturating_sub(MAX_EARLIER_WINDOWS))..*k;
            self.is_open(windows[*k], deviations_pa[*k], &deviations_pa[earlier])
        };
        (0..windows.len()).filter(|k| deviations_pa[*k] > noticeable).find(is_open).map(|k| {
            self.departure(
                windows[k],
                (NOISE_DEVIATIONS * self.noise_pa).max(WINDOW_DEVIATION_FRACTION * deviations_pa[k]),
            )
        })
    }

    /// The straight line through the readings before a given one.
    fn line_before(&self, first: usize) -> Line {
        let rows = first - LINE_WINDOWS * self.width..first;
        Line::through(&self.time_s[rows.clone()], &self.pressure_pa[rows])
    }

    /// Median deviation of a window's readings, Pa, from the line through those before it.
    fn deviation_pa(&self, first: usize) -> f64 {
        let line = self.line_before(first);
        let rows = first..first + self.width;
        median(rows.map(|row| self.pressure_pa[row] - line.at(self.time_s[row])).collect::<Vec<f64>>())
    }

    /// Standard deviation of that median due to noise, Pa: the line's error in the middle of a window is 1/before + 12
    /// distance²/before³.
    fn error_pa(&self) -> f64 {
        let (w, b) = (self.width as f64, (LINE_WINDOWS * self.width) as f64);
        let distance = 0.5 * (w + b);
        self.noise_pa * (1.0 / w + 1.0 / b + 12.0 * distance * distance / b.powi(3)).sqrt()
    }

    /// Whether a window's readings are of an open chamber, given their deviation, Pa, and the deviations in earlier windows, Pa.
    fn is_open(&self, first: usize, deviation_pa: f64, earlier_pa: &[f64]) -> bool {
        let is_last = first + self.width == self.time_s.len();
        let factor = if is_last { 1.0 } else { INNER_WINDOW_FACTOR };
        let worst = earlier_pa.iter().copied().fold(0.0, f64::max);
        let usual = DEVIATION_OF_MEDIAN * median(earlier_pa.to_vec());
        earlier_pa.len() >= MIN_EARLIER_WINDOWS
            && deviation_pa > factor * (USUAL_DEVIATION_MULTIPLE * usual).max(LARGEST_DEVIATION_MULTIPLE * worst)
            && (is_last || self.stays_open(first, deviation_pa))
    }

    /// Whether the change lasts: until the end of the hold, the pressure moves on to a new level.
    fn stays_open(&self, first: usize, deviation_pa: f64) -> bool {
        let line = self.line_before(first);
        let distance_s = median(self.time_s[first..first + self.width].to_vec()) - line.middle_s;
        let mean = |rows: Range<usize>| self.pressure_pa[rows.clone()].iter().sum::<f64>() / rows.len() as f64;
        let rows = self.time_s.len();
        let went = mean(rows - self.width..rows) - line.mean;
        let relaxed = mean(first / 2..first / 2 + self.width) - line.mean;
        deviation_pa > MIN_SLOPE_RATIO * (line.slope * distance_s).abs() && went.abs() > relaxed.abs().max(deviation_pa)
    }

    /// First of the consecutive readings, up to an open window, that deviate by more than `threshold_pa`, Pa: the pressure may
    /// have departed from the line among the readings it is fitted to.
    fn departure(&self, first: usize, threshold_pa: f64) -> usize {
        let before = LINE_WINDOWS * self.width;
        let line = self.line_before(first.saturating_sub(self.width).max(before));
        let is_off = |row: &usize| (self.pressure_pa[*row] - line.at(self.time_s[*row])).abs() > threshold_pa;
        (before..first + self.width).rev().take_while(is_off).last().unwrap_or(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = 800;

    fn normal(random: &mut fastrand::Rng) -> f64 {
        (-2.0 * (1.0 - random.f64()).ln()).sqrt() * (std::f64::consts::TAU * random.f64()).cos()
    }

    /// A hold of eight seconds that relaxes with a time constant of 0.7 s; by kind, the noise is white, coloured, a random walk,
    /// that of a sticking sensor, or white plus hum.
    fn hold(kind: usize, random: &mut fastrand::Rng) -> (Vec<f64>, Vec<f64>) {
        let (mut coloured, mut walk) = (0.0, 0.0);
        let time_s: Vec<f64> = (0..ROWS).map(|i| 0.01 * i as f64).collect();
        let phase = std::f64::consts::TAU * random.f64();
        let reading = |t: &f64| {
            coloured = 0.9 * coloured + 40.0 * normal(random);
            walk += 20.0 * normal(random);
            let course = 4e5 + 3e4 * (-t / 0.7).exp();
            let white = 60.0 * normal(random);
            match kind {
                0 => course + white,
                1 => course + white + coloured,
                2 => course + white + walk,
                3 => ((course + 0.3 * white) / 390.0).round() * 390.0,
                _ => course + white + 500.0 * (1.9 * t + phase).sin(),
            }
        };
        let pressure_pa = time_s.iter().map(reading).collect();
        (time_s, pressure_pa)
    }

    /// Standard deviation of a reading, Pa, including its rounding, by kind of hold.
    const NOISE_PA: [f64; 5] = [60.0, 60.0, 60.0, 114.0, 60.0];

    #[test]
    fn readings_that_stay_on_their_course_are_kept_whatever_their_noise() {
        let mut random = fastrand::Rng::with_seed(11);
        for (kind, noise_pa) in NOISE_PA.into_iter().enumerate() {
            let found = (0..1000).filter(|_| {
                let (time_s, pressure_pa) = hold(kind, &mut random);
                opened_from(&time_s, &pressure_pa, noise_pa).is_some()
            });
            assert_eq!(found.count(), 0, "noise of kind {kind}");
        }
    }

    #[test]
    fn the_last_readings_are_of_an_opened_chamber_from_where_they_leave_their_course() {
        let mut random = fastrand::Rng::with_seed(12);
        for (kind, noise_pa) in NOISE_PA.into_iter().enumerate() {
            for open in [6, 15, 40] {
                let (time_s, mut pressure_pa) = hold(kind, &mut random);
                for (k, pressure) in pressure_pa[ROWS - open..].iter_mut().enumerate() {
                    *pressure -= 1500.0 * (1 + k) as f64;
                }
                let found = opened_from(&time_s, &pressure_pa, noise_pa).map_or(0, |first| ROWS - first);
                assert!((open..open + 25).contains(&found), "noise of kind {kind}: {found} for {open}");
            }
        }
    }

    #[test]
    fn a_chamber_that_fills_again_within_a_hold_is_open_from_there() {
        let mut random = fastrand::Rng::with_seed(14);
        for (kind, noise_pa) in NOISE_PA.into_iter().enumerate() {
            for (open, tau_s) in [(400, 0.2), (400, 1.5), (600, 1.5)] {
                let (time_s, mut pressure_pa) = hold(kind, &mut random);
                let at_s = time_s[open];
                for (t, pressure) in time_s.iter().zip(&mut pressure_pa).skip(open) {
                    *pressure -= 3e5 * (1.0 - (-(t - at_s) / tau_s).exp());
                }
                let found = opened_from(&time_s, &pressure_pa, noise_pa).unwrap_or(ROWS);
                assert!((open - 20..open + 5).contains(&found), "noise of kind {kind}: {found} for {open}");
            }
        }
    }

    #[test]
    fn a_seal_that_shuts_and_a_late_end_of_the_move_open_no_chamber() {
        let mut random = fastrand::Rng::with_seed(15);
        for seal in [true, false] {
            let (time_s, mut pressure_pa) = hold(0, &mut random);
            for (t, pressure) in time_s.iter().zip(&mut pressure_pa) {
                *pressure += if seal { 5e4 * (4.0 - t).max(0.0) } else { -2e5 * (3.0 - t).max(0.0) };
            }
            assert_eq!(opened_from(&time_s, &pressure_pa, 60.0), None, "seal: {seal}");
        }
    }

    #[test]
    fn a_hold_of_few_readings_is_kept_whole() {
        let (time_s, mut pressure_pa) = hold(0, &mut fastrand::Rng::with_seed(13));
        pressure_pa[60] = 0.0;
        assert_eq!(opened_from(&time_s[..61], &pressure_pa[..61], 60.0), None);
    }
}
