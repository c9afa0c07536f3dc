//! Conditions for a set to enter: decisive evidence, a lower error on left-out data, and credible parameters.

use super::starts::fit_model;
use super::{Candidate, Search, sort, terms};
use crate::fit::{Fit, covariance};
use crate::judge::evidence::bic;
use crate::judge::{adequacy, left_out, sanity};
use crate::parameters::Model;
use crate::policy;
use chamber::card::Fitted;
use chamber::effects::CARDS;
use rayon::prelude::*;

impl Search {
    /// Lets the best admissible candidate without an exhausted effect enter; returns whether one did.
    pub(super) fn take_best(&mut self, mut candidates: Vec<Candidate>) -> bool {
        candidates.retain(|c| c.fit.exhausted().is_none());
        self.take_best_of(candidates)
    }

    /// Where nothing else helps and the chosen model is not adequate, lets the best set with an almost exhausted effect enter. It
    /// describes the records; that effect is not their cause.
    pub(super) fn take_best_exhausted(&mut self) -> bool {
        if self.chosen_adequacy.is_adequate() {
            return false;
        }
        let least = self.chosen.delta_bic + policy::DECISIVE;
        let is_better = |c: &&Candidate| c.fit.exhausted().is_some() && c.delta_bic > least;
        let mut better: Vec<Candidate> = self.tried.iter().filter(is_better).cloned().collect();
        self.judge(&mut better, policy::JUDGED);
        for c in &better {
            self.tried.iter_mut().filter(|t| t.model == c.model).for_each(|t| t.held_out = c.held_out);
        }
        self.take_best_of(better)
    }

    /// Lets the best candidate that meets the conditions enter.
    fn take_best_of(&mut self, mut candidates: Vec<Candidate>) -> bool {
        let among = candidates.len().max(2) as f64;
        candidates.retain(|c| self.may_enter(c, among));
        sort(&mut candidates);
        let Some(highest) = candidates.first().map(|c| c.delta_bic) else { return false };
        candidates.retain(|c| c.delta_bic > highest - policy::DECISIVE);
        // Which of several close candidates is best may show only with their secondary parameters free.
        let freed: Vec<Candidate> = candidates.par_iter().filter_map(|c| self.freed(c)).collect();
        self.keep(freed.iter().cloned());
        candidates.extend(freed);
        sort(&mut candidates);
        let Some(best) = candidates.into_iter().next() else { return false };
        let plain = self.no_longer_freed(&best);
        self.keep(plain.iter().cloned());
        let best = plain.unwrap_or(best);
        self.chosen_adequacy = adequacy::test(&self.data, &best.fit);
        self.steps.push(best.clone());
        self.chosen = best;
        true
    }

    /// Whether a candidate has decisive evidence over the chosen model, predicts left-out data better by more than `least_gain`,
    /// and has credible parameters.
    fn may_enter(&self, c: &Candidate, among: f64) -> bool {
        let over = &self.chosen;
        // Effects of the rig in place of per-record terms need not predict better, only no worse.
        let in_place = over.model.has_terms_of_records() && !c.model.has_terms_of_records();
        let least_gain = if in_place { 0.0 } else { self.least_gain() };
        let decisive = policy::DECISIVE + among.ln();
        let lower = match over.held_out {
            // A candidate that errs less only in fast moves, where rows tell little, must not err more elsewhere.
            Some(_) if c.errs_more(over, self.data.accuracy_pa()) => false,
            Some(_) => c.errs_less(over, least_gain) || self.is_another_cause(c, decisive),
            None => c.held_out.is_some(),
        };
        // An effect that the fit has switched off does not count.
        let is_on = c.fit.chamber().active().contains(c.model.of_rig());
        let has_room = || sanity::dead_volume(&self.data, &c.fit).is_ok();
        let can_be = || is_credible(&c.fit) && self.may_have_its_coefficient(c) && has_room();
        lower && is_on && c.delta_bic - over.delta_bic > decisive && can_be()
    }

    /// Whether a set of the rig's effects that lacks some of the chosen ones, while these leave only noise or less than the
    /// accuracy, predicts left-out data no worse by more than the accuracy, and has decisively more evidence than all sets with
    /// the chosen ones up to its size. Then these imitate its cause: leaving little does not make them the cause.
    fn is_another_cause(&self, c: &Candidate, decisive: f64) -> bool {
        let chosen = &self.chosen;
        let has_chosen = |other: &&Candidate| terms::is_part(&chosen.model, &other.model);
        if chosen.model.terms() == 0 || !self.needs_no_more_names() || c.model.has_terms_of_records() || has_chosen(&c)
        {
            return false;
        }
        let as_large = |other: &&Candidate| other.model.terms() <= c.model.terms();
        let with_chosen = self.tried.iter().filter(has_chosen).filter(as_large);
        let most = with_chosen.map(|with| with.delta_bic).fold(chosen.delta_bic, f64::max);
        c.delta_bic > most + decisive && !chosen.errs_less(c, self.data.accuracy_pa())
    }

