//! The verdict on the chosen model, from what it leaves on the fitted and on the left-out records.

use super::{Candidate, Search, Verdict, terms};
use crate::judge::{left_out, misfit};
use crate::policy;
use chamber::card::Tried;
use chamber::effects::CARDS;

impl Search {
    /// The verdict on the chosen model: `depends_on_test` by [`test_dependence`](crate::judge::test_dependence), `carries_over`
    /// to records left out whole.
    pub(super) fn verdict(&self, depends_on_test: bool, carries_over: bool) -> Verdict {
        let nothing_named = self.chosen.model.of_rig().is_empty();
        if self.chosen.model.terms() == 0 {
            return if self.baseline_adequacy.is_adequate() { Verdict::Adequate } else { Verdict::Unexplained };
        }
        // Noise is just noise, whatever the misfit was before.
        let before_pa = if self.chosen_adequacy.is_noise { 0.0 } else { self.to_be_explained_pa() };
        if !depends_on_test && self.chosen_adequacy.accounts_for(before_pa) {
            return match self.explains(before_pa) {
                _ if nothing_named => Verdict::Adequate,
                _ if self.chosen.fit.exhausted().is_some() || self.chosen.fit.needs_other_surroundings() => {
                    Verdict::Improved
                }
                true if carries_over && !self.chosen_adequacy.has_plain_shape(before_pa) => Verdict::Explained,
                _ => Verdict::Improved,
            };
        }
        // In fast moves the positions cause errors on left-out data, whatever the model.
        let halves =
            self.chosen_adequacy.systematic_pa < policy::PREDICTS_BETTER * self.baseline_adequacy.systematic_pa;
        let predicts_better = self.leaves_of_left_out(policy::PREDICTS_BETTER) || halves && carries_over;
        if predicts_better { Verdict::Improved } else { Verdict::Unexplained }
    }

    /// Whether the chosen names explain a systematic misfit of `before_pa`. With an effect that is only tried beside others, the
    /// remainder must be noise or next to nothing: such an effect can imitate the rest of a cause that it is not.
    pub(super) fn explains(&self, before_pa: f64) -> bool {
        let imitates = self.chosen.model.of_rig().iter().any(|e| CARDS[e].tried == Tried::BesideOthers);
        let left = &self.chosen_adequacy;
        if imitates { left.is_noise || left.is_next_to_nothing(before_pa) } else { left.explains(before_pa) }
    }

    /// Systematic misfit, Pa, that the chosen terms must account for: that of the paper's model or, with a timing among them,
    /// that which the timing alone leaves. In a fast move a wrong timing makes an error that dwarfs all others.
    fn to_be_explained_pa(&self) -> f64 {
        let all_pa = self.baseline_adequacy.systematic_pa;
        let timing = terms::timing_of(&self.chosen.model);
        if timing.terms() == 0 || timing.terms() == self.chosen.model.terms() {
            return all_pa;
        }
        let left = |c: Candidate| misfit::systematic(&self.data, &misfit::residuals(&self.data, &c.fit));
        self.part_refitted(timing).map_or(all_pa, |c| left(c).min(all_pa))
    }

    /// Whether the chosen model leaves less than this fraction of the paper's model's systematic error on left-out data.
    fn leaves_of_left_out(&self, share: f64) -> bool {
        let pair = self.baseline.held_out_pa().zip(self.chosen.held_out_pa());
        pair.is_some_and(|(before, after)| self.leaves_less([before, after], share))
    }

    /// Whether less than the fraction `share` of the systematic part of an error `before`, Pa rms, is left in `after`.
    pub(super) fn leaves_less(&self, [before, after]: [f64; 2], share: f64) -> bool {
        let noise = self.data.noise.total_pa();
        let systematic = |rms: f64| (rms * rms - noise * noise).max(0.0).sqrt();
        systematic(after) < share * systematic(before)
    }

    /// Whether the chosen model's error on records left out whole is hardly larger than on the fitted ones: a cause is at work in
    /// all of them. It may be somewhat larger if the uncertainty of the fit to the others accounts for that; and where the fitted
    /// records do not cover the left-out ones, it is enough that most of the error goes.
    pub(super) fn carries_over(&self) -> bool {
        let Some(left_out_pa) = self.chosen.held_out_pa() else { return true };
        let fitted_pa = self.fitted_pa(&self.chosen);
        if left_out_pa < policy::CARRIES_OVER * fitted_pa {
            return true;
        }
        if !left_out::are_representative(&self.data) {
            return self.leaves_of_left_out(policy::MOST_GONE);
        }
        left_out_pa < policy::CARRIES_OVER_WITHIN_UNCERTAINTY * fitted_pa
            && left_out::squares_added(&self.data, &self.chosen.fit, &self.folds)
                .is_some_and(|added| added < policy::CARRIES_OVER.powi(2))
    }

