//! Sets of effects, at compile time, by what they act on.

use chamber::card::ActsOn;
use chamber::effects::{self, EffectSet, Empirical};
use chamber::effects_where;

/// The effects of a set that act on the gas: neither on its reading nor on a record of the stroke.
pub const fn on_the_gas(set: EffectSet) -> EffectSet {
    set.without(effects::of_sensor()).without(effects::of_recorded_stroke())
}

/// The effects on the gas with at most so many states of their own, but for the curve of any kind, whose code is long.
pub const fn on_the_gas_with(states: usize) -> EffectSet {
    let few = effects_where!(card => matches!(card.acts_on, ActsOn::Gas) && card.states.len() <= states);
    few.without(Empirical::SET)
}
