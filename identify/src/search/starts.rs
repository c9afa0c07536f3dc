//! Fits of a model with added terms, each from several starts where its error surface has several valleys.

use crate::fit::{self, Descent, Fit, Selection, Until};
use crate::judge::evidence;
use crate::parameters::{Hypothesis, Model, Sizes, first_chamber, is_decay};
use crate::policy::{FIRST_GUESS_REACH, FIRST_LAMBDA0};
use crate::record::data::Data;
use chamber::Chamber;
use chamber::card::{Fitted, Unit};
use chamber::effects::{CARDS, EffectSet, PARAMETER_OFFSETS};
use rayon::prelude::*;

/// Iterations of every trial start, and further ones of those not far above the best, before the best are fitted to the end: few,
/// since each costs as much as one of the final fit.
const TRIAL_ITERATIONS: [usize; 2] = [2, 2];
/// Iterations that determine how large a curve is: its order of magnitude is enough.
const SIZE_ITERATIONS: usize = 4;
/// Number of starts fitted to the end: the best, and a rival that a few iterations do not tell from it.
const STARTS_KEPT: usize = 2;
/// A start is kept beside the best one if its χ² is less than this multiple of the best one's...
const NOT_FAR_BEHIND: f64 = 2.0;
/// ...and differs from it by more than this fraction: otherwise both have reached the same minimum.
const THE_SAME: f64 = 1e-4;

/// Fits `model`, starting from the fit of a part of it: the part's parameters keep their values, the others start anew. If the
/// part has lost λ0, that starts anew too; the better fit counts.
pub fn fit_model(data: &Data, model: Model, part: &Fit, sizes: &Sizes) -> Option<Fit> {
    fit_model_until(data, model, part, sizes, Until::SETTLED)
}

/// The same with other stopping criteria.
pub fn fit_model_until(data: &Data, model: Model, part: &Fit, sizes: &Sizes, until: Until) -> Option<Fit> {
    let bases = bases(data, part, &model).into_par_iter();
    best(bases.filter_map(|base| fit_from(&base, data, model, part, sizes, until)).collect())
}

fn best(fits: Vec<Fit>) -> Option<Fit> {
    fits.into_iter().min_by(|a, b| a.marginal.total_cmp(&b.marginal))
}

/// The chambers from which a model larger than this part starts: the fitted one and, if the paper's model would not start from
/// its λ0, the same with λ0 and dead volume as first guessed. A model that lacks a delay, for instance, fits best without heat
/// transfer, and there nothing shows how the other effects of the gas would help. A first guess with which the gas relaxes from
/// one row to the next is not used: the records would not show it, and its equations would be stiff (times in ms declared as s).
///
/// A secondary parameter that the part had free and the larger model does not free is as its card states it: as found it would be
/// a parameter that is not counted.
fn bases(data: &Data, part: &Fit, model: &Model) -> Vec<Chamber> {
    let not_freed = model.effects.without(model.secondary).iter().filter(|e| CARDS[*e].is_candidate()).collect();
    let known = as_stated(&part.chamber(), not_freed);
    let first = first_chamber(data);
    let shows = |Sizes { relaxation, row, .. }: Sizes| relaxation > row;
    let mut out = vec![known];
    if has_lost_lambda0(&known) && shows(Sizes::of(data, &first)) {
        out.push(Chamber { heat_transfer: first.heat_transfer, geometry: first.geometry, ..known });
    }
    out
}

/// The chamber with the secondary parameters of these effects as their cards state them.
fn as_stated(chamber: &Chamber, effects: EffectSet) -> Chamber {
    let mut stated = *chamber;
    for e in effects.iter() {
        let values = stated.effects.of_mut(e).iter_mut().zip(CARDS[e].parameters);
        values.filter(|(_, p)| p.fitted != Fitted::Always).for_each(|(value, p)| *value = p.neutral);
    }
    stated
}

/// Whether λ0 is farther from its first guess than is likely for a gas in a cylinder.
fn has_lost_lambda0(chamber: &Chamber) -> bool {
    (chamber.heat_transfer.coefficient / FIRST_LAMBDA0).ln().abs() > FIRST_GUESS_REACH
}

fn fit_from(base: &Chamber, data: &Data, model: Model, part: &Fit, sizes: &Sizes, until: Until) -> Option<Fit> {
    let selection = fit::all_blocks(data);
    let begun = trials(base, data, model, part, sizes, &selection);
    let least = begun.first()?.1.chi2;
    let is_kept = |start: &Descent| start.chi2 == least || is_rival(start.chi2, least);
    let kept: Vec<_> = begun.into_iter().filter(|(_, start)| is_kept(start)).take(STARTS_KEPT).collect();
    let fitted =
        |(h, start): (Hypothesis, Descent)| fit::fit_until(data, &h, start.rig, start.records, &selection, until).ok();
    best(kept.into_par_iter().filter_map(fitted).collect())
}

