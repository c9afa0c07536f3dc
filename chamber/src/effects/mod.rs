//! What the paper's model neglects. One effect, one file; adding one touches its file and the list below.
//!
//! An effect declares itself on a [`Card`] and takes part in [`balance::rates`](crate::balance::rates) through the hooks of
//! [`Effect`], each neutral by default ([`EffectValues`] combines them). Hooks run in the order of the trait's methods, effects
//! in the order of the list.

mod effect;
pub mod iso6358;
mod nearest;
mod set;
mod values;

pub use effect::Effect;
pub use set::EffectSet;
pub use values::EffectValues;

use crate::card::{ActsOn, Balance, Card};

// `$dollar` is the dollar sign for the macros defined inside this one, which cannot write it themselves.
macro_rules! effects {
    ($dollar:tt $($module:ident::$name:ident),* $(,)?) => {
        $(pub mod $module; pub use $module::$name;)*

        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Id { $($module,)* COUNT }

        /// Number of effects.
        pub const COUNT: usize = Id::COUNT as usize;

        $(impl $module::$name {
            /// Its index in the list of effects.
            pub const INDEX: usize = Id::$module as usize;
            /// The set that contains only this effect.
            pub const SET: EffectSet = EffectSet::one(Self::INDEX);
        })*

        $(impl Indexed for $module::$name { const INDEX: usize = Self::INDEX; })*

        /// Evaluates an expression for each effect, or each effect in a set, which it can refer to by the given name.
        macro_rules! each {
            ($dollar effect:ident in $dollar set:expr => $dollar body:expr) => {
                each!($dollar effect => if $dollar set.has($dollar effect::INDEX) { $dollar body; })
            };
            ($dollar effect:ident => $dollar body:expr) => {
                $({ type $dollar effect = $crate::effects::$name; $dollar body; })*
            };
        }

        /// Array of an expression's values, one per effect.
        macro_rules! of_each {
            ($dollar effect:ident => $dollar value:expr) => {
                [$({ type $dollar effect = $crate::effects::$name; $dollar value }),*]
            };
        }
    };
}

effects![$
    leakage::Leakage,
    wall_heating::WallHeating,
    pressure_exponent::PressureExponent,
    natural_convection::NaturalConvection,
    forced_convection::ForcedConvection,
    decaying_turbulence::DecayingTurbulence,
    gas_column_length::GasColumnLength,
    gas_zones::GasZones,
    tube_volume::TubeVolume,
    sensor_lag::SensorLag,
    record_delay::RecordDelay,
    sensor_drift::SensorDrift,
    dead_volume_surface::DeadVolumeSurface,
    warm_wall::WarmWall,
    temperature_dependent_heat_capacity::TemperatureDependentHeatCapacity,
    laminar_leakage::LaminarLeakage,
    supply_leakage::SupplyLeakage,
    sensor_offset::SensorOffset,
    position_delay::PositionDelay,
    position_averaging::PositionAveraging,
    wall_conduction::WallConduction,
    empirical::Empirical,
];

// After the list, because it expands over all effects.
mod hooks;

pub use hooks::initial;

/// The set of effects whose cards meet a condition, evaluated at compile time.
#[macro_export]
macro_rules! effects_where {
    ($card:ident => $condition:expr) => {{
        let (mut bits, mut effect) = (0, 0);
        while effect < $crate::effects::COUNT {
            let $card = &$crate::effects::CARDS[effect];
            bits |= ($condition as u32) << effect;
            effect += 1;
        }
        $crate::effects::EffectSet::from_bits(bits)
    }};
}

impl EffectSet {
    /// All effects.
    pub const ALL: EffectSet = EffectSet::of([true; COUNT]);

    /// The set with these [`bits`](Self::bits).
    pub const fn from_bits(bits: u32) -> Self {
        Self::of_bits(bits).intersection(Self::ALL)
    }
}

/// Every effect's declaration, in order.
pub const CARDS: [Card; COUNT] = of_each!(E => E::CARD);

