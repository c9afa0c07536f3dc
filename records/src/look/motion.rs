//! Rests and moves of a piston, and the windows of single push-and-hold tests.

use crate::look::readings::Readings;
use crate::opened::opened_from;
use crate::shut::shut_from;
use crate::statistics::{extremes, interval};
use crate::trace::movement_threshold;
use std::ops::Range;

/// Time without motion after which a piston counts as at rest, s ...
const REST_S: f64 = 0.15;
/// ... or number of rows, if that is longer.
const REST_ROWS: usize = 8;
/// Longest part of the rest before a push that belongs to its window, s.
const LEAD_S: f64 = 1.0;
/// Smallest response of a closed chamber to a move, as a fraction of the isothermal response without dead volume.
const LEAST_ANSWER: f64 = 0.15;
/// Up to this fraction of a move ...
const EARLY: f64 = 0.1;
/// ... the pressure of a closed chamber makes at most this fraction of its total change.
const MOST_EARLY: f64 = 0.6;
/// Latest time after the move, s, at which a response is checked for lasting: the gas is at the wall's temperature by then, and a
/// leak has lost little.
const LASTING_S: f64 = 3.0;
/// A chamber that was opened has a steady pressure again if the change before a move is below this multiple of its noise.
const STEADY: f64 = 10.0;

/// Part of a record in which the piston rests or moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// Rows of the trace that belong to it.
    pub rows: Range<usize>,
    /// Whether the piston moves.
    pub moving: bool,
}

/// Rests and moves in order, which together cover all rows. Creep counts as rest.
pub fn phases(time_s: &[f64], position_m: &[f64]) -> Vec<Phase> {
    let n = position_m.len();
    let threshold = movement_threshold(position_m);
    let interval = interval(time_s);
    let width = ((REST_S / interval.max(f64::MIN_POSITIVE)) as usize).clamp(REST_ROWS, (n / 10).max(REST_ROWS));
    let spread = |rows: Range<usize>| {
        let (low, high) = extremes(&position_m[rows]);
        high - low
    };
    let rests = |row: usize| spread(row..(row + width).min(n)) <= 2.0 * threshold;
    let mut phases: Vec<Phase> = Vec::new();
    let mut row = 0;
    while row < n {
        let first = row;
        let moving = !rests(row);
        if moving {
            while row < n && !rests(row) {
                row += 1;
            }
        } else {
            // Far from its recent mean position: it moves.
            let mut sum: f64 = position_m[row..(row + width).min(n)].iter().sum();
            let mut count = (row + width).min(n) - row;
            row = (row + width).min(n);
            while row < n && (position_m[row] - sum / count as f64).abs() <= threshold {
                sum += position_m[row] - position_m[row - width];
                row += 1;
                count = width;
            }
            // A piston that crosses the threshold within one row started in the row before.
            if row < n {
                row = (row - 1).max(first + 1);
            }
        }
        match phases.last_mut() {
            Some(last) if last.moving == moving => last.rows.end = row,
            _ => phases.push(Phase { rows: first..row, moving }),
        }
    }
    phases
}

/// Part of a record with one move between two rests, with the chamber closed.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// First time, s.
    pub from_s: f64,
    /// Last time, s.
    pub to_s: f64,
    /// Whether the move makes the chamber smaller.
    pub compresses: bool,
}

/// Rounds a row's time for display: to the millisecond, or to a tenth of the row interval where that is less.
pub fn as_written(time_s: f64, interval_s: f64) -> f64 {
    let finest = (0.1 * interval_s).clamp(1e-9, 1e-3);
    let per_second = 10_f64.powf((-finest.log10() - 1e-6).ceil());
    // No negative zero.
    (time_s * per_second).round() / per_second + 0.0
}

