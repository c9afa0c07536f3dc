//! Rows in which a position was read, if its sensor is read less often than the rows come; positions in m.
//!
//! A held readout changes only at its readings, an interpolated one bends only at them. The rate of the former shows in a move,
//! where it jumps by many steps of the sensor, or in its noise; that of the latter in its noise, as for a pressure, or in a move,
//! where it bends by many steps.

use crate::record::sampling::readout::{Between, changes, interpolated};
use crate::record::series::bends::{Bends, scatter};
use crate::record::series::lattice;
use crate::record::stroke::position_noise::{NOTHING_M, step};
use records::extremes;

/// If the piston moves by this many steps of the sensor per row, every row that is read shows it, ...
const STEPS: f64 = 5.0;
/// ...and this must occur so often for a slower readout to be believed.
const FEWEST_JUMPS: usize = 5;
/// Changes at every k-th row only are no chance if that probability is one in a million: k to the power of minus their number.
const NO_CHANCE: f64 = 14.0;
/// Largest bend of a straight line due to arithmetic, over the whole travel.
const ROUNDING: f64 = 1e-9;

/// How a sensor was read: what the rows between readings do, and the rows of the readings, ascending.
pub type Slow = (Between, Vec<usize>);

/// The readings, if the rows show that there are fewer of them than rows.
pub fn readings(position_m: &[f64]) -> Option<Slow> {
    let straight = || straight_between(position_m).or_else(|| far_apart(position_m));
    let held = held(position_m).map(|rows| (Between::Held, rows));
    held.or_else(|| Some((Between::Interpolated, straight()?)))
}

/// The readings at every `period`-th row, if all changes, or bends, are in such rows.
pub fn readings_at_every(period: usize, between: Between, position_m: &[f64]) -> Option<Slow> {
    let marks = match between {
        Between::Nothing => return None,
        Between::Held => changes(position_m),
        Between::Interpolated => bends(position_m),
    };
    let [first, _, ..] = marks[..] else { return None };
    let fit = marks.iter().all(|row| (row - first).is_multiple_of(period));
    fit.then(|| (between, (first % period..position_m.len()).step_by(period).collect()))
}

/// The rows of the readings of a held readout: no two successive rows change.
fn held(position_m: &[f64]) -> Option<Vec<usize>> {
    let changes = changes(position_m);
    if changes.windows(2).any(|w| w[1] - w[0] < 2) {
        return None;
    }
    let period = period_of_jumps(position_m, &changes).or_else(|| period_of_noise(&changes))?;
    // While nothing changes, the sensor is read at the same rate.
    let ends = changes.iter().copied().chain([position_m.len()]);
    let starts = std::iter::once(0).chain(changes.iter().copied());
    let read =
        |(from, to): (usize, usize)| (from..to).step_by(period).filter(move |row| *row == from || row + period <= to);
    Some(starts.zip(ends).flat_map(read).collect())
}

/// Rows from one reading to the next where the piston moves by many steps at a time. While it hardly moves, a fine encoder
/// changes by single steps.
fn period_of_jumps(position_m: &[f64], changes: &[usize]) -> Option<usize> {
    let far = STEPS * lattice::of_changes(position_m, NOTHING_M);
    let is_far = |row: &usize| (position_m[*row] - position_m[row - 1]).abs() >= far;
    let mut periods: Vec<usize> = changes.windows(2).filter(|w| w.iter().all(is_far)).map(|w| w[1] - w[0]).collect();
    if periods.len() < FEWEST_JUMPS {
        return None;
    }
    periods.sort_unstable();
    Some(periods[periods.len() / 2])
}

/// Rows from one reading to the next if all changes, most of them due to position noise, lie a multiple of this apart. The steps
/// of an encoder in a steady move also come at equal distances and do not count.
fn period_of_noise(changes: &[usize]) -> Option<usize> {
    let gaps = gaps(changes);
    let uneven = gaps.windows(2).filter(|w| w[0] != w[1]).count();
    common_divisor(&gaps).filter(|period| no_chance(uneven, *period))
}

/// Distances between successive rows.
fn gaps(rows: &[usize]) -> Vec<usize> {
    rows.windows(2).map(|w| w[1] - w[0]).collect()
}

fn common_divisor(gaps: &[usize]) -> Option<usize> {
    fn greatest(a: usize, b: usize) -> usize {
        if b == 0 { a } else { greatest(b, a % b) }
    }
    gaps.iter().copied().reduce(greatest)
}

/// Whether this number of distances between rows is unlikely to be all multiples of `period` by chance.
fn no_chance(distances: usize, period: usize) -> bool {
    distances as f64 * (period as f64).ln() > NO_CHANCE
}

/// The rows of the readings of an interpolated readout: they bend more than the others, and some by many steps.
fn straight_between(position_m: &[f64]) -> Option<Vec<usize>> {
    let readout = interpolated(&micrometres(position_m))?;
    // An encoder's single steps in a steady move can fall on every k-th row as well.
    let bends: Vec<usize> = bends(position_m).into_iter().filter(|&row| readout.is_reading(row)).collect();
    let shown = bends.len() >= FEWEST_JUMPS && within_motion(position_m, &bends, readout.period);
    shown.then(|| (0..position_m.len()).filter(|&row| readout.is_reading(row)).collect())
}

fn micrometres(position_m: &[f64]) -> Vec<f64> {
    position_m.iter().map(|x| 1e6 * x).collect()
}

