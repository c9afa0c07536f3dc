//! Which rows of a record belong to moves of the piston, by its positions in m.

use crate::record::line::Line;
use crate::record::position_noise::position_noise;
use crate::record::spline::extent;

/// Mean of some values.
pub fn mean(rows: &[f64]) -> f64 {
    rows.iter().sum::<f64>() / rows.len() as f64
}

/// Which rows belong to moves, where a stop of fewer rows than `shortest_hold` is part of one.
///
/// So fast a recording that a row's way is lost in the noise shows its moves in pieces of few rows, or none: then means of rows
/// are looked at instead, of twice as many until the moves are whole.
pub fn moving(position_m: &[f64], shortest_hold: usize) -> Vec<bool> {
    /// No move is shorter, once it has its gentle begin and end.
    const FEWEST_ROWS: usize = 10;
    /// A record is not looked at in fewer means.
    const FEWEST_MEANS: usize = 2000;
    let mut averaged = 1;
    loop {
        let means: Vec<f64> = position_m.chunks(averaged).map(mean).collect();
        let noise_m = position_noise(&means);
        let (low, high) = extent(&means);
        let mut moving = moving_rows(&means, (8.0 * noise_m).max(2e-4 * (high - low)), shortest_hold);
        widen(&mut moving, &means, noise_m);
        let in_pieces = ranges(&moving).into_iter().any(|(first, end, moves)| moves && end - first < FEWEST_ROWS);
        let is_whole = moving.contains(&true) && !in_pieces;
        if is_whole || means.len() < 2 * FEWEST_MEANS {
            return moving.iter().flat_map(|moves| [*moves].repeat(averaged)).take(position_m.len()).collect();
        }
        averaged *= 2;
    }
}

/// Rows within reach of a change of position larger than `threshold`, and holds of fewer rows than `shortest_hold`.
fn moving_rows(position_m: &[f64], threshold: f64, shortest_hold: usize) -> Vec<bool> {
    const REACH: usize = 3;
    let n = position_m.len();
    let mut moving: Vec<bool> = (0..n)
        .map(|i| {
            let (low, high) = extent(&position_m[i.saturating_sub(REACH)..(i + REACH + 1).min(n)]);
            high - low > threshold
        })
        .collect();
    let mut start = 0;
    while start < n {
        let end = (start..n).find(|&i| moving[i] != moving[start]).unwrap_or(n);
        if !moving[start] && end - start < shortest_hold {
            moving[start..end].fill(true);
        }
        start = end;
    }
    moving
}

/// Gives moves their gentle begins and ends, which single rows do not show in the position's noise. Between two moves, one of them
/// longer, a piston that does not come to rest does not stop.
fn widen(moving: &mut [bool], position_m: &[f64], noise_m: f64) {
    let parts = ranges(moving);
    let length = |k: usize| parts.get(k).map_or(0, |(first, end, _)| end - first);
    // Of the move before, with what has been added to it.
    let mut before = 0;
    for (k, &(first, end, moves)) in parts.iter().enumerate() {
        if moves {
            before += end - first;
            continue;
        }
        let backwards: Vec<f64> = position_m[first..end].iter().rev().copied().collect();
        let after = length(k + 1);
        let begin = if k > 0 { unsettled(&position_m[first..end], before, noise_m) } else { Some(0) };
        let rest = if k + 1 < parts.len() { unsettled(&backwards, after, noise_m) } else { Some(0) };
        if k > 0 && after > 0 && (begin.is_none() || rest.is_none()) && end - first < before.max(after) {
            moving[first..end].fill(true);
            before += end - first;
            continue;
        }
        moving[first..first + begin.unwrap_or(0)].fill(true);
        moving[end - rest.unwrap_or(0)..end].fill(true);
        before = 0;
    }
}

/// How many of a hold's rows, counted from a move of so many rows, still belong to it: those whose means over a window differ from
/// where the piston is held, and one window more, in which a mean would not show them either. A piston that swings to its stop
/// passes its place in between. It is held along the straight line of the half of the rows that is farther from the move; none if
/// it does not get there.
fn unsettled(rows: &[f64], length: usize, noise_m: f64) -> Option<usize> {
    const SHORTEST_WINDOW: usize = 8;
    /// Windows in a move.
    const WINDOWS: usize = 16;
    /// Windows for which a swing may stay near the place at which the piston will rest.
    const PASSING: usize = 4;
    /// A mean so far off shows that the move goes on, and after a pause that it has not been over.
    const DEVIATIONS: [f64; 2] = [2.7, 3.5];
    /// A move's end is no longer than so many times what single rows show of it.
    const LONGEST: usize = 8;
    let window = (length / WINDOWS).max(SHORTEST_WINDOW);
    let half = rows.len() / 2;
    let index: Vec<f64> = (0..rows.len()).map(|i| i as f64).collect();
    if half < window {
        let line = Line::through(&index, rows);
        let squares: f64 = index.iter().zip(rows).map(|(i, row)| (row - line.at(*i)).powi(2)).sum();
        return (squares < DEVIATIONS[0] * noise_m * noise_m * rows.len() as f64).then_some(0);
    }
    let line = Line::through(&index[half..], &rows[half..]);
    let held = (rows.len() - half) as f64;
    let is_off = |i: usize, deviations: f64| {
        let middle = i as f64 + 0.5 * (window - 1) as f64;
        let reach = (middle - line.middle_s) / held;
        let error_m = noise_m * (1.0 / window as f64 + (1.0 + 12.0 * reach * reach) / held).sqrt();
        (mean(&rows[i..i + window]) - line.at(middle)).abs() > deviations * error_m
    };
    let mut moved = 0;
    for i in 0..half.min(LONGEST * length) {
        if is_off(i, DEVIATIONS[usize::from(i > moved)]) {
            moved = i + 1;
        } else if i > moved + PASSING * window {
            return Some(moved + window);
        }
    }
    (moved + window < half.min(LONGEST * length)).then_some(moved + window)
}

/// Takes readings at either end of a move that do not differ from where the piston is held out of it, but for the one next to it: a
/// reading that stands for many rows is missed in a hold.
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

/// Ranges of rows, from one to before another, that all move or do not.
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
