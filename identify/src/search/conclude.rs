//! How a search ends: terms that nothing needs go out again, what is left is judged, and where it is more than noise the missing
//! term is read off as a curve.
//!
//! A term stays if it is decisive beside the others, and with the stated numbers far more uncertain than stated: an effect that a
//! wrong bore could imitate is not named. At last the numbers of the reported model are checked for contradictions
//! ([`sanity`]).

use super::entry::is_credible;
use super::starts::{as_stated, fit_model};
use super::{Candidate, Found, Search, Verdict, distinct, terms};
use crate::error::Error;
use crate::fit::Fit;
use crate::judge::evidence::bic_widened;
use crate::judge::{adequacy, kinds, left_out, misfit, sanity};
use crate::parameters::{Model, is_timing};
use crate::policy;
use crate::record::data::Data;
use chamber::card::Balance;
use chamber::effects::{CARDS, EffectSet};
use rayon::prelude::*;

impl Search {
    /// Terms that are not decisive beside the others go out again; so do effects that a wrong geometry can stand for.
    pub(super) fn conclude(mut self) -> Result<(Data, Found), Error> {
        let mut by_geometry = None;
        while self.chosen.model.terms() > 0 {
            let asked = |less: Candidate| (self.needed(&less), self.needed_in_wide_geometry(&less), less);
            let least = |(needed, wide, _): &(f64, f64, Candidate)| needed.min(*wide);
            let weakest = self.without_one().into_iter().map(asked).min_by(|a, b| least(a).total_cmp(&least(b)));
            let Some((needed, wide, less)) = weakest else { break };
            if needed.min(wide) > policy::DECISIVE {
                break;
            }
            if needed > policy::DECISIVE {
                by_geometry = Some(self.chosen.model.effects.without(less.model.effects));
            }
            self.steps.retain(|s| terms::is_part(&s.model, &less.model) && s.model != less.model);
            self.chosen_adequacy = adequacy::test(&self.data, &less.fit);
            self.chosen = self.judged(less);
            self.steps.push(self.chosen.clone());
        }
        let mut follows_the_test = kinds::follows_the_test(&self.data, &self.chosen.fit);
        let mut carries_over = self.carries_over();
        let mut verdict = self.verdict(follows_the_test, carries_over);
        if matches!(verdict, Verdict::Improved | Verdict::Unexplained) {
            // Beside a leak the first fit cannot tell, and with wrong pressures another term may have entered in its place.
            let leaky = self.tried.iter().find(|c| has_a_leak_alone(&c.model));
            let leaky = leaky.filter(|c| c.model != self.chosen.model);
            [Some(&self.chosen), leaky]
                .into_iter()
                .flatten()
                .try_for_each(|c| sanity::reference(&self.data, &c.fit))?;
        }
        if verdict == Verdict::Explained {
            self.try_other_timings();
        }
        if verdict != Verdict::Unexplained {
            self.leave_earliness_to_the_records();
        }
        let mut alike = self.alike();
        let settled = if verdict == Verdict::Unexplained { &self.baseline } else { &self.chosen };
        let read_off = match verdict {
            Verdict::Adequate => None,
            Verdict::Explained if self.chosen.model.of_rig().iter().count() < 2 => None,
            Verdict::Explained => self.in_place_of(&self.chosen),
            Verdict::Improved if self.is_settled() && !follows_the_test => None,
            Verdict::Improved | Verdict::Unexplained => self.read_off(settled),
        };
        if let Some(found) = read_off.as_ref().filter(|found| found.fate.is_accepted()) {
            self.steps.retain(|s| terms::is_part(&s.model, &found.candidate.model));
            self.steps.push(found.candidate.clone());
            self.tried.insert(0, found.candidate.clone());
            self.chosen = found.candidate.clone();
            self.chosen_adequacy = adequacy::test(&self.data, &self.chosen.fit);
            follows_the_test = kinds::follows_the_test(&self.data, &self.chosen.fit);
            carries_over = self.carries_over();
            (verdict, alike) = (Verdict::Improved, Vec::new());
        }
        let found = Found {
            verdict,
            baseline: self.baseline,
            baseline_adequacy: self.baseline_adequacy,
            tried: self.tried,
            chosen: self.chosen,
            chosen_adequacy: self.chosen_adequacy,
            steps: self.steps,
            alike,
            follows_the_test,
            carries_over,
            by_geometry,
            read_off,
        };
        sanity::dead_volume(&self.data, &found.reported().fit)?;
        if let Some(better) = found.better_than_reported(&self.data) {
            sanity::dead_volume(&self.data, &better.fit)?;
        }
        if found.coefficient_stands_for().is_none() {
            sanity::coefficient(&self.data, &found.reported().fit)?;
        }
        Ok((self.data, found))
    }