    /// Whether a model's error on records left out whole, Pa rms, is hardly larger than on the fitted ones.
    pub(super) fn predicts_as_it_fits(&self, c: &Candidate, left_out_pa: f64) -> bool {
        left_out_pa < policy::CARRIES_OVER * self.fitted_pa(c)
    }

    /// A model's error on the fitted records, Pa rms.
    fn fitted_pa(&self, c: &Candidate) -> f64 {
        misfit::rms(&self.data, &misfit::residuals(&self.data, &c.fit))
    }

    /// Whether the chosen model is adequate with credible ambient temperatures of the records.
    pub(super) fn is_credibly_adequate(&self) -> bool {
        self.chosen_adequacy.is_adequate() && !self.chosen.fit.needs_other_surroundings()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::adequacy::Adequacy;
    use crate::judge::left_out::HeldOut;
    use crate::parameters::Model;
    use crate::search::starts::fit_model;
    use crate::synthetic::Recipe;
    use chamber::effects::{EffectSet, Leakage, find};

    #[test]
    fn effects_beside_a_timing_are_judged_by_the_misfit_that_the_timing_alone_leaves() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) }.with("record_delay", &[0.01]);
        let recipe = recipe.with("leakage", &[1e-12]);
        let mut search = Search::after_first_fit(&recipe);
        let all_pa = search.baseline_adequacy.systematic_pa;
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

    #[test]
    fn effects_explain_a_misfit_with_little_left_only_if_they_are_also_tried_alone() {
        let mut search = Search::after_first_fit(&Recipe { repeats: 1, ..Recipe::from_seed(5) });
        let mut explains = |name: &str, left: f64| {
            search.chosen.model = Model::with(EffectSet::one(find(name).unwrap().0));
            let left = Adequacy { systematic_pa: left * 100.0, ..search.chosen_adequacy.clone() };
            search.chosen_adequacy = Adequacy { is_noise: false, is_good_enough: true, ..left };
            search.explains(100.0)
        };
        assert!(explains("leakage", 0.05) && !explains("leakage", 0.2));
        assert!(explains("decaying_turbulence", 0.01) && !explains("decaying_turbulence", 0.05));
    }

    /// Errors on left-out data that are this fraction of the paper's model's.
    fn share_of_baseline(search: &Search, share: f64) -> Option<HeldOut> {
        let HeldOut { rmse_pa, weighed_pa } = search.baseline.held_out?;
        Some(HeldOut { rmse_pa: share * rmse_pa, weighed_pa: share * weighed_pa })
    }

    #[test]
    fn effects_that_fail_on_records_left_out_whole_describe_and_do_not_explain() {
        let mut recipe = Recipe::from_seed(5);
        recipe.chamber.effects.of_mut(Leakage::INDEX)[0] = 2e-11;
        let mut search = Search::after_first_fit(&recipe);
        search.first_round();
        assert!(search.carries_over());
        assert_eq!(search.verdict(false, search.carries_over()), Verdict::Explained);
        // Half as much again may be the uncertainty of the fit to the others, since its squares show no failure.
        let predicted = search.chosen.held_out.unwrap();
        let mut times = |factor: f64| {
            search.chosen.held_out = Some(HeldOut { rmse_pa: factor * predicted.rmse_pa, ..predicted });
            search.verdict(false, search.carries_over())
        };
        assert_eq!([times(1.5), times(2.5)], [Verdict::Explained, Verdict::Improved]);
        // Not explained with ambient temperatures that differ by more than is credible.
        search.chosen.held_out = Some(predicted);
        let mut scattered = |deviations: f64| {
            search.chosen.fit.ambient_scatter = deviations;
            search.verdict(false, true)
        };
        assert_eq!([scattered(3.5), scattered(2.5)], [Verdict::Improved, Verdict::Explained]);

        // With few records, each of which need not show all of the effect, it is enough that most of the error goes.
        search.data.traces.truncate(3);
        search.data.traces.iter_mut().for_each(|t| t.repeat = 0);
        search.chosen.fit.records.truncate(3);
        assert_eq!(search.verdict(false, search.carries_over()), Verdict::Explained);
        search.chosen.held_out = share_of_baseline(&search, 0.4);
        assert_eq!(search.verdict(false, search.carries_over()), Verdict::Improved);
    }

    #[test]
    fn halving_the_misfit_and_carrying_over_is_an_improvement_however_large_the_left_out_error() {
        let recipe = Recipe { repeats: 2, ..Recipe::from_seed(5) }.with("leakage", &[2e-11]);
        let mut search = Search::after_first_fit(&recipe);
        search.first_round();
        // Three quarters of the error on left-out data are left, and a third of the misfit.
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
