//! What the paper's model neglects. One effect, one file; adding one touches its file and the list below.
//!
//! An effect declares itself on a [`Card`] and takes part in [`balance::rates`](crate::balance::rates) through the
//! hooks of [`Effect`], each neutral by default. Hooks run in the order of the trait's methods, effects in the list's.

mod effect;
pub mod iso6358;
mod set;
mod values;

pub use effect::Effect;
pub use set::EffectSet;
pub use values::EffectValues;

use crate::card::{ActsOn, Balance, Card};
use crate::gas::Gas;
use crate::parts::{Conditions, Course, Flows, Rates};
use crate::real::Real;

macro_rules! effects {
    ($($module:ident::$name:ident),* $(,)?) => {
        $(pub mod $module; pub use $module::$name;)*

        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Id { $($module,)* COUNT }

        /// Number of effects.
        pub const COUNT: usize = Id::COUNT as usize;

        /// Every effect's declaration, in order.
        pub const CARDS: [Card; COUNT] = [$($module::$name::CARD),*];

        $(impl $module::$name {
            /// Its place in the list of effects.
            pub const PLACE: usize = Id::$module as usize;
            /// The set of it alone.
            pub const SET: EffectSet = EffectSet::one(Self::PLACE);
        })*

        $(impl Place for $module::$name { const PLACE: usize = Self::PLACE; })*

        /// Own states of all effects in a chamber at rest in equilibrium.
        #[inline(always)]
        pub fn initial<R: Real>(at: &Conditions<R>, own: &mut [R; OWN_STATES]) {
            $($module::$name::initial(at, $module::$name::own_mut(own));)*
        }

        /// Temperature at which gas and wall are at rest in surroundings of `ambient`, K.
        #[inline(always)]
        pub fn rest_temperature<R: Real>(values: &EffectValues<R>, ambient: R) -> R {
            let mut temperature = ambient;
            $(temperature += $module::$name::wall_excess($module::$name::values(values));)*
            temperature
        }

        /// Effects with [`Effect::CALORIC`].
        pub const CALORIC: EffectSet = EffectSet::of([$($module::$name::CALORIC),*]);

        /// Internal energy over m cv T at a temperature, K: the product of [`Effect::internal_energy`] of the effects in `set`.
        #[inline(always)]
        pub fn internal_energy<R: Real>(set: EffectSet, values: &EffectValues<R>, temperature: R) -> R {
            let mut product = R::ONE;
            $(if $module::$name::CALORIC && set.has($module::$name::PLACE) {
                product = product * $module::$name::internal_energy($module::$name::values(values), temperature);
            })*
            product
        }

        /// [`Effect::decays`] of the effects in `set`, 1/s; zero of all other own states.
        pub fn decays<R: Real>(set: EffectSet, values: &EffectValues<R>, at: &Conditions<R>) -> [R; OWN_STATES] {
            let mut out = [R::ZERO; OWN_STATES];
            $(if set.has($module::$name::PLACE) {
                $module::$name::decays($module::$name::values(values), at, $module::$name::own_mut(&mut out));
            })*
            out
        }

        /// [`Effect::temperature`] of the effects in `set`, K.
        #[inline(always)]
        pub fn temperature<R: Real>(set: EffectSet, values: &EffectValues<R>, by_energy: R) -> R {
            let mut temperature = by_energy;
            $(if $module::$name::CALORIC && set.has($module::$name::PLACE) {
                temperature = $module::$name::temperature($module::$name::values(values), temperature);
            })*
            temperature
        }

        /// [`Effect::gas_properties`] of the effects in `set`.
        #[inline(always)]
        pub fn gas_properties<R: Real>(set: EffectSet, values: &EffectValues<R>, at: &mut Conditions<R>) {
            $(if $module::$name::CALORIC && set.has($module::$name::PLACE) {
                $module::$name::gas_properties($module::$name::values(values), at);
            })*
        }

        /// Sum of [`Effect::excess_enthalpy`] of the effects in `set`.
        #[inline(always)]
        pub fn excess_enthalpy<R: Real>(
            set: EffectSet, values: &EffectValues<R>, at: &Conditions<R>, flows: &Flows<R>,
        ) -> [R; 2] {
            let mut sum = [R::ZERO; 2];
            $(if $module::$name::CALORIC && set.has($module::$name::PLACE) {
                let [energy, pressure] = $module::$name::excess_enthalpy($module::$name::values(values), at, flows);
                sum[0] += energy;
                sum[1] += pressure;
            })*
            sum
        }

        /// Effects with [`Effect::VOLUMETRIC`].
        pub const VOLUMETRIC: EffectSet = EffectSet::of([$($module::$name::VOLUMETRIC),*]);

        /// Whether the gas fills another volume than the geometry's by an effect in `set`, with these parameters.
        #[inline(always)]
        pub fn is_volumetric<R: Real>(set: EffectSet, values: &EffectValues<R>) -> bool {
            false $(|| $module::$name::VOLUMETRIC
                && set.has($module::$name::PLACE)
                && $module::$name::is_volumetric($module::$name::values(values)))*
        }

        /// [`Effect::volume`] of the effects in `set`.
        #[inline(always)]
        pub fn volume<R: Real>(set: EffectSet, values: &EffectValues<R>, position: R, pressure: R) -> [R; 3] {
            let mut all = [R::ONE, R::ZERO, R::ZERO];
            $(if $module::$name::VOLUMETRIC && set.has($module::$name::PLACE) {
                let one = $module::$name::volume($module::$name::values(values), position, pressure);
                all = [all[0] * one[0], all[1] * one[0] + all[0] * one[1], all[2] * one[0] + all[0] * one[2]];
            })*
            all
        }

        /// Heat into the gas, W: that from the wall, and [`Effect::heat_flow`] of the effects in `set`.
        #[inline(always)]
        pub fn heat_flow<R: Real>(set: EffectSet, values: &EffectValues<R>, at: &Conditions<R>, from_wall: R) -> R {
            let mut heat = from_wall;
            $(if set.has($module::$name::PLACE) {
                $module::$name::heat_flow($module::$name::values(values), at, &mut heat);
            })*
            heat
        }

        /// Effects with [`Effect::OF_WALL`].
        pub const OF_WALL: EffectSet = EffectSet::of([$($module::$name::OF_WALL),*]);

        /// [`Effect::conditions`] of the effects in `set` whose own states are among the first `M`.
        #[inline(always)]
        pub fn conditions<R: Real, const M: usize>(
            set: EffectSet, values: &EffectValues<R>, own: &[R; M], at: &mut Conditions<R>,
        ) {
            $(if $module::$name::lies_within(M) && set.has($module::$name::PLACE) {
                $module::$name::conditions($module::$name::values(values), $module::$name::own(own), at);
            })*
        }

        /// Product of [`Effect::heat_transfer_factor`] of the effects in `set`, times `base`.
        #[inline(always)]
        pub fn heat_transfer_factor<R: Real>(set: EffectSet, values: &EffectValues<R>, at: &Conditions<R>, base: R) -> R {
            let mut product = base;
            $(if set.has($module::$name::PLACE) {
                product = product * $module::$name::heat_transfer_factor($module::$name::values(values), at);
            })*
            product
        }

        /// [`Effect::heat_transfer_area`] of the effects in `set`, from that of the area law, m².
        #[inline(always)]
        pub fn heat_transfer_area<R: Real>(set: EffectSet, values: &EffectValues<R>, of_law: R) -> R {
            let mut area = of_law;
            $(if set.has($module::$name::PLACE) {
                area = $module::$name::heat_transfer_area($module::$name::values(values), area);
            })*
            area
        }

        /// [`Effect::constant`] of every effect.
        #[inline(always)]
        pub fn constants<R: Real>(values: &EffectValues<R>, gas: &Gas<R>) -> EffectConstants<R> {
            [$($module::$name::constant($module::$name::values(values), gas)),*]
        }

        /// [`Effect::flows`] of the effects in `set`.
        #[inline(always)]
        pub fn flows<R: Real>(
            set: EffectSet, values: &EffectValues<R>, constants: &EffectConstants<R>, at: &Conditions<R>, flows: &mut Flows<R>,
        ) {
            $(if set.has($module::$name::PLACE) {
                let place = $module::$name::PLACE;
                $module::$name::flows($module::$name::values(values), constants[place], at, flows);
            })*
        }

        /// Effects with [`Effect::SINGULAR`].
        pub const SINGULAR: EffectSet = EffectSet::of([$($module::$name::SINGULAR),*]);

        /// Effects with [`Effect::CORNERS`].
        pub const WITH_CORNERS: EffectSet = EffectSet::of([$($module::$name::CORNERS),*]);

        /// [`Effect::corner`] of the effects in `set`: the first of all.
        #[inline(always)]
        pub fn corner<R: Real>(set: EffectSet, values: &EffectValues<R>, ambient_pressure: R, from: R, to: R) -> R {
            let mut first = to;
            $(if set.has($module::$name::PLACE) {
                first = $module::$name::corner($module::$name::values(values), ambient_pressure, from, first);
            })*
            first
        }

        /// Number of functions that [`kinks`] gives.
        pub const KINKS: usize = 0 $(+ $module::$name::KINKS)*;

        /// The effects that have some.
        pub const WITH_KINKS: EffectSet = EffectSet::of([$($module::$name::KINKS > 0),*]);

        /// [`Effect::kinks`] of all effects, in order; one for those that are not in `set`.
        pub fn kinks<R: Real>(
            set: EffectSet, values: &EffectValues<R>, own: &[R; OWN_STATES], at: &Conditions<R>, rates: &Rates<R>,
        ) -> [R; KINKS] {
            let mut out = [R::ONE; KINKS];
            let mut rest = &mut out[..];
            $(
                let (part, after) = rest.split_at_mut($module::$name::KINKS);
                if set.has($module::$name::PLACE) {
                    $module::$name::kinks($module::$name::values(values), $module::$name::own(own), at, rates, part);
                }
                rest = after;
            )*
            debug_assert!(rest.is_empty());
            out
        }

        /// Effects with [`Effect::STORES`].
        pub const STORING: EffectSet = EffectSet::of([$($module::$name::STORES),*]);

        /// Adds [`Effect::storage`] of the effects in `set` to the flows.
        #[inline(always)]
        pub fn storage<R: Real>(
            set: EffectSet, values: &EffectValues<R>, at: &Conditions<R>, course: &Course<R>, flows: &mut Flows<R>,
        ) {
            $(if $module::$name::STORES && set.has($module::$name::PLACE) {
                let (flow, temperature) = $module::$name::storage($module::$name::values(values), at, course);
                flows.leave(flow, temperature);
            })*
        }

        /// [`Effect::own_rates`] of the effects in `set` whose own states are among the first `M`; zero for the others.
        #[inline(always)]
        pub fn own_rates<R: Real, const M: usize>(
            set: EffectSet, values: &EffectValues<R>, own: &[R; M], at: &Conditions<R>, flows: &Flows<R>, rates: &Rates<R>,
        ) -> [R; M] {
            let mut out = [R::ZERO; M];
            $(if $module::$name::lies_within(M) && set.has($module::$name::PLACE) {
                $module::$name::own_rates(
                    $module::$name::values(values), $module::$name::own(own), at, flows, rates, $module::$name::own_mut(&mut out),
                );
            })*
            out
        }

        /// [`Effect::heated`] of the effects in `set` whose own states are among the first `M`.
        pub fn heated<R: Real, const M: usize>(
            set: EffectSet, values: &EffectValues<R>, at: &Conditions<R>, area: R, heat: R, own: &mut [R; M],
        ) {
            $(if $module::$name::lies_within(M) && set.has($module::$name::PLACE) {
                let own = $module::$name::own_mut(own);
                $module::$name::heated($module::$name::values(values), at, area, heat, own);
            })*
        }

        /// What the sensor shows of `pressure`, Pa: [`Effect::reading`] of the effects in `set`, in order.
        #[inline(always)]
        pub fn reading<R: Real>(set: EffectSet, values: &EffectValues<R>, own: &[R; OWN_STATES], pressure: R, time: R) -> R {
            let mut reading = pressure;
            $(if set.has($module::$name::PLACE) {
                reading = $module::$name::reading($module::$name::values(values), $module::$name::own(own), reading, time);
            })*
            reading
        }

        /// Effects with [`Effect::BENDS`].
        pub const WITH_BENDS: EffectSet = EffectSet::of([$($module::$name::BENDS),*]);

        /// [`Effect::bend`] of the effects in `set`: the first of all.
        pub fn bend<R: Real>(set: EffectSet, values: &EffectValues<R>, from: R, to: R) -> R {
            let mut first = to;
            $(if set.has($module::$name::PLACE) {
                first = $module::$name::bend($module::$name::values(values), from, first);
            })*
            first
        }

        /// Effects with [`Effect::REMEMBERS`].
        pub const REMEMBERING: EffectSet = EffectSet::of([$($module::$name::REMEMBERS),*]);

        effects! { @sum inverse_effusivity of $($module::$name),* }
        effects! { @sum lag of $($module::$name),* }
        effects! { @sum delay of $($module::$name),* }
        effects! { @sum stroke_delay of $($module::$name),* }
        effects! { @sum stroke_filter of $($module::$name),* }
        effects! { @sum stroke_window of $($module::$name),* }
    };
    (@sum $hook:ident of $($module:ident::$name:ident),*) => {
        #[doc = concat!("Sum of [`Effect::", stringify!($hook), "`] of the effects in `set`.")]
        #[inline(always)]
        pub fn $hook<R: Real>(set: EffectSet, values: &EffectValues<R>) -> R {
            let mut sum = R::ZERO;
            $(if set.has($module::$name::PLACE) {
                sum += $module::$name::$hook($module::$name::values(values));
            })*
            sum
        }
    };
}

