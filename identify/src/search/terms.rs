//! Terms that a model can gain or lose in one step: an effect of the rig, a per-record effect of the recording, the records'
//! initial temperatures, and those of a wall that warms.

use crate::parameters::{self, Model, RecordStart};
use crate::policy;
use crate::record::data::Data;
use chamber::card::{ActsOn, Card, Scope, Tried, Unit};
use chamber::effects::{self, CARDS, EffectSet};

/// The models with one term more; what is freed of the others stays free, as they needed it alone.
pub fn added_to(data: &Data, model: &Model) -> Vec<Model> {
    let suits = |card: &Card| match card.tried {
        Tried::Always => true,
        Tried::BesideOthers => !model.of_rig().is_empty(),
        Tried::Never => false,
    };
    let mut out = Vec::new();
    for (e, card) in effects::all().filter(|(e, card)| suits(card) && !model.effects.has(*e)) {
        let one = EffectSet::one(e);
        let effects = model.effects.union(one);
        out.push(Model { effects, ..*model });
        // A per-record delay has either sign: a second one, of the position, would be equivalent.
        if is_of_record(card) && data.traces.len() > 1 && !parameters::delays_position(e) {
            out.push(Model { effects, per_record: model.per_record.union(one), ..*model });
        }
    }
    let longer =
        RecordStart::ALL.into_iter().filter(|start| model.record_start < *start && *start <= model.most_of_start());
    out.extend(longer.map(|start| Model { record_start: start, ..*model }));
    out
}

/// All pairs of these models that share no terms but those of `base`, which is a part of each.
pub fn pairs(models: &[Model], base: &Model) -> Vec<Model> {
    let mut out = Vec::new();
    for (i, a) in models.iter().enumerate() {
        for b in &models[i + 1..] {
            let joined = Model {
                effects: a.effects.union(b.effects),
                per_record: a.per_record.union(b.per_record),
                secondary: a.secondary.union(b.secondary),
                record_start: a.record_start.max(b.record_start),
            };
            if joined.terms() + base.terms() == a.terms() + b.terms() {
                out.push(joined);
            }
        }
    }
    out
}

/// Whether a model has no more terms than allowed: see [`policy::MOST_TERMS`].
pub fn is_small(model: &Model) -> bool {
    let gas = |e: &usize| !matches!(CARDS[*e].acts_on, ActsOn::Reading | ActsOn::RecordedStroke);
    let of_gas = model.effects.iter().filter(gas).count();
    of_gas <= policy::MOST_TERMS && model.terms() <= policy::MOST_IN_ALL
}

/// Whether a model recovers the stroke from a lagging or averaging record of it, not just from one that is late.
pub fn takes_back_the_stroke(model: &Model) -> bool {
    let is_only_late = |e: usize| parameters::delays_position(e) && !model.secondary.has(e);
    model.effects.iter().any(|e| CARDS[e].acts_on == ActsOn::RecordedStroke && !is_only_late(e))
}

/// The models with one term less; what is freed of the others stays free.
pub fn without_one(model: &Model) -> Vec<Model> {
    let mut out: Vec<Model> = model.effects.iter().map(|e| model.without(EffectSet::one(e))).collect();
    let shorter = RecordStart::ALL.into_iter().rfind(|start| *start < model.record_start);
    out.extend(shorter.map(|start| Model { record_start: start, ..*model }));
    out
}

/// The models with one of the rig's effects that shift or smear records in time exchanged for another.
pub fn with_other_timing(model: &Model) -> Vec<Model> {
    let is_of_time = |card: &Card| card.is_candidate() && parameters::is_timing(card);
    let timings: EffectSet = effects::all().filter(|(_, card)| is_of_time(card)).map(|(e, _)| e).collect();
    let mut out = Vec::new();
    for gone in model.of_rig().iter().filter(|e| timings.has(*e)) {
        for new in timings.without(model.effects).iter() {
            let effects = model.effects.without(EffectSet::one(gone)).union(EffectSet::one(new));
            out.push(Model { effects, secondary: EffectSet::NONE, ..*model });
        }
    }
    out
}

/// Whether every term of `part` is one of `whole`, in the same scope.
pub fn is_part(part: &Model, whole: &Model) -> bool {
    whole.effects.contains(part.effects)
        && part.effects.iter().all(|e| part.per_record.has(e) == whole.per_record.has(e))
        && part.record_start <= whole.record_start
}

/// The terms of a model that shift or smear the records in time.
pub fn timing_of(model: &Model) -> Model {
    let part = |set: EffectSet| set.intersection(of_timing());
    let Model { effects, per_record, secondary, .. } = *model;
    Model {
        effects: part(effects),
        per_record: part(per_record),
        secondary: part(secondary),
        record_start: RecordStart::Nothing,
    }
}

/// Whether a model has nothing but a delay between pressures and positions.
pub fn is_delay(model: &Model) -> bool {
    model.terms() == 1 && model.effects.iter().any(|e| parameters::delays_pressure(e) || parameters::delays_position(e))
}

/// The first effect for which this holds.
pub fn effect_that(is_so: impl Fn(usize) -> bool) -> Option<usize> {
    effects::all().map(|(e, _)| e).find(|e| is_so(*e))
}

/// Effects of the recording, which can be per-record.
pub fn of_record() -> EffectSet {
    effects::all().filter(|(_, card)| is_of_record(card)).map(|(e, _)| e).collect()
}

/// Effects of the recording that shift or smear it in time without changing the amount read.
pub fn of_timing() -> EffectSet {
    effects::all().filter(|(_, card)| is_of_record(card) && parameters::is_timing(card)).map(|(e, _)| e).collect()
}

/// Effects of the recording that grow with time.
pub fn growing_with_time() -> EffectSet {
    let grows = |card: &Card| card.parameters.iter().any(|p| p.unit == Unit::PascalPerSecond);
    effects::all().filter(|(_, card)| is_of_record(card) && grows(card)).map(|(e, _)| e).collect()
}

fn is_of_record(card: &Card) -> bool {
    card.is_candidate() && card.scope == Scope::Record
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Recipe;
    use chamber::effects::find;

    #[test]
    fn only_a_record_that_lags_or_averages_is_taken_back_and_not_one_that_is_late() {
        let with = |name: &str| Model::with(EffectSet::one(find(name).unwrap().0));
        let late = with("position_delay");
        assert!(!takes_back_the_stroke(&late) && !takes_back_the_stroke(&with("record_delay")));
        assert!(takes_back_the_stroke(&Model { secondary: late.effects, ..late }));
        assert!(takes_back_the_stroke(&with("position_averaging")));
    }

    #[test]
    fn freed_parameters_of_a_set_stay_free_with_a_further_term_and_in_pairs() {
        let data = Data::prepare(&Recipe { repeats: 1, ..Recipe::from_seed(5) }.rig()).unwrap();
        let [leak, lag, late] =
            ["leakage", "sensor_lag", "position_delay"].map(|name| EffectSet::one(find(name).unwrap().0));
        let filtered = Model { secondary: late, ..Model::with(late) };
        assert!(added_to(&data, &filtered).iter().all(|model| model.secondary == late));
        let leaky = Model { secondary: leak, ..Model::with(leak) };
        let joined = pairs(&[filtered, leaky, Model::with(lag)], &Model::PAPER);
        let freed: Vec<EffectSet> = joined.iter().map(|model| model.secondary).collect();
        assert_eq!(freed, [late.union(leak), late, leak]);
    }
}
