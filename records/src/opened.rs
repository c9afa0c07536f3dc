//! A chamber that is opened while its piston is held: the pressure leaves its course at once.
//!
//! In a closed chamber with a held piston the pressure relaxes smoothly, so that a few readings lie on the straight line through those
//! before them, but for noise. How far they lie off it, whatever the noise's colour, the hold shows before. From where they lie off
//! by many times as much and do not come back, the readings are those of an open chamber: somebody opened the port, to let the piston
//! return or to end the test.

use crate::line::Line;
use crate::statistics::{DEVIATION_OF_MEDIAN, median};
use std::ops::Range;

/// Readings that are looked at together, at the least; each further number is half as many more.
const FEWEST: usize = 8;
/// The line goes through so many times as many readings before them.
const BEFORE: usize = 2;
/// So many places in the later half of the hold before, where the gas has relaxed for the most part, show how far readings usually
/// lie off, at the least...
const FEWEST_PLACES: usize = 8;
/// ...and at the most, the last ones.
const MOST_PLACES: usize = 64;
/// Readings that lie off by more than so many times as much as usual are of an open chamber: chance brings ten standard deviations
/// into no record, and an opened port goes on far beyond them...
const TIMES: f64 = 10.0;
/// ...and by so many times as much as at the worst of those places, as few of them show the usual poorly.
const TIMES_WORST: f64 = 4.0;
/// Where the hold goes on, there are many more readings to be taken for those of an open chamber by chance: so many times both.
const STRICTER: f64 = 2.0;
/// Readings before a window belong to the open chamber if they are off the course by more than so many standard deviations of one...
const OFF_COURSE: f64 = 3.0;
/// ...and by this share of what the window is.
const SHARE_OF_WINDOW: f64 = 0.1;
/// An opened port changes the slope by so many times what it was: a seal that shuts, or a move that ends later than the piston's
/// record says, makes it less.
const TIMES_SLOPE: f64 = 2.0;

/// The first of a hold's readings, of which each has its time, s, and pressure, Pa, that is of an opened chamber, to the end.
/// `noise_pa`: standard deviation of a reading, with its rounding, Pa.
pub fn opened_from(time_s: &[f64], pressure_pa: &[f64], noise_pa: f64) -> Option<usize> {
    let most = time_s.len() / 2 / (FEWEST_PLACES + 1);
    let widths =
        std::iter::successors(Some(FEWEST), |width| Some(width + width / 2)).take_while(|width| *width <= most);
    widths.filter_map(|width| Hold { time_s, pressure_pa, noise_pa, width }.opened_from()).min()
}

/// A hold whose readings are looked at in windows.
struct Hold<'a> {
    time_s: &'a [f64],
    pressure_pa: &'a [f64],
    noise_pa: f64,
    /// Readings of a window.
    width: usize,
}

impl Hold<'_> {
    /// The first reading of the open chamber as windows of this width show it. They end with the hold's last reading.
    fn opened_from(&self) -> Option<usize> {
        let (rows, width) = (self.time_s.len(), self.width);
        let most = (rows - BEFORE * width) / width;
        let windows: Vec<usize> = (1..=most).rev().map(|k| rows - k * width).collect();
        let off: Vec<f64> = windows.iter().map(|first| self.off_course(*first).abs()).collect();
        let noticeable = TIMES * self.error_pa();
        let is_open = |k: &usize| {
            let later_half = windows[..*k].partition_point(|first| *first < windows[*k] / 2);
            let places = later_half.max(k.saturating_sub(MOST_PLACES))..*k;
            self.is_open(windows[*k], off[*k], &off[places])
        };
        (0..windows.len())
            .filter(|k| off[*k] > noticeable)
            .find(is_open)
            .map(|k| self.left_course(windows[k], (OFF_COURSE * self.noise_pa).max(SHARE_OF_WINDOW * off[k])))
    }

    /// The straight line through the readings before one.
    fn course(&self, first: usize) -> Line {
        let rows = first - BEFORE * self.width..first;
        Line::through(&self.time_s[rows.clone()], &self.pressure_pa[rows])
    }

    /// How far the readings of a window are off the line through those before it, Pa, by their median.
    fn off_course(&self, first: usize) -> f64 {
        let course = self.course(first);
        let rows = first..first + self.width;
        median(rows.map(|row| self.pressure_pa[row] - course.at(self.time_s[row])).collect::<Vec<f64>>())
    }

    /// Standard deviation of that by the noise, Pa: the line errs in the middle of a window by 1/before + 12 distance²/before³.
    fn error_pa(&self) -> f64 {
        let (w, b) = (self.width as f64, (BEFORE * self.width) as f64);
        let distance = 0.5 * (w + b);
        self.noise_pa * (1.0 / w + 1.0 / b + 12.0 * distance * distance / b.powi(3)).sqrt()
    }

    /// Whether the readings of a window, which are off so much, Pa, are of an open chamber, by how much they are at places before, Pa.
    fn is_open(&self, first: usize, off_pa: f64, elsewhere: &[f64]) -> bool {
        let is_last = first + self.width == self.time_s.len();
        let stricter = if is_last { 1.0 } else { STRICTER };
        let worst = elsewhere.iter().copied().fold(0.0, f64::max);
        let usual = DEVIATION_OF_MEDIAN * median(elsewhere.to_vec());
        elsewhere.len() >= FEWEST_PLACES
            && off_pa > stricter * (TIMES * usual).max(TIMES_WORST * worst)
            && (is_last || self.stays_open(first, off_pa))
    }

    /// Whether the pressure goes on to somewhere else, from before the hold's end.
    fn stays_open(&self, first: usize, off_pa: f64) -> bool {
        let course = self.course(first);
        let distance_s = median(self.time_s[first..first + self.width].to_vec()) - course.middle_s;
        let mean = |rows: Range<usize>| self.pressure_pa[rows.clone()].iter().sum::<f64>() / rows.len() as f64;
        let rows = self.time_s.len();
        let went = mean(rows - self.width..rows) - course.mean;
        let relaxed = mean(first / 2..first / 2 + self.width) - course.mean;
        off_pa > TIMES_SLOPE * (course.slope * distance_s).abs() && went.abs() > relaxed.abs().max(off_pa)
    }

    /// The first reading that is off by more than that, Pa, and all from there to a window that is open: the pressure may have left
    /// its course within the line's readings.
    fn left_course(&self, first: usize, off_pa: f64) -> usize {
        let before = BEFORE * self.width;
        let course = self.course(first.saturating_sub(self.width).max(before));
        let is_off = |row: &usize| (self.pressure_pa[*row] - course.at(self.time_s[*row])).abs() > off_pa;
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

    /// A hold of eight seconds that relaxes with 0.7 s, its noise white, coloured, a random walk, that of a sensor that sticks, or
    /// white beside a hum.
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

    /// Standard deviation of a reading, its rounding included, by kind of hold, Pa.
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