    /// Decrease of the error on left-out data that a term needs, Pa: the accuracy. Where little more than that is systematic, or
    /// less beside names, half the square of what is systematic is enough, since no term removes more than that.
    pub(super) fn least_gain(&self) -> f64 {
        let (accuracy_pa, chosen) = (self.data.accuracy_pa(), &self.chosen_adequacy);
        let is_satisfactory = chosen.is_good_enough && self.needs_no_more_names();
        if is_satisfactory { accuracy_pa } else { accuracy_pa.min(chosen.systematic_pa * 0.5f64.sqrt()) }
    }

    /// The set without the effects that its fit has switched off, if it was not tried or is decisively better than as tried:
    /// beside such an effect a fit may reach a valley that it missed without it.
    pub(super) fn without_what_is_off(&self, c: &Candidate) -> Option<Candidate> {
        let off = c.model.of_rig().without(c.fit.chamber().active());
        let model = c.model.without(off);
        if off.is_empty() || model.terms() == 0 {
            return None;
        }
        let part = self.candidate(self.refitted_without(&c.fit, model)?);
        let known = self.tried.iter().find(|known| known.model == model);
        known.is_none_or(|known| part.delta_bic > known.delta_bic + policy::DECISIVE).then_some(part)
    }

    /// The same set with its secondary parameters free, if that is decisively better.
    pub(super) fn freed(&self, c: &Candidate) -> Option<Candidate> {
        let model = Model { secondary: c.model.of_rig(), ..c.model };
        let has_secondary = |e: usize| CARDS[e].fitted(Fitted::Secondary).next().is_some();
        if model == c.model || !model.secondary.iter().any(has_secondary) {
            return None;
        }
        let fit = fit_model(&self.data, model, &c.fit, &self.sizes)?;
        if fit.hypothesis.axes.len() == c.fit.hypothesis.axes.len() || bic(&c.fit) - bic(&fit) < policy::DECISIVE {
            return None;
        }
        Some(self.judged(self.candidate(fit)))
    }

    /// The same set without free secondary parameters, if its evidence is about the same: another term has entered that one of
    /// them imitated.
    pub(super) fn no_longer_freed(&self, c: &Candidate) -> Option<Candidate> {
        let model = c.model.with_nothing_freed();
        if model == c.model {
            return None;
        }
        let plain = self.candidate(self.refitted_without(&c.fit, model)?);
        (c.delta_bic - plain.delta_bic < policy::DECISIVE && is_credible(&plain.fit)).then(|| self.judged(plain))
    }

    pub(super) fn judged(&self, mut c: Candidate) -> Candidate {
        self.hold_out(&mut c);
        c
    }

    /// Computes a candidate's error on left-out data, unless known.
    pub(super) fn hold_out(&self, c: &mut Candidate) {
        if c.held_out.is_none() {
            c.held_out = left_out::error(&self.data, &c.fit, &self.folds);
        }
    }

    /// Computes the error on left-out data of the first `most` credible candidates.
    pub(super) fn judge(&self, candidates: &mut [Candidate], most: usize) {
        let may_enter: Vec<&mut Candidate> = candidates.iter_mut().filter(|c| is_credible(&c.fit)).take(most).collect();
        may_enter.into_par_iter().for_each(|c| self.hold_out(c));
    }
}

/// Whether a fit has reached a minimum with credible parameters: a λ0 that the records determine (it is their purpose), and no
/// recording fault so large that it has another cause.
pub(super) fn is_credible(fit: &Fit) -> bool {
    fit.converged && !fit.is_at_prior_limit() && determines_lambda0(fit)
}