/// The windows of single push-and-hold tests, and the number of moves skipped because the pressure did not respond: the port was
/// open. A window begins after the port is shut, and ends before the next move or where opening the port makes the pressure
/// depart from its course.
///
/// The record consists of time, s, pressure, Pa, and position, m.
pub fn cycles(record: [&[f64]; 3], readings: &Readings, phases: &[Phase]) -> (Vec<Cycle>, usize) {
    let [time_s, pressure_pa, position_m] = record;
    let mean = |values: &[f64], rows: Range<usize>| values[rows.clone()].iter().sum::<f64>() / rows.len() as f64;
    let (mut cycles, mut open) = (Vec::new(), 0);
    // Moves are not checked.
    let closed_until = |phase: &Phase| match phase.moving {
        true => phase.rows.end,
        false => closed_until([time_s, pressure_pa], readings, phase.rows.clone()),
    };
    let until: Vec<usize> = phases.iter().map(closed_until).collect();
    for (triple, until) in phases.windows(3).zip(until.windows(3)) {
        let ([before, push, after], &[opened, _, last]) = (triple, until) else { continue };
        if before.moving || !push.moving || after.rows.len() < REST_ROWS {
            continue;
        }
        let lead =
            time_s[before.rows.end - 1] - LEAD_S.min((time_s[before.rows.end - 1] - time_s[before.rows.start]) / 2.0);
        let in_lead = before.rows.start + time_s[before.rows.clone()].partition_point(|t| *t < lead);
        // If the port was opened or shut during the rest, earlier rows do not belong to this test.
        let shut = closed_from([time_s, pressure_pa], readings, before.rows.clone());
        let opened = Some(opened).filter(|row| *row < before.rows.end.saturating_sub(REST_ROWS));
        let first = shut.into_iter().chain(opened).fold(in_lead, usize::max);
        let begin = before.rows.end.saturating_sub(REST_ROWS).max(first)..before.rows.end;
        let end = after.rows.start..(after.rows.start + REST_ROWS).min(after.rows.end);
        let [from_m, to_m] = [begin.clone(), end.clone()].map(|rows| mean(position_m, rows));
        // The zero of positions is unknown: assume only the smallest possible relative change of the volume.
        let travel = (from_m - to_m) / from_m.abs().max(to_m.abs());
        let rest_pa = mean(pressure_pa, begin.clone());
        let answer = |rows: Range<usize>| (mean(pressure_pa, rows) / rest_pa).ln();
        let is_answered = |rows: Range<usize>| answer(rows) * travel.signum() >= LEAST_ANSWER * travel.abs();
        // An opened port changes the pressure before the piston has moved far.
        let on_its_way = |row: &usize| (position_m[*row] - from_m).abs() > EARLY * (to_m - from_m).abs();
        let early = push.rows.clone().find(on_its_way).map_or(push.rows.start, |row| (row - 1).max(begin.start));
        let answered_early = (pressure_pa[early] / rest_pa).ln() / answer(end.clone());
        // A brief response indicates a narrow port, as does a chamber that is still emptying or filling.
        let judged_s = time_s[after.rows.start] + LASTING_S;
        let judged = after.rows.start + time_s[after.rows.start..last].partition_point(|t| *t < judged_s);
        let settled = judged.saturating_sub(REST_ROWS).max(after.rows.start)..judged;
        let is_steady = (pressure_pa[first] - rest_pa).abs() < STEADY * readings.deviation_pa();
        let is_open = opened.is_some() && shut.is_none() && !is_steady;
        if !is_answered(end) || !is_answered(settled) || answered_early > MOST_EARLY || is_open {
            open += 1;
            continue;
        }
        let [from_s, to_s] = [first, last - 1].map(|row| as_written(time_s[row], readings.interval_s));
        cycles.push(Cycle { from_s, to_s, compresses: travel > 0.0 });
    }
    (cycles, open)
}

