//! Sets of effects, at compile time: by name, and by what they act on.

use chamber::card::ActsOn;
use chamber::effects::{self, EffectSet};

/// The set of the effect of that name alone.
pub const fn only(name: &str) -> EffectSet {
    EffectSet::from_bits(bit(name))
}

/// The bit of the effect of that name in [`EffectSet::bits`].
pub const fn bit(name: &str) -> u32 {
    1 << place(name)
}

/// The place of the effect of that name among all.
pub const fn place(name: &str) -> usize {
    let mut index = 0;
    while index < effects::COUNT {
        let (a, b) = (effects::CARDS[index].name.as_bytes(), name.as_bytes());
        let mut same = a.len() == b.len();
        let mut i = 0;
        while same && i < a.len() {
            same = a[i] == b[i];
            i += 1;
        }
        if same {
            return index;
        }
        index += 1;
    }
    panic!("no effect of that name")
}

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
    EffectSet::from_bits(bits & !bit("empirical"))
}