effects![
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

/// `value` where it lies between the two, else `to`.
#[inline(always)]
fn nearer<R: Real>(value: R, from: R, to: R) -> R {
    ((value - from) * (to - value)).where_positive(value, to)
}

/// Where each effect's parameters begin in [`EffectValues`]; the last entry is their number.
pub const PARAMETER_OFFSETS: [usize; COUNT + 1] = offsets(true);
/// Where each effect's own states begin; the last entry is their number.
pub const STATE_OFFSETS: [usize; COUNT + 1] = offsets(false);
/// Number of parameters of all effects.
pub const PARAMETERS: usize = PARAMETER_OFFSETS[COUNT];
/// Number of own states of all effects.
pub const OWN_STATES: usize = STATE_OFFSETS[COUNT];

/// Number of own states of the effects before the first that has more than four.
pub const FEW_OWN_STATES: usize = {
    let mut i = 0;
    while i < COUNT && CARDS[i].states.len() <= MANY {
        i += 1;
    }
    STATE_OFFSETS[i]
};
/// An effect with more own states than this is integrated in code of its own, so that the others do not carry them along.
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

/// Number of own states up to the last one that an effect in `set` has: those behind it do not move.
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

/// An effect's place in the list, and with it in the arrays of parameters and own states.
trait Place {
    const PLACE: usize;

    #[inline(always)]
    fn values<R>(values: &EffectValues<R>) -> &[R] {
        &values.0[PARAMETER_OFFSETS[Self::PLACE]..PARAMETER_OFFSETS[Self::PLACE + 1]]
    }
    /// Its own states among the first `M` of all effects: empty where it has none.
    #[inline(always)]
    fn own<R, const M: usize>(own: &[R; M]) -> &[R] {
        own.get(STATE_OFFSETS[Self::PLACE]..STATE_OFFSETS[Self::PLACE + 1]).unwrap_or_default()
    }
    #[inline(always)]
    fn own_mut<R, const M: usize>(own: &mut [R; M]) -> &mut [R] {
        own.get_mut(STATE_OFFSETS[Self::PLACE]..STATE_OFFSETS[Self::PLACE + 1]).unwrap_or_default()
    }
    /// Whether all its own states are among the first `count` of all effects.
    #[inline(always)]
    fn lies_within(count: usize) -> bool {
        let (begin, end) = (STATE_OFFSETS[Self::PLACE], STATE_OFFSETS[Self::PLACE + 1]);
        begin == end || end <= count
    }
}

/// Every effect's declaration with its place in the list.
pub fn all() -> impl Iterator<Item = (usize, &'static Card)> {
    static ALL: [Card; COUNT] = CARDS;
    ALL.iter().enumerate()
}

/// The effects that act behind the gas, on what the sensor shows.
pub const fn of_sensor() -> EffectSet {
    const { acting_on(ActsOn::Reading) }
}

/// The effects that act on the record of the stroke: of no meaning where the stroke is the true one.
pub const fn of_recorded_stroke() -> EffectSet {
    const { acting_on(ActsOn::RecordedStroke) }
}

/// Effects that act on the energy of the gas and let none of it pass: with these alone, and without flows, its mass stays
/// what it is.
pub const KEEP_THE_MASS: EffectSet = {
    let mut is_in = [false; COUNT];
    let mut i = 0;
    while i < COUNT {
        is_in[i] = matches!(CARDS[i].balance, Balance::Energy) && matches!(CARDS[i].acts_on, ActsOn::Gas);
        i += 1;
    }
    EffectSet::of(is_in)
};

const fn acting_on(part: ActsOn) -> EffectSet {
    let mut is_in = [false; COUNT];
    let mut i = 0;
    while i < COUNT {
        is_in[i] = CARDS[i].acts_on as u8 == part as u8;
        i += 1;
    }
    EffectSet::of(is_in)
}

/// The effect of that name: its place in the list and its declaration.
pub fn find(name: &str) -> Option<(usize, &'static Card)> {
    all().find(|(_, card)| card.name == name)
}

/// [`Effect::constant`] of each effect.
pub type EffectConstants<R = f64> = [R; COUNT];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::{Balances, Boundary, OWN};
    use crate::card::Fitted;
    use crate::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};

    #[test]
    fn cards_state_neutral_values_within_their_bounds_and_typical_ones_that_are_not_neutral() {
        for (_, card) in all() {
            assert!(!card.doc.is_empty() && !card.source.is_empty() && !card.equation.is_empty(), "{}", card.name);
            for p in card.parameters {
                assert!(p.bounds.contains(&p.neutral) && p.bounds.contains(&p.typical), "{}.{}", card.name, p.name);
                assert!(p.neutral != p.typical || p.fitted != Fitted::Always, "{}.{}", card.name, p.name);
                assert!(!p.doc.is_empty() && !p.doc.ends_with('.'), "{}.{}", card.name, p.name);
            }
        }
    }

    #[test]
    fn own_states_decay_by_themselves_at_the_rates_that_their_effects_state() {
        let chamber = Chamber::new(
            Gas::AIR,
            Geometry::new(0.02, 0.0, 1.57e-6, AreaLaw::Total),
            HeatTransfer::at_paper_reference(0.0),
        );
        let mut balance = Balances::of(chamber);
        for (i, card) in all() {
            let typical = card.parameters.iter().map(|parameter| parameter.typical);
            balance.chamber.effects.of_mut(i).iter_mut().zip(typical).for_each(|(value, typical)| *value = typical);
        }
        balance.work_out();
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
    fn what_bends_the_reading_comes_after_all_else_that_the_sensor_does() {
        let first = WITH_BENDS.iter().min();
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
