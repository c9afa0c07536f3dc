//! Which rows of a record belong to moves of the piston, from its positions in m.

use super::position_noise::position_noise;
use super::spline::mean;
use super::turn::{REACH, is_turn};
use records::{Line, extremes};

/// Which rows belong to moves, where a stop of fewer rows than `shortest_hold` is part of one, and positions have this noise, m.
///
/// In a recording so fast that the travel per row is lost in the noise, moves come out in pieces of few rows, or not at all, or
/// the piston moves where it seems to be held. Means of rows are then used instead, of twice as many each time until the moves
/// are whole.
pub fn moving(position_m: &[f64], shortest_hold: usize, noise_m: f64) -> Vec<bool> {
    /// A move, with its gentle start and end, is never shorter.
    const FEWEST_ROWS: usize = 10;
    /// A record is not reduced to fewer means, ...
    const FEWEST_MEANS: usize = 200;
    /// ...nor to fewer than these if no number of means shows its moves whole, but a larger number shows some.
    const FEWEST_IN_PIECES: usize = 2000;
    /// A held piston wanders by no more than this fraction of the record's travel, ...
    const MOST_WANDER: f64 = 0.02;
    /// ...and creeps by no more than this one.
    const MOST_CREEP: f64 = 0.05;
    let mut averaged = 1;
    let mut in_pieces = Vec::new();
    loop {
        let means: Vec<f64> = position_m.chunks(averaged).map(mean).collect();
        let noise_m = if averaged == 1 { noise_m } else { position_noise(&means).min(noise_m) };
        let (low, high) = extremes(&means);
        let mut moving = moving_rows(&means, (8.0 * noise_m).max(2e-4 * (high - low)), shortest_hold);
        without_turns(&mut moving, &means, noise_m);
        join(&mut moving, &means);
        widen(&mut moving, &means, noise_m);
        let whole = |(first, end, moves): (usize, usize, bool)| match moves {
            true => end - first >= FEWEST_ROWS,
            false => {
                let [wander_m, creep_m] = wander_and_creep(&means[first..end]);
                wander_m < MOST_WANDER * (high - low) && creep_m < MOST_CREEP * (high - low)
            }
        };
        let is_whole = moving.contains(&true) && ranges(&moving).into_iter().all(whole);
        let rows = moving.iter().flat_map(|moves| [*moves].repeat(averaged)).take(position_m.len()).collect();
        if is_whole {
            return rows;
        }
        if means.len() >= FEWEST_IN_PIECES || !in_pieces.contains(&true) {
            in_pieces = rows;
        }
        if means.len() < 2 * FEWEST_MEANS {
            return in_pieces;
        }
        averaged *= 2;
    }
}

/// Rows within reach of a position change larger than `threshold`, and holds of fewer rows than `shortest_hold`. Before a
/// record's first move any row outside that reach shows a rest.
fn moving_rows(position_m: &[f64], threshold: f64, shortest_hold: usize) -> Vec<bool> {
    let n = position_m.len();
    let mut moving: Vec<bool> = (0..n)
        .map(|i| {
            let (low, high) = extremes(&position_m[i.saturating_sub(REACH)..(i + REACH + 1).min(n)]);
            high - low > threshold
        })
        .collect();
    let mut start = 0;
    while start < n {
        let end = (start..n).find(|&i| moving[i] != moving[start]).unwrap_or(n);
        if start > 0 && !moving[start] && end - start < shortest_hold {
            moving[start..end].fill(true);
        }
        start = end;
    }
    moving
}

/// Largest distance of the means of a stop's rows from their straight line, and the change along that line, m.
fn wander_and_creep(position_m: &[f64]) -> [f64; 2] {
    const PARTS: usize = 20;
    if position_m.len() < 2 * PARTS {
        return [0.0; 2];
    }
    let means: Vec<f64> = position_m.chunks_exact(position_m.len() / PARTS).map(mean).collect();
    let index: Vec<f64> = (0..means.len()).map(|i| i as f64).collect();
    let line = Line::through(&index, &means);
    let wander_m = index.iter().zip(&means).map(|(i, x)| (x - line.at(*i)).abs()).fold(0.0, f64::max);
    [wander_m, line.slope.abs() * means.len() as f64]
}

/// Joins moves between which the piston turns without a stop, and extends those at the record's ends by the turns that they begin
/// or end with.
fn without_turns(moving: &mut [bool], position_m: &[f64], noise_m: f64) {
    let parts = ranges(moving);
    for (k, &(first, end, moves)) in parts.iter().enumerate() {
        let before = k.checked_sub(1).map_or(first, |k| parts[k].0);
        let after = parts.get(k + 1).map_or(end, |part| part.1);
        if !moves && parts.len() > 1 && is_turn(position_m, first..end, before..after, noise_m) {
            moving[first..end].fill(true);
        }
    }
}

/// Joins moves between which the piston does not stop: a piston that swings to its stop does not stop where it turns, nor does
/// one that starts gently. Between a move and one of less than half its travel, a stop must last.
fn join(moving: &mut [bool], position_m: &[f64]) {
    const PART: f64 = 0.5;
    /// Duration of the longer move over that of the shortest stop beside it.
    const SHORTEST_STOP: usize = 6;
    let travel = |first: usize, end: usize| {
        let (low, high) = extremes(&position_m[first..end]);
        high - low
    };
    let mut begun = None;
    for stop in ranges(moving).windows(3) {
        let [before, (first, end, moves), after] = [stop[0], stop[1], stop[2]];
        if moves {
            continue;
        }
        // Start of the move before, including what was joined to it.
        let from = begun.unwrap_or(before.0);
        let travels = [travel(from, first), travel(after.0, after.1)];
        let lasts = SHORTEST_STOP * (end - first) > (first - from).max(after.1 - after.0);
        let is_one = !lasts && travels[0].min(travels[1]) < PART * travels[0].max(travels[1]);
        if is_one {
            moving[first..end].fill(true);
        }
        begun = is_one.then_some(from);
    }
}

