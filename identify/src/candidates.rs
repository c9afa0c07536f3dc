//! Fits of the paper's model with effects added, each from several starts where its error surface has several valleys.

use crate::fit::{self, Fit, Selection};
use crate::hypothesis::{Hypothesis, Sizes};
use crate::prepare::Data;
use chamber::Chamber;
use chamber::card::Unit;
use chamber::effects::{CARDS, EffectSet, PARAMETER_OFFSETS};
use rayon::prelude::*;

/// Iterations of a trial start before the best go on.
const TRIAL_ITERATIONS: usize = 4;
/// How many starts go on to the end.
const GO_ON: usize = 2;

/// Fits `set`, beginning from the fit of a part of it: what the part has keeps its values, the rest starts anew.
pub fn fit_set(data: &Data, set: EffectSet, part: &Fit, sizes: &Sizes, selection: &Selection) -> Option<Fit> {
    let base = part.chamber();
    let fresh: Vec<usize> = set.iter().filter(|e| !part.hypothesis.effects.has(*e)).collect();
    let starts = starts(&base, &fresh, sizes);
    let hypothesis = Hypothesis::new(data, set, &base, sizes);
    if starts.len() == 1 {
        return fit::fit(data, &hypothesis, hypothesis.coordinates(&starts[0]), part.locals.clone(), selection).ok();
    }
    // Trials see one repeat of each experiment only.
    let few: Vec<usize> = data.traces.iter().zip(selection).map(|(t, n)| if t.repeat == 0 { *n } else { 0 }).collect();
    let few = if few.iter().all(|n| *n == 0) { selection.to_vec() } else { few };
    let mut trials: Vec<Fit> = starts
        .par_iter()
        .filter_map(|start| {
            let x = hypothesis.coordinates(start);
            fit::fit_with(data, &hypothesis, x, part.locals.clone(), &few, TRIAL_ITERATIONS).ok()
        })
        .collect();
    trials.sort_by(|a, b| a.chi2.total_cmp(&b.chi2));
    trials
        .into_iter()
        .take(GO_ON)
        .filter_map(|trial| fit::fit(data, &hypothesis, trial.globals, part.locals.clone(), selection).ok())
        .min_by(|a, b| a.chi2.total_cmp(&b.chi2))
}

/// Chambers to begin from: all combinations of the fresh effects' parameter starts.
fn starts(base: &Chamber, fresh: &[usize], sizes: &Sizes) -> Vec<Chamber> {
    let mut out = vec![*base];
    for &e in fresh {
        let free: Vec<usize> = (0..CARDS[e].parameters.len()).filter(|&p| CARDS[e].parameters[p].fitted).collect();
        for &p in &free {
            let values = parameter_starts(e, p, free.len(), sizes);
            out = out
                .iter()
                .flat_map(|chamber| {
                    values.iter().map(move |v| {
                        let mut c = *chamber;
                        c.effects.0[PARAMETER_OFFSETS[e] + p] = *v;
                        c
                    })
                })
                .collect();
        }
    }
    out
}

/// A parameter that changes nothing at a neutral value inside its bounds starts there; one whose neutral value is the
/// lower bound starts above it, at several sizes where a second parameter shapes the same effect.
fn parameter_starts(effect: usize, parameter: usize, free: usize, sizes: &Sizes) -> Vec<f64> {
    let p = &CARDS[effect].parameters[parameter];
    let (low, high) = (*p.bounds.start(), *p.bounds.end());
    if p.neutral > low {
        return vec![p.neutral];
    }
    let size = sizes.size_of(p.unit, p.typical);
    let factors: &[f64] = match (free, p.unit) {
        (1, Unit::Second) => &[0.3, 3.0],
        (1, _) => &[0.1],
        (_, Unit::JoulePerKelvin) => &[0.1, 1.0, 10.0],
        (_, Unit::One) => &[0.4, 1.6],
        (_, _) => &[0.05, 0.5, 5.0],
    };
    factors.iter().map(|f| (f * size).clamp(low, high)).collect()
}
