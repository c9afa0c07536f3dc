//! Removes terms that are not needed from the chosen model.
//!
//! A term stays if it is decisive beside the others, also with the stated parameters far more uncertain than stated, γ within its
//! tolerance: an effect that a wrong bore or humid air could imitate is not named.

use super::entry::is_credible;
use super::starts::fit_model;
use super::{Candidate, Found, Search, terms};
use crate::fit::Fit;
use crate::judge::adequacy;
use crate::judge::evidence::bic_widened;
use crate::parameters::Model;
use crate::policy;
use chamber::effects::EffectSet;
use rayon::prelude::*;

impl Search {
    /// Removes terms that are not decisive beside the others, and effects that a wrong geometry could imitate; returns the last
    /// of the latter, and the models without each of the remaining terms in turn.
    pub(super) fn leave_out_unneeded(&mut self) -> (Option<EffectSet>, Vec<Candidate>) {
        let mut by_geometry = None;
        while self.chosen.model.terms() > 0 {
            let mut parts = self.without_one();
            let needed: Vec<f64> = parts.iter().map(|less| self.chosen.least_gain_over(less)).collect();
            let weakest = (0..parts.len()).min_by(|a, b| needed[*a].total_cmp(&needed[*b]));
            let Some(weakest) = weakest else { break };
            if needed[weakest] > policy::DECISIVE {
                return (by_geometry, parts);
            }
            let less = parts.swap_remove(weakest);
            let gone = self.chosen.model.effects.without(less.model.effects);
            if self.needed(&less) > policy::DECISIVE && !gone.is_empty() {
                by_geometry = Some(gone);
            }
            self.steps.retain(|s| terms::is_part(&s.model, &less.model) && s.model != less.model);
            self.chosen_adequacy = adequacy::test(&self.data, &less.fit);
            self.chosen = self.judged(less);
            self.steps.push(self.chosen.clone());
        }
        (by_geometry, Vec::new())
    }

    /// The chosen model without each of its terms in turn: with the others' free secondary parameters, in whose place a term may
    /// have entered, or with none of them free, whichever has the better evidence.
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

    /// A part of the chosen model, the better of the one tried and a fit from the chosen parameters: a fit that ended short of
    /// its optimum would make a term seem needed.
    pub(super) fn part_refitted(&self, model: Model) -> Option<Candidate> {
        let known = self.tried.iter().find(|c| c.model == model).cloned();
        let anew = self.refitted_without(&self.chosen.fit, model).map(|fit| self.candidate(fit));
        known.into_iter().chain(anew).max_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic))
    }

    /// Fits a part of a fitted model, starting from its parameters there.
    pub(super) fn refitted_without(&self, whole: &Fit, model: Model) -> Option<Fit> {
        let mut from = whole.clone();
        let gone = whole.hypothesis.model.effects.without(model.effects);
        from.hypothesis.base = whole.chamber();
        from.hypothesis.base.effects = from.hypothesis.base.effects.without(gone);
        from.hypothesis.axes.clear();
        from.rig.clear();
        fit_model(&self.data, model, &from, &self.sizes)
    }

    /// Evidence of the chosen model over one with a term less.
    fn needed(&self, less: &Candidate) -> f64 {
        self.chosen.delta_bic - less.delta_bic
    }
}

impl Candidate {
    /// Evidence over another candidate: the smaller of that with the tolerances as stated and that with the geometry far more
    /// uncertain.
    fn least_gain_over(&self, less: &Candidate) -> f64 {
        let wide = |c: &Candidate| bic_widened(&c.fit, policy::GEOMETRY_WIDENED);
        (self.delta_bic - less.delta_bic).min(wide(less) - wide(self))
    }
}

impl Found {
    /// The tried sets with credible parameters and no exhausted effect.
    pub(crate) fn credible_sets(&self) -> impl Iterator<Item = &Candidate> {
        self.tried.iter().filter(|c| is_credible(&c.fit) && c.fit.exhausted().is_none())
    }

    /// The best set with one effect more than the chosen one whose evidence is decisive with a wide geometry too. It is not named
    /// because it removes less than the requested accuracy, but asking for less accurate pressures does not mean asking for less
    /// certain parameters.
    pub(crate) fn evident_beside_chosen(&self) -> Option<&Candidate> {
        let chosen = &self.chosen;
        let is_next =
            |c: &&Candidate| terms::is_part(&chosen.model, &c.model) && c.model.terms() == chosen.model.terms() + 1;
        let can_be =
            |c: &&Candidate| !c.model.has_terms_of_records() && is_credible(&c.fit) && c.fit.exhausted().is_none();
        let best = self.tried.iter().filter(is_next).filter(can_be).max_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
        best.filter(|best| best.least_gain_over(chosen) > policy::DECISIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Recipe;
    use chamber::effects::{GasZones, Leakage, SensorDrift};

    #[test]
    fn gas_zones_that_imitate_humid_air_are_removed_again_and_noise_is_left() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.faults.stated.heat_capacity_ratio_times = 1.001;
        let mut search = Search::after_first_fit(&recipe);
        let zones = Model::with(GasZones::SET);
        let fit = fit_model(&search.data, zones, &search.baseline.fit, &search.sizes).unwrap();
        search.chosen = search.candidate(fit);
        assert!(search.needed(&search.baseline) < policy::DECISIVE);
        search.leave_out_unneeded();
        assert_eq!(search.chosen.model, Model::PAPER);
        assert!(search.chosen_adequacy.is_noise);
    }

    #[test]
    fn a_term_that_imitated_a_freed_parameter_of_another_is_removed_again() {
        let (leakage, drift) = (Leakage::INDEX, SensorDrift::INDEX);
        let mut recipe = Recipe::from_seed(5);
        recipe.chamber.effects.of_mut(leakage)[..2].copy_from_slice(&[2e-11, 0.1]);
        let mut search = Search::after_first_fit(&recipe);
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
}