/// The same where a move bends so much at every reading that nothing else counts: most bends are one reading apart.
fn far_apart(position_m: &[f64]) -> Option<Vec<usize>> {
    let bends = bends(position_m);
    let gaps = gaps(&bends);
    let period = common_divisor(&gaps).filter(|period| no_chance(gaps.len(), *period))?;
    let one_apart = gaps.iter().filter(|gap| **gap == period).count();
    let shown = 2 * one_apart > gaps.len() && within_motion(position_m, &bends, period);
    let Bends { squares, rounding, .. } = Bends::of(&micrometres(position_m));
    let between = squares.into_iter().zip(1..).filter(|(_, row)| row % period != bends[0] % period);
    let shown = shown && !scatter(between.map(|(square, _)| square), rounding);
    shown.then(|| (bends[0] % period..position_m.len()).step_by(period).collect())
}

/// Whether as many of these bends lie within motion as do in a move, or in noise. The corners of a planned stroke can also be
/// multiples of many rows apart, but have a rest on one side.
fn within_motion(position_m: &[f64], bends: &[usize], period: usize) -> bool {
    /// A ramp that is read slowly has half of its bends at rest.
    const SHARE: f64 = 0.25;
    let nothing = 0.5 * step(position_m);
    let change = |row: usize| position_m.get(row + period).map_or(0.0, |next| next - position_m[row]);
    let at = |row: &&usize| change(row.saturating_sub(period)).abs() > nothing && change(**row).abs() > nothing;
    bends.iter().filter(at).count() as f64 > SHARE * bends.len() as f64
}

/// Rows in which a course bends by many steps.
fn bends(position_m: &[f64]) -> Vec<usize> {
    let (low, high) = extremes(position_m);
    let far = (STEPS * step(position_m)).max(ROUNDING * (high - low));
    records::second_differences(position_m).zip(1..).filter(|(bend, _)| *bend >= far).map(|(_, row)| row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    #[test]
    fn steps_of_an_encoder_in_a_steady_move_are_no_held_readout() {
        let position_m: Vec<f64> = (0..900).map(|row| 0.1 - 1e-4 * (row.clamp(300, 600) / 3) as f64).collect();
        assert_eq!(readings(&position_m), None);
    }

    #[test]
    fn corners_of_a_plan_at_round_times_are_no_interpolated_readout() {
        // To and fro in half a second each, less far each time, with rests of half a second.
        let share = |row: usize| match row % 200 {
            0..50 => 0.0,
            there @ 50..100 => (there - 50) as f64 / 50.0,
            100..150 => 1.0,
            back => (200 - back) as f64 / 50.0,
        };
        let far = |row: usize| 0.05 - 1e-3 * (row / 200) as f64;
        let planned: Vec<f64> = (0..4000).map(|row| ((0.1 - far(row) * share(row)) * 1e6).round() * 1e-6).collect();
        assert!(bends(&planned).len() > 20);
        assert_eq!(readings(&planned), None);
    }

    #[test]
    fn the_corners_of_a_triangle_are_no_readings_where_the_rows_between_them_are_noisy() {
        let mut random = Random::new(9);
        for (noise_m, step_m) in [(5e-6, 1e-6), (1e-6, 1e-6), (1e-6, 1e-9), (5e-7, 1e-6)] {
            let corner = |row: usize| (row % 100) as f64 / 50.0 - 1.0;
            let position = |row: usize| 0.1 - 0.03 * (1.0 - corner(row).abs());
            let triangle: Vec<f64> = (0..1000)
                .map(|row| if !(100..=900).contains(&row) { 0.1 } else { position(row) } + noise_m * random.normal())
                .map(|x| (x / step_m).round() * step_m)
                .collect();
            assert_eq!(readings(&triangle), None, "noise of {noise_m} m in steps of {step_m} m");
        }
    }

    /// Moves of 100 rows each, read at every 20th row from the fifth on, straight in between, and rounded to 1 µm.
    fn interpolated_moves(moves: usize) -> Vec<f64> {
        let mut random = Random::new(8);
        let position = |row: f64| {
            let u = ((row / 500.0).fract() * 5.0 - 2.0).clamp(0.0, 1.0);
            let done = (row / 500.0).floor() + u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
            0.1 - 0.02 * done
        };
        let readings: Vec<f64> = (0..=25 * moves)
            .map(|k| position((20 * k) as f64) + 4e-7 * random.normal())
            .map(|x| (x * 1e6).round() * 1e-6)
            .collect();
        let between = |row: usize| {
            let share = (row % 20) as f64 / 20.0;
            readings[row / 20] * (1.0 - share) + readings[row / 20 + 1] * share
        };
        (15..500 * moves).map(|row| (between(row) * 1e6).round() * 1e-6).collect()
    }

    #[test]
    fn an_interpolated_readout_is_found_by_the_bends_of_its_moves_where_rounding_hides_its_noise() {
        let position_m = interpolated_moves(2);
        assert_eq!(straight_between(&position_m), None);
        let (between, rows) = readings(&position_m).unwrap();
        assert_eq!(between, Between::Interpolated);
        assert_eq!(rows, (5..985).step_by(20).collect::<Vec<_>>());
    }

    #[test]
    fn a_period_that_is_known_is_that_of_a_record_whose_bends_all_fit_it() {
        let position_m = interpolated_moves(1);
        let few: Vec<f64> = position_m[..240].to_vec();
        assert_eq!(readings(&few), None);
        let every = |period| readings_at_every(period, Between::Interpolated, &few).map(|(_, rows)| rows);
        assert_eq!(every(20), Some((5..240).step_by(20).collect()));
        assert_eq!(every(15), None);
        assert_eq!(readings_at_every(20, Between::Interpolated, &[0.1; 240]), None);
    }
}