    /// The chosen model without each of its terms in turn: with the secondary parameters of the others as free as they are, which a
    /// term may have entered in place of, or with none of them free, whichever has the better evidence.
    fn without_one(&self) -> Vec<Candidate> {
        let models = terms::without_one(&self.chosen.model);
        models
            .into_par_iter()
            .filter_map(|model| {
                if model == Model::PAPER {
                    return Some(self.baseline.clone());
                }
                let plain = model.with_nothing_freed();
                let freed = (model != plain).then(|| self.part_refitted(model)).flatten();
                freed.into_iter().chain(self.part_refitted(plain)).max_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic))
            })
            .collect()
    }

    /// A part of the chosen model, as it was tried or from the chosen numbers: a fit that ended beside its best would make a term
    /// seem needed.
    fn part_refitted(&self, model: Model) -> Option<Candidate> {
        let known = self.tried.iter().find(|c| c.model == model).cloned();
        let anew = self.refitted_without(&self.chosen.fit, model).map(|fit| self.candidate(fit));
        known.into_iter().chain(anew).max_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic))
    }

    /// A fit of a part of a fitted model, from the numbers that it has there.
    pub(super) fn refitted_without(&self, whole: &Fit, model: Model) -> Option<Fit> {
        let mut from = whole.clone();
        let chamber = whole.chamber();
        let gone = whole.hypothesis.model.effects.without(model.effects);
        let chamber = chamber::Chamber { effects: chamber.effects.without(gone), ..chamber };
        from.hypothesis.base = as_stated(&chamber, whole.hypothesis.model.secondary.without(model.secondary));
        from.hypothesis.axes.clear();
        from.rig.clear();
        fit_model(&self.data, model, &from, &self.sizes)
    }

    /// Whether the chosen model is adequate with surroundings of the records that can be.
    fn is_settled(&self) -> bool {
        self.chosen_adequacy.is_adequate() && !self.chosen.fit.needs_other_surroundings()
    }

    /// Evidence of the chosen model over one with a term less.
    fn needed(&self, less: &Candidate) -> f64 {
        self.chosen.delta_bic - less.delta_bic
    }

    /// The same with the geometry far more uncertain than stated.
    fn needed_in_wide_geometry(&self, less: &Candidate) -> f64 {
        let wide = |fit: &Fit| bic_widened(fit, policy::GEOMETRY_WIDENED);
        wide(&less.fit) - wide(&self.chosen.fit)
    }

    pub(super) fn verdict(&self, follows_the_test: bool, carries_over: bool) -> Verdict {
        let nothing_named = self.chosen.model.of_rig().is_empty();
        if self.chosen.model.terms() == 0 {
            return if self.baseline_adequacy.is_adequate() { Verdict::Adequate } else { Verdict::Unexplained };
        }
        // Noise is no more than that, whatever there was before.
        let before_pa = if self.chosen_adequacy.is_noise { 0.0 } else { self.to_be_explained_pa() };
        if !follows_the_test && self.chosen_adequacy.settles(before_pa) {
            return match self.chosen_adequacy.explains(before_pa) {
                _ if nothing_named => Verdict::Adequate,
                _ if self.chosen.fit.exhausted().is_some() || self.chosen.fit.needs_other_surroundings() => {
                    Verdict::Improved
                }
                true if carries_over => Verdict::Explained,
                _ => Verdict::Improved,
            };
        }
        // In fast moves left-out data have errors that the positions leave open, whatever the model.
        let halves =
            self.chosen_adequacy.systematic_pa < policy::PREDICTS_BETTER * self.baseline_adequacy.systematic_pa;
        let predicts_better = self.leaves_of_left_out(policy::PREDICTS_BETTER) || halves && carries_over;
        if predicts_better { Verdict::Improved } else { Verdict::Unexplained }
    }

    /// The systematic misfit, Pa, that the chosen terms have to account for: that of the paper's model, or, where a timing is among
    /// them, that which the timing alone leaves. In a fast move a wrong timing makes an error beside which all others are nothing.
    fn to_be_explained_pa(&self) -> f64 {
        let all_pa = self.baseline_adequacy.systematic_pa;
        let timing = terms::timing_of(&self.chosen.model);
        if timing.terms() == 0 || timing.terms() == self.chosen.model.terms() {
            return all_pa;
        }
        let left = |c: Candidate| misfit::systematic(&self.data, &misfit::residuals(&self.data, &c.fit));
        self.part_refitted(timing).map_or(all_pa, |c| left(c).min(all_pa))
    }

    /// Whether the chosen model leaves less than this share of the paper's model's systematic error on left-out data.
    fn leaves_of_left_out(&self, share: f64) -> bool {
        let pair = self.baseline.held_out_pa().zip(self.chosen.held_out_pa());
        pair.is_some_and(|(before, after)| self.leaves_less([before, after], share))
    }

    /// Whether of an error before, Pa rms, less than this share of what is systematic in it is left after.
    pub(super) fn leaves_less(&self, [before, after]: [f64; 2], share: f64) -> bool {
        let noise = self.data.noise.total_pa();
        let systematic = |rms: f64| (rms * rms - noise * noise).max(0.0).sqrt();
        systematic(after) < share * systematic(before)
    }

    /// Whether the chosen model errs on records left out whole hardly more than on those it was fitted to: a cause is at work in
    /// all of them. Somewhat more is what the fit to the others leaves open, if that accounts for it; and what nothing like it was
    /// fitted to may be predicted less well, as long as most of the error goes.
    pub(super) fn carries_over(&self) -> bool {
        let Some(left_out_pa) = self.chosen.held_out_pa() else { return true };
        let fitted_pa = self.fitted_pa(&self.chosen);
        if left_out_pa < policy::CARRIES_OVER * fitted_pa {
            return true;
        }
        if !left_out::are_representative(&self.data) {
            return self.leaves_of_left_out(policy::MOST_GONE);
        }
        left_out_pa < policy::LEFT_OPEN * fitted_pa
            && left_out::squares_added(&self.data, &self.chosen.fit, &self.folds)
                .is_some_and(|added| added < policy::CARRIES_OVER.powi(2))
    }

    /// Whether a model's error on records left out whole, Pa rms, is hardly more than that on those it was fitted to.
    pub(super) fn predicts_as_it_fits(&self, c: &Candidate, left_out_pa: f64) -> bool {
        left_out_pa < policy::CARRIES_OVER * self.fitted_pa(c)
    }

    /// A model's error on the records it was fitted to, Pa rms.
    fn fitted_pa(&self, c: &Candidate) -> f64 {
        misfit::rms(&self.data, &misfit::residuals(&self.data, &c.fit))
    }

    /// Tries the sets beside the chosen one that shift or smear the records in time otherwise: within a row a delay and a lag are
    /// hardly told apart, and the search need not have come to both.
    fn try_other_timings(&mut self) {
        let models = terms::with_other_timing(&self.chosen.model);
        let fresh: Vec<Model> =
            models.into_iter().filter(|m| !self.tried.iter().any(|c| c.model.has_same_terms(m))).collect();
        let fitted = self.fit_all(&fresh);
        self.keep(fitted);
    }

    /// Whether a set shifts or smears the records in time otherwise than the chosen one, and each of them by less than half a row:
    /// the stroke between rows, and by it what tells one from the other, is not known so well.
    fn differs_within_a_row(&self, other: &Candidate) -> bool {
        let [ours, theirs] = [self.chosen.model.of_rig(), other.model.of_rig()];
        let (gone, new) = (ours.without(theirs), theirs.without(ours));
        let is_one_of_time = |set: EffectSet| set.iter().count() == 1 && set.iter().all(|e| is_timing(&CARDS[e]));
        is_one_of_time(gone)
            && is_one_of_time(new)
            && seconds(&self.chosen, gone).max(seconds(other, new)) < 0.5 * self.data.shortest_row_s()
    }

    /// Other sets of as many terms with about the same evidence or more, whose numbers can be a rig's.
    fn alike(&self) -> Vec<Model> {
        let chosen = self.chosen.model;
        let is_other = |m: &Model| m.terms() == chosen.terms() && !m.has_same_terms(&chosen);
        let is_near = |c: &&Candidate| {
            let by = self.chosen.delta_bic - c.delta_bic;
            by < policy::INDISTINGUISHABLE
                || by < policy::INDISTINGUISHABLE_WITHIN_A_ROW && self.differs_within_a_row(c)
        };
        let others = self.tried.iter().filter(|c| is_other(&c.model)).filter(is_near);
        distinct(others.filter(|c| is_credible(&c.fit) && c.fit.exhausted().is_none()).map(|c| c.model).collect())
    }
}

