//! Per-record effects that become one effect of the rig.
//!
//! Delays, offsets and drifts that agree between records are a property of the rig, with one value instead of many. A fit that
//! starts without them need not find that: over a common delay the error has a corner wherever the end of a move passes a row, and
//! a drift beside a leak is first taken up by per-record drifts, which enter the search earlier. The fit therefore starts at the
//! mean of the per-record values.

use super::{Candidate, Search, starts, terms};
use crate::fit::{self, Fit};
use crate::judge::adequacy;
use crate::parameters::{self, Hypothesis, Model, RecordSlot};
use crate::policy;
use crate::record::data::Data;
use chamber::Chamber;
use chamber::effects::{CARDS, EffectSet};

impl Search {
    /// Turns the best suited per-record effect of the chosen model into one of the rig: where the evidence for a common value,
    /// which decides whether the records agree, is decisive and left-out data are predicted no worse by more than the accuracy.
    /// Also where they are predicted better: the freer model must not predict worse, or it follows something else than its name
    /// says.
    pub(super) fn pool(&mut self) {
        let fits = self.chosen.model.per_record.iter().filter_map(|e| self.in_common(e));
        let mut pooled: Vec<Candidate> = fits.map(|fit| self.candidate(fit)).collect();
        if pooled.is_empty() {
            return;
        }
        self.judge(&mut pooled, usize::MAX);
        self.keep(pooled.iter().cloned());
        let best = pooled.into_iter().filter(|c| self.agrees(c)).max_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
        let Some(best) = best else { return };
        self.put_in_place_of_chosen(best);
    }

    /// Replaces the chosen model and its step by a model that says the same in other scopes, or that is indistinguishable.
    pub(super) fn put_in_place_of_chosen(&mut self, other: Candidate) {
        self.chosen_adequacy = adequacy::test(&self.data, &other.fit);
        self.steps.pop();
        self.steps.push(other.clone());
        self.chosen = other;
    }

    /// Whether one common value is as good as one per record.
    fn agrees(&self, c: &Candidate) -> bool {
        let accuracy_pa = self.data.accuracy_pa();
        let (Some(common), Some(separate)) = (c.held_out_pa(), self.chosen.held_out_pa()) else { return false };
        let evident = c.delta_bic - self.chosen.delta_bic > policy::DECISIVE
            && common.powi(2) - separate.powi(2) < accuracy_pa.powi(2);
        c.fit.converged && (evident || c.errs_less(&self.chosen, accuracy_pa))
    }

    /// Fits the chosen model with one of its per-record effects in common.
    fn in_common(&self, effect: usize) -> Option<Fit> {
        let fit = &self.chosen.fit;
        let whole = &fit.hypothesis.model;
        let means: Vec<(usize, f64)> = (0..CARDS[effect].parameters.len())
            .filter_map(|p| Some((p, mean_of_records(&self.data, fit, RecordSlot::Effect(effect, p))?)))
            .collect();
        // A pressure that is early relative to its position is a position that is late.
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
        let records = starts::record_coordinates(&self.data, &h, fit);
        fit::fit(&self.data, &h, h.coordinates(&chamber), records, &fit::all_blocks(&self.data)).ok()
    }
}

/// Mean over the records of a per-record parameter.
fn mean_of_records(data: &Data, fit: &Fit, slot: RecordSlot) -> Option<f64> {
    let of_each = fit.hypothesis.of_each(data, &fit.records, slot);
    let values: Option<Vec<f64>> = of_each.map(|number| number.map(|(axis, x)| axis.value(x))).collect();
    values.map(|values| values.iter().sum::<f64>() / values.len() as f64)
}
