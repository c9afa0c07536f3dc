//! What each record has for itself, as one number of the rig.
//!
//! Delays, offsets and drifts that agree are a property of the rig, and one number instead of many. A fit that begins without
//! them need not get there: over a common delay the error has a corner wherever the end of a move passes a row, and a drift
//! beside a leak is first taken by the records' own ones, which enter the search before it. Hence the mean of those is where to
//! begin.

use super::{Candidate, Search, starts, terms};
use crate::fit::{self, Fit};
use crate::judge::adequacy;
use crate::parameters::{self, Hypothesis, Model, Own};
use crate::policy;
use crate::record::data::Data;
use chamber::Chamber;
use chamber::effects::{CARDS, EffectSet};

impl Search {
    /// Lets each effect of the chosen model that its records have for themselves be one of the rig, where the evidence for one
    /// number is decisive, which judges whether the records agree, and left-out data are predicted no worse by what matters. It
    /// is one of the rig too where left-out data are predicted better: what is freer has to predict no worse, or it follows
    /// something else than what its name says.
    pub(super) fn fold(&mut self) {
        let fits = self.chosen.model.own.iter().filter_map(|e| self.in_common(e));
        let mut folded: Vec<Candidate> = fits.map(|fit| self.candidate(fit)).collect();
        if folded.is_empty() {
            return;
        }
        self.judge(&mut folded, usize::MAX);
        self.keep(folded.iter().cloned());
        let best = folded.into_iter().filter(|c| self.agrees(c)).max_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
        let Some(best) = best else { return };
        self.put_in_place_of_chosen(best);
    }

    /// A model takes the place of the chosen one, and that of its step: it says the same in other scopes, or is alike.
    pub(super) fn put_in_place_of_chosen(&mut self, other: Candidate) {
        self.chosen_adequacy = adequacy::test(&self.data, &other.fit);
        self.steps.pop();
        self.steps.push(other.clone());
        self.chosen = other;
    }

    /// Whether one number in common is as good as one for each record.
    fn agrees(&self, c: &Candidate) -> bool {
        let accuracy_pa = self.data.accuracy_pa();
        let (Some(common), Some(own)) = (c.held_out_pa(), self.chosen.held_out_pa()) else { return false };
        let evident = c.delta_bic - self.chosen.delta_bic > policy::DECISIVE
            && common.powi(2) - own.powi(2) < accuracy_pa.powi(2);
        c.fit.converged && (evident || c.errs_less(&self.chosen, accuracy_pa))
    }

    /// The chosen model fitted with an effect in common that its records have for themselves.
    fn in_common(&self, effect: usize) -> Option<Fit> {
        let fit = &self.chosen.fit;
        let whole = &fit.hypothesis.model;
        let means: Vec<(usize, f64)> = (0..CARDS[effect].parameters.len())
            .filter_map(|p| Some((p, mean_of_records(&self.data, fit, Own::Effect(effect, p))?)))
            .collect();
        // A pressure that is early beside its position is a position that is late.
        let is_early = parameters::delays_pressure(effect) && means.iter().any(|(_, mean)| *mean < 0.0);
        let common = if is_early { terms::effect_that(parameters::delays_position)? } else { effect };
        let without = whole.without(EffectSet::one(effect));
        if without.effects.has(common) {
            return None;
        }
        let model = Model { effects: without.effects.union(EffectSet::one(common)), ..without };
        let chamber = fit.chamber();
        let mut values = chamber.effects.without(EffectSet::one(effect));
        for (p, mean) in means {
            values.of_mut(common)[p] = if is_early { -mean } else { mean };
        }
        let chamber = Chamber { effects: values, ..chamber };
        let h = Hypothesis::new(&self.data, model, &chamber, &self.sizes);
        let own = starts::owns(&self.data, &h, fit);
        fit::fit(&self.data, &h, h.coordinates(&chamber), own, &fit::all_blocks(&self.data)).ok()
    }
}

/// Mean over the records of a number that each has for itself.
fn mean_of_records(data: &Data, fit: &Fit, slot: Own) -> Option<f64> {
    let of_each = fit.hypothesis.of_each(data, &fit.own, slot);
    let values: Option<Vec<f64>> = of_each.map(|number| number.map(|(axis, x)| axis.value(x))).collect();
    values.map(|values| values.iter().sum::<f64>() / values.len() as f64)
}
