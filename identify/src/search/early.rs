//! Pressures after a digital low-pass, which are early by a fraction of a row.
//!
//! A digital filter has already read its latest input when it answers: y_k = a y_{k−1} + (1 − a) u_k is ahead of the
//! low-pass τ dy/dt = u − y with a = e^(−h/τ) by half of its step h. Beside an unfiltered position, a pressure that lags and is
//! early by less than a row therefore does not mean a late position: the delay is made a per-record one, and is not named.

use super::{Candidate, Search, sort, starts, terms};
use crate::fit;
use crate::parameters::{Hypothesis, Model, delays_position, delays_pressure};
use crate::record::data::Data;
use chamber::Chamber;
use chamber::effects::EffectSet;

impl Search {
    /// Makes the time by which a digital low-pass of the pressure is early a per-record delay, where the chosen model has it as a
    /// late position of the rig.
    pub(super) fn make_early_delay_per_record(&mut self) {
        let Some(other) = self.with_per_record_delay(&self.chosen) else { return };
        self.tried.retain(|c| earliness(&self.data, c).is_none());
        self.tried.push(other.clone());
        sort(&mut self.tried);
        self.put_in_place_of_chosen(other);
    }

    fn with_per_record_delay(&self, c: &Candidate) -> Option<Candidate> {
        let early_s = earliness(&self.data, c)?;
        let (late, delay) = (terms::effect_that(delays_position)?, terms::effect_that(delays_pressure)?);
        if c.model.effects.has(delay) {
            return None;
        }
        let (gone, new) = (EffectSet::one(late), EffectSet::one(delay));
        let without = c.model.without(gone);
        let model = Model { effects: without.effects.union(new), per_record: without.per_record.union(new), ..without };
        let chamber = c.fit.chamber();
        let mut chamber = Chamber { effects: chamber.effects.without(gone), ..chamber };
        chamber.effects.of_mut(delay)[0] = -early_s;
        let h = Hypothesis::new(&self.data, model, &chamber, &self.sizes);
        let records = starts::record_coordinates(&self.data, &h, &c.fit);
        let fit = fit::fit(&self.data, &h, h.coordinates(&chamber), records, &fit::all_blocks(&self.data)).ok()?;
        fit.converged.then(|| self.judged(self.candidate(fit)))
    }
}

/// Time by which the pressures of a model are early relative to the positions, s, where a digital low-pass may be the cause.
fn earliness(data: &Data, c: &Candidate) -> Option<f64> {
    let (of_rig, chamber) = (c.model.of_rig(), c.fit.chamber());
    let early_s = chamber.effects.stroke_delay(of_rig) + chamber.effects.stroke_filter(of_rig);
    let lags = chamber.effects.lag(of_rig) > 0.0;
    (lags && early_s > 0.0 && early_s < data.shortest_row_s()).then_some(early_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::{Found, search};
    use crate::synthetic::Recipe;
    use chamber::effects::{RecordDelay, find};

    /// The result for a rig whose pressure passes a low-pass of 20 ms, computed at each of its rows, every 10 ms.
    fn found(digital: bool, late_s: f64) -> Found {
        let mut recipe = Recipe { repeats: 1, rate_hz: 100.0, ..Recipe::from_seed(5) };
        (recipe.faults.low_pass_s, recipe.faults.digital, recipe.faults.position_delay_s) = (0.02, digital, late_s);
        search(Data::prepare(&recipe.rig()).unwrap(), &|_, _| ()).unwrap().1
    }

    fn set(names: &[&str]) -> EffectSet {
        names.iter().map(|name| find(name).unwrap().0).collect()
    }

    #[test]
    fn the_earliness_of_a_digital_low_pass_is_no_position_delay() {
        let found = found(true, 0.0);
        let Model { effects, per_record, .. } = found.chosen.model;
        assert_eq!((effects, per_record), (set(&["sensor_lag", "record_delay"]), set(&["record_delay"])));
        let fit = &found.chosen.fit;
        let delay = RecordDelay::INDEX;
        assert_eq!(fit.chamber_of_rig().effects.of(delay), [0.0], "the model as it is written");
        for record in &fit.records {
            let (axis, x) = fit.hypothesis.record_effects.last().zip(record.last()).unwrap();
            assert!((axis.value(*x) + 0.005).abs() < 1e-3, "{}", axis.value(*x));
        }
        let late = set(&["sensor_lag", "position_delay"]);
        assert!(!found.tried.iter().any(|c| c.model.effects == late));
    }

    #[test]
    fn a_position_delay_of_more_than_a_row_is_named_beside_a_lag() {
        assert_eq!(found(false, 0.0).chosen.model, Model::with(set(&["sensor_lag"])));
        assert_eq!(found(false, 0.03).chosen.model.of_rig(), set(&["sensor_lag", "position_delay"]));
    }
}