/// Fits `model` where the hypothesis depends on how large its parameters are (the smaller a curve, the straighter it is kept):
/// with the size that a few iterations give them.
pub fn fit_by_size(data: &Data, model: Model, part: &Fit, sizes: &Sizes, until: Until) -> Option<Fit> {
    let selection = fit::all_blocks(data);
    let (h, start) = begun(&part.chamber(), data, model, part, sizes).into_iter().next()?;
    let found = fit::descend(data, &h, start.rig, start.records, &selection, Until::after(SIZE_ITERATIONS)).ok()?;
    let chamber = h.chamber(&found.rig);
    let h = Hypothesis::new(data, model, &chamber, sizes);
    fit::fit_until(data, &h, h.coordinates(&chamber), found.records, &selection, until).ok()
}

/// BIC that `model` would have if the best of its starts achieved the prediction for its first step: a cheap way to choose what
/// to fit.
pub fn predicted_bic(data: &Data, model: Model, part: &Fit, sizes: &Sizes) -> Option<f64> {
    let predicted = |(h, start): (Hypothesis, Descent)| {
        let squares = fit::predicted_squares(data, &h, &start.rig, &start.records)? + fit::smoothed(data, &model);
        Some(evidence::of_squares(squares, part.blocks, h.freedom(0..data.traces.len())))
    };
    let begun = bases(data, part, &model).into_iter().flat_map(|base| begun(&base, data, model, part, sizes));
    begun.collect::<Vec<_>>().into_par_iter().filter_map(predicted).min_by(f64::total_cmp)
}

/// The starts of `model` on a chamber, before any iteration.
fn begun(base: &Chamber, data: &Data, model: Model, part: &Fit, sizes: &Sizes) -> Vec<(Hypothesis, Descent)> {
    let fresh: Vec<usize> = model.effects.iter().filter(|e| !part.hypothesis.model.effects.has(*e)).collect();
    let mut starts = starts(base, &fresh, sizes);
    let freed = model.secondary.iter().filter(|e| !part.hypothesis.model.secondary.has(*e));
    starts.extend(freed.flat_map(|e| exchanged(base, e)));
    let unmoved = |start: &Chamber| {
        let h = Hypothesis::new(data, model, start, sizes);
        let (rig, records) = (h.coordinates(start), record_coordinates(data, &h, part));
        (h, Descent::at(rig, records))
    };
    starts.iter().map(unmoved).collect()
}

/// Whether a start may end in another minimum than the best one, and in a lower one.
fn is_rival(chi2: f64, best: f64) -> bool {
    chi2 > best * (1.0 + THE_SAME) && chi2 < best * NOT_FAR_BEHIND
}

/// The starts of `model` on a chamber after a few iterations, best first; a single one is not iterated.
fn trials(
    base: &Chamber,
    data: &Data,
    model: Model,
    part: &Fit,
    sizes: &Sizes,
    selection: &Selection,
) -> Vec<(Hypothesis, Descent)> {
    let begun = begun(base, data, model, part, sizes);
    if begun.len() == 1 {
        return begun;
    }
    // Trials use one repeat of each experiment only.
    let few: Vec<usize> = data.traces.iter().zip(selection).map(|(t, n)| if t.repeat == 0 { *n } else { 0 }).collect();
    let few = if few.iter().all(|n| *n == 0) { selection.to_vec() } else { few };
    let mut trials = begun;
    for iterations in TRIAL_ITERATIONS {
        trials = trials
            .into_par_iter()
            .filter_map(|(h, start)| {
                let found = fit::descend(data, &h, start.rig, start.records, &few, Until::after(iterations)).ok()?;
                Some((h, found))
            })
            .collect();
        trials.sort_by(|a, b| a.1.chi2.total_cmp(&b.1.chi2));
        let best = trials.first().map_or(0.0, |(_, found)| found.chi2);
        trials.retain(|(_, found)| found.chi2 <= best * NOT_FAR_BEHIND);
    }
    trials
}

/// Starting values of the per-record parameters: what the part has found of them, first guesses for the rest.
pub fn record_coordinates(data: &Data, h: &Hypothesis, part: &Fit) -> Vec<Vec<f64>> {
    data.traces
        .iter()
        .zip(&part.records)
        .map(|(t, known)| {
            let known_axes = part.hypothesis.record_axes(t);
            let found = |slot| known_axes.iter().position(|a| a.slot == slot).map(|i| known[i]);
            let first = h.record_guess(t);
            h.record_axes(t).iter().zip(first).map(|(axis, first)| found(axis.slot).unwrap_or(first)).collect()
        })
        .collect()
}

