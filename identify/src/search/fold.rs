//! What each record has for itself of its times, as one number of the rig.
//!
//! Delays that agree are a property of the rig, and one number instead of many. A fit that begins from no delay need not get
//! there: over a common delay the error has a corner wherever the end of a move passes a row, while delays that each record has
//! for itself come there one by one. Hence the mean of those is where to begin.

use super::{Candidate, Search, sort, starts, terms};
use crate::fit::{self, Fit};
use crate::judge::adequacy;
use crate::parameters::{self, Hypothesis, Model, Own};
use crate::record::prepare::Data;
use chamber::Chamber;
use chamber::effects::{self, CARDS, EffectSet};

impl Search {
    /// Lets each delay or average of the chosen model that its records have for themselves be one of the rig, where that is
    /// decisively better, which judges whether they agree. It is one of the rig too where it then predicts left-out data
    /// better: what is freer has to predict no worse, or it follows something else than what its name says.
    pub(super) fn fold(&mut self) {
        let own: Vec<usize> = self.chosen.model.own.iter().filter(|e| terms::of_timing().has(*e)).collect();
        let fits = own.into_iter().filter_map(|e| self.in_common(e));
        let mut folded: Vec<Candidate> = fits.map(|fit| self.candidate(fit)).collect();
        if folded.is_empty() {
            return;
        }
        self.judge(&mut folded, usize::MAX);
        self.tried.extend(folded.iter().cloned());
        sort(&mut self.tried);
        if self.take_best(folded.clone()) {
            return;
        }
        let accuracy_pa = self.data.accuracy_pa();
        let best = folded.into_iter().filter(|c| c.fit.converged && self.errs_less_on_left_out(c, accuracy_pa));
        let Some(best) = best.max_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic)) else { return };
        self.chosen_adequacy = adequacy::test(&self.data, &best.fit);
        self.steps.pop();
        self.steps.push(best.clone());
        self.chosen = best;
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
        let common =
            if is_early { effects::all().map(|(e, _)| e).find(|e| parameters::delays_position(*e))? } else { effect };
        let without = whole.effects.without(EffectSet::one(effect));
        if without.has(common) {
            return None;
        }
        let model = Model {
            effects: without.union(EffectSet::one(common)),
            own: whole.own.without(EffectSet::one(effect)),
            secondary: EffectSet::NONE,
            ..*whole
        };
        let chamber = fit.chamber();
        let mut values = chamber.effects.without(EffectSet::one(effect));
        for (p, mean) in means {
            values.of_mut(common)[p] = mean.abs();
        }
        let chamber = Chamber { effects: values, ..chamber };
        let h = Hypothesis::new(&self.data, model, &chamber, &self.sizes);
        let own = starts::owns(&self.data, &h, fit);
        fit::fit(&self.data, &h, h.coordinates(&chamber), own, &fit::all_blocks(&self.data)).ok()
    }
}

/// Mean over the records of a number that each has for itself.
fn mean_of_records(data: &Data, fit: &Fit, slot: Own) -> Option<f64> {
    let values: Option<Vec<f64>> = data
        .traces
        .iter()
        .zip(&fit.own)
        .map(|(t, own)| {
            let axes = fit.hypothesis.own_of(t);
            let place = axes.iter().position(|axis| axis.slot == slot)?;
            Some(axes[place].value(own[place]))
        })
        .collect();
    values.map(|values| values.iter().sum::<f64>() / values.len() as f64)
}