/// Extends moves by their gentle starts and ends, which single rows do not show in the position noise.
fn widen(moving: &mut [bool], position_m: &[f64], noise_m: f64) {
    let parts = ranges(moving);
    let length = |k: usize| parts.get(k).map_or(0, |(first, end, _)| end - first);
    for (k, &(first, end, moves)) in parts.iter().enumerate() {
        if moves {
            continue;
        }
        let [before, after] = [k.checked_sub(1).map_or(0, length), length(k + 1)];
        let backwards: Vec<f64> = position_m[first..end].iter().rev().copied().collect();
        // Neither the gentle start of the next move nor the end of the one before is where the piston is held.
        let rows = end - first;
        let beside = |length: usize| length.min(rows / 4);
        let late = unsettled(&backwards[..rows - beside(before)], after, noise_m);
        let next = if late == 0 { beside(after) } else { late };
        let early = unsettled(&position_m[first..end - next], before, noise_m);
        let late = if early == beside(before) { late } else { unsettled(&backwards[..rows - early], after, noise_m) };
        moving[first..first + early].fill(true);
        moving[end - late..end].fill(true);
    }
}

/// Number of a hold's rows, counted from a move of `length` rows, that still belong to it: those whose means over a window differ
/// from the held position, and one window more, in which a mean would not show them. A piston that swings to its stop passes its
/// place in between. The held position is the straight line through the half of the rows that is farther from the move. Zero if
/// the piston does not get there, or if there is no move.
fn unsettled(rows: &[f64], length: usize, noise_m: f64) -> usize {
    const SHORTEST_WINDOW: usize = 8;
    /// Least number of windows in a move, and in a hold.
    const WINDOWS: [usize; 2] = [16, 8];
    /// Windows for which a swing may stay near the final position.
    const PASSING: usize = 4;
    /// Distances of a mean, in its standard deviations, that show that the move continues, and after a pause that it was not
    /// over.
    const DEVIATIONS: [f64; 2] = [2.7, 3.5];
    /// Longest end of a move, over the length that single rows show of it.
    const LONGEST: usize = 8;
    let window = (length / WINDOWS[0]).min(rows.len() / WINDOWS[1]).max(SHORTEST_WINDOW);
    let half = rows.len() / 2;
    if length == 0 || half < window {
        return 0;
    }
    let index: Vec<f64> = (0..rows.len()).map(|i| i as f64).collect();
    let line = Line::through(&index[half..], &rows[half..]);
    // Cumulative sums of the distances from it.
    let mut sums = vec![0.0];
    sums.extend(index.iter().zip(rows).scan(0.0, |sum, (i, row)| {
        *sum += row - line.at(*i);
        Some(*sum)
    }));
    let held = (rows.len() - half) as f64;
    let off = |i: usize| (sums[i + window] - sums[i]).abs() / window as f64;
    let error = |i: usize| {
        let reach = (i as f64 + 0.5 * (window - 1) as f64 - line.middle_s) / held;
        noise_m * (1.0 / window as f64 + (1.0 + 12.0 * reach * reach) / held).sqrt()
    };
    // A held piston may wander.
    let means = (half..=rows.len() - window).step_by(window).map(|i| off(i).powi(2));
    let wander = (means.clone().sum::<f64>() / means.count() as f64).sqrt();
    let most = half.min(LONGEST * length);
    let mut moved = 0;
    for i in 0..most {
        let continues = i == moved && off(i) > DEVIATIONS[0] * error(i);
        if continues || off(i) > DEVIATIONS[1] * error(i).max(wander) {
            moved = i + 1;
        } else if i > moved + PASSING * window {
            break;
        }
    }
    if moved < most { moved + window } else { 0 }
}

/// Moves readings at either end of a move that do not differ from the held position to the hold, which needs every reading that
/// represents many rows; the one next to the rest of the move stays in it.
pub fn narrow(moving: &mut [bool], readings_m: &[f64], noise_m: f64) {
    const DEVIATIONS: f64 = 3.0;
    let limit = DEVIATIONS * noise_m;
    for (first, end, moves) in ranges(moving) {
        if moves {
            continue;
        }
        let level = mean(&readings_m[first..end]);
        let is_held = |row: &usize| (readings_m[*row] - level).abs() <= limit;
        let after = (end..readings_m.len()).take_while(|row| moving[*row] && is_held(row)).count();
        let before = (0..first).rev().take_while(|row| moving[*row] && is_held(row)).count();
        moving[end..end + after.saturating_sub(1)].fill(false);
        moving[first - before.saturating_sub(1)..first].fill(false);
    }
}

/// Ranges of successive rows, `first..end`, that all move or all do not.
pub fn ranges(moving: &[bool]) -> Vec<(usize, usize, bool)> {
    let mut out = Vec::new();
    let mut start = 0;
    while start < moving.len() {
        let end = (start..moving.len()).find(|&i| moving[i] != moving[start]).unwrap_or(moving.len());
        out.push((start, end, moving[start]));
        start = end;
    }
    out
}
