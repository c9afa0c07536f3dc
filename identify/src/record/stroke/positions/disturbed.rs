//! Readings of a position that stand out from those around them, m: lost or disturbed ones.

use super::without;
use crate::record::series::hampel::{accidental, middle_and_scatter};
use crate::record::stroke::position_noise::position_noise;
use records::extremes;

/// A reading stands out if it is this many standard deviations of the noise from the median of those around it...
const FROM_MEDIAN: f64 = 9.0;
/// ...and also this fraction of the whole travel...
const OF_THE_TRAVEL: f64 = 1e-3;
/// ...and this multiple of the distance of half of them: a piston comes and goes, but not within two rows.
const OF_THE_OTHERS: f64 = 6.0;
/// Rows on either side that a reading is compared with.
const REACH: usize = 2;
/// Largest part of a disturbed reading's distance that may remain in its neighbours' distances from their cubics without it: a
/// corner of the stroke leaves a sixth.
const LEFT: f64 = 0.14;

/// Those rows whose position stands out from those around them. A neighbour of one may hide: once those found are removed, the
/// others are examined again.
pub fn stand_out(rows: &[usize], position_m: &[f64]) -> Vec<usize> {
    let mut all = Vec::new();
    loop {
        let found = stand_out_at_once(&without(rows, &all), position_m);
        let mut more = accidental([&all[..], &found[..]].concat(), rows.len());
        if found.is_empty() || more.is_empty() {
            return all;
        }
        more.sort_unstable();
        all = more;
    }
}

/// Those rows whose position is far from what the two on either side predict: from the median of the five, which is near the
/// middle one along a piston's path, however fast it goes (Hampel's identifier, J. Am. Stat. Assoc. 69 (1974) 383), or, in a
/// smooth move, from the cubic through the other four.
fn stand_out_at_once(rows: &[usize], position_m: &[f64]) -> Vec<usize> {
    let readings: Vec<f64> = rows.iter().map(|&row| position_m[row]).collect();
    let (low, high) = extremes(&readings);
    let noise_m = position_noise(&readings);
    let least = (FROM_MEDIAN * noise_m).max(OF_THE_TRAVEL * (high - low));
    if readings.len() < 2 * REACH + 1 {
        return Vec::new();
    }
    let last = readings.len() - 1;
    // Beyond its second and second-last readings a record is mirrored.
    let at = |k: usize, by: isize| {
        let index = k.checked_add_signed(by).unwrap_or_else(|| by.unsigned_abs() - k);
        readings[if index > last { 2 * last - index } else { index }]
    };
    let stands_out = |k: &usize| {
        if *k == 0 || *k == last {
            let inwards = |by: usize| readings[k.abs_diff(by)];
            return off_course([inwards(0), inwards(1), inwards(2), inwards(3)]).abs() > least;
        }
        let five = [-2, -1, 0, 1, 2].map(|by| at(*k, by));
        // Most readings lie near both neighbours.
        let near = |other: usize| (five[REACH] - five[other]).abs() < 0.5 * least;
        !(near(REACH - 1) && near(REACH + 1))
            && (off_median(five).abs() > least || is_off_cubic(&readings, *k, least, noise_m))
    };
    (0..=last).filter(stands_out).map(|k| rows[k]).collect()
}

/// Distance of a record's first or last reading from where the three beside it lead, by a straight line or a parabola, or from a
/// shorter travel, since the piston may have begun to move between two rows; zero if line and parabola are nearly as far apart.
fn off_course([reading, next, second, third]: [f64; 4]) -> f64 {
    let led_to = [2.0 * next - second, 3.0 * (next - second) + third];
    let [low, high] = [f64::min(led_to[0], led_to[1]), f64::max(led_to[0], led_to[1])];
    let off = reading - reading.clamp(low.min(next), high.max(next));
    if off.abs() > OF_THE_OTHERS * (high - low) { off } else { 0.0 }
}

/// Distance of the middle one of five from their median; zero if half of them are as far.
fn off_median(mut five: [f64; 2 * REACH + 1]) -> f64 {
    let reading = five[REACH];
    let [median, others] = middle_and_scatter(&mut five);
    let off = reading - median;
    if off.abs() > OF_THE_OTHERS * others { off } else { 0.0 }
}

/// Whether a reading is off the cubic through the two on either side by more than `least` and than noise can hide, while its
/// neighbours are off theirs only by what it contributes to them.
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
