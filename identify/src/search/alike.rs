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

    /// Sets that the data cannot tell from the chosen one.
    pub(super) fn alike(&self) -> Vec<Model> {
        distinct(self.others_alike().map(|c| c.model).collect())
    }

    /// Other sets of as many terms with about the same evidence or more, whose numbers can be a rig's.
    fn others_alike(&self) -> impl Iterator<Item = &Candidate> {
        let chosen = self.chosen.model;
        let is_other = move |m: &Model| m.terms() == chosen.terms() && !m.has_same_terms(&chosen);
        let is_near = |c: &&Candidate| {
            let by = self.chosen.lead_over(c);
            by < policy::INDISTINGUISHABLE
                || by < policy::INDISTINGUISHABLE_WITHIN_A_ROW && self.differs_within_a_row(c)
        };
        let others = self.tried.iter().filter(move |c| is_other(&c.model)).filter(is_near);
        others.filter(|c| is_credible(&c.fit) && c.fit.exhausted().is_none())
    }

    /// Takes the likeliest of the sets alike in the place of the chosen one, where that is likelier only with the gas exactly as
    /// stated; whether one is. Nobody knows a gas so well, and the search, which compares fits in the gas as stated, may have
    /// followed an effect that stands for the rest. A set that is likelier in that gas, too, did not enter for another reason, and one
    /// with terms of single records in the place of effects says less.
    pub(super) fn take_likelier_in_uncertain_gas(&mut self) -> bool {
        let lead = |c: &Candidate| c.lead_over(&self.chosen);
        let says_as_much = |c: &&Candidate| c.model.own == self.chosen.model.own;
        let likely = self.others_alike().filter(says_as_much).filter(|c| c.delta_bic < self.chosen.delta_bic);
        let likeliest = likely.max_by(|a, b| lead(a).total_cmp(&lead(b)));
        let Some(likelier) = likeliest.filter(|c| lead(c) > policy::INDISTINGUISHABLE).cloned() else { return false };
        self.put_in_place_of_chosen(self.judged(likelier));
        true
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
    use chamber::effects::find;

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
    fn of_sets_alike_the_likelier_one_in_a_gas_known_within_its_tolerance_is_chosen() {
        let mut recipe =
            Recipe { repeats: 1, ..Recipe::from_seed(5) }.with_strength(find("gas_column_length").unwrap().0, 1.0);
        recipe.faults.stated.heat_capacity_ratio_times = 0.999;
        let mut search = Search::after_first_fit(&recipe);
        let [column, surface] = ["gas_column_length", "dead_volume_surface"].map(|name| {
            let model = Model::with(EffectSet::one(find(name).unwrap().0));
            search.candidate(fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap())
        });
        assert!(surface.delta_bic > column.delta_bic + policy::DECISIVE);
        search.tried = vec![surface.clone(), column.clone()];
        search.chosen = surface;
        search.tried[1].delta_bic = search.chosen.delta_bic + 1.0;
        assert!(!search.take_likelier_in_uncertain_gas());
        search.tried[1] = Candidate { model: Model { own: column.model.effects, ..column.model }, ..column.clone() };
        assert!(!search.take_likelier_in_uncertain_gas());
        search.tried[1] = column.clone();
        assert!(search.take_likelier_in_uncertain_gas());
        assert_eq!(search.chosen.model, column.model);
        assert_eq!(search.alike(), []);
        assert!(!search.take_likelier_in_uncertain_gas());
    }
}
