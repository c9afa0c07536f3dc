//! Which rows of a record are readings of the position, m.
//!
//! A position sensor that is read less often than the rows come fills those in between with its last reading or with straight
//! lines; and single rows stand out of all around them, where a reading was lost or disturbed. Neither says where the piston
//! is: the stroke goes through the others.

use super::hampel::{accidental, middle_and_scatter};
use super::lattice;
use super::position_noise::position_noise;
use super::readout::{Between, interpolated};
use super::spline::extent;
use records::fill_between;

/// A reading this many standard deviations of the noise from the median of those around it stands out...
const FROM_MEDIAN: f64 = 9.0;
/// ...if it is also this far, of the whole way...
const OF_THE_WAY: f64 = 1e-3;
/// ...and so many times as far as half of them: a piston goes and comes, but not within two rows.
const OF_THE_OTHERS: f64 = 6.0;
/// Rows on either side that a reading is compared with.
const REACH: usize = 2;
/// Of a reading that stands out of a move, what is left in its neighbours' distances from their own cubics without it: a corner
/// of the stroke leaves a sixth.
const LEFT: f64 = 0.14;
/// A piston that goes so many of the sensor's steps from one row to the next is seen in every row that is read, ...
const STEPS: f64 = 5.0;
/// ...and must have gone so far that often for a slower readout to be believed.
const FEWEST_JUMPS: usize = 5;
/// Changes at every k-th row only are no chance where it would be one in a million: k to the power of minus their number.
const NO_CHANCE: f64 = 14.0;
/// Fewer readings show no stroke.
const FEWEST_READINGS: usize = 12;

/// Which rows are readings of the position.
#[derive(Clone, Debug, PartialEq)]
pub struct Positions {
    /// Rows that are, ascending.
    pub rows: Vec<usize>,
    /// Rows that stand out of those around them.
    pub outliers: Vec<usize>,
    /// What stands between two readings.
    pub between: Between,
}

impl Positions {
    /// Of the positions of all rows, m.
    pub fn of(position_m: &[f64]) -> Self {
        let mut kept: Vec<usize> = (0..position_m.len()).collect();
        let mut outliers = stand_out(&kept, position_m);
        let without = filled(&without(&kept, &outliers), position_m);
        let slow = held(&without).map(|rows| (Between::Held, rows)).or_else(|| {
            let rows = straight_between(&without)?;
            Some((Between::Interpolated, rows))
        });
        let slow = slow.filter(|(_, rows)| rows.len() >= FEWEST_READINGS);
        let between = slow.as_ref().map_or(Between::Nothing, |(between, _)| *between);
        if let Some((_, rows)) = slow {
            // A disturbed reading stands in all rows up to the next one.
            outliers.extend(stand_out(&rows, &without));
            outliers.sort_unstable();
            kept = rows;
        }
        Self { rows: self::without(&kept, &outliers), outliers, between }
    }

    /// Whether all rows are.
    pub fn are_all(&self) -> bool {
        self.between == Between::Nothing && self.outliers.is_empty()
    }

    /// Rows from one reading to the next in the mean; 1 where every row is read.
    pub fn rows_per_reading(&self) -> usize {
        match (self.between, self.rows.as_slice()) {
            (Between::Nothing, _) | (_, [] | [_]) => 1,
            (_, [first, .., last]) => ((last - first) as f64 / (self.rows.len() - 1) as f64).round() as usize,
        }
    }

    /// The positions of all rows, linear between readings.
    pub fn filled(&self, position_m: &[f64]) -> Vec<f64> {
        filled(&self.rows, position_m)
    }
}

/// These rows but for some of them, ascending too.
fn without(rows: &[usize], gone: &[usize]) -> Vec<usize> {
    rows.iter().copied().filter(|row| gone.binary_search(row).is_err()).collect()
}

/// All rows, linear between these and as the nearest of them beyond.
fn filled(rows: &[usize], position_m: &[f64]) -> Vec<f64> {
    let mut out = position_m.to_vec();
    fill_between(rows, &mut out);
    out
}

/// Those of the rows whose position is far from what the two on either side say: from their median, which is near the middle one
/// of five in a piston's way, however fast it goes (Hampel's identifier, J. Am. Stat. Assoc. 69 (1974) 383), or, in a smooth move,
/// from the cubic through them.
fn stand_out(rows: &[usize], position_m: &[f64]) -> Vec<usize> {
    let readings: Vec<f64> = rows.iter().map(|&row| position_m[row]).collect();
    let (low, high) = extent(&readings);
    let noise_m = position_noise(&readings);
    let least = (FROM_MEDIAN * noise_m).max(OF_THE_WAY * (high - low));
    if readings.len() < 2 * REACH + 1 {
        return Vec::new();
    }
    let last = readings.len() - 1;
    // Beyond its ends a record is taken to go back.
    let at = |k: usize, by: isize| {
        let place = k.checked_add_signed(by).unwrap_or_else(|| by.unsigned_abs() - k);
        readings[if place > last { 2 * last - place } else { place }]
    };
    let stands_out = |k: &usize| {
        let five = [-2, -1, 0, 1, 2].map(|by| at(*k, by));
        // Most readings lie near both neighbours.
        let near = |other: usize| (five[REACH] - five[other]).abs() < 0.5 * least;
        !(near(REACH - 1) && near(REACH + 1))
            && (off_median(five).abs() > least || is_off_cubic(&readings, *k, least, noise_m))
    };
    let found: Vec<usize> = (0..=last).filter(stands_out).map(|k| rows[k]).collect();
    accidental(found, rows.len())
}

