//! End of a search: removes terms that are not needed (`needed`), judges the rest (`verdict`), tries sets with one effect
//! exchanged where several explain the records, and fits the missing term as a curve where more than noise is left
//! ([`curve`](super::curve)). Finally the reported model is checked for contradictions (`contradictions`).

use super::{Candidate, Found, Search, Verdict, contradictions, terms};
use crate::error::Error;
use crate::judge::{adequacy, test_dependence};
use crate::policy;
use crate::record::data::Data;

impl Search {
    /// Reaches a verdict; returns it with the data as the search has weighted them.
    pub(super) fn conclude(mut self) -> Result<(Data, Found), Error> {
        let (mut by_geometry, parts) = self.leave_out_unneeded();
        let (mut verdict, mut depends_on_test, mut carries_over) = self.judged_as_a_whole();
        if verdict == Verdict::Explained && (self.try_further() || self.try_others_in_place(&parts)) {
            (by_geometry, _) = self.leave_out_unneeded();
            (verdict, depends_on_test, carries_over) = self.judged_as_a_whole();
        }
        if matches!(verdict, Verdict::Improved | Verdict::Unexplained) {
            self.refuse_pressures()?;
        }
        if verdict == Verdict::Explained {
            self.try_other_timings();
        }
        if verdict != Verdict::Unexplained {
            self.make_early_delay_per_record();
            self.try_leaner_rivals();
        }
        let mut alike = self.alike();
        let otherwise = if verdict == Verdict::Unexplained { &self.baseline } else { &self.chosen };
        let curve_fit = match verdict {
            Verdict::Adequate => None,
            Verdict::Explained if self.chosen.model.of_rig().iter().count() < 2 => None,
            Verdict::Explained => self.curve_instead_of(&self.chosen),
            Verdict::Improved if self.is_credibly_adequate() && !depends_on_test => None,
            Verdict::Improved | Verdict::Unexplained => self.fit_curve(otherwise),
        };
        if let Some(found) = curve_fit.as_ref().filter(|found| found.fate.is_accepted()) {
            self.take_curve(&found.candidate);
            depends_on_test = test_dependence::depends_on_test(&self.data, &self.chosen.fit);
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
            depends_on_test,
            carries_over,
            by_geometry,
            curve_fit,
        };
        contradictions::refuse(&self.data, &found)?;
        Ok((self.data, found))
    }

    /// The verdict on the chosen model, whether its per-record terms depend on the kind of test, and whether it carries over
    /// to records left out whole.
    fn judged_as_a_whole(&self) -> (Verdict, bool, bool) {
        let depends_on_test = test_dependence::depends_on_test(&self.data, &self.chosen.fit);
        let carries_over = self.carries_over();
        (self.verdict(depends_on_test, carries_over), depends_on_test, carries_over)
    }

    /// Tries the sets with a further effect that are predicted best; returns whether one entered. With only noise left the rounds have
    /// ended before them, but the parameters may depend on an effect hidden in the noise.
    fn try_further(&mut self) -> bool {
        let further = terms::added_to(&self.data, &self.chosen.model);
        self.try_all([further.into_iter().filter(|model| !model.has_terms_of_records()).collect()])
    }

    /// Tries sets with another effect in place of each of the chosen ones, added to `parts`, the models without it. This is for
    /// sets so large that the search, adding one effect after another, has not reached all of that size. Returns whether one
    /// entered.
    fn try_others_in_place(&mut self, parts: &[Candidate]) -> bool {
        let chosen = self.chosen.model;
        if chosen.of_rig().iter().count() < policy::EXCHANGED_FROM {
            return false;
        }
        self.keep(parts.iter().cloned());
        let others = parts.iter().flat_map(|part| terms::added_to(&self.data, &part.model));
        let models = others.filter(|model| !model.has_terms_of_records() && !model.has_same_terms(&chosen)).collect();
        self.try_all([models])
    }

    /// Appends a model with a curve as the last of the steps that led to it.
    fn take_curve(&mut self, with_curve: &Candidate) {
        self.steps.retain(|s| terms::is_part(&s.model, &with_curve.model));
        self.steps.push(with_curve.clone());
        self.tried.insert(0, with_curve.clone());
        self.chosen = with_curve.clone();
        self.chosen_adequacy = adequacy::test(&self.data, &self.chosen.fit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Model;
    use crate::search::starts::fit_model;
    use crate::synthetic::Recipe;
    use chamber::effects::{EffectSet, find};

    #[test]
    fn a_further_effect_that_is_evident_beside_effects_that_leave_noise_is_tried() {
        let [column, surface] = ["gas_column_length", "dead_volume_surface"].map(|name| find(name).unwrap().0);
        let recipe = Recipe { noise_pa: 40.0, ..Recipe::from_seed(5) }.with_strength(column, 1.0);
        let mut search = Search::after_first_fit(&recipe.with_strength(surface, 1.0));
        let fit = |search: &Search, set| {
            fit_model(&search.data, Model::with(set), &search.baseline.fit, &search.sizes).unwrap()
        };
        let both: EffectSet = [column, surface].into_iter().collect();
        search.chosen = search.judged(search.candidate(fit(&search, EffectSet::one(column))));
        search.chosen_adequacy = adequacy::test(&search.data, &search.chosen.fit);
        search.try_further();
        let found = search.tried.iter().find(|c| c.model.effects == both).unwrap();
        assert!(found.delta_bic > search.chosen.delta_bic + policy::DECISIVE || search.chosen.model.effects == both);
    }

    #[test]
    fn an_effect_that_imitates_another_one_beside_two_more_is_exchanged_for_it() {
        let set = |names: [&str; 3]| names.map(|name| find(name).unwrap().0).into_iter().collect::<EffectSet>();
        let (truth, imitation) =
            (["leakage", "sensor_drift", "wall_heating"], ["laminar_leakage", "sensor_drift", "wall_heating"]);
        let recipe = set(truth).iter().fold(Recipe::from_seed(5), |recipe, effect| recipe.with_strength(effect, 1.0));
        let mut search = Search::after_first_fit(&recipe);
        let fit = fit_model(&search.data, Model::with(set(imitation)), &search.baseline.fit, &search.sizes).unwrap();
        search.chosen = search.judged(search.candidate(fit));
        search.chosen_adequacy = adequacy::test(&search.data, &search.chosen.fit);
        let (_, parts) = search.leave_out_unneeded();
        assert!(search.try_others_in_place(&parts));
        assert_eq!(search.chosen.model.effects, set(truth));
        let (_, parts) = search.leave_out_unneeded();
        assert!(!search.try_others_in_place(&parts));
    }
}
