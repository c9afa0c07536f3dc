//! Which rows of a record belong to moves of the piston, by its positions in m.

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

/// Gives moves their gentle begins and ends, which single rows do not show in the position's noise: rows next to a move
/// whose means over a window differ from where the piston is held, and one window more, in which a mean would not show
/// them either. A piston that creeps all along is none of these.
fn widen(moving: &mut [bool], position_m: &[f64], noise_m: f64) {
    const WINDOW: usize = 8;
    const DEVIATIONS: f64 = 2.7;
    let parts = ranges(moving);
    for (k, &(first, end, moves)) in parts.iter().enumerate() {
        let half = (end - first) / 2;
        if moves || half < WINDOW {
            continue;
        }
        let limit = DEVIATIONS * noise_m * (1.0 / WINDOW as f64 + 1.0 / half as f64).sqrt();
        let length = |k: usize| parts.get(k).map_or(0, |(first, end, _)| end - first);
        if k > 0 {
            let (level, most) = (mean(&position_m[first + half..end]), half.min(length(k - 1)));
            let off = |i: &usize| (mean(&position_m[first + i..first + i + WINDOW]) - level).abs() > limit;
            let rows = (0..most).take_while(off).count();
            if rows < most {
                moving[first..first + rows + WINDOW].fill(true);
            }
        }
        if k + 1 < parts.len() {
            let (level, most) = (mean(&position_m[first..end - half]), half.min(length(k + 1)));
            let off = |i: &usize| (mean(&position_m[end - i - WINDOW..end - i]) - level).abs() > limit;
            let rows = (0..most).take_while(off).count();
            if rows < most {
                moving[end - rows - WINDOW..end].fill(true);
            }
        }
    }
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
