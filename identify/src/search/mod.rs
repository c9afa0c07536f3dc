//! From a rig's residual to the terms that explain it, or to the statement that none of the known ones does.
//!
//! The paper's model is fitted, its residual gives the recording's noise, and the search begins: every term alone, then the
//! better sets with every further term (a beam of all sets and one of those without terms of single records; those are fitted
//! whose first step promises most) and, where none helps alone, with two of them, until what is left is adequate, nothing
//! enters, or [`policy::MOST_TERMS`] are in. A term is an effect of the rig, an effect of the recording that each record has for
//! itself, or initial temperatures. It enters by decisive evidence and a lower error on left-out data; at the end each has to be
//! decisive beside the others and with the geometry far more uncertain than stated, or it goes out again. Where that leaves
//! more than noise, the missing term is read off the residual as a curve ([`curve`]).

pub mod baseline;
mod conclude;
pub mod curve;
mod fold;
pub mod starts;
pub mod terms;

use crate::error::Error;
use crate::fit::{self, Fit, covariance};
use crate::judge::adequacy::{self, Adequacy};
use crate::judge::evidence::{self, bic};
use crate::judge::left_out::{self, Fold};
use crate::judge::{misfit, sanity};
use crate::parameters::{Model, Sizes};
use crate::policy;
use crate::record::prepare::Data;
use crate::record::{colour, outliers};
use chamber::effects::{CARDS, EffectSet};
use curve::ReadOff;
use rayon::prelude::*;
pub use records::Verdict;
use starts::fit_model;

/// A model that was fitted.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Terms that it has beyond the paper's model.
    pub model: Model,
    /// Best parameters and the linearised problem there.
    pub fit: Fit,
    /// BIC of the paper's model less its own.
    pub delta_bic: f64,
    /// Error on left-out data, Pa, where it was judged.
    pub held_out_pa: Option<f64>,
}

/// All that the search found.
#[derive(Clone, Debug)]
pub struct Found {
    /// How it ended.
    pub verdict: Verdict,
    /// The paper's model.
    pub baseline: Candidate,
    /// What it leaves.
    pub baseline_adequacy: Adequacy,
    /// Every model tried, best evidence first.
    pub tried: Vec<Candidate>,
    /// The model to go on with; the paper's where nothing entered.
    pub chosen: Candidate,
    /// What that leaves.
    pub chosen_adequacy: Adequacy,
    /// The way to the chosen model, the paper's first, each with one term more.
    pub steps: Vec<Candidate>,
    /// Models with as many terms as the chosen one that the data cannot tell from it.
    pub alike: Vec<Model>,
    /// Whether what the records have for themselves follows the kind of test: see [`crate::judge::kinds`].
    pub follows_the_test: bool,
    /// An effect that would enter only with the geometry exactly as stated.
    pub by_geometry: Option<EffectSet>,
    /// The missing term as a curve, where no name fits.
    pub read_off: Option<ReadOff>,
}

