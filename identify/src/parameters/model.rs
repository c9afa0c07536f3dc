//! Which terms a model has beyond the paper's.

use chamber::card::{ActsOn, Card, Unit};
use chamber::effects::{self, CARDS, EffectSet, EffectValues, WallHeating};

/// Temperatures that each record begins with for itself, also where it begins at rest: each step is a term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum OwnStart {
    /// Gas and wall begin as warm as their surroundings.
    Nothing,
    /// The gas does not: it was filled or moved shortly before.
    Gas,
    /// A wall that warms does not either: tests shortly before have warmed or cooled it.
    GasAndWall,
}

impl OwnStart {
    /// From nothing to all.
    pub const ALL: [Self; 3] = [Self::Nothing, Self::Gas, Self::GasAndWall];

    /// The term that it has beyond the one before it.
    pub fn term(self) -> Option<&'static str> {
        match self {
            Self::Nothing => None,
            Self::Gas => Some("initial_temperature"),
            Self::GasAndWall => Some("initial_wall_temperature"),
        }
    }
}

/// Which model is to be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Model {
    /// Effects beyond the paper's model.
    pub effects: EffectSet,
    /// Those of them whose parameters each record has for itself.
    pub own: EffectSet,
    /// Effects whose secondary parameters are free too.
    pub secondary: EffectSet,
    /// Which initial temperatures each record has for itself.
    pub own_start: OwnStart,
}

impl Model {
    /// The paper's.
    pub const PAPER: Model = Model {
        effects: EffectSet::NONE,
        own: EffectSet::NONE,
        secondary: EffectSet::NONE,
        own_start: OwnStart::Nothing,
    };

    /// The paper's with these effects of the rig.
    pub fn with(effects: EffectSet) -> Self {
        Self { effects, ..Self::PAPER }
    }

    /// Without some effects, and what is free of them.
    pub fn without(&self, effects: EffectSet) -> Self {
        let without = |set: EffectSet| set.without(effects);
        let [own, secondary] = [self.own, self.secondary].map(without);
        let effects = without(self.effects);
        Self { effects, own, secondary, own_start: self.own_start.min(Self::with(effects).most_of_start()) }
    }

    /// The most that its records can have for themselves of their start.
    pub fn most_of_start(&self) -> OwnStart {
        if self.effects.has(WallHeating::PLACE) { OwnStart::GasAndWall } else { OwnStart::Gas }
    }

    /// The same terms, none with secondary parameters free.
    pub fn with_nothing_freed(&self) -> Self {
        Self { secondary: EffectSet::NONE, ..*self }
    }

    /// Whether another model has the same terms, whatever is freed of them.
    pub fn has_same_terms(&self, other: &Self) -> bool {
        self.with_nothing_freed() == other.with_nothing_freed()
    }

    /// Effects that hold for the rig: what a diagnosis names.
    pub fn of_rig(&self) -> EffectSet {
        self.effects.without(self.own)
    }

    /// Whether some of it each record has for itself, beyond its initial pressure: with many records that fits much.
    pub fn has_terms_of_records(&self) -> bool {
        self.own_start > OwnStart::Nothing || !self.own.is_empty()
    }

    /// Number of effects that shift or smear the records in time, and the stroke's noise with them.
    pub fn timings(&self) -> usize {
        self.effects.iter().filter(|&e| is_timing(&CARDS[e])).count()
    }

    /// Its terms, joined by " + ".
    pub fn words(&self) -> String {
        let of_rig = names(self.of_rig()).into_iter().map(str::to_owned);
        let starts = OwnStart::ALL.into_iter().filter(|start| *start <= self.own_start);
        let of_records = names(self.own).into_iter().chain(starts.filter_map(OwnStart::term));
        let of_records = of_records.map(|name| format!("{name} (each record its own)"));
        of_rig.chain(of_records).collect::<Vec<_>>().join(" + ")
    }

    /// Number of terms beyond the paper's model.
    pub fn terms(&self) -> usize {
        self.effects.iter().count() + self.own_start as usize
    }
}

/// Whether an effect of the sensor or the logger shifts or smears records in time, and has no part in how much is read.
pub fn is_timing(card: &Card) -> bool {
    let of_recording = matches!(card.acts_on, ActsOn::Reading | ActsOn::RecordedStroke);
    of_recording && card.parameters.iter().all(|p| p.unit == Unit::Second)
}

/// Whether the effect shows the pressure late.
pub fn delays_pressure(effect: usize) -> bool {
    ones(effect).delay(EffectSet::one(effect)) > 0.0
}

/// Whether the effect is a stroke that was recorded late.
pub fn delays_position(effect: usize) -> bool {
    ones(effect).stroke_delay(EffectSet::one(effect)) > 0.0
}

fn ones(effect: usize) -> EffectValues {
    let mut values = EffectValues::NEUTRAL;
    values.of_mut(effect).fill(1.0);
    values
}

/// Places of the effects of a set, by name, in the list's order.
pub fn names(set: EffectSet) -> Vec<&'static str> {
    effects::all().filter(|(i, _)| set.has(*i)).map(|(_, card)| card.name).collect()
}
