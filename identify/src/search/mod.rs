//! Searches for the terms that explain a rig's residual, or states that none of the known ones does.
//!
//! The paper's model is fitted, its residual gives the recording's noise, and the search begins: every term alone, then the
//! better sets with every further term (one beam of all sets and one of those without per-record terms; sets are fitted if
//! their first step is predicted to remove most), pairs of the better ones, and each effect beside a delay. It ends where what
//! is left is adequate or next to nothing, where nothing enters and no set of the rig's effects can reach the chosen set's
//! evidence, or at sets of [`policy::MOST_IN_ALL`] terms. A term is an effect of the rig, a per-record effect of the
//! recording, or initial temperatures of gas or wall. It enters by decisive evidence and a lower error on left-out data
//! (`entry`). Per-record effects may become one effect of the rig (`pooling`), and data are reweighted as better models show
//! their noise (`reweighting`). At the end each term must be decisive beside the others, also with the stated parameters far
//! more uncertain than stated, or it is removed (`needed`). Where more than noise is left, the missing term is fitted to the
//! residual as a curve (`curve`).

mod alike;
mod at_zero;
pub mod baseline;
mod conclude;
mod contradictions;
pub(crate) mod curve;
mod early;
mod entry;
mod faulty_record;
mod in_gas;
mod moved;
mod needed;
mod pooling;
pub mod reweighting;
pub mod starts;
pub(crate) mod terms;
mod verdict;

use crate::error::Error;
use crate::fit::{Fit, Until};
use crate::judge::adequacy::{self, Adequacy};
use crate::judge::evidence::bic;
use crate::judge::left_out::{self, Fold, HeldOut};
use crate::judge::misfit;
use crate::judge::sanity;
use crate::parameters::{Model, Sizes};
use crate::policy;
use crate::record::data::Data;
use chamber::effects::EffectSet;
use curve::CurveFit;
use rayon::prelude::*;
pub use records::Verdict;
use starts::fit_model_until;

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Terms beyond the paper's model.
    pub model: Model,
    /// Best parameters and the linearised problem there.
    pub fit: Fit,
    /// BIC of the paper's model minus its own.
    pub delta_bic: f64,
    /// Error on left-out data, where it was judged.
    pub held_out: Option<HeldOut>,
}

impl Candidate {
    /// Error on left-out data as reported, Pa rms, where it was judged.
    pub fn held_out_pa(&self) -> Option<f64> {
        self.held_out.map(|error| error.rmse_pa)
    }

    /// Whether its error on left-out data is smaller than the other candidate's by more than `by_pa`, Pa.
    fn errs_less(&self, than: &Self, by_pa: f64) -> bool {
        self.held_out.zip(than.held_out).is_some_and(|(ours, theirs)| ours.is_less(&theirs, by_pa))
    }

    /// Whether its weighted error on left-out data is larger than the other candidate's by more than `by_pa`, Pa.
    fn errs_more(&self, than: &Self, by_pa: f64) -> bool {
        self.held_out.zip(than.held_out).is_some_and(|(ours, theirs)| ours.is_more(&theirs, by_pa))
    }
}

/// Result of a search.
#[derive(Clone, Debug)]
pub struct Found {
    /// How far the final model accounts for the records.
    pub verdict: Verdict,
    /// The paper's model.
    pub baseline: Candidate,
    /// What the model of the paper leaves, tested against noise and accuracy.
    pub baseline_adequacy: Adequacy,
    /// Every model tried, best evidence first, except that an accepted curve precedes all others.
    pub tried: Vec<Candidate>,
    /// The final model; the paper's where nothing entered.
    pub chosen: Candidate,
    /// What the final model leaves, tested in the same way.
    pub chosen_adequacy: Adequacy,
    /// The models chosen on the way, from the paper's to the last: usually with one term more than the one before, or one
    /// exchanged.
    pub steps: Vec<Candidate>,
    /// Models with as many terms as the chosen one that the data cannot tell from it.
    pub alike: Vec<Model>,
    /// Whether per-record terms depend on the kind of test: see `judge::test_dependence`.
    pub depends_on_test: bool,
    /// Whether the chosen model predicts records left out whole about as well as it fits the others.
    pub carries_over: bool,
    /// An effect that would enter only with the geometry exactly as stated.
    pub by_geometry: Option<EffectSet>,
    /// The missing term as a curve, where no named effect fits.
    pub curve_fit: Option<CurveFit>,
}