/// How far effects shift or smear the records in time, s.
fn seconds(c: &Candidate, effects: EffectSet) -> f64 {
    let chamber = c.fit.chamber();
    effects.iter().map(|e: usize| chamber.effects.of(e)[0]).fold(0.0, f64::max)
}

/// Whether the rig alone loses or gains gas, and nothing is taken up by terms of single records.
fn has_a_leak_alone(model: &Model) -> bool {
    !model.has_terms_of_records() && model.effects.iter().any(|e| CARDS[e].balance == Balance::Mass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::adequacy::Adequacy;
    use crate::judge::left_out::HeldOut;
    use crate::search::baseline;
    use crate::synthetic::Recipe;
    use chamber::effects::find;

    #[test]
    fn a_term_that_stood_for_a_freed_number_of_another_goes_out_again() {
        let (leakage, drift) = (find("leakage").unwrap().0, find("sensor_drift").unwrap().0);
        let mut recipe = Recipe::from_seed(5);
        recipe.chamber.effects.of_mut(leakage)[..2].copy_from_slice(&[2e-11, 0.1]);
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let adequacy = adequacy::test(&data, &paper);
        let mut search = Search::new(data, paper, adequacy);
        let leak = EffectSet::one(leakage);
        let both = Model { secondary: leak, ..Model::with(leak.union(EffectSet::one(drift))) };
        let fit = fit_model(&search.data, both, &search.baseline.fit, &search.sizes).unwrap();
        search.chosen = search.candidate(fit);
        let without = search.without_one();
        let less = without.iter().find(|c| c.model.effects == leak).unwrap();
        assert_eq!(less.model.secondary, leak);
        assert!(search.needed(less) < policy::DECISIVE, "{}", search.needed(less));
        let plain = search.part_refitted(Model::with(leak)).unwrap();
        assert!(search.needed(&plain) > policy::DECISIVE, "{}", search.needed(&plain));
    }

    #[test]
    fn a_delay_within_a_row_is_alike_to_a_lag_that_the_search_did_not_come_to() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5).with("sensor_lag", &[1.5e-3]) };
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let adequacy = adequacy::test(&data, &paper);
        let mut search = Search::new(data, paper, adequacy);
        let single = |name: &str| Model::with(EffectSet::one(find(name).unwrap().0));
        let fit = fit_model(&search.data, single("record_delay"), &search.baseline.fit, &search.sizes).unwrap();
        search.chosen = search.candidate(fit);
        assert_eq!(search.alike(), []);
        search.try_other_timings();
        assert!(search.alike().contains(&single("sensor_lag")), "{:?}", search.alike());
    }

    #[test]
    fn what_effects_explain_beside_a_timing_is_judged_by_what_the_timing_alone_leaves() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) }.with("record_delay", &[0.01]);
        let recipe = recipe.with("leakage", &[1e-12]);
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let adequacy = adequacy::test(&data, &paper);
        let all_pa = adequacy.systematic_pa;
        let mut search = Search::new(data, paper, adequacy);
        let mut to_be_explained_pa = |names: &[&str]| {
            let effects = names.iter().map(|name| find(name).unwrap().0).collect();
            let fit = fit_model(&search.data, Model::with(effects), &search.baseline.fit, &search.sizes).unwrap();
            search.chosen = search.candidate(fit);
            search.to_be_explained_pa()
        };
        assert_eq!(to_be_explained_pa(&["record_delay"]), all_pa);
        assert_eq!(to_be_explained_pa(&["leakage"]), all_pa);
        let by_the_leak_pa = to_be_explained_pa(&["leakage", "record_delay"]);
        let noise_pa = recipe.noise_rms_pa();
        assert!((noise_pa..0.5 * all_pa).contains(&by_the_leak_pa), "{by_the_leak_pa} of {all_pa}, noise {noise_pa}");
    }

    /// Errors on left-out data that are this share of the paper's model's.
    fn share_of_baseline(search: &Search, share: f64) -> Option<HeldOut> {
        let HeldOut { rmse_pa, weighed_pa } = search.baseline.held_out?;
        Some(HeldOut { rmse_pa: share * rmse_pa, weighed_pa: share * weighed_pa })
    }

    #[test]
    fn what_fails_on_records_left_out_whole_describes_and_does_not_explain() {
        let mut recipe = Recipe::from_seed(5);
        recipe.chamber.effects.of_mut(find("leakage").unwrap().0)[0] = 2e-11;
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let adequacy = adequacy::test(&data, &paper);
        let mut search = Search::new(data, paper, adequacy);
        search.first_round();
        assert!(search.carries_over());
        assert_eq!(search.verdict(false, search.carries_over()), Verdict::Explained);
        // Half as much again would be what the fit to the others leaves open, since its squares tell of no failure.
        let predicted = search.chosen.held_out.unwrap();
        let mut times = |factor: f64| {
            search.chosen.held_out = Some(HeldOut { rmse_pa: factor * predicted.rmse_pa, ..predicted });
            search.verdict(false, search.carries_over())
        };
        assert_eq!([times(1.5), times(2.5)], [Verdict::Explained, Verdict::Improved]);
        // Nor do surroundings of the records that differ by more than they can.
        search.chosen.held_out = Some(predicted);
        let mut scattered = |deviations: f64| {
            search.chosen.fit.ambient_scatter = deviations;
            search.verdict(false, true)
        };
        assert_eq!([scattered(3.5), scattered(2.5)], [Verdict::Improved, Verdict::Explained]);

        // Of few records, which need not show all of the effect each, only that most of the error goes.
        search.data.traces.truncate(3);
        search.data.traces.iter_mut().for_each(|t| t.repeat = 0);
        search.chosen.fit.own.truncate(3);
        assert_eq!(search.verdict(false, search.carries_over()), Verdict::Explained);
        search.chosen.held_out = share_of_baseline(&search, 0.4);
        assert_eq!(search.verdict(false, search.carries_over()), Verdict::Improved);
    }

    #[test]
    fn what_halves_the_misfit_and_errs_no_more_on_left_out_data_improves_whatever_else_is_left_there() {
        let recipe = Recipe { repeats: 2, ..Recipe::from_seed(5) }.with("leakage", &[2e-11]);
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let adequacy = adequacy::test(&data, &paper);
        let mut search = Search::new(data, paper, adequacy);
        search.first_round();
        // Of the error on left-out data three quarters are left, and of the misfit a third.
        search.chosen.held_out = share_of_baseline(&search, 0.75);
        let systematic_pa = search.baseline_adequacy.systematic_pa / 3.0;
        search.chosen_adequacy =
            Adequacy { systematic_pa, is_noise: false, is_good_enough: false, ..search.chosen_adequacy };
        assert_eq!(search.verdict(false, true), Verdict::Improved);
        assert_eq!(search.verdict(false, false), Verdict::Unexplained);
        search.chosen_adequacy.systematic_pa *= 2.0;
        assert_eq!(search.verdict(false, true), Verdict::Unexplained);
    }
}