/// Effects with [`Effect::CALORIC`].
pub const CALORIC: EffectSet = EffectSet::of(of_each!(E => E::CALORIC));
/// Effects with [`Effect::VOLUMETRIC`].
pub const VOLUMETRIC: EffectSet = EffectSet::of(of_each!(E => E::VOLUMETRIC));
/// Effects with [`Effect::OF_WALL`].
pub const OF_WALL: EffectSet = EffectSet::of(of_each!(E => E::OF_WALL));
/// Effects with [`Effect::SINGULAR`].
pub const SINGULAR: EffectSet = EffectSet::of(of_each!(E => E::SINGULAR));
/// Effects with [`Effect::HAS_PRESSURE_KINKS`].
pub const WITH_PRESSURE_KINKS: EffectSet = EffectSet::of(of_each!(E => E::HAS_PRESSURE_KINKS));
/// Effects with [`Effect::STORES`].
pub const STORING: EffectSet = EffectSet::of(of_each!(E => E::STORES));
/// Effects with [`Effect::HAS_READING_KINKS`].
pub const WITH_READING_KINKS: EffectSet = EffectSet::of(of_each!(E => E::HAS_READING_KINKS));
/// Effects with [`Effect::REMEMBERS`].
pub const REMEMBERING: EffectSet = EffectSet::of(of_each!(E => E::REMEMBERS));
/// Effects with a nonzero [`Effect::KINK_INDICATORS`].
pub const WITH_KINK_INDICATORS: EffectSet = EffectSet::of(of_each!(E => E::KINK_INDICATORS != 0));

/// Number of functions returned by [`EffectValues::kink_indicators`].
pub const KINK_INDICATORS: usize = {
    let mut sum = 0;
    each!(E => sum += E::KINK_INDICATORS);
    sum
};

/// [`Effect::constant`] of each effect.
pub type EffectConstants<R = f64> = [R; COUNT];

/// Where each effect's parameters begin in [`EffectValues`]; the last entry is their number.
pub const PARAMETER_OFFSETS: [usize; COUNT + 1] = offsets(true);
/// Where each effect's own states begin; the last entry is their number.
pub const STATE_OFFSETS: [usize; COUNT + 1] = offsets(false);
/// Number of parameters of all effects.
pub const PARAMETERS: usize = PARAMETER_OFFSETS[COUNT];
/// Number of own states of all effects.
pub const OWN_STATES: usize = STATE_OFFSETS[COUNT];

/// Number of own states of the effects before the first with more than four.
pub const FEW_OWN_STATES: usize = {
    let mut i = 0;
    while i < COUNT && CARDS[i].states.len() <= MANY {
        i += 1;
    }
    STATE_OFFSETS[i]
};
/// Effects with more own states than this are integrated by separate code, so that the others do not carry those states.
pub const MANY: usize = 4;

/// Nominal sizes of all effects' own states.
pub const NOMINALS: [f64; OWN_STATES] = {
    let mut out = [0.0; OWN_STATES];
    let mut i = 0;
    while i < COUNT {
        let mut j = 0;
        while j < CARDS[i].states.len() {
            out[STATE_OFFSETS[i] + j] = CARDS[i].states[j].nominal;
            j += 1;
        }
        i += 1;
    }
    out
};

/// Number of own states up to the last one of an effect in `set`: later ones do not change.
pub fn own_states_of(set: EffectSet) -> usize {
    all()
        .filter(|(i, card)| set.has(*i) && !card.states.is_empty())
        .map(|(i, _)| STATE_OFFSETS[i + 1])
        .max()
        .unwrap_or(0)
}

const fn offsets(of_parameters: bool) -> [usize; COUNT + 1] {
    let mut out = [0; COUNT + 1];
    let mut i = 0;
    while i < COUNT {
        let width = if of_parameters { CARDS[i].parameters.len() } else { CARDS[i].states.len() };
        out[i + 1] = out[i] + width;
        i += 1;
    }
    out
}

/// An effect's index in the list, and hence its slices of parameters and own states.
trait Indexed {
    const INDEX: usize;

    #[inline(always)]
    fn values<R>(values: &EffectValues<R>) -> &[R] {
        &values.0[PARAMETER_OFFSETS[Self::INDEX]..PARAMETER_OFFSETS[Self::INDEX + 1]]
    }
    /// Its own states within the first `M` of all effects: empty where it has none.
    #[inline(always)]
    fn own<R, const M: usize>(own: &[R; M]) -> &[R] {
        own.get(STATE_OFFSETS[Self::INDEX]..STATE_OFFSETS[Self::INDEX + 1]).unwrap_or_default()
    }
    #[inline(always)]
    fn own_mut<R, const M: usize>(own: &mut [R; M]) -> &mut [R] {
        own.get_mut(STATE_OFFSETS[Self::INDEX]..STATE_OFFSETS[Self::INDEX + 1]).unwrap_or_default()
    }
    /// Whether all its own states lie within the first `count` of all effects.
    #[inline(always)]
    fn lies_within(count: usize) -> bool {
        let (begin, end) = (STATE_OFFSETS[Self::INDEX], STATE_OFFSETS[Self::INDEX + 1]);
        begin == end || end <= count
    }
}