/// Searches. `progress` is told what is being done and how far it is. The data come back with outliers left out and the noise as
/// the best model shows it.
///
/// # Errors
/// Where the data contradict the model in a way that has a name: see [`sanity`].
pub fn search(data: Data, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<(Data, Found), Error> {
    progress("fitting the paper's model", 0.0);
    let (data, baseline) = baseline::fitted(data)?;
    let adequacy = adequacy::test(&data, &baseline);
    if !adequacy.is_adequate() {
        sanity::reference(&data, &baseline)?;
    }
    let mut search = Search::new(data, baseline, adequacy);
    progress("one term at a time", 0.1);
    search.first_round();
    search.refuse_hopeless()?;
    search.settle();
    search.fold();
    let mut level = 1;
    while search.goes_on(level) {
        progress("further terms", 0.1 + 0.8 * (level + 1) as f64 / (1 + policy::MOST_IN_ALL) as f64);
        if !search.round(level) && !search.describes() {
            break;
        }
        search.settle();
        search.fold();
        level = (level + 1).max(search.chosen.model.terms());
    }
    progress("checking what was found", 0.9);
    let found = search.conclude()?;
    progress("done", 1.0);
    Ok(found)
}

struct Search {
    data: Data,
    sizes: Sizes,
    folds: Vec<Fold>,
    baseline: Candidate,
    baseline_adequacy: Adequacy,
    tried: Vec<Candidate>,
    chosen: Candidate,
    chosen_adequacy: Adequacy,
    steps: Vec<Candidate>,
}

impl Search {
    fn new(data: Data, baseline: Fit, adequacy: Adequacy) -> Self {
        let sizes = Sizes::of(&data, &baseline.chamber());
        let folds = left_out::folds(&data);
        let mut baseline = Candidate { model: Model::PAPER, fit: baseline, delta_bic: 0.0, held_out_pa: None };
        baseline.held_out_pa = left_out::rmse(&data, &baseline.fit, &folds);
        Self {
            sizes,
            folds,
            tried: Vec::new(),
            chosen: baseline.clone(),
            chosen_adequacy: adequacy.clone(),
            steps: vec![baseline.clone()],
            baseline,
            baseline_adequacy: adequacy,
            data,
        }
    }

    /// Every term alone.
    fn first_round(&mut self) {
        let models = terms::added_to(&self.data, &Model::PAPER);
        let mut singles = self.fit_all(&models);
        let best = singles.first().filter(|c| c.delta_bic > policy::DECISIVE).map(|c| c.fit.clone());
        if best.is_some_and(|best| self.weighs_anew(&best)) {
            singles = self.refitted(&singles);
        }
        let strongest = singles.len().min(policy::PAIRED);
        singles[..strongest].par_iter_mut().for_each(|single| {
            if let Some(freed) = self.freed(single) {
                *single = freed;
            }
        });
        sort(&mut singles);
        self.judge(&mut singles, usize::MAX);
        self.tried = singles;
        self.take_best(self.tried.clone());
    }

    /// Refuses a coefficient that no single term brings near to one that a gas in a cylinder can have: with a wrong unit of time
    /// the search would go on to the end with ever larger sets.
    fn refuse_hopeless(&self) -> Result<(), Error> {
        let far = policy::FIRST_GUESS_REACH.exp();
        let (least, most) = (*policy::PLAUSIBLE_COEFFICIENT.start() / far, *policy::PLAUSIBLE_COEFFICIENT.end() * far);
        let is_near = |c: &Candidate| (least..most).contains(&c.fit.chamber().heat_transfer.coefficient);
        match self.tried.iter().chain([&self.baseline]).any(is_near) {
            true => Ok(()),
            false => sanity::coefficient(&self.data, &self.baseline.fit),
        }
    }

    /// Whether a further term than the sets of this many is worth looking for.
    fn goes_on(&self, level: usize) -> bool {
        let model = &self.chosen.model;
        if level > policy::MOST_IN_ALL {
            return false;
        }
        if self.chosen_adequacy.is_adequate() {
            // One more round where a term has entered, as another one may be hidden behind it; and while what single records
            // have for themselves may stand for effects of the rig.
            return (level == 1 && model.terms() == 1) || model.has_terms_of_records();
        }
        // Next to nothing, and less than noise: there the interpolation of a stroke counts that is taken back from an average or
        // a low-pass.
        let is_next_to_nothing = self.chosen_adequacy.systematic_pa < self.data.noise.total_pa()
            && self.chosen_adequacy.settles(&self.baseline_adequacy);
        !(terms::takes_back_the_stroke(model) && is_next_to_nothing)
    }

    /// The better sets of so many terms, each with every further term; whether that led on: a set entered, or those without
    /// terms of single records became so much better that they may enter yet.
    fn round(&mut self, level: usize) -> bool {
        let chosen = self.chosen.model;
        let enough = self.chosen_adequacy.is_adequate() && !chosen.has_terms_of_records();
        let parts = if enough { vec![chosen] } else { self.beam(level) };
        let mut models: Vec<Model> = parts.iter().flat_map(|part| terms::added_to(&self.data, part)).collect();
        if level == 1 && !enough {
            models.extend(terms::pairs(&self.best_of(level, policy::PAIRED, |_| true), &Model::PAPER));
        }
        let of_rig = self.best_of_rig();
        if self.try_all(models) {
            return true;
        }
        if enough || chosen.terms() == 0 {
            return false;
        }
        // None of them helps alone: the better ones two by two.
        let more = self.best_of(chosen.terms() + 1, policy::PAIRED, |m| terms::is_part(&chosen, m));
        self.try_all(terms::pairs(&more, &chosen)) || self.catches_up(self.best_of_rig() - of_rig, level + 1)
    }

    /// Whether sets of the rig's effects, whose evidence grew by `gain` with the last of so many terms, may come to that of the
    /// chosen one: if each further term gains as much, where later ones mostly gain less.
    fn catches_up(&self, gain: f64, terms: usize) -> bool {
        let further = policy::MOST_IN_ALL.saturating_sub(terms) as f64;
        gain > policy::DECISIVE && self.best_of_rig() + further * gain > self.chosen.delta_bic
    }

    /// Sets of so many terms that go on: the chosen one and the best, and the best of those without terms of single records,
    /// which fit much and would crowd the rig's effects out.
    fn beam(&self, level: usize) -> Vec<Model> {
        let mut parts = vec![self.chosen.model];
        parts.retain(|chosen| chosen.terms() == level);
        parts.extend(self.best_of(level, policy::GO_ON, |_| true));
        parts.extend(self.best_of(level, policy::GO_ON, |m| !m.has_terms_of_records()));
        distinct(parts)
    }

    /// The best sets of so many terms.
    fn best_of(&self, terms: usize, most: usize, suits: impl Fn(&Model) -> bool) -> Vec<Model> {
        let leads_on = |c: &&Candidate| c.delta_bic > 0.0 && c.fit.exhausted().is_none();
        let sets = self.tried.iter().filter(|c| c.model.terms() == terms).filter(leads_on).map(|c| c.model);
        distinct(sets.filter(suits).collect()).into_iter().take(most).collect()
    }

    /// Evidence of the best set without terms of single records.
    fn best_of_rig(&self) -> f64 {
        let is_of_rig = |c: &&Candidate| !c.model.has_terms_of_records() && c.fit.exhausted().is_none();
        self.tried.iter().find(is_of_rig).map_or(0.0, |c| c.delta_bic)
    }

    /// Those whose first step promises the best evidence, with terms of single records and without.
    fn promising(&self, models: Vec<Model>) -> Vec<Model> {
        let promised =
            |model: Model| Some((starts::promised_bic(&self.data, model, self.part_of(&model), &self.sizes)?, model));
        let mut promised: Vec<(f64, Model)> = models.into_par_iter().filter_map(promised).collect();
        promised.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (of_records, of_rig): (Vec<Model>, Vec<Model>) =
            promised.into_iter().map(|(_, model)| model).partition(Model::has_terms_of_records);
        [of_records, of_rig].into_iter().flat_map(|models| models.into_iter().take(policy::FITTED)).collect()
    }

    /// Fits the promising of those that were not tried yet; whether one of them entered.
    fn try_all(&mut self, models: Vec<Model>) -> bool {
        let mut fresh: Vec<Model> = Vec::new();
        for model in models {
            let is_new = !fresh.contains(&model) && self.tried.iter().all(|c| c.model != model);
            if is_new && terms::is_small(&model, 0) {
                fresh.push(model);
            }
        }
        let found = self.fit_all(&self.promising(fresh));
        let (mut found, exhausting): (Vec<Candidate>, _) = found.into_iter().partition(|c| c.fit.exhausted().is_none());
        self.judge(&mut found, policy::JUDGED);
        self.tried.extend(found.iter().cloned().chain(exhausting));
        sort(&mut self.tried);
        self.take_best(found)
    }

    /// Lets the best of these enter that may; whether one did.
    fn take_best(&mut self, mut candidates: Vec<Candidate>) -> bool {
        candidates.retain(|c| c.fit.exhausted().is_none());
        self.take_best_of(candidates)
    }

    /// Where nothing else leads on and more than noise is left: lets the best set enter that has nearly exhausted an effect.
    /// It describes the records; that effect is not their cause.
    fn describes(&mut self) -> bool {
        if self.chosen_adequacy.is_adequate() {
            return false;
        }
        let mut better = self.tried.clone();
        better.retain(|c| c.fit.exhausted().is_some() && c.delta_bic > self.chosen.delta_bic + policy::DECISIVE);
        self.judge(&mut better, policy::JUDGED);
        for c in &better {
            self.tried.iter_mut().filter(|t| t.model == c.model).for_each(|t| t.held_out_pa = c.held_out_pa);
        }
        self.take_best_of(better)
    }

    fn take_best_of(&mut self, mut candidates: Vec<Candidate>) -> bool {
        let among = candidates.len().max(2) as f64;
        candidates.retain(|c| self.enters(c, among));
        sort(&mut candidates);
        let Some(highest) = candidates.first().map(|c| c.delta_bic) else { return false };
        candidates.retain(|c| c.delta_bic > highest - policy::DECISIVE);
        // Which of those next to each other is best may show with their secondary parameters free only.
        let freed: Vec<Candidate> = candidates.par_iter().filter_map(|c| self.freed(c)).collect();
        self.tried.extend(freed.iter().cloned());
        sort(&mut self.tried);
        candidates.extend(freed);
        sort(&mut candidates);
        let Some(best) = candidates.into_iter().next() else { return false };
        self.chosen_adequacy = adequacy::test(&self.data, &best.fit);
        self.steps.push(best.clone());
        self.chosen = best;
        true
    }

    /// Decisive evidence over the chosen model, left-out data predicted better by more than nobody minds, and numbers that can
    /// be the rig's.
    fn enters(&self, c: &Candidate, among: f64) -> bool {
        let over = &self.chosen;
        // Effects of the rig in the place of what single records have for themselves need not predict better, only no worse.
        let in_place = over.model.has_terms_of_records() && !c.model.has_terms_of_records();
        let least_gain = if in_place { 0.0 } else { self.least_gain() };
        let lower = match over.held_out_pa {
            Some(_) => self.errs_less_on_left_out(c, least_gain),
            None => c.held_out_pa.is_some(),
        };
        lower && c.delta_bic - over.delta_bic > policy::DECISIVE + among.ln() && is_credible(&c.fit)
    }

    /// Whether a model takes more than this error, Pa, off that of the chosen one on left-out data.
    fn errs_less_on_left_out(&self, c: &Candidate, least_gain: f64) -> bool {
        let (Some(a), Some(b)) = (c.held_out_pa, self.chosen.held_out_pa) else { return false };
        b * b - a * a > least_gain.powi(2)
    }

    /// The error that a term has to take off left-out data, Pa: what matters, or half the power of all that is systematic.
    fn least_gain(&self) -> f64 {
        self.data.accuracy_pa().min(self.chosen_adequacy.systematic_pa * 0.5f64.sqrt())
    }

    /// The same set with its secondary parameters free, where that is decisively better.
    fn freed(&self, c: &Candidate) -> Option<Candidate> {
        let model = Model { secondary: c.model.of_rig(), ..c.model };
        let has_secondary = |e: usize| CARDS[e].parameters.iter().any(|p| !p.fitted);
        if model == c.model || !model.secondary.iter().any(has_secondary) {
            return None;
        }
        let fit = fit_model(&self.data, model, &c.fit, &self.sizes)?;
        if fit.hypothesis.axes.len() == c.fit.hypothesis.axes.len() || bic(&c.fit) - bic(&fit) < policy::DECISIVE {
            return None;
        }
        Some(self.judged(self.candidate(fit)))
    }

    fn candidate(&self, fit: Fit) -> Candidate {
        Candidate {
            model: fit.hypothesis.model,
            delta_bic: bic(&self.baseline.fit) - bic(&fit),
            fit,
            held_out_pa: None,
        }
    }

    fn judged(&self, mut c: Candidate) -> Candidate {
        self.hold_out(&mut c);
        c
    }

    /// Judges a candidate by data left out, unless that was done.
    fn hold_out(&self, c: &mut Candidate) {
        if c.held_out_pa.is_none() {
            c.held_out_pa = left_out::rmse(&self.data, &c.fit, &self.folds);
        }
    }

    /// Judges the first so many of those that may enter by data left out.
    fn judge(&self, candidates: &mut [Candidate], most: usize) {
        let may_enter: Vec<&mut Candidate> = candidates.iter_mut().filter(|c| is_credible(&c.fit)).take(most).collect();
        may_enter.into_par_iter().for_each(|c| self.hold_out(c));
    }

    /// Fits each model from the largest part of it that is there; best evidence first.
    fn fit_all(&self, models: &[Model]) -> Vec<Candidate> {
        let mut out: Vec<Candidate> = models
            .par_iter()
            .filter_map(|model| fit_model(&self.data, *model, self.part_of(model), &self.sizes))
            .map(|fit| self.candidate(fit))
            .collect();
        sort(&mut out);
        out
    }

    fn part_of(&self, model: &Model) -> &Fit {
        let known = self.tried.iter().chain([&self.chosen]).filter(|c| terms::is_part(&c.model, model));
        known
            .min_by_key(|c| (usize::MAX - c.model.terms(), c.fit.marginal as u64))
            .map_or(&self.baseline.fit, |c| &c.fit)
    }

    /// Begins again with the outliers and the noise that this fit leaves and, where its records are moving averages, without what
    /// these leave open of the moves; whether that is other data. The paper's model is then fitted anew.
    fn weighs_anew(&mut self, best: &Fit) -> bool {
        let Some(data) = self.as_shown_by(best, true) else { return false };
        self.begin_again(data);
        true
    }

    /// The data as a fit shows them, with the noise that it leaves where it tells that; `None` where that is as they are taken.
    fn as_shown_by(&self, fit: &Fit, tells_noise: bool) -> Option<Data> {
        let residuals = misfit::residuals(&self.data, fit);
        let found = outliers::in_residuals(&self.data, &residuals);
        let mut other = self.data.looked_at(&fit.looks(&self.data));
        if !self.data.is_without(&found) {
            other = Some(other.unwrap_or_else(|| self.data.clone()).without(&found));
        }
        if tells_noise {
            let data = other.as_ref().unwrap_or(&self.data);
            let noise = colour::estimate(data, &residuals, &data.noise);
            if !baseline::is_alike(&noise, &data.noise) {
                other = Some(other.unwrap_or_else(|| self.data.clone()).with_noise(noise));
            }
        }
        other
    }

    /// Begins again with the data as the chosen model shows them, in whatever round that was found: without what the moves leave
    /// open where the records are averages, without its outliers, and with the noise that it leaves where it has found when each
    /// record was read. Before, repeats that are read at different times differ by more than noise. All that was tried is fitted
    /// anew.
    fn settle(&mut self) {
        let has_own_times = self.chosen.model.own.iter().any(|e| terms::of_timing().has(e));
        let Some(data) = self.as_shown_by(&self.chosen.fit, has_own_times) else { return };
        self.begin_again(data);
        let mut tried = self.refitted(&self.tried);
        self.judge(&mut tried, policy::FITTED);
        self.tried = tried;
        self.take_best(self.tried.clone());
    }

    /// Fits the paper's model to data with other weights, and begins the search with it.
    fn begin_again(&mut self, data: Data) {
        self.data = data;
        // Without other outliers there are other blocks.
        self.folds = left_out::folds(&self.data);
        let fit = self.refit(&self.baseline.fit).unwrap_or_else(|| self.baseline.fit.clone());
        self.baseline_adequacy = adequacy::test(&self.data, &fit);
        self.baseline = self.judged(Candidate { fit, held_out_pa: None, ..self.baseline.clone() });
        self.chosen = self.baseline.clone();
        self.chosen_adequacy = self.baseline_adequacy.clone();
        self.steps = vec![self.baseline.clone()];
    }

    fn refit(&self, fit: &Fit) -> Option<Fit> {
        fit::fit(&self.data, &fit.hypothesis, fit.rig.clone(), fit.own.clone(), &fit::all_blocks(&self.data)).ok()
    }

    fn refitted(&self, candidates: &[Candidate]) -> Vec<Candidate> {
        let again: Vec<Candidate> =
            candidates.par_iter().filter_map(|c| Some(self.candidate(self.refit(&c.fit)?))).collect();
        let mut out: Vec<Candidate> = again.par_iter().map(|c| self.no_worse_than_a_part(c, &again)).collect();
        sort(&mut out);
        out
    }

    /// A candidate, begun anew from the best of its parts among the others where that fits better: with other weights of the
    /// data the part may have gone on to a lower valley, and the candidate have stayed where it was.
    fn no_worse_than_a_part(&self, c: &Candidate, others: &[Candidate]) -> Candidate {
        let squares = |c: &Candidate| evidence::of_squares(c.fit.marginal, c.fit.blocks, 0);
        let is_part = |part: &&Candidate| part.model != c.model && terms::is_part(&part.model, &c.model);
        let parts = others.iter().chain([&self.baseline]).filter(is_part);
        parts
            .min_by(|a, b| a.fit.marginal.total_cmp(&b.fit.marginal))
            .filter(|part| squares(c) - squares(part) > policy::INDISTINGUISHABLE)
            .and_then(|part| fit_model(&self.data, c.model, &part.fit, &self.sizes))
            .filter(|fit| fit.marginal < c.fit.marginal)
            .map_or_else(|| c.clone(), |fit| self.candidate(fit))
    }
}

/// Whether a fit has come to a minimum with numbers that can be the rig's: a λ0 that the records determine (it is what they
/// are for), and no fault of the recording so large that it has another cause.
fn is_credible(fit: &Fit) -> bool {
    fit.converged && !fit.is_beyond_belief() && determines_lambda0(fit)
}

/// Whether the records tell λ0 better than its first guess does.
fn determines_lambda0(fit: &Fit) -> bool {
    covariance::covariance(fit, false)[(0, 0)].sqrt() < policy::FIRST_GUESS_REACH
}

/// The first of the models with the same terms.
fn distinct(models: Vec<Model>) -> Vec<Model> {
    let mut out: Vec<Model> = Vec::new();
    for model in models {
        let terms = |m: &Model| Model { secondary: EffectSet::NONE, ..*m };
        if out.iter().all(|other| terms(other) != terms(&model)) {
            out.push(model);
        }
    }
    out
}

fn sort(candidates: &mut [Candidate]) {
    candidates.sort_by(|a, b| b.delta_bic.total_cmp(&a.delta_bic));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Recipe;
    use chamber::effects::find;
    use std::sync::atomic::{AtomicBool, Ordering};

    #[test]
    fn a_set_that_ends_worse_than_its_part_is_begun_anew_from_that() {
        let data = Data::prepare(&Recipe::from_seed(5).rig()).unwrap();
        let (data, paper) = baseline::fitted(data).unwrap();
        let adequacy = adequacy::test(&data, &paper);
        let search = Search::new(data, paper, adequacy);
        let model = Model::with(EffectSet::one(find("leakage").unwrap().0));
        let fit = fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap();
        let good = search.candidate(fit);
        assert_eq!(search.no_worse_than_a_part(&good, &[]).fit.marginal, good.fit.marginal);
        let mut stuck = good.clone();
        stuck.fit.marginal *= 2.0;
        let anew = search.no_worse_than_a_part(&stuck, &[]);
        assert!((anew.fit.marginal / good.fit.marginal - 1.0).abs() < 1e-6);
    }

    #[test]
    fn times_in_ms_declared_as_s_are_refused_before_larger_sets_are_tried() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.tests.truncate(1);
        recipe.faults.time_unit = 1e3;
        let goes_on = AtomicBool::new(false);
        let watch = |what: &str, _: f64| {
            goes_on.fetch_or(what == "further terms", Ordering::Relaxed);
        };
        let error = search(Data::prepare(&recipe.rig()).unwrap(), &watch);
        assert!(matches!(error, Err(Error::ImplausibleCoefficient { .. })));
        assert!(!goes_on.into_inner());
    }

    /// A search after its first fit, and a set with gas zones of which next to all gas is in the core, much better than the rest.
    fn search_with_exhausted_zones() -> (Search, Candidate) {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.chamber.effects.of_mut(find("natural_convection").unwrap().0)[0] = 0.4;
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let adequacy = adequacy::test(&data, &paper);
        assert!(!adequacy.is_adequate());
        let search = Search::new(data, paper, adequacy);
        let model = Model::with(EffectSet::one(find("gas_zones").unwrap().0));
        let fit = fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap();
        assert_eq!(fit.exhausted(), None);
        let mut zones = search.candidate(fit);
        let fraction = zones.fit.rig.len() - 2;
        zones.fit.rig[fraction] = 0.94 / zones.fit.hypothesis.axes[fraction].scale;
        (zones.delta_bic, zones.held_out_pa) = (1e6, Some(0.0));
        (search, zones)
    }

    #[test]
    fn an_effect_that_is_nearly_exhausted_has_a_name_and_one_that_is_off_or_without_influence_has_none() {
        let (_, mut zones) = search_with_exhausted_zones();
        assert_eq!(zones.fit.exhausted().map(|slot| slot.name()), Some("gas_zones.mass_fraction".to_owned()));
        let (fraction, conductance) = (zones.fit.rig.len() - 2, zones.fit.rig.len() - 1);
        zones.fit.rig[fraction] = 0.0;
        zones.fit.rig[conductance] = zones.fit.hypothesis.axes[conductance].bounds[1];
        assert_eq!(zones.fit.exhausted(), None);
    }

    #[test]
    fn a_set_that_has_nearly_exhausted_an_effect_enters_only_to_describe_what_nothing_else_does() {
        let (mut search, zones) = search_with_exhausted_zones();
        assert!(!search.take_best(vec![zones.clone()]));
        search.tried = vec![zones.clone()];
        assert!(search.best_of(1, 1, |_| true).is_empty());
        assert!(search.describes());
        assert_eq!(search.chosen.model, zones.model);
        assert_ne!(search.verdict(false), Verdict::Explained);

        let (mut search, zones) = search_with_exhausted_zones();
        search.tried = vec![zones];
        search.chosen_adequacy = Adequacy { is_good_enough: true, ..search.chosen_adequacy };
        assert!(search.chosen_adequacy.is_adequate() && !search.describes());
    }

    #[test]
    fn a_fault_at_the_end_of_its_prior_is_beyond_belief_and_one_that_is_not_there_is_not() {
        let data = Data::prepare(&Recipe { repeats: 1, ..Recipe::from_seed(5) }.rig()).unwrap();
        let (data, paper) = baseline::fitted(data).unwrap();
        let sizes = Sizes::of(&data, &paper.chamber());
        for (name, ends) in [("sensor_offset", [true, true]), ("position_delay", [false, true])] {
            let model = Model::with(EffectSet::one(find(name).unwrap().0));
            let mut fit = fit_model(&data, model, &paper, &sizes).unwrap();
            assert!(!fit.is_beyond_belief(), "{name}");
            let last = fit.rig.len() - 1;
            for (end, is_beyond) in fit.hypothesis.axes[last].bounds.into_iter().zip(ends) {
                fit.rig[last] = end;
                assert_eq!(fit.is_beyond_belief(), is_beyond, "{name} {end}");
            }
        }
    }
}
