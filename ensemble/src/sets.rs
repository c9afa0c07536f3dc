//! Sets of effects by what they act on, at compile time.

use chamber::card::ActsOn;
use chamber::effects::{self, EffectSet, Empirical};
use chamber::effects_where;

/// The effects of a set that act on the gas, not on the pressure reading or on the recorded stroke.
pub const fn on_the_gas(set: EffectSet) -> EffectSet {
    set.without(effects::of_sensor()).without(effects::of_recorded_stroke())
}

/// The effects on the gas with at most `states` states of their own, except for the empirical curve, whose code is long.
pub const fn on_the_gas_with(states: usize) -> EffectSet {
    let few = effects_where!(card => matches!(card.acts_on, ActsOn::Gas) && card.states.len() <= states);
    few.without(Empirical::SET)
}
