//! Pressures at an end of the sensor's range: the readings stay there, whatever the gas does.
//!
//! The sign is a run of readings equal to the record's extreme while the piston moves, or in a record whose noise moves every
//! row. Where noise does not move the readings, gas in equilibrium gives equal ones too, and those of a late sensor continue into
//! the move: then the run must last, from the start of a move, for longer than that move. Nor need a coarse sensor show the end
//! of a move in which the pressure changes by less than a step.

use crate::error::Error;
use crate::record::far_off::{first_few, from_to};
use crate::record::sampling::readout::Readout;
use crate::record::series::lattice;
use crate::record::series::scatter::scatter;
use crate::record::stroke::{Motion, Phase};
use records::{LineNumbers, Trace, extremes, reversal_fraction};
use std::ops::Range;
use std::path::Path;

/// A move of less than this fraction of the travel may leave a coarse sensor unchanged.
const SHORT_MOVE: f64 = 0.05;
/// So may a part of a move with less than this fraction of its travel.
const SHORT_PART: f64 = 0.1;
/// A run of this many equal extreme readings means a sensor at the end of its range...
const LONGEST_HONEST_RUN: usize = 5;
/// ...if the noise moves its readings: noise of less than this many steps may leave them unchanged.
const STEPS_OF_NOISE: f64 = 0.6;
/// Fraction of the changes between readings that turn back, above which noise makes them: white noise turns back two of three,
/// and a gas none between two moves.
const TURNED_BACK: f64 = 0.05;
/// A run in a hold, longer than in a move by this factor, is a sign too...
const IN_HOLD: usize = 2;
/// ...if no more than this fraction of all readings equals the one before.
const FEW_EQUAL: f64 = 0.2;

/// An end of the sensor's range.
pub struct End {
    /// Its reading there, Pa.
    pub value_pa: f64,
    /// Error with which the record that shows it is refused if no other is left.
    pub error: Error,
}

/// The ends of the sensor's range that a record shows.
pub fn ends(trace: &Trace, pressure_pa: &[f64], motion: &Motion, readout: &Readout) -> Vec<End> {
    let rows: Vec<usize> = (0..pressure_pa.len()).filter(|&i| readout.is_data(i)).collect();
    let (least, most) = extremes(pressure_pa);
    let end = |(value_pa, high)| {
        let run = longest_run(&rows, pressure_pa, value_pa);
        let error = || Error::Saturated {
            trace: trace.path.clone(),
            rows: run.len(),
            from_s: trace.time_s[run[0]],
            value_pa,
            high,
        };
        is_saturated(trace, pressure_pa, motion, readout, &rows, run).then(|| End { value_pa, error: error() })
    };
    [(most, true), (least, false)].into_iter().filter_map(end).collect()
}

/// The rows of a record that read these ends of the range, including the few between them.
pub fn rows_at(ends_pa: &[f64], pressure_pa: &[f64]) -> Vec<Range<usize>> {
    ends_pa.iter().flat_map(|end_pa| stretches(pressure_pa, *end_pa)).collect()
}

/// Whether a run of equal readings, out of all `rows` that were read, is too long for a sensor within its range.
fn is_saturated(
    trace: &Trace,
    pressure_pa: &[f64],
    motion: &Motion,
    readout: &Readout,
    rows: &[usize],
    run: &[usize],
) -> bool {
    let (Some(&first), Some(&last)) = (run.first(), run.last()) else { return false };
    let readings: Vec<f64> = rows.iter().map(|&row| pressure_pa[row]).collect();
    let is_beside = |row: &usize| !(first..=last).contains(row);
    let beside: Vec<f64> = rows.iter().filter(|row| is_beside(row)).map(|&row| pressure_pa[row]).collect();
    let step_pa = lattice::of_changes(&beside, 1e-9);
    let noisy = !readings_stick(&beside, step_pa) && reversal_fraction(readings.iter().copied()) > TURNED_BACK;
    let travel_of = |rows: Range<usize>| {
        let (low, high) = extremes(&trace.position_m[rows]);
        high - low
    };
    let travel = travel_of(0..trace.position_m.len());
    let in_a_move = motion.segments.iter().any(|s| {
        let inside = first.max(s.first)..(last + 1).min(s.end);
        let stroke = travel_of(s.first..s.end);
        s.phase == Phase::Move
            && stroke > SHORT_MOVE * travel
            && inside.len() as f64 >= LONGEST_HONEST_RUN as f64 * readout.readings.period()
            && travel_of(inside.clone()) > SHORT_PART * stroke
            && change_pa(pressure_pa[first], &trace.position_m[inside]) > step_pa
            && (noisy || last + 1 > first.max(s.first) + (s.end - s.first))
    });
    let equal = readings.windows(2).filter(|w| w[0] == w[1]).count() as f64;
    let in_a_hold = run.len() > IN_HOLD * LONGEST_HONEST_RUN && equal < FEW_EQUAL * (rows.len() - 1) as f64 && noisy;
    run.len() >= LONGEST_HONEST_RUN && (in_a_move || in_a_hold)
}

/// Change of a pressure while the piston is at these positions, Pa: isothermal, in a chamber without dead volume.
fn change_pa(pressure_pa: f64, position_m: &[f64]) -> f64 {
    let (low, high) = extremes(position_m);
    if low > 0.0 { pressure_pa * (1.0 - low / high) } else { f64::INFINITY }
}