/// How far the middle one of five is from their median; zero where half of them are as far.
fn off_median(mut five: [f64; 2 * REACH + 1]) -> f64 {
    let reading = five[REACH];
    let [median, others] = middle_and_scatter(&mut five);
    let off = reading - median;
    if off.abs() > OF_THE_OTHERS * others { off } else { 0.0 }
}

/// Whether a reading is off the cubic through the two on either side by more than `least` and than noise can hide, and its
/// neighbours off theirs by what that makes of them, and nothing else.
fn is_off_cubic(readings: &[f64], k: usize, least: f64, noise_m: f64) -> bool {
    let off = |i: usize| {
        let [a, b, x, c, d] = [-2, -1, 0, 1, 2].map(|by| readings[i.wrapping_add_signed(by)]);
        x - (4.0 * (b + c) - a - d) / 6.0
    };
    let least = least.max(FROM_MEDIAN * noise_m / LEFT);
    if k < 2 * REACH || k + 2 * REACH >= readings.len() || off(k).abs() < least {
        return false;
    }
    let most = LEFT * off(k).abs();
    let shares = [(k - 2, -1.0 / 6.0), (k - 1, 4.0 / 6.0), (k + 1, 4.0 / 6.0), (k + 2, -1.0 / 6.0)];
    shares.iter().all(|(i, share)| (off(*i) + share * off(k)).abs() < most)
}

/// Steps of the sensor, m, as the changes from row to row show them; zero where these have none in common.
pub fn step(position_m: &[f64]) -> f64 {
    lattice::of_changes(position_m, 1e-12)
}

/// The rows that a held readout was read in: no two rows in a row change.
fn held(position_m: &[f64]) -> Option<Vec<usize>> {
    let changes: Vec<usize> = (1..position_m.len()).filter(|&i| position_m[i] != position_m[i - 1]).collect();
    if changes.windows(2).any(|w| w[1] - w[0] < 2) {
        return None;
    }
    let period = period_of_jumps(position_m, &changes).or_else(|| common_period(&changes))?;
    // While nothing changes, the sensor is read as often.
    let ends = changes.iter().copied().chain([position_m.len()]);
    let starts = std::iter::once(0).chain(changes.iter().copied());
    let read =
        |(from, to): (usize, usize)| (from..to).step_by(period).filter(move |row| *row == from || row + period <= to);
    Some(starts.zip(ends).flat_map(read).collect())
}

/// Rows from one reading to the next where the piston goes many steps at a time. A fine encoder's changes while it hardly moves
/// are of single steps.
fn period_of_jumps(position_m: &[f64], changes: &[usize]) -> Option<usize> {
    let far = STEPS * step(position_m);
    let is_far = |row: &usize| (position_m[*row] - position_m[row - 1]).abs() >= far;
    let mut periods: Vec<usize> = changes.windows(2).filter(|w| w.iter().all(is_far)).map(|w| w[1] - w[0]).collect();
    if periods.len() < FEWEST_JUMPS {
        return None;
    }
    periods.sort_unstable();
    Some(periods[periods.len() / 2])
}

/// Rows from one reading to the next where all changes, most of them of the position's noise, lie a multiple of these apart.
/// Steps of an encoder along a steady way come at equal distances as well and do not count.
fn common_period(changes: &[usize]) -> Option<usize> {
    let gaps: Vec<usize> = changes.windows(2).map(|w| w[1] - w[0]).collect();
    let period = gaps.iter().copied().reduce(greatest_common_divisor)?;
    let uneven = gaps.windows(2).filter(|w| w[0] != w[1]).count();
    (uneven as f64 * (period as f64).ln() > NO_CHANCE).then_some(period)
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// The rows that a readout was read in that is interpolated in between: bends of many steps at every k-th row only.
fn straight_between(position_m: &[f64]) -> Option<Vec<usize>> {
    const MICROMETRES: f64 = 1e6;
    let scaled: Vec<f64> = position_m.iter().map(|x| MICROMETRES * x).collect();
    let readout = interpolated(&scaled)?;
    let rows: Vec<usize> = (0..position_m.len()).filter(|&row| readout.is_reading(row)).collect();
    let inner = rows.iter().filter(|&&row| row > 0 && row + 1 < position_m.len());
    let bends = inner.map(|&row| (position_m[row - 1] - 2.0 * position_m[row] + position_m[row + 1]).abs());
    // An encoder's single steps along a steady way can fall on every k-th row as well.
    let far = STEPS * step(position_m);
    (bends.filter(|bend| *bend >= far).count() >= FEWEST_JUMPS).then_some(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

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
    fn every_row_of_a_usual_record_is_a_reading() {
        let exact = |f: fn(f64) -> f64| (0..300).map(|i| f(i as f64 * 0.01)).collect::<Vec<f64>>();
        let ramp = |t: f64| 0.1 - 0.02 * (t - 0.5).clamp(0.0, 2.0);
        // Steps of 0.1 mm, of which a steady way makes one in every fifth or tenth row.
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
    fn steps_of_an_encoder_along_a_steady_way_are_no_held_readout() {
        let position_m: Vec<f64> = (0..900).map(|row| 0.1 - 1e-4 * (row.clamp(300, 600) / 3) as f64).collect();
        assert!(Positions::of(&position_m).are_all());
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
        // In the fastest part of a move, by half of what it goes in a row.
        let mut position_m = good.clone();
        position_m[65] -= 0.0015;
        assert_eq!(Positions::of(&position_m).outliers, [65]);
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