/// Whether the records determine λ0 better than its first guess does, with the stated parameters free within their tolerances.
fn determines_lambda0(fit: &Fit) -> bool {
    covariance::profile_variance(fit, 0).sqrt() < policy::FIRST_GUESS_REACH
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::adequacy::Adequacy;
    use crate::judge::left_out::HeldOut;
    use crate::parameters::{Sizes, Slot};
    use crate::record::data::Data;
    use crate::search::{Verdict, baseline};
    use crate::synthetic::Recipe;
    use chamber::effects::{EffectSet, GasColumnLength, GasZones, NaturalConvection, find};

    /// A search after its first fit, and a set with gas zones with nearly all gas in the core, much better than the rest.
    fn search_with_exhausted_zones() -> (Search, Candidate) {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.chamber.effects.of_mut(NaturalConvection::INDEX)[0] = 0.4;
        let search = Search::after_first_fit(&recipe);
        assert!(!search.baseline_adequacy.is_adequate());
        let model = Model::with(GasZones::SET);
        let fit = fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap();
        assert_eq!(fit.exhausted(), None);
        let mut zones = search.candidate(fit);
        let fraction = zones.fit.rig.len() - 2;
        zones.fit.rig[fraction] = 0.94 / zones.fit.hypothesis.axes[fraction].scale;
        (zones.delta_bic, zones.held_out) = (1e6, Some(HeldOut { rmse_pa: 0.0, weighed_pa: 0.0 }));
        (search, zones)
    }

    #[test]
    fn a_nearly_exhausted_effect_is_recognised_and_one_that_is_off_or_without_influence_is_not() {
        let (_, mut zones) = search_with_exhausted_zones();
        assert_eq!(zones.fit.exhausted().map(|slot| slot.name()), Some("gas_zones.mass_fraction".to_owned()));
        let (fraction, conductance) = (zones.fit.rig.len() - 2, zones.fit.rig.len() - 1);
        zones.fit.rig[fraction] = 0.0;
        zones.fit.rig[conductance] = zones.fit.hypothesis.axes[conductance].bounds[1];
        assert_eq!(zones.fit.exhausted(), None);
    }

    #[test]
    fn a_coefficient_that_grows_with_the_gas_column_is_no_plausible_effect() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        let search = Search::after_first_fit(&recipe);
        let exhausted_with = |exponent: f64| {
            let mut fit = search.baseline.fit.clone();
            let model = Model::with(GasColumnLength::SET);
            fit = fit_model(&search.data, model, &fit, &search.sizes).unwrap();
            let column = fit.rig.len() - 1;
            fit.rig[column] = exponent / fit.hypothesis.axes[column].scale;
            fit.exhausted().map(|slot| slot.name())
        };
        assert_eq!(exhausted_with(-0.5), None);
        assert_eq!(exhausted_with(0.7), Some("gas_column_length.exponent".to_owned()));
    }

    #[test]
    fn a_set_with_an_effect_that_its_fit_has_switched_off_does_not_enter() {
        let (search, mut zones) = search_with_exhausted_zones();
        let (fraction, conductance) = (zones.fit.rig.len() - 2, zones.fit.rig.len() - 1);
        assert!(search.may_enter(&zones, 2.0));
        (zones.fit.rig[fraction], zones.fit.rig[conductance]) = (0.0, 0.0);
        assert!(!search.may_enter(&zones, 2.0));
    }

    #[test]
    fn a_set_that_needs_a_volume_below_zero_does_not_enter() {
        let (search, mut zones) = search_with_exhausted_zones();
        assert!(search.may_enter(&zones, 2.0));
        let index = zones.fit.hypothesis.axes.iter().position(|axis| axis.slot == Slot::DeadVolume).unwrap();
        zones.fit.rig[index] = zones.fit.hypothesis.axes[index].bounds[0];
        assert!(!search.may_enter(&zones, 2.0));
    }

    #[test]
    fn another_cause_replaces_effects_that_leave_little_only_if_no_extension_of_them_has_as_much_evidence() {
        let (mut search, mut zones) = search_with_exhausted_zones();
        let single = |name: &str| Model::with(EffectSet::one(find(name).unwrap().0));
        let of = |model: Model| fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap();
        let convection = search.candidate(of(single("natural_convection")));
        let with_more = search.candidate(of(Model::with(convection.model.effects.union(single("sensor_lag").effects))));
        let [evidence, error] = [convection.delta_bic, 100.0];
        let errs = |rmse_pa: f64| Some(HeldOut { rmse_pa, weighed_pa: rmse_pa });
        search.chosen = Candidate { held_out: errs(error), ..convection };
        search.chosen_adequacy = Adequacy { is_noise: true, ..search.chosen_adequacy };
        (zones.delta_bic, zones.held_out) = (evidence + 30.0, errs(error));
        assert!(search.may_enter(&zones, 2.0));
        search.tried = vec![Candidate { delta_bic: evidence + 25.0, ..with_more.clone() }];
        assert!(
            search.may_enter(&Candidate { delta_bic: evidence + 40.0, ..zones.clone() }, 2.0)
                && zones.model.terms() < 2
        );
        // A set as large as the one in question counts.
        let larger = single("wall_heating").effects.union(zones.model.effects);
        let mut large = search.candidate(of(Model::with(larger)));
        (large.delta_bic, large.held_out) = (evidence + 30.0, errs(error));
        assert!(!search.may_enter(&large, 2.0));
        large.delta_bic = evidence + 40.0;
        assert!(search.may_enter(&large, 2.0));
        // Not if it predicts worse by a relevant amount, nor where more than noise is left.
        large.held_out = errs(error + 2.0 * search.data.accuracy_pa());
        assert!(!search.may_enter(&large, 2.0));
        // Nor if it errs less in fast moves alone and more elsewhere.
        let more_elsewhere = HeldOut { rmse_pa: 0.0, weighed_pa: error + 2.0 * search.data.accuracy_pa() };
        assert!(!search.may_enter(&Candidate { held_out: Some(more_elsewhere), ..large.clone() }, 2.0));
        large.held_out = errs(error);
        search.chosen_adequacy.is_noise = false;
        search.chosen_adequacy.is_good_enough = false;
        assert!(!search.may_enter(&large, 2.0));
    }

    #[test]
    fn a_set_without_its_effect_that_is_off_is_fitted_from_the_larger_one() {
        let (search, mut zones) = search_with_exhausted_zones();
        let model = Model::with(NaturalConvection::SET.union(zones.model.effects));
        zones = search.candidate(fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap());
        let of_zones = |fit: &Fit| {
            let is_of_zones = |axis: &crate::parameters::Axis| axis.slot.name().starts_with("gas_zones");
            (0..fit.rig.len()).filter(|k| is_of_zones(&fit.hypothesis.axes[*k])).collect::<Vec<_>>()
        };
        of_zones(&zones.fit).into_iter().for_each(|k| zones.fit.rig[k] = 0.0);
        let part = search.without_what_is_off(&zones).unwrap();
        assert_eq!(part.model, Model::with(NaturalConvection::SET));
        assert!(part.delta_bic > policy::DECISIVE && part.fit.converged);
        // Not if that part is already known.
        let tried = vec![part];
        assert!(Search { tried, ..search }.without_what_is_off(&zones).is_none());
    }

    #[test]
    fn a_set_that_has_nearly_exhausted_an_effect_enters_only_to_describe_what_nothing_else_does() {
        let (mut search, zones) = search_with_exhausted_zones();
        assert!(!search.take_best(vec![zones.clone()]));
        search.tried = vec![zones.clone()];
        assert!(search.best_of(1, 1, |_| true).is_empty());
        assert!(search.take_best_exhausted());
        assert_eq!(search.chosen.model, zones.model);
        assert_ne!(search.verdict(false, search.carries_over()), Verdict::Explained);

        let (mut search, zones) = search_with_exhausted_zones();
        search.tried = vec![zones];
        search.chosen_adequacy = Adequacy { is_good_enough: true, ..search.chosen_adequacy };
        assert!(search.chosen_adequacy.is_adequate() && !search.take_best_exhausted());
    }

    #[test]
    fn an_effect_that_removes_less_than_the_accuracy_is_not_named() {
        let recipe = Recipe { repeats: 2, ..Recipe::from_seed(5).with("leakage", &[1e-13, 0.3]) };
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let found_with = |accuracy_pa: f64| {
            let data = Data { accuracy_pa: Some(accuracy_pa), ..data.clone() };
            let adequacy = adequacy::test(&data, &paper);
            let mut search = Search::new(data, paper.clone(), adequacy);
            search.first_round();
            search
        };
        let names = |search: &Search| search.chosen.model.terms();
        let weighed_pa = |c: &Candidate| c.held_out.unwrap().weighed_pa;
        let plain = found_with(1.0);
        let taken_pa = (weighed_pa(&plain.baseline).powi(2) - weighed_pa(&plain.chosen).powi(2)).sqrt();
        assert!(names(&plain) == 1 && plain.chosen.delta_bic > 2.0 * policy::DECISIVE);
        assert!(names(&found_with(0.5 * taken_pa)) == 1);
        assert!(names(&found_with(2.0 * taken_pa)) == 0, "{taken_pa} {}", plain.baseline_adequacy.systematic_pa);
        // Little above the accuracy, all of the misfit would have to go, so half is enough.
        let systematic_pa = plain.baseline_adequacy.systematic_pa;
        assert!(names(&found_with(0.99 * systematic_pa)) == 1, "{taken_pa} {systematic_pa}");
    }

    #[test]
    fn a_fault_at_the_end_of_its_prior_is_not_credible_and_one_of_zero_is() {
        let data = Data::prepare(&Recipe { repeats: 1, ..Recipe::from_seed(5) }.rig()).unwrap();
        let (data, paper) = baseline::fitted(data).unwrap();
        let sizes = Sizes::of(&data, &paper.chamber());
        for (name, ends) in [("sensor_offset", [true, true]), ("position_delay", [false, true])] {
            let model = Model::with(EffectSet::one(find(name).unwrap().0));
            let mut fit = fit_model(&data, model, &paper, &sizes).unwrap();
            assert!(!fit.is_at_prior_limit(), "{name}");
            let last = fit.rig.len() - 1;
            for (end, is_beyond) in fit.hypothesis.axes[last].bounds.into_iter().zip(ends) {
                fit.rig[last] = end;
                assert_eq!(fit.is_at_prior_limit(), is_beyond, "{name} {end}");
            }
        }
    }
}