/// Whether the noise is too small to move readings off the sensor's steps.
fn readings_stick(pressure_pa: &[f64], step_pa: f64) -> bool {
    scatter(pressure_pa) < STEPS_OF_NOISE * step_pa
}

/// The longest run of the value `of`.
fn longest_run<'a>(rows: &'a [usize], values: &[f64], of: f64) -> &'a [usize] {
    let (mut best, mut length) = (0..0, 0);
    for (k, &i) in rows.iter().enumerate() {
        length = if values[i] == of { length + 1 } else { 0 };
        if length > best.len() {
            best = k + 1 - length..k + 1;
        }
    }
    &rows[best]
}

/// Ranges from the first to the last row of that value, including gaps of a few rows: noise takes readings off an end of the
/// range and back. A single row is not necessarily at the end.
fn stretches(values: &[f64], of: f64) -> Vec<Range<usize>> {
    let mut out: Vec<Range<usize>> = Vec::new();
    for k in (0..values.len()).filter(|&k| values[k] == of) {
        match out.last_mut() {
            Some(rows) if k - rows.end < LONGEST_HONEST_RUN => rows.end = k + 1,
            _ => out.push(k..k + 1),
        }
    }
    out.retain(|rows| rows.len() > 1);
    out
}

/// Names in a sentence the rows of a record that are left out because its sensor was at an end of its range, if any, with their
/// lines and seconds.
pub fn sentence(path: &Path, rows: &[Range<usize>], lines: &LineNumbers, time_s: &[f64]) -> Option<String> {
    let stretch = |rows: &Range<usize>| from_to([rows.start, rows.end - 1], lines, time_s);
    let count: usize = rows.iter().map(Range::len).sum();
    let (named, more) = first_few(rows);
    (count > 0).then(|| {
        format!(
            "{}: the pressure sensor is saturated; {count} rows in which it reads an end of its range are left out ({}{more} after the first row)",
            path.display(),
            named.iter().map(stretch).collect::<Vec<_>>().join("; ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    #[test]
    fn white_noise_turns_changes_back_and_a_gas_does_not() {
        let rows: Vec<usize> = (0..400).collect();
        let mut random = Random::new(33);
        let relaxing = |i: usize| if i < 100 { 1e5 } else { 1e5 + 2e5 * (-((i - 100) as f64) / 60.0).exp() };
        let noisy: Vec<f64> = rows.iter().map(|&i| relaxing(i) + 50.0 * random.normal()).collect();
        assert!(reversal_fraction(noisy) > 3.0 * TURNED_BACK);
        let smooth: Vec<f64> = rows.iter().map(|&i| (relaxing(i) * 1e4).round() * 1e-4).collect();
        assert!(reversal_fraction(smooth) < 0.2 * TURNED_BACK);
    }

    #[test]
    fn readings_stick_where_the_noise_is_small_against_the_steps() {
        let sticks = |noise_pa: f64| {
            let mut random = Random::new(31);
            let relaxing = |i: usize| 3e5 + 2e5 * (-(i as f64) / 60.0).exp();
            let rounded = |p: f64| (p / 390.6).round() * 390.6;
            let p: Vec<f64> = (0..290).map(|i| rounded(relaxing(i) + noise_pa * random.normal())).collect();
            readings_stick(&p, lattice::of_changes(&p, 1e-9))
        };
        assert!(sticks(20.0) && sticks(80.0));
        assert!(!sticks(400.0));
        let mut random = Random::new(32);
        let unrounded: Vec<f64> = (0..300).map(|_| 3e5 + 80.0 * random.normal()).collect();
        assert!(!readings_stick(&unrounded, lattice::of_changes(&unrounded, 1e-9)));
    }

    #[test]
    fn rows_at_an_end_of_the_range_are_found_with_the_few_between_them() {
        let values = [1.0, 5.0, 5.0, 4.9, 5.0, 3.0, 2.0, 5.0, 2.0, 2.0, 2.0, 2.0, 2.0, 5.0, 5.0];
        assert_eq!(rows_at(&[5.0], &values), [1..8, 13..15]);
        let values = [1.0, 5.0, 5.0, 4.9, 5.0, 3.0, 2.0, 2.0, 2.0, 2.0, 2.0, 5.0, 5.0];
        let rows: Vec<usize> = (0..values.len()).collect();
        assert_eq!(rows_at(&[5.0], &values), [1..5, 11..13]);
        let lines: LineNumbers = (2..15).collect();
        let time_s: Vec<f64> = rows.iter().map(|i| 0.1 * *i as f64).collect();
        let said = |rows: &[Range<usize>]| sentence(Path::new("a.csv"), rows, &lines, &time_s);
        assert_eq!(said(&[]), None);
        let said = said(&[1..5, 11..13]).unwrap();
        assert!(said.contains("6 rows in which it reads an end of its range are left out"), "{said}");
        assert!(
            said.ends_with(
                "(lines 3 to 6, 0.100 s to 0.400 s; lines 13 to 14, 1.100 s to 1.200 s after the first row)"
            ),
            "{said}"
        );
    }
}
