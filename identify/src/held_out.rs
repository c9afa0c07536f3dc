//! The error on data that took no part in the fit: repeats left out in turn; without repeats, the last third of each
//! record, simulated on from its beginning.
//!
//! A left-out record brings its own initial pressure (and temperature, where it starts in motion): no row is judged by
//! what it helped to find, but each half of a record's rows, in alternating runs, with the initial state that the other
//! half asks for. The mean before the first move alone would be a few rows' noise, several times as large after a push.

use crate::fit::{self, Fit, readings};
use crate::prepare::{Data, Prepared};
use chamber::Chamber;
use chamber::dual::Dual;
use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;

/// One way of leaving data out: the blocks that are fitted, and the rows that are judged.
#[derive(Clone, Debug)]
pub struct Fold {
    /// Leading blocks of each trace that are fitted.
    pub selection: Vec<usize>,
    /// Rows of each trace that are judged: from this row on (all rows: 0; none: the trace's length).
    pub judged_from: Vec<usize>,
}

/// The folds of a rig.
pub fn folds(data: &Data) -> Vec<Fold> {
    let repeats = data.traces.iter().map(|t| t.repeat).max().unwrap_or(0) + 1;
    if repeats > 1 {
        let has_repeats: Vec<bool> =
            (0..data.experiments.len()).map(|e| data.traces.iter().filter(|t| t.experiment == e).count() > 1).collect();
        return (0..repeats)
            .map(|repeat| {
                let out = |t: &Prepared| t.repeat == repeat && has_repeats[t.experiment];
                Fold {
                    selection: data.traces.iter().map(|t| if out(t) { 0 } else { t.blocks.len() }).collect(),
                    judged_from: data.traces.iter().map(|t| if out(t) { 0 } else { t.time_s.len() }).collect(),
                }
            })
            .filter(|f| f.selection.contains(&0) && f.selection.iter().any(|n| *n > 0))
            .collect();
    }
    let cut = |t: &Prepared| 2 * t.time_s.len() / 3;
    vec![Fold {
        selection: data.traces.iter().map(|t| t.blocks.iter().filter(|b| b.end <= cut(t)).count()).collect(),
        judged_from: data.traces.iter().map(cut).collect(),
    }]
}

/// Root mean square of measured − predicted, Pa, over all judged rows of all folds; `None` where a fold cannot be fitted.
pub fn rmse(data: &Data, fitted: &Fit, folds: &[Fold]) -> Option<f64> {
    let mut squares = 0.0;
    let mut rows = 0;
    for fold in folds {
        let h = &fitted.hypothesis;
        let refit = fit::fit(data, h, fitted.globals.clone(), fitted.locals.clone(), &fold.selection).ok()?;
        let chamber = refit.chamber();
        let parts: Option<Vec<(f64, usize)>> = (0..data.traces.len())
            .into_par_iter()
            .filter(|&k| fold.judged_from[k] < data.traces[k].time_s.len())
            .map(|k| {
                let t = &data.traces[k];
                if fold.selection[k] == 0 {
                    return Some((by_other_half(data, &refit, k)?, t.time_s.len()));
                }
                let model = readings(t, &chamber, &refit.locals[k]).ok()?;
                let from = fold.judged_from[k];
                let sum = t.pressure_pa.iter().zip(&model).skip(from).map(|(y, m)| (y - m).powi(2)).sum();
                Some((sum, t.time_s.len() - from))
            })
            .collect();
        for (sum, n) in parts? {
            squares += sum;
            rows += n;
        }
    }
    (rows > 0).then(|| (squares / rows as f64).sqrt())
}

/// Residuals, Pa, of a fit on records of another rig file: the globals stay, each record brings its own initial state
/// (from its rest, or from its first third, which is then left out of the answer).
pub fn on_other(fitted: &Fit, other: &Data) -> Option<Vec<Vec<f64>>> {
    let chamber = fitted.chamber();
    (0..other.traces.len())
        .map(|k| {
            let t = &other.traces[k];
            let (local, from) = if t.starts_at_rest {
                (from_rest(t, &chamber)?, 0)
            } else {
                (first_third(other, fitted, k)?, t.time_s.len() / 3)
            };
            let model = readings(t, &chamber, &local).ok()?;
            Some(t.pressure_pa.iter().zip(&model).skip(from).map(|(y, m)| y - m).collect())
        })
        .collect()
}

/// Σ of squares of a left-out record's residual, each half of its rows with the initial state that the other half asks for.
fn by_other_half(data: &Data, fitted: &Fit, k: usize) -> Option<f64> {
    const RUN: usize = 16;
    let t = &data.traces[k];
    let guess = if t.starts_at_rest { from_rest(t, &fitted.chamber())? } else { first_third(data, fitted, k)? };
    let own: Vec<Dual<2>> = guess.iter().enumerate().map(|(i, x)| Dual::variable(*x, i)).collect();
    let chamber: Chamber<Dual<2>> = fitted.chamber().lift();
    let model = fit::run(t, &chamber, fitted.hypothesis.effects, &own).pressures(&t.time_s).ok()?;
    let length = RUN.max(4 * data.noise.correlation_rows.ceil() as usize);
    let half = |i: usize| (i / length) % 2;
    // Close to the guess the readings are linear in the initial state: one step each.
    let steps: Option<Vec<Vector2<f64>>> = (0..2)
        .map(|other| {
            let (mut square, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for (_, (y, m)) in t.pressure_pa.iter().zip(&model).enumerate().filter(|(i, _)| half(*i) == other) {
                let slope = Vector2::from(m.tangent);
                square += slope * slope.transpose();
                right += slope * (y - m.value);
            }
            if guess.len() == 1 {
                square[(1, 1)] = 1.0;
            }
            Some(square.cholesky()?.solve(&right))
        })
        .collect();
    let steps = steps?;
    let left = |(i, (y, m)): (usize, (&f64, &Dual<2>))| {
        (y - m.value - Vector2::from(m.tangent).dot(&steps[1 - half(i)])).powi(2)
    };
    Some(t.pressure_pa.iter().zip(&model).enumerate().map(left).sum())
}

/// The initial pressure with which the model's mean over the rest is the measured one.
fn from_rest(t: &Prepared, chamber: &Chamber) -> Option<Vec<f64>> {
    let rest = t.course.motion.segments.first().map_or(1, |s| s.end).max(1);
    let model = fit::run(t, chamber, chamber.active(), &[1.0]).pressures(&t.time_s[..rest]).ok()?;
    let ratio = t.pressure_pa[..rest].iter().sum::<f64>() / model.iter().sum::<f64>();
    Some(vec![ratio])
}

/// Locals of a trace that starts in motion, from its first third with the globals held.
fn first_third(data: &Data, fitted: &Fit, k: usize) -> Option<Vec<f64>> {
    let mut held = fitted.hypothesis.clone();
    held.base = fitted.chamber();
    held.axes.clear();
    let cut = data.traces[k].time_s.len() / 3;
    let selection: Vec<usize> = (0..data.traces.len())
        .map(|i| if i == k { data.traces[k].blocks.iter().filter(|b| b.end <= cut).count() } else { 0 })
        .collect();
    let mut locals = fit::fit(data, &held, Vec::new(), fit::first_locals(data), &selection).ok()?.locals;
    Some(locals.swap_remove(k))
}
