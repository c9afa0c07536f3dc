//! A chamber that is opened at the end of a record, while the piston is held: the pressure leaves its course at once.
//!
//! In a closed chamber with a held piston the pressure relaxes smoothly, so that a few readings lie on the straight line through those
//! before them, but for noise. How far they lie off it, whatever the noise's colour, the rest of the hold shows. The last readings of
//! a record are left out where they lie off by many times as much: as a rule somebody opened the port before the recording was
//! stopped. Two dozen good readings that go with them are no loss.

use crate::record::line::Line;
use records::{DEVIATION_OF_MEDIAN, median};

/// Readings at the end that are looked at, at the least; each further number is half as many more.
const FEWEST: usize = 8;
/// The line goes through so many times as many readings before them.
const BEFORE: usize = 2;
/// So many places in the later half of the hold, where the gas has relaxed for the most part, show how far readings usually lie off,
/// at the least.
const FEWEST_PLACES: usize = 6;
/// Readings at the end that lie off by more than so many times as much as elsewhere are of an open chamber: chance brings ten
/// standard deviations into no record, and an opened port goes on far beyond them...
const TIMES: f64 = 10.0;
/// ...and by so many times as much as at the worst of those places, as few of them show the usual poorly.
const TIMES_WORST: f64 = 3.0;
/// A reading that is off the course before by more than so many standard deviations of a single one is of the open chamber.
const OFF_COURSE: f64 = 3.0;

/// How many of a hold's readings, of which each has its time, s, and pressure, Pa, are of a chamber that was opened: the last so
/// many. `noise_pa`: standard deviation of a reading, with its rounding, Pa.
pub fn at_end(time_s: &[f64], pressure_pa: &[f64], noise_pa: f64) -> usize {
    let most = time_s.len() / 2 / (FEWEST_PLACES + 1);
    let widths =
        std::iter::successors(Some(FEWEST), |width| Some(width + width / 2)).take_while(|width| *width <= most);
    widths.filter_map(|width| open_within(time_s, pressure_pa, width, noise_pa)).max().unwrap_or(0)
}

/// The same by the last `width` readings.
fn open_within(time_s: &[f64], pressure_pa: &[f64], width: usize, noise_pa: f64) -> Option<usize> {
    let (rows, before) = (time_s.len(), BEFORE * width);
    let line = |first: usize| Line::through(&time_s[first - before..first], &pressure_pa[first - before..first]);
    let off_course = |first: usize| {
        let course = line(first);
        median((first..first + width).map(|row| pressure_pa[row] - course.at(time_s[row])).collect::<Vec<f64>>()).abs()
    };
    let last = rows - width;
    // The line errs at the middle of the readings behind it by so much: 1/before + 12 (distance)²/before³, and 1/width of theirs.
    let (w, b) = (width as f64, before as f64);
    let distance = 0.5 * (w + b);
    let of_noise = noise_pa * (1.0 / w + 1.0 / b + 12.0 * distance * distance / b.powi(3)).sqrt();
    let off_at_end = off_course(last);
    // Cheap first: most records end on their course.
    if off_at_end <= TIMES * of_noise {
        return None;
    }
    let later_half = (rows / 2).max(before)..=last - width;
    let elsewhere: Vec<f64> = later_half.step_by(width).map(off_course).collect();
    let worst = elsewhere.iter().copied().fold(0.0, f64::max);
    let is_open = elsewhere.len() >= FEWEST_PLACES
        && off_at_end > (TIMES * DEVIATION_OF_MEDIAN * median(elsewhere)).max(TIMES_WORST * worst);
    is_open.then(|| {
        // Those before the last that are off the course too, which may have begun to leave it within the line's readings.
        let course = line(last.saturating_sub(width).max(before));
        let is_off = |row: usize| (pressure_pa[row] - course.at(time_s[row])).abs() > OFF_COURSE * noise_pa;
        let first = (before..rows).rev().take_while(|row| is_off(*row)).last().unwrap_or(last);
        rows - first.min(last)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    const ROWS: usize = 800;

    /// A hold of eight seconds that relaxes with 0.7 s, its noise white, coloured, a random walk, or that of a sensor that sticks.
    fn hold(kind: usize, random: &mut Random) -> (Vec<f64>, Vec<f64>) {
        let (mut coloured, mut walk) = (0.0, 0.0);
        let time_s: Vec<f64> = (0..ROWS).map(|i| 0.01 * i as f64).collect();
        let reading = |t: &f64| {
            coloured = 0.9 * coloured + 40.0 * random.normal();
            walk += 20.0 * random.normal();
            let course = 4e5 + 3e4 * (-t / 0.7).exp();
            let white = 60.0 * random.normal();
            match kind {
                0 => course + white,
                1 => course + white + coloured,
                2 => course + white + walk,
                _ => ((course + 0.3 * white) / 390.0).round() * 390.0,
            }
        };
        let pressure_pa = time_s.iter().map(reading).collect();
        (time_s, pressure_pa)
    }

    /// Standard deviation of a reading, its rounding included, by kind of hold, Pa.
    const NOISE_PA: [f64; 4] = [60.0, 60.0, 60.0, 114.0];

    #[test]
    fn readings_that_stay_on_their_course_are_kept_whatever_their_noise() {
        let mut random = Random::new(11);
        for (kind, noise_pa) in NOISE_PA.into_iter().enumerate() {
            let found = (0..1000).filter(|_| {
                let (time_s, pressure_pa) = hold(kind, &mut random);
                at_end(&time_s, &pressure_pa, noise_pa) > 0
            });
            assert_eq!(found.count(), 0, "noise of kind {kind}");
        }
    }

    #[test]
    fn the_last_readings_are_of_an_opened_chamber_from_where_they_leave_their_course() {
        let mut random = Random::new(12);
        for (kind, noise_pa) in NOISE_PA.into_iter().enumerate() {
            for open in [6, 15, 40] {
                let (time_s, mut pressure_pa) = hold(kind, &mut random);
                for (k, pressure) in pressure_pa[ROWS - open..].iter_mut().enumerate() {
                    *pressure -= 1500.0 * (1 + k) as f64;
                }
                let found = at_end(&time_s, &pressure_pa, noise_pa);
                assert!((open..open + 25).contains(&found), "noise of kind {kind}: {found} for {open}");
            }
        }
    }

    #[test]
    fn a_hold_of_few_readings_is_kept_whole() {
        let (time_s, mut pressure_pa) = hold(0, &mut Random::new(13));
        pressure_pa[60] = 0.0;
        assert_eq!(at_end(&time_s[..61], &pressure_pa[..61], 60.0), 0);
    }
}
