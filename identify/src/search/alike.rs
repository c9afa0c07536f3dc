//! Sets that the data cannot tell from the chosen one.

use super::entry::is_credible;
use super::{Candidate, Search, distinct, terms};
use crate::judge::evidence;
use crate::parameters::{Model, is_timing};
use crate::policy;
use chamber::card::Fitted;
use chamber::effects::{CARDS, EffectSet};
use rayon::prelude::*;

impl Search {
    /// Tries sets that shift or smear the records in time in another way than the chosen one: within a row a delay and a lag are
    /// hardly distinguishable, and the search need not have reached both.
    pub(super) fn try_other_timings(&mut self) {
        let models = terms::with_other_timing(&self.chosen.model);
        let fresh: Vec<Model> =
            models.into_iter().filter(|m| !self.tried.iter().any(|c| c.model.has_same_terms(m))).collect();
        let fitted = self.fit_all(&fresh);
        self.keep(fitted);
    }

    /// Tries sets close to the chosen one without free secondary parameters, if their evidence is about the same: with a
    /// parameter that is not needed, and that the chosen one lacks, they would seem distinguishable from it.
    pub(super) fn try_leaner_rivals(&mut self) {
        let chosen = &self.chosen;
        let price = |c: &Candidate| {
            let secondary = |e: usize| CARDS[e].fitted(Fitted::Secondary).count();
            let freed: usize = c.model.secondary.iter().map(secondary).sum();
            let bic = |freedom| evidence::of_squares(c.fit.marginal, c.fit.blocks, freedom);
            bic(freed) - bic(0)
        };
        let is_near = |c: &&Candidate| c.delta_bic + price(c) > chosen.delta_bic - policy::INDISTINGUISHABLE;
        let is_rival = |c: &&Candidate| is_other(&c.model, &chosen.model) && is_near(c);
        let rivals: Vec<&Candidate> = self.tried.iter().filter(is_rival).collect();
        let leaner: Vec<Candidate> = rivals.into_par_iter().filter_map(|c| self.no_longer_freed(c)).collect();
        self.keep(leaner);
    }

    /// Whether a set differs from the chosen one in how it shifts or smears the records in time, by less than half a row in
    /// either: the stroke between rows, which tells one from the other, is not known that well.
    fn differs_within_a_row(&self, other: &Candidate) -> bool {
        let [ours, theirs] = [self.chosen.model.of_rig(), other.model.of_rig()];
        let (gone, new) = (ours.without(theirs), theirs.without(ours));
        let is_one_of_time = |set: EffectSet| set.iter().count() == 1 && set.iter().all(|e| is_timing(&CARDS[e]));
        is_one_of_time(gone)
            && is_one_of_time(new)
            && seconds(&self.chosen, gone).max(seconds(other, new)) < 0.5 * self.data.shortest_row_s()
    }

    /// Sets that the data cannot tell from the chosen one: different ones with as many terms, about the same evidence or more,
    /// and credible parameters.
    pub(super) fn alike(&self) -> Vec<Model> {
        let is_near = |c: &&Candidate| {
            let by = self.chosen.delta_bic - c.delta_bic;
            by < policy::INDISTINGUISHABLE
                || by < policy::INDISTINGUISHABLE_WITHIN_A_ROW && self.differs_within_a_row(c)
        };
        let others = self.tried.iter().filter(|c| is_other(&c.model, &self.chosen.model)).filter(is_near);
        distinct(others.filter(|c| is_credible(&c.fit) && c.fit.exhausted().is_none()).map(|c| c.model).collect())
    }
}

/// Whether a set has as many terms as the chosen one, but different ones.
fn is_other(model: &Model, chosen: &Model) -> bool {
    model.terms() == chosen.terms() && !model.has_same_terms(chosen)
}

/// Largest time by which effects shift or smear the records, s.
fn seconds(c: &Candidate, effects: EffectSet) -> f64 {
    let chamber = c.fit.chamber();
    effects.iter().map(|e: usize| chamber.effects.of(e)[0]).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::starts::fit_model;
    use crate::synthetic::Recipe;
    use chamber::effects::{GasColumnLength, find};

    #[test]
    fn a_delay_within_a_row_is_indistinguishable_from_a_lag_that_the_search_did_not_reach() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5).with("sensor_lag", &[1.5e-3]) };
        let mut search = Search::after_first_fit(&recipe);
        let single = |name: &str| Model::with(EffectSet::one(find(name).unwrap().0));
        let fit = fit_model(&search.data, single("record_delay"), &search.baseline.fit, &search.sizes).unwrap();
        search.chosen = search.candidate(fit);
        assert_eq!(search.alike(), []);
        search.try_other_timings();
        assert!(search.alike().contains(&single("sensor_lag")), "{:?}", search.alike());
    }

    #[test]
    fn a_rival_is_indistinguishable_without_the_parameter_that_it_does_not_need() {
        let [column, surface, exponent] =
            ["gas_column_length", "dead_volume_surface", "pressure_exponent"].map(|name| find(name).unwrap().0);
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) }.with_strength(surface, 0.3);
        let mut search = Search::after_first_fit(&recipe.with_strength(exponent, 1.0));
        let with = |other: usize| Model::with([other, exponent].into_iter().collect());
        let fitted = |model| fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap();
        let freed = Model { secondary: EffectSet::one(exponent), ..with(column) };
        search.chosen = search.candidate(fitted(with(surface)));
        search.tried = vec![search.candidate(fitted(freed))];
        let lean = search.candidate(fitted(with(column))).delta_bic;
        assert!(lean > search.tried[0].delta_bic && search.tried[0].model.has_same_terms(&with(column)));
        search.chosen.delta_bic = lean + 0.5 * policy::INDISTINGUISHABLE;
        assert_eq!(search.alike(), []);
        search.try_leaner_rivals();
        assert_eq!(search.alike(), [with(column)]);
    }

    #[test]
    fn a_wrong_gas_gives_the_dead_volume_surface_no_more_evidence_than_the_gas_column_length() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) }.with_strength(GasColumnLength::INDEX, 1.0);
        recipe.faults.stated.heat_capacity_ratio_times = 0.999;
        let mut search = Search::after_first_fit(&recipe);
        let [column, surface] = ["gas_column_length", "dead_volume_surface"].map(|name| {
            let model = Model::with(EffectSet::one(find(name).unwrap().0));
            search.candidate(fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap())
        });
        assert!(surface.fit.chi2 < column.fit.chi2, "in the gas as stated the surface fits better");
        assert!(column.delta_bic > surface.delta_bic + policy::INDISTINGUISHABLE);
        search.tried = vec![surface.clone(), column.clone()];
        search.chosen = column;
        assert_eq!(search.alike(), []);
        search.chosen = surface;
        assert_eq!(search.alike().len(), 1);
    }
}