/// Every effect's index and declaration.
pub fn all() -> impl Iterator<Item = (usize, &'static Card)> {
    static ALL: [Card; COUNT] = CARDS;
    ALL.iter().enumerate()
}

/// The effects that act after the gas, on what the sensor shows.
pub const fn of_sensor() -> EffectSet {
    const { effects_where!(card => matches!(card.acts_on, ActsOn::Reading)) }
}

/// The effects that act on the stroke record: meaningless where the stroke is the true one.
pub const fn of_recorded_stroke() -> EffectSet {
    const { effects_where!(card => matches!(card.acts_on, ActsOn::RecordedStroke)) }
}

/// Effects on the energy of the gas that pass no gas: with these alone and no flows, its mass is constant.
pub const KEEP_THE_MASS: EffectSet =
    effects_where!(card => matches!(card.balance, Balance::Energy) && matches!(card.acts_on, ActsOn::Gas));

/// The effect of that name: its index in the list and its declaration.
pub fn find(name: &str) -> Option<(usize, &'static Card)> {
    all().find(|(_, card)| card.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AreaLaw;
    use crate::balance::{Balances, Boundary, OWN};
    use crate::card::Fitted;
    use crate::papers_chamber::section_31;

    #[test]
    fn cards_state_neutral_values_within_their_bounds_and_typical_ones_that_are_not_neutral() {
        let geometry = section_31(AreaLaw::Total).geometry;
        for (_, card) in all() {
            assert!(!card.doc.is_empty() && !card.source.is_empty() && !card.equation.is_empty(), "{}", card.name);
            for p in card.parameters {
                assert!(p.bounds.contains(&p.neutral) && p.bounds.contains(&p.typical), "{}.{}", card.name, p.name);
                let plausible = p.plausible_values(&geometry);
                assert!(plausible.contains(&p.neutral) && plausible.contains(&p.typical), "{}.{}", card.name, p.name);
                assert!(p.neutral != p.typical || p.fitted != Fitted::Always, "{}.{}", card.name, p.name);
                assert!(!p.doc.is_empty() && !p.doc.ends_with('.'), "{}.{}", card.name, p.name);
            }
        }
    }

    #[test]
    fn own_states_decay_by_themselves_at_the_rates_that_their_effects_state() {
        let mut chamber = section_31(AreaLaw::Total).with_typical(EffectSet::ALL);
        chamber.heat_transfer.coefficient = 0.0;
        let balance = Balances::of(chamber);
        let boundary = Boundary::closed(0.05, 293.0, 1.013e5);
        let at = |set| {
            let states = balance.state_at(set, &boundary, 2e5, 293.0);
            (states, balance.decays(set, &boundary, &states))
        };
        let (states, decays) = at(EffectSet::ALL);
        let decaying: Vec<usize> = (OWN..states.len()).filter(|i| decays[*i] > 0.0).collect();
        assert_eq!(decaying.len(), 3 + wall_conduction::MODES);
        for i in decaying {
            let set = all().map(|(e, _)| e).find(|e| OWN + STATE_OFFSETS[e + 1] > i).map(EffectSet::one).unwrap();
            let (states, decays) = at(set);
            let rate = |warmer: f64| {
                let mut states = states;
                states[i] += warmer;
                balance.rates(set, &boundary, &states)[i]
            };
            assert!((rate(2.0) - rate(0.0) + 2.0 * decays[i]).abs() < 1e-9 * decays[i], "{i}");
        }
    }

    #[test]
    fn effects_with_reading_kinks_follow_all_others_on_the_sensor() {
        let first = WITH_READING_KINKS.iter().min();
        assert!(of_sensor().iter().all(|effect| first.is_none_or(|first| effect < first)));
    }

    #[test]
    fn effects_at_their_neutral_values_are_off() {
        assert!(EffectValues::NEUTRAL.active().is_empty());
        for (i, _) in all() {
            let mut values = EffectValues::NEUTRAL;
            values.of_mut(i)[0] += 0.1;
            assert_eq!(values.active(), EffectSet::one(i));
        }
    }
}
