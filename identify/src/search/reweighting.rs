//! Restarts the search with other weights of the data: the outliers, the noise and the uncertainty of moves that a better model
//! shows.

use super::starts::fit_model;
use super::{Candidate, Search, baseline, sort, terms};
use crate::fit::{self, Fit, Until};
use crate::judge::{adequacy, evidence, left_out, misfit};
use crate::policy;
use crate::record::colour;
use crate::record::data::Data;
use crate::record::plausibility::outliers;
use rayon::prelude::*;

/// The data reweighted by a fit: with the outliers and timings that it shows, and with the noise of its residual if
/// `tells_noise` or if that is far less than what was taken for noise; `None` where nothing changes.
pub fn reweighted(data: &Data, fit: &Fit, tells_noise: bool) -> Option<Data> {
    let residuals = misfit::residuals(data, fit);
    let found = outliers::in_residuals(data, &residuals);
    let mut other = data.with_timings(&fit.sensor_timings(data));
    other = other.as_ref().unwrap_or(data).with_convection_responses(fit.convection_responses_pa(data)).or(other);
    if !data.is_without(&found) {
        other = Some(other.unwrap_or_else(|| data.clone()).without(&found));
    }
    let shown = other.as_ref().unwrap_or(data);
    // Repeats that differ within the uncertainty of their moves seemed to differ by more than noise before.
    let tells_noise = tells_noise || shown.has_convection_errors();
    let leaves_far_less = misfit::rms(shown, &residuals) < policy::FAR_LESS_NOISE * shown.noise.total_pa();
    if tells_noise || leaves_far_less {
        let noise = colour::estimate(shown, &residuals, &shown.noise);
        if !baseline::is_alike(&noise, &shown.noise) {
            other = Some(other.unwrap_or_else(|| data.clone()).with_noise(noise));
        }
    }
    other
}

impl Search {
    /// Restarts with the outliers and the noise that this fit shows and, where its records are moving averages, with the
    /// uncertainty of moves that these leave; returns whether the data have changed. The paper's model is then refitted.
    pub(super) fn reweigh_by(&mut self, best: &Fit) -> bool {
        let Some(data) = reweighted(&self.data, best, true) else { return false };
        self.restart(data);
        true
    }

    /// Restarts with the data as the chosen model shows them, whatever round found it: with the uncertainty of moves where the
    /// records are averages, without its outliers, and with its noise where it has per-record timings, or leaves far less noise.
    /// Before, repeats that were read at different times, or that moved differently, differ by more than noise. Everything tried
    /// is refitted.
    pub(super) fn reweigh(&mut self) {
        let has_record_timings = self.chosen.model.per_record.iter().any(|e| terms::of_timing().has(e));
        let Some(data) = reweighted(&self.data, &self.chosen.fit, has_record_timings) else { return };
        self.restart(data);
        let mut tried = self.refitted(&self.tried);
        self.judge(&mut tried, policy::REJUDGED);
        self.tried = tried;
        self.take_best(self.tried.clone());
    }

    /// Fits the paper's model to reweighted data, and restarts the search with it.
    fn restart(&mut self, data: Data) {
        self.data = data;
        // Other outliers make other blocks.
        self.folds = left_out::folds(&self.data);
        let fit = self.refit(&self.baseline.fit, Until::SETTLED).unwrap_or_else(|| self.baseline.fit.clone());
        self.baseline_adequacy = adequacy::test(&self.data, &fit);
        self.baseline = self.judged(Candidate { fit, held_out: None, ..self.baseline.clone() });
        self.chosen = self.baseline.clone();
        self.chosen_adequacy = self.baseline_adequacy.clone();
        self.steps = vec![self.baseline.clone()];
    }

    pub(super) fn refit(&self, fit: &Fit, until: Until) -> Option<Fit> {
        let selection = fit::all_blocks(&self.data);
        fit::fit_until(&self.data, &fit.hypothesis, fit.rig.clone(), fit.records.clone(), &selection, until).ok()
    }

    /// Refits candidates, given best first; those that stay far above the best are given up.
    pub(super) fn refitted(&self, candidates: &[Candidate]) -> Vec<Candidate> {
        let Some((first, others)) = candidates.split_first() else { return Vec::new() };
        let best = self.refit(&first.fit, Until::SETTLED);
        let until = best.as_ref().map_or(Until::SETTLED, |best| Until::beside(best.chi2));
        let others = others.par_iter().filter_map(|c| self.refit(&c.fit, until)).collect::<Vec<_>>();
        let again: Vec<Candidate> = best.into_iter().chain(others).map(|fit| self.candidate(fit)).collect();
        let mut out: Vec<Candidate> = again.par_iter().map(|c| self.no_worse_than_a_part(c, &again)).collect();
        sort(&mut out);
        out
    }

    /// A candidate, refitted from the best of its parts among the others where that fits better: with other weights of the data
    /// the part may have moved to a lower valley while the candidate stayed where it was.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Model;
    use crate::synthetic::{Recipe, Shape};
    use chamber::effects::{ForcedConvection, Leakage};

    #[test]
    fn a_set_that_ends_worse_than_its_part_is_refitted_from_that_part() {
        let search = Search::after_first_fit(&Recipe::from_seed(5));
        let model = Model::with(Leakage::SET);
        let fit = fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap();
        let good = search.candidate(fit);
        assert_eq!(search.no_worse_than_a_part(&good, &[]).fit.marginal, good.fit.marginal);
        let mut stuck = good.clone();
        stuck.fit.marginal *= 2.0;
        let anew = search.no_worse_than_a_part(&stuck, &[]);
        assert!((anew.fit.marginal / good.fit.marginal - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_uncertainty_of_forced_convection_in_fast_moves_is_neither_noise_nor_misfit() {
        let mut recipe = Recipe { noise_pa: 20.0, ..Recipe::from_seed(5) }.with("forced_convection", &[4.0]);
        recipe.tests.iter_mut().flat_map(|test| &mut test.moves).for_each(|(_, length_s, shape, _)| {
            (*length_s, *shape) = (0.07, Shape::Trapezoid);
        });
        let search = Search::after_first_fit(&recipe);
        let (model, mut data, mut fit) =
            (Model::with(ForcedConvection::SET), search.data.clone(), search.baseline.fit.clone());
        let mut deviations = Vec::new();
        for _ in 0..2 {
            fit = fit_model(&data, model, &fit, &search.sizes).unwrap();
            deviations.push(adequacy::test(&data, &fit).squares_deviations);
            data = reweighted(&data, &fit, false).unwrap_or(data);
        }
        assert!(
            data.has_convection_errors() && data.noise.colours.is_empty() && data.noise.hum.is_none(),
            "{:?}",
            data.noise
        );
        assert!((data.noise.white_pa / 20.0 - 1.0).abs() < 0.1, "{:?}", data.noise);
        assert!(
            deviations[0] > 2.0 * policy::SQUARES_DEVIATIONS && deviations[1] < policy::SQUARES_DEVIATIONS,
            "{deviations:?}"
        );
        let truth = recipe.chamber.heat_transfer.coefficient;
        let found = fit.chamber().heat_transfer.coefficient;
        assert!((found / truth - 1.0).abs() < 0.05, "{found} {truth}");
        // A model without forced convection does not show this.
        assert!(!reweighted(&data, &search.baseline.fit, false).unwrap().has_convection_errors());
    }
}
