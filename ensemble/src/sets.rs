//! Sets of effects, at compile time, by what they act on.

use chamber::card::ActsOn;
use chamber::effects::{self, EffectSet, Empirical};

/// The effects of a set that act on the gas: neither on its reading nor on a record of the stroke.
pub const fn on_the_gas(set: EffectSet) -> EffectSet {
    set.without(effects::of_sensor()).without(effects::of_recorded_stroke())
}

/// The effects on the gas with at most so many states of their own, but for the curve of any kind, whose code is long.
pub const fn on_the_gas_with(states: usize) -> EffectSet {
    let mut bits = 0;
    let mut effect = 0;
    while effect < effects::COUNT {
        let card = &effects::CARDS[effect];
        if matches!(card.acts_on, ActsOn::Gas) && card.states.len() <= states {
            bits |= 1 << effect;
        }
        effect += 1;
    }
    EffectSet::from_bits(bits).without(Empirical::SET)
}