impl Found {
    /// The model that is reported and written: the chosen one, or the paper's where nothing known predicts better.
    pub fn reported(&self) -> &Candidate {
        if self.verdict == Verdict::Unexplained { &self.baseline } else { &self.chosen }
    }

    /// Adequacy of the reported model.
    pub fn adequacy(&self) -> &Adequacy {
        if self.verdict == Verdict::Unexplained { &self.baseline_adequacy } else { &self.chosen_adequacy }
    }

    /// The best set with no more terms than the reported one, decisively more evidence and only noise left: an impossible dead
    /// volume may have kept it from entering.
    pub(crate) fn better_than_reported(&self, data: &Data) -> Option<&Candidate> {
        let reported = self.reported();
        let is_better = |c: &&Candidate| c.delta_bic > reported.delta_bic + policy::DECISIVE && c.fit.converged;
        let is_no_larger = |c: &&Candidate| c.model.terms() <= reported.model.terms().max(1);
        let leaves_noise = |c: &&Candidate| adequacy::has_squares_of_noise(data, &c.fit);
        self.tried.iter().filter(is_better).filter(is_no_larger).find(leaves_noise)
    }

    /// Where nothing explains the records and the paper's model has an implausible coefficient: the best set, decisively better
    /// than that model, with a plausible one. Then the coefficient makes up for what the paper's model lacks and not for a wrong
    /// unit.
    pub fn set_with_plausible_coefficient(&self) -> Option<&Candidate> {
        let is_open = self.verdict == Verdict::Unexplained && !sanity::has_plausible_coefficient(&self.baseline.fit);
        let mut better = self.tried.iter().filter(|c| is_open && c.delta_bic > policy::DECISIVE && c.fit.converged);
        better.find(|c| c.fit.exhausted().is_none() && sanity::has_plausible_coefficient(&c.fit))
    }
}

