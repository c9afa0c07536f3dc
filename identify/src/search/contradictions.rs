//! Contradictions: a set with parameters that no chamber can have does not enter, and a rig whose records call for one is refused
//! ([`sanity`]).

use super::{Candidate, Found, Search};
use crate::error::Error;
use crate::judge::adequacy;
use crate::judge::sanity::{self, has_plausible_coefficient};
use crate::parameters::Model;
use crate::record::data::Data;
use chamber::card::Balance;
use chamber::effects::CARDS;

impl Search {
    /// Refuses wrong pressures beside the chosen model, and beside the best one with a leak: without the leak the first fit
    /// cannot show them, and with wrong pressures another term may have entered in its place.
    pub(super) fn refuse_pressures(&self) -> Result<(), Error> {
        let leaky = self.tried.iter().find(|c| has_a_leak_alone(&c.model));
        let leaky = leaky.filter(|c| c.model != self.chosen.model);
        [Some(&self.chosen), leaky].into_iter().flatten().try_for_each(|c| sanity::reference(&self.data, &c.fit))
    }

    /// Whether a set's heat transfer coefficient is acceptable. An implausible one may be due to a wrong unit of time, which the
    /// end of the search refuses, if the set leaves only noise or if that of the chosen model is implausible too. Otherwise a fit
    /// has only distorted it: the set is wrong and not the rig.
    pub(super) fn may_have_its_coefficient(&self, c: &Candidate) -> bool {
        has_plausible_coefficient(&c.fit)
            || !has_plausible_coefficient(&self.chosen.fit)
            || adequacy::has_squares_of_noise(&self.data, &c.fit)
    }
}

/// Refuses a result with an impossible dead volume or coefficient, and a dead volume that alone may have kept a better set out.
pub(super) fn refuse(data: &Data, found: &Found) -> Result<(), Error> {
    sanity::dead_volume(data, &found.reported().fit)?;
    if let Some(better) = found.better_than_reported(data) {
        sanity::dead_volume(data, &better.fit)?;
    }
    if found.set_with_plausible_coefficient().is_none() {
        sanity::coefficient(data, &found.reported().fit)?;
    }
    Ok(())
}

/// Whether the rig loses or gains gas, without per-record terms that could take that up.
fn has_a_leak_alone(model: &Model) -> bool {
    !model.has_terms_of_records() && model.effects.iter().any(|e| CARDS[e].balance == Balance::Mass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::left_out::HeldOut;
    use crate::search::starts::fit_model;
    use crate::synthetic::Recipe;
    use chamber::effects::NaturalConvection;

    #[test]
    fn a_set_that_leaves_more_than_noise_does_not_enter_with_an_implausible_coefficient() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5).with("natural_convection", &[0.4]) };
        let mut search = Search::after_first_fit(&recipe);
        let model = Model::with(NaturalConvection::SET);
        let fit = fit_model(&search.data, model, &search.baseline.fit, &search.sizes).unwrap();
        let mut better = search.candidate(fit);
        (better.delta_bic, better.held_out) = (1e6, Some(HeldOut { rmse_pa: 0.0, weighed_pa: 0.0 }));
        let takes = |search: &mut Search, c: &Candidate| {
            let before = search.chosen.clone();
            let taken = search.take_best(vec![c.clone()]);
            search.chosen = before;
            taken
        };
        assert!(takes(&mut search, &better));

        // A thousandth of the coefficient, as for times in ms declared as s.
        better.fit.rig[0] -= 1e3f64.ln();
        assert!(!has_plausible_coefficient(&better.fit));
        assert!(search.may_have_its_coefficient(&better), "it leaves only noise");
        better.fit.marginal *= 10.0;
        assert!(!search.may_have_its_coefficient(&better) && !takes(&mut search, &better));
        search.chosen.fit.rig[0] -= 1e3f64.ln();
        assert!(search.may_have_its_coefficient(&better), "the chosen model has none that can be either");
    }
}