/// The first row of a rest after the port was shut, if it was shut during the rest.
fn closed_from(record: [&[f64]; 2], readings: &Readings, rest: Range<usize>) -> Option<usize> {
    let (rows, [times_s, pressures_pa]) = read_out(record, readings, rest);
    shut_from(&times_s, &pressures_pa, readings.deviation_pa()).map(|first| rows[first])
}

/// The rows in a range at which the sensor was read out, with their times, s, and pressures, Pa.
fn read_out(record: [&[f64]; 2], readings: &Readings, rows: Range<usize>) -> (Vec<usize>, [Vec<f64>; 2]) {
    let rows: Vec<usize> = readings.read_out(rows).collect();
    let columns = record.map(|column| rows.iter().map(|row| column[*row]).collect());
    (rows, columns)
}

/// One past the last row of a hold before its pressure departs from its course, or, in the second half, changes faster than in
/// the first.
fn closed_until([time_s, pressure_pa]: [&[f64]; 2], readings: &Readings, hold: Range<usize>) -> usize {
    let rate = |row: usize| (pressure_pa[row + 1] - pressure_pa[row]).abs();
    let middle = hold.start + hold.len() / 2;
    let fastest = (hold.start..middle).map(rate).fold(0.0, f64::max);
    let fast_change = (middle..hold.end - 1).find(|row| rate(*row) > 2.0 * fastest);
    let (rows, [times_s, held_pa]) = read_out([time_s, pressure_pa], readings, hold.clone());
    let opened = opened_from(&times_s, &held_pa, readings.deviation_pa()).map(|first| rows[first]);
    // The last rows before a move or a fast change may already belong to it.
    let until = fast_change.into_iter().chain(opened).min().unwrap_or(hold.end);
    until.saturating_sub(2).max(hold.start + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rest, push, hold, return, rest, three times; time, position and the pressure of a chamber closed except during returns.
    fn record() -> [Vec<f64>; 3] {
        let mut all = [Vec::new(), Vec::new(), Vec::new()];
        for k in 0..3000 {
            let t = (k % 1000) as f64 * 0.01;
            let noise = 3e-6 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
            let push = 0.05 * ((t - 2.0) / 0.1).clamp(0.0, 1.0);
            let back = 0.05 * ((t - 7.0) / 0.1).clamp(0.0, 1.0);
            let relaxed = if t > 2.1 { 5e4 * (-(t - 2.1) / 0.5).exp() } else { 5e5 * push };
            let closed = if t > 6.5 { 1e5 } else { 1e5 / (1.0 - 10.0 * push) + relaxed };
            [k as f64 * 0.01, 0.1 - push + back + noise, closed]
                .into_iter()
                .zip(&mut all)
                .for_each(|(v, all)| all.push(v));
        }
        all
    }

    #[test]
    fn rests_and_moves_follow_each_other() {
        let [time, position, _] = record();
        let found = phases(&time, &position);
        let moves: Vec<f64> = found.iter().filter(|p| p.moving).map(|p| time[p.rows.start]).collect();
        assert_eq!(moves.len(), 6, "{found:?}");
        for (begin, expected) in moves.iter().zip([2.0, 7.0, 12.0, 17.0, 22.0, 27.0]) {
            assert!((begin - expected).abs() < 0.03, "{begin} {expected}");
        }
        assert!(
            found.windows(2).all(|pair| pair[0].rows.end == pair[1].rows.start && pair[0].moving != pair[1].moving)
        );
        assert_eq!((found[0].rows.start, found.last().unwrap().rows.end), (0, 3000));
    }

    #[test]
    fn times_are_written_in_milliseconds_or_tenths_of_a_row() {
        assert_eq!([0.3000000000029104, 7.99999999].map(|time| as_written(time, 0.005)), [0.3, 8.0]);
        assert_eq!(as_written(1.23456789, 0.01), 1.235);
        assert_eq!([1e-3, 1e-4].map(|interval| as_written(1.23456789, interval)), [1.2346, 1.23457]);
        assert_eq!(as_written(1_764_000_000.3000002, 0.01), 1_764_000_000.3);
        assert_eq!(as_written(-0.0004, 1.0), 0.0);
    }

    #[test]
    fn creep_is_no_move() {
        let time: Vec<f64> = (0..2000).map(|k| k as f64 * 0.01).collect();
        let creep = |t: f64| 0.1 - 0.05 * ((t - 2.0) / 0.1).clamp(0.0, 1.0) - 1e-4 * t;
        let position: Vec<f64> = time.iter().map(|t| creep(*t)).collect();
        assert_eq!(phases(&time, &position).iter().filter(|p| p.moving).count(), 1);
    }

    #[test]
    fn cycles_are_cut_where_the_chamber_is_closed() {
        let [time, position, pressure] = record();
        let (found, open) =
            cycles([&time, &pressure, &position], &Readings::of(&time, &pressure), &phases(&time, &position));
        assert_eq!((found.len(), open), (3, 3), "{found:?}");
        for (k, cycle) in found.iter().enumerate() {
            let start = 10.0 * k as f64;
            assert!(cycle.from_s >= start && cycle.from_s <= start + 1.05, "{cycle:?}");
            assert!((cycle.to_s - start - 6.49).abs() < 0.03, "{cycle:?}");
            assert!(cycle.compresses);
        }
    }

    #[test]
    fn a_window_ends_where_a_held_chamber_is_opened_and_a_return_through_a_narrow_port_is_none() {
        let [time, position, mut pressure] = record();
        let normal = |k: usize| 50.0 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
        for (k, (t, p)) in time.iter().zip(&mut pressure).enumerate() {
            let t = t % 10.0;
            // Opened at 5 s, it empties with a time constant of 0.8 s; the return lowers the pressure by a third, and it fills
            // again.
            let open = (1e5 - *p).min(0.0) * (1.0 - (-(t - 5.0).max(0.0) / 0.8).exp());
            let drawn = if t < 7.0 { 0.0 } else { -3e4 * ((t - 7.0) / 0.1).min((-(t - 7.1) / 0.8).exp()) };
            *p = if t < 6.5 { *p + open } else { 1e5 + 9.3e4 * (-(t - 5.0) / 0.8).exp() + drawn } + normal(k);
        }
        let readings = Readings::of(&time, &pressure);
        let (found, open) = cycles([&time, &pressure, &position], &readings, &phases(&time, &position));
        assert_eq!((found.len(), open), (3, 3), "{found:?}");
        for (k, cycle) in found.iter().enumerate() {
            assert!((cycle.to_s - 10.0 * k as f64 - 4.99).abs() < 0.06, "{cycle:?}");
        }
    }

    #[test]
    fn a_long_hold_of_a_leaky_chamber_is_a_test_and_a_return_shortly_after_the_port_is_opened_is_none() {
        let normal = |k: usize| 50.0 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
        for [leak_s, opened] in [[1.6, 6.5], [1e9, 6.7]] {
            let [time, position, mut pressure] = record();
            for (k, (t, p)) in time.iter().zip(&mut pressure).enumerate() {
                let t = t % 10.0;
                let kept = |t: f64| (-(t - 2.1).max(0.0) / leak_s).exp();
                let above = if t > 6.5 { 1e5 * kept(t.min(opened)) } else { (*p - 1e5) * kept(t) };
                let drawn = 1.0 - 0.4 * ((t - 7.0) / 0.1).clamp(0.0, 1.0);
                *p = 1e5 + above * (-(t - opened).max(0.0) / 0.8).exp() * drawn + normal(k);
            }
            let readings = Readings::of(&time, &pressure);
            let (found, open) = cycles([&time, &pressure, &position], &readings, &phases(&time, &position));
            assert_eq!((found.len(), open), (3, 3), "{found:?}");
            assert!(found.iter().all(|cycle| cycle.compresses), "{found:?}");
        }
    }
}