/// Searches. `progress` receives the current activity and its progress. The data are returned without outliers and with the noise
/// that the best model shows.
///
/// # Errors
/// Where the data contradict the model in a known way: see `judge::sanity`.
pub fn search(data: Data, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<(Data, Found), Error> {
    let found = faulty_record::search(data, progress)?;
    progress("done", 1.0);
    Ok(found)
}

/// The same with gas and position zero as the data state them.
fn search_as_stated(data: Data, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<(Data, Found), Error> {
    progress("fitting the paper's model", 0.0);
    let (data, baseline) = baseline::fitted(data)?;
    let adequacy = adequacy::test(&data, &baseline);
    if !adequacy.is_adequate() {
        sanity::reference(&data, &baseline)?;
    }
    let mut search = Search::new(data, baseline, adequacy);
    progress("one term at a time", 0.1);
    search.first_round();
    search.refuse_implausible_coefficient()?;
    search.reweigh();
    search.pool();
    let mut level = 1;
    while search.continues_beyond(level) {
        progress("further terms", 0.1 + 0.8 * (level + 1) as f64 / (1 + policy::MOST_IN_ALL) as f64);
        if !search.round(level) && !search.take_best_exhausted() {
            break;
        }
        search.reweigh();
        search.pool();
        level = (level + 1).max(search.chosen.model.terms());
    }
    progress("checking what was found", 0.9);
    search.conclude()
}

/// Fits the paper's model and tests it. Where it leaves more than noise, outliers and noise are those that the best single term
/// shows: what the model lacks is no noise of the recording.
///
/// # Errors
/// Where its simulation fails at the starting point.
pub fn paper(data: Data) -> Result<(Data, Fit, Adequacy), Error> {
    let (data, baseline) = baseline::fitted(data)?;
    let adequacy = adequacy::test(&data, &baseline);
    if adequacy.is_noise {
        return Ok((data, baseline, adequacy));
    }
    let mut search = Search::new(data, baseline, adequacy);
    search.singles();
    Ok((search.data, search.baseline.fit, search.baseline_adequacy))
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
        let mut baseline = Candidate { model: Model::PAPER, fit: baseline, delta_bic: 0.0, held_out: None };
        baseline.held_out = left_out::error(&data, &baseline.fit, &folds);
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

    /// Fits every term alone, with the data weighted as the best of them shows.
    fn singles(&mut self) -> Vec<Candidate> {
        let models = terms::added_to(&self.data, &Model::PAPER);
        let singles = self.fit_all(&models);
        let best = singles.first().filter(|c| c.delta_bic > policy::DECISIVE).map(|c| c.fit.clone());
        if best.is_some_and(|best| self.reweigh_by(&best)) { self.refitted(&singles) } else { singles }
    }

    /// Tries every term alone and takes the best one that may enter.
    fn first_round(&mut self) {
        let mut singles = self.singles();
        let strongest = singles.len().min(policy::FREED);
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

    /// Refuses a coefficient that no single term brings near the plausible range: with a wrong unit of time the search would
    /// continue to the end with ever larger sets.
    fn refuse_implausible_coefficient(&self) -> Result<(), Error> {
        let far = policy::FIRST_GUESS_REACH.exp();
        let (least, most) = (*policy::PLAUSIBLE_COEFFICIENT.start() / far, *policy::PLAUSIBLE_COEFFICIENT.end() * far);
        let is_near = |c: &Candidate| (least..most).contains(&c.fit.chamber().heat_transfer.coefficient);
        match self.tried.iter().chain([&self.baseline]).any(is_near) {
            true => Ok(()),
            false => sanity::coefficient(&self.data, &self.baseline.fit),
        }
    }

    /// Whether to look for sets with more than `level` terms.
    fn continues_beyond(&self, level: usize) -> bool {
        let model = &self.chosen.model;
        if level > policy::MOST_IN_ALL {
            return false;
        }
        if self.needs_no_more_names() {
            // One more round after the first term, as another one may be hidden behind it; also while per-record terms may
            // imitate effects of the rig, and while further per-record terms are possible.
            return (level == 1 && model.terms() == 1) || model.has_terms_of_records() || self.records_may_differ();
        }
        // Next to nothing, and less than noise: of this size is the interpolation error of a stroke recovered from an average or
        // a low-pass.
        let is_next_to_nothing = self.chosen_adequacy.systematic_pa < self.data.noise.total_pa()
            && self.chosen_adequacy.accounts_for(self.baseline_adequacy.systematic_pa);
        !(terms::takes_back_the_stroke(model) && is_next_to_nothing)
    }

    /// Whether further per-record terms are possible: the chosen model leaves more than noise altogether, however little of it
    /// repeats share and however slow it is. A gauge zero that is read anew before each record is no noise.
    fn records_may_differ(&self) -> bool {
        let noise_pa = self.data.noise.total_pa().hypot(self.data.accuracy_pa());
        misfit::weighed_rms(&self.data, &misfit::residuals(&self.data, &self.chosen.fit)) > noise_pa
    }

    /// Whether what the chosen model leaves is noise, or is below the accuracy while nothing is named or the names explain the
    /// misfit. Otherwise they may imitate the cause of what is left, however little that is.
    pub(super) fn needs_no_more_names(&self) -> bool {
        let left = &self.chosen_adequacy;
        let explains = self.chosen.model.of_rig().is_empty() || self.explains(self.baseline_adequacy.systematic_pa);
        left.is_noise || left.is_good_enough && explains
    }

    /// Extends the better sets of `level` terms by every further term; returns whether that helped: a set entered, or those
    /// without per-record terms improved so much that one may enter later.
    fn round(&mut self, level: usize) -> bool {
        let chosen = self.chosen.model;
        let enough = self.needs_no_more_names() && !chosen.has_terms_of_records();
        let parts = if enough { vec![chosen] } else { self.beam(level) };
        let mut models: Vec<Model> = parts.iter().flat_map(|part| terms::added_to(&self.data, part)).collect();
        if level == 1 && !enough {
            models.extend(terms::pairs(&self.best_of(level, policy::PAIRED, |_| true), &Model::PAPER));
        }
        let of_rig = self.best_of_rig();
        let delayed = if level == 1 { self.singles_with_a_delay() } else { Vec::new() };
        if self.try_all([models, delayed]) {
            return true;
        }
        if enough || chosen.terms() == 0 {
            return false;
        }
        // None of them helps alone: try the better ones in pairs.
        let more = self.best_of(chosen.terms() + 1, policy::PAIRED, |m| terms::is_part(&chosen, m));
        self.try_all([terms::pairs(&more, &chosen)]) || self.may_reach_chosen(self.best_of_rig() - of_rig, level + 1)
    }

    /// Each single effect of the gas with a delay of either sign. Where a delay of as little as half a row is missing, another
    /// term that imitates both may fit better and leave next to nothing.
    fn singles_with_a_delay(&self) -> Vec<Model> {
        let singles = self.tried.iter().map(|c| c.model).filter(|m| m.terms() == 1 && !m.has_terms_of_records());
        let (delays, others): (Vec<Model>, Vec<Model>) =
            distinct(singles.collect()).into_iter().partition(terms::is_delay);
        delays
            .iter()
            .flat_map(|delay| others.iter().flat_map(|other| terms::pairs(&[*other, *delay], &Model::PAPER)))
            .collect()
    }

    /// Whether sets of the rig's effects, whose evidence grew by `gain` with the last of `terms` terms, may reach that of the
    /// chosen set if each further term gains as much; later ones mostly gain less.
    fn may_reach_chosen(&self, gain: f64, terms: usize) -> bool {
        let further = policy::MOST_IN_ALL.saturating_sub(terms) as f64;
        gain > policy::DECISIVE && self.best_of_rig() + further * gain > self.chosen.delta_bic
    }

    /// Sets of `level` terms to be extended: the chosen one, the best ones, and the best ones without per-record terms, as those
    /// fit a lot and would crowd out the rig's effects.
    fn beam(&self, level: usize) -> Vec<Model> {
        let mut parts = vec![self.chosen.model];
        parts.retain(|chosen| chosen.terms() == level);
        parts.extend(self.best_of(level, policy::BEAM_WIDTH, |_| true));
        parts.extend(self.best_of(level, policy::BEAM_WIDTH, |m| !m.has_terms_of_records()));
        distinct(parts)
    }

    /// The best sets of `terms` terms with credible parameters: those that imitate another cause would crowd them out.
    fn best_of(&self, terms: usize, most: usize, suits: impl Fn(&Model) -> bool) -> Vec<Model> {
        let is_a_rigs = |fit: &Fit| fit.exhausted().is_none() && !fit.is_at_prior_limit();
        let is_extendable = |c: &&Candidate| c.delta_bic > 0.0 && is_a_rigs(&c.fit);
        let sets = self.tried.iter().filter(|c| c.model.terms() == terms).filter(is_extendable).map(|c| c.model);
        distinct(sets.filter(suits).collect()).into_iter().take(most).collect()
    }

    /// Evidence of the best set without per-record terms.
    fn best_of_rig(&self) -> f64 {
        let is_of_rig = |c: &&Candidate| !c.model.has_terms_of_records() && c.fit.exhausted().is_none();
        self.tried.iter().find(is_of_rig).map_or(0.0, |c| c.delta_bic)
    }

    /// The models with the best evidence predicted for their first step, some with per-record terms and some without.
    fn best_predicted(&self, models: Vec<Model>) -> Vec<Model> {
        let predicted =
            |model: Model| Some((starts::predicted_bic(&self.data, model, self.part_of(&model), &self.sizes)?, model));
        let mut predicted: Vec<(f64, Model)> = models.into_par_iter().filter_map(predicted).collect();
        predicted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (of_records, of_rig): (Vec<Model>, Vec<Model>) =
            predicted.into_iter().map(|(_, model)| model).partition(Model::has_terms_of_records);
        [of_records, of_rig].into_iter().flat_map(|models| models.into_iter().take(policy::FITTED)).collect()
    }

    /// Fits and judges the best predicted models of each group that were not tried yet; returns whether one entered. Those that
    /// exhaust an effect do not enter.
    fn try_all(&mut self, groups: impl IntoIterator<Item = Vec<Model>>) -> bool {
        let fresh = |models: Vec<Model>| {
            let is_fresh = |model: &Model| {
                let has_it =
                    |c: &Candidate| c.model.has_same_terms(model) && c.model.secondary.contains(model.secondary);
                terms::is_small(model) && !self.tried.iter().any(has_it)
            };
            with_all_that_is_freed(models).into_iter().filter(is_fresh).collect()
        };
        let predicted = groups.into_iter().flat_map(|models| self.best_predicted(fresh(models)));
        let mut found = self.fit_all(&with_all_that_is_freed(predicted.collect()));
        found.extend(found.par_iter().filter_map(|c| self.without_what_is_off(c)).collect::<Vec<_>>());
        sort(&mut found);
        let (mut found, exhausting): (Vec<Candidate>, _) = found.into_iter().partition(|c| c.fit.exhausted().is_none());
        self.judge(&mut found, policy::JUDGED);
        self.keep(found.iter().cloned().chain(exhausting));
        self.take_best(found)
    }

    /// Adds to the sets tried: keeps the better fit of each model, best evidence first.
    fn keep(&mut self, more: impl IntoIterator<Item = Candidate>) {
        self.tried.extend(more);
        sort(&mut self.tried);
        let mut kept: Vec<Model> = Vec::with_capacity(self.tried.len());
        self.tried.retain(|c| {
            let is_new = !kept.contains(&c.model);
            kept.extend(is_new.then_some(c.model));
            is_new
        });
    }

    fn candidate(&self, fit: Fit) -> Candidate {
        Candidate { model: fit.hypothesis.model, delta_bic: bic(&self.baseline.fit) - bic(&fit), fit, held_out: None }
    }

    /// Fits each model, starting from its largest fitted part; those far above the best so far are given up. Best evidence first.
    fn fit_all(&self, models: &[Model]) -> Vec<Candidate> {
        let best = self.tried.first().map_or(self.chosen.fit.chi2, |c| c.fit.chi2.min(self.chosen.fit.chi2));
        let mut out: Vec<Candidate> = models
            .par_iter()
            .filter_map(|model| {
                fit_model_until(&self.data, *model, self.part_of(model), &self.sizes, Until::beside(best))
            })
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
}

/// Keeps the first of the models with the same terms.
fn distinct(models: Vec<Model>) -> Vec<Model> {
    let mut out: Vec<Model> = Vec::new();
    for model in models {
        if !out.iter().any(|other| other.has_same_terms(&model)) {
            out.push(model);
        }
    }
    out
}

/// Merges models with the same terms, with everything free that is free in any of them.
fn with_all_that_is_freed(models: Vec<Model>) -> Vec<Model> {
    let mut out: Vec<Model> = Vec::new();
    for model in models {
        match out.iter_mut().find(|other| other.has_same_terms(&model)) {
            Some(other) => other.secondary = other.secondary.union(model.secondary),
            None => out.push(model),
        }
    }
    out
}

fn sort(candidates: &mut [Candidate]) {
    candidates.sort_by(|a, b| b.delta_bic.total_cmp(&a.delta_bic));
}

#[cfg(test)]
impl Search {
    /// A search on a recipe's rig after the fit of the paper's model, before any term was tried.
    fn after_first_fit(recipe: &crate::synthetic::Recipe) -> Self {
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let adequacy = adequacy::test(&data, &paper);
        Self::new(data, paper, adequacy)
    }
}

#[cfg(test)]
mod tests {
    use super::starts::fit_model;
    use super::*;
    use crate::synthetic::Recipe;
    use chamber::effects::find;
    use std::sync::atomic::{AtomicBool, Ordering};

    #[test]
    fn records_are_not_refused_if_another_model_makes_the_coefficient_plausible() {
        let search = Search::after_first_fit(&Recipe { repeats: 1, ..Recipe::from_seed(5) });
        let with = |verdict, far: f64, delta_bic| {
            let mut baseline = search.baseline.clone();
            baseline.fit.rig[0] += far;
            let better = Candidate { delta_bic, ..search.baseline.clone() };
            let found = Found {
                verdict,
                chosen: baseline.clone(),
                baseline,
                baseline_adequacy: search.baseline_adequacy.clone(),
                chosen_adequacy: search.chosen_adequacy.clone(),
                tried: vec![better],
                steps: Vec::new(),
                alike: Vec::new(),
                depends_on_test: false,
                carries_over: true,
                by_geometry: None,
                curve_fit: None,
            };
            found.set_with_plausible_coefficient().is_some()
        };
        assert!(with(Verdict::Unexplained, 5.0, 100.0));
        assert!(!with(Verdict::Unexplained, 0.0, 100.0) && !with(Verdict::Unexplained, 5.0, 1.0));
        assert!(!with(Verdict::Improved, 5.0, 100.0));
    }

    #[test]
    fn a_recording_fault_that_is_not_credible_is_not_extended_however_well_it_fits() {
        let mut search = Search::after_first_fit(&Recipe { repeats: 1, ..Recipe::from_seed(5) });
        let single = |name: &str| {
            let model = Model::with(EffectSet::one(find(name).unwrap().0));
            let fit = fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap();
            Candidate { delta_bic: 50.0, ..search.candidate(fit) }
        };
        let (leak, mut offset) = (single("leakage"), single("sensor_offset"));
        offset.delta_bic = 100.0;
        search.tried = vec![offset.clone(), leak.clone()];
        assert_eq!(search.best_of(1, 2, |_| true), [offset.model, leak.model]);
        let last = offset.fit.rig.len() - 1;
        offset.fit.rig[last] = offset.fit.hypothesis.axes[last].bounds[1];
        search.tried[0] = offset;
        assert_eq!(search.best_of(1, 2, |_| true), [leak.model]);
    }

    #[test]
    fn an_effect_beside_a_delay_of_half_a_row_is_found_although_another_term_imitates_both() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        let half_a_row_s = 0.5 * Data::prepare(&recipe.rig()).unwrap().shortest_row_s();
        let mut recipe = recipe.with("natural_convection", &[0.3]).with("record_delay", &[half_a_row_s]);
        recipe.tests.truncate(1);
        let mut search = Search::after_first_fit(&recipe);
        search.first_round();
        let both = ["natural_convection", "record_delay"].map(|name| find(name).unwrap().0).into_iter().collect();
        assert!(search.singles_with_a_delay().contains(&Model::with(both)));
        search.round(1);
        assert!(search.tried.iter().any(|c| c.model.of_rig() == both && c.fit.converged));
    }

    #[test]
    fn per_record_gauge_zeros_are_tried_beside_effects_that_repeats_agree_on() {
        let effects = ["leakage", "tube_volume"].map(|name| find(name).unwrap().0);
        let mut recipe = Recipe { repeats: 3, noise_pa: 60.0, ..Recipe::from_seed(5) };
        recipe.faults.offset_pa.between = 600.0;
        let recipe = effects.iter().fold(recipe, |recipe, effect| recipe.with_strength(*effect, 1.0));
        let mut search = Search::after_first_fit(&recipe);
        let both = Model::with(effects.into_iter().collect());
        let fit = fit_model(&search.data, both, &search.baseline.fit, &search.sizes).unwrap();
        search.chosen = search.judged(search.candidate(fit));
        search.chosen_adequacy = adequacy::test(&search.data, &search.chosen.fit);
        assert!(search.needs_no_more_names() && search.records_may_differ() && search.continues_beyond(2));
        search.round(2);
        let per_record = search.chosen.model.per_record;
        assert!(per_record.has(find("sensor_offset").unwrap().0), "{:?}", search.chosen.model);
        assert!(!search.records_may_differ());
    }

    #[test]
    fn times_in_ms_declared_as_s_are_refused_before_larger_sets_are_tried() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.tests.truncate(1);
        recipe.faults.time_unit = 1e3;
        let tried_further = AtomicBool::new(false);
        let watch = |what: &str, _: f64| {
            tried_further.fetch_or(what == "further terms", Ordering::Relaxed);
        };
        let error = search(Data::prepare(&recipe.rig()).unwrap(), &watch);
        assert!(matches!(error, Err(Error::ImplausibleCoefficient { .. })));
        assert!(!tried_further.into_inner());
    }
}
