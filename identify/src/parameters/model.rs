//! Terms of a model beyond the paper's.

use chamber::card::{ActsOn, Card, Unit};
use chamber::effects::{self, CARDS, EffectSet, EffectValues, WallHeating};

/// Per-record initial temperatures, also where a record begins at rest: each step is a term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RecordStart {
    /// Gas and wall begin at the temperature of their surroundings.
    Nothing,
    /// The gas does not: it was filled or moved shortly before.
    Gas,
    /// Nor does a wall that warms: tests shortly before have warmed or cooled it.
    GasAndWall,
}

impl RecordStart {
    /// In increasing order.
    pub const ALL: [Self; 3] = [Self::Nothing, Self::Gas, Self::GasAndWall];

    /// The term that it adds to the one before it.
    pub fn term(self) -> Option<&'static str> {
        match self {
            Self::Nothing => None,
            Self::Gas => Some("initial_temperature"),
            Self::GasAndWall => Some("initial_wall_temperature"),
        }
    }
}

/// A model to be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Model {
    /// Effects beyond the paper's model.
    pub effects: EffectSet,
    /// Those of them with per-record parameters.
    pub per_record: EffectSet,
    /// Effects whose secondary parameters are free too.
    pub secondary: EffectSet,
    /// Per-record initial temperatures.
    pub record_start: RecordStart,
}

impl Model {
    /// The paper's model.
    pub const PAPER: Model = Model {
        effects: EffectSet::NONE,
        per_record: EffectSet::NONE,
        secondary: EffectSet::NONE,
        record_start: RecordStart::Nothing,
    };

    /// The paper's model with these effects of the rig.
    pub fn with(effects: EffectSet) -> Self {
        Self { effects, ..Self::PAPER }
    }

    /// Removes these effects and their free parameters.
    pub fn without(&self, effects: EffectSet) -> Self {
        let without = |set: EffectSet| set.without(effects);
        let [per_record, secondary] = [self.per_record, self.secondary].map(without);
        let effects = without(self.effects);
        Self {
            effects,
            per_record,
            secondary,
            record_start: self.record_start.min(Self::with(effects).most_of_start()),
        }
    }

    /// The most initial temperatures that its records can have free.
    pub fn most_of_start(&self) -> RecordStart {
        if self.effects.has(WallHeating::INDEX) { RecordStart::GasAndWall } else { RecordStart::Gas }
    }

    /// The same terms without free secondary parameters.
    pub fn with_nothing_freed(&self) -> Self {
        Self { secondary: EffectSet::NONE, ..*self }
    }

    /// Whether another model has the same terms, whatever secondary parameters are free.
    pub fn has_same_terms(&self, other: &Self) -> bool {
        self.with_nothing_freed() == other.with_nothing_freed()
    }

    /// Effects of the rig: those that a diagnosis names.
    pub fn of_rig(&self) -> EffectSet {
        self.effects.without(self.per_record)
    }

    /// Whether it has per-record terms beyond the initial pressure: with many records they can fit a lot.
    pub fn has_terms_of_records(&self) -> bool {
        self.record_start > RecordStart::Nothing || !self.per_record.is_empty()
    }

    /// Number of effects that shift or smear the records in time, including the noise of the stroke.
    pub fn timings(&self) -> usize {
        self.effects.iter().filter(|&e| is_timing(&CARDS[e])).count()
    }

    /// Its terms, joined by " + ".
    pub fn words(&self) -> String {
        let of_rig = names(self.of_rig()).into_iter().map(str::to_owned);
        let starts = RecordStart::ALL.into_iter().filter(|start| *start <= self.record_start);
        let of_records = names(self.per_record).into_iter().chain(starts.filter_map(RecordStart::term));
        let of_records = of_records.map(|name| format!("{name} (each record its own)"));
        of_rig.chain(of_records).collect::<Vec<_>>().join(" + ")
    }

    /// Number of terms beyond the paper's model.
    pub fn terms(&self) -> usize {
        self.effects.iter().count() + self.record_start as usize
    }
}

/// Whether an effect of the sensor or the logger shifts or smears records in time without changing the amount read.
pub fn is_timing(card: &Card) -> bool {
    let of_recording = matches!(card.acts_on, ActsOn::Reading | ActsOn::RecordedStroke);
    of_recording && card.parameters.iter().all(|p| p.unit == Unit::Second)
}

/// Whether the effect delays the pressure.
pub fn delays_pressure(effect: usize) -> bool {
    ones(effect).delay(EffectSet::one(effect)) > 0.0
}

/// Whether the effect is a delay of the recorded stroke.
pub fn delays_position(effect: usize) -> bool {
    ones(effect).stroke_delay(EffectSet::one(effect)) > 0.0
}

fn ones(effect: usize) -> EffectValues {
    let mut values = EffectValues::NEUTRAL;
    values.of_mut(effect).fill(1.0);
    values
}

/// Names of the effects of a set, in the list's order.
pub fn names(set: EffectSet) -> Vec<&'static str> {
    effects::all().filter(|(i, _)| set.has(*i)).map(|(_, card)| card.name).collect()
}
