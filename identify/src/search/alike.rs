//! Sets that the data cannot tell from the chosen one.

use super::entry::is_credible;
use super::{Candidate, Search, distinct, terms};
use crate::parameters::{Model, is_timing};
use crate::policy;
use chamber::effects::{CARDS, EffectSet};

impl Search {
    /// Tries the sets beside the chosen one that shift or smear the records in time otherwise: within a row a delay and a lag are
    /// hardly told apart, and the search need not have come to both.
    pub(super) fn try_other_timings(&mut self) {
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

    /// Sets that the data cannot tell from the chosen one: others of as many terms with about the same evidence or more, whose numbers
    /// can be a rig's.
    pub(super) fn alike(&self) -> Vec<Model> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::starts::fit_model;
    use crate::synthetic::Recipe;
    use chamber::effects::{GasColumnLength, find};

    #[test]
    fn a_delay_within_a_row_is_alike_to_a_lag_that_the_search_did_not_come_to() {
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
    fn a_surface_of_the_dead_volume_has_no_more_evidence_than_a_columns_length_because_the_gas_is_off() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) }.with_strength(GasColumnLength::PLACE, 1.0);
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