/// Starting chambers: all combinations of the new effects' parameter starts.
fn starts(base: &Chamber, fresh: &[usize], sizes: &Sizes) -> Vec<Chamber> {
    let mut out = vec![*base];
    for &e in fresh {
        let free: Vec<usize> = CARDS[e].fitted(Fitted::Always).map(|(p, _)| p).collect();
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

/// A chamber for each secondary parameter of an effect that can act like a fitted one of the same unit, with the former in place
/// of the latter. A filter looks like a delay, but the path from one to the other may lead over a hill.
fn exchanged(base: &Chamber, effect: usize) -> Vec<Chamber> {
    let of = |fitted| CARDS[effect].fitted(fitted);
    let pairs = of(Fitted::Always).flat_map(|p| of(Fitted::Secondary).map(move |q| (p, q)));
    pairs
        .filter(|((_, fitted), (_, secondary))| fitted.unit == secondary.unit)
        .map(|((p, fitted), (q, secondary))| {
            let mut chamber = *base;
            let values = chamber.effects.of_mut(effect);
            values[q] = values[p].clamp(*secondary.bounds.start(), *secondary.bounds.end());
            values[p] = fitted.neutral;
            chamber
        })
        .collect()
}

/// Starting values of a parameter. One that changes nothing at a neutral value inside its bounds starts there; one whose neutral
/// value is the lower bound starts above it, at several sizes where a second parameter shapes the same effect. A time starts
/// above it, too, as a digital filter goes only slightly below.
fn parameter_starts(effect: usize, parameter: usize, free: usize, sizes: &Sizes) -> Vec<f64> {
    let p = &CARDS[effect].parameters[parameter];
    let (low, high) = (*p.bounds.start(), *p.bounds.end());
    if p.neutral > low && p.unit != Unit::Second {
        return vec![p.neutral];
    }
    let size = if is_decay(p) { sizes.relaxation } else { sizes.size_of(p.unit, p.typical) };
    let factors: &[f64] = match (free, p.unit) {
        // Decay times: over long before the gas has relaxed, or as long.
        _ if is_decay(p) => &[0.1, 1.0],
        (_, Unit::SecondPerMetre) => &[0.5],
        // Within a row and beyond it: over a time the error has a corner wherever the end of a move passes a row.
        (1, Unit::Second) => &[0.3, 3.0],
        // A single parameter has one valley, which is reached from a small value.
        (1, _) => &[0.1],
        // Of two that shape an effect together: from a light wall to a heavy one...
        (_, Unit::JoulePerKelvin) => &[0.1, 1.0, 10.0],
        // ...from a small fraction to a large one, within 0 and 1...
        (_, Unit::One) => &[0.4, 1.6],
        // ...and from almost no exchange to a fast one, a decade apart.
        (_, _) => &[0.05, 0.5, 5.0],
    };
    factors.iter().map(|f| (f * size).clamp(low, high)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::baseline;
    use crate::synthetic::Recipe;
    use chamber::effects::{GasZones, Leakage};

    #[test]
    fn a_fit_also_starts_from_the_first_guess_where_the_coefficient_of_its_part_is_far_off() {
        let recipe = Recipe::from_seed(5);
        let recipe = recipe.clone().with("leakage", &[recipe.leak_of(1.0)]);
        let (data, mut part) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        assert_eq!(bases(&data, &part, &Model::PAPER).len(), 1);
        part.rig[0] = -12.0;
        let coefficients: Vec<f64> =
            bases(&data, &part, &Model::PAPER).iter().map(|base| base.heat_transfer.coefficient).collect();
        assert_eq!(coefficients, [part.chamber().heat_transfer.coefficient, FIRST_LAMBDA0]);
        let leak = Model::with(Leakage::SET);
        let sizes = Sizes::of(&data, &first_chamber(&data));
        let found = fit_model(&data, leak, &part, &sizes).unwrap().chamber().heat_transfer.coefficient;
        let truth = recipe.chamber.heat_transfer.coefficient;
        assert!((found / truth - 1.0).abs() < 0.05, "{found} against {truth}");
    }

    #[test]
    fn a_larger_set_does_not_keep_a_secondary_parameter_that_only_its_part_needed() {
        let (leakage, zones) = (Leakage::INDEX, GasZones::INDEX);
        let mut recipe = Recipe::from_seed(5);
        recipe.chamber.effects.of_mut(leakage)[0] = 2e-11;
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let sizes = Sizes::of(&data, &first_chamber(&data));
        let leak = EffectSet::one(leakage);
        let part = fit_model(&data, Model::with(leak), &paper, &sizes).unwrap();
        let both = Model::with(leak.union(EffectSet::one(zones)));
        let right = fit_model(&data, both, &part, &sizes).unwrap().marginal;
        let mut wrong = part;
        wrong.hypothesis.base.effects.of_mut(leakage)[1] = 0.8;
        assert_eq!(
            bases(&data, &wrong, &both).iter().map(|base| base.effects.of(leakage)[1]).collect::<Vec<_>>(),
            [0.3]
        );
        let found = fit_model(&data, both, &wrong, &sizes).unwrap();
        assert_eq!(found.chamber().effects.of(leakage)[1], 0.3);
        assert!(found.marginal < 1.001 * right, "{} {right}", found.marginal);
    }

    #[test]
    fn a_fit_does_not_start_where_the_gas_relaxes_within_a_row() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        let lost = |recipe: &Recipe| {
            let (data, mut part) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
            part.rig[0] = -12.0;
            bases(&data, &part, &Model::PAPER).len()
        };
        assert_eq!(lost(&recipe), 2);
        recipe.faults.time_unit = 1e3;
        assert_eq!(lost(&recipe), 1);
    }
}
