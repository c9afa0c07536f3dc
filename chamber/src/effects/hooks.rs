//! Joint action of the effects of a set: each hook of [`Effect`] for the parameters of all effects, as a method.

use super::{Effect, EffectConstants, EffectSet, EffectValues, Indexed, KINK_INDICATORS, OWN_STATES};
use crate::gas::Gas;
use crate::parts::{Conditions, Flows, PressureTrend, Rates};
use crate::real::Real;

/// Initial own states of all effects in a chamber at rest in equilibrium.
#[inline(always)]
pub fn initial<R: Real>(at: &Conditions<R>, own: &mut [R; OWN_STATES]) {
    each!(E => E::initial(at, E::own_mut(own)));
}

macro_rules! sums_of {
    ($($hook:ident)*) => {$(
        #[doc = concat!("Sum of [`Effect::", stringify!($hook), "`] of the effects in `set`.")]
        #[inline(always)]
        pub fn $hook(&self, set: EffectSet) -> R {
            let mut sum = R::ZERO;
            each!(E in set => sum += E::$hook(E::values(self)));
            sum
        }
    )*};
}

impl<R: Real> EffectValues<R> {
    /// Temperature of gas and wall at rest in surroundings at `ambient`, K.
    #[inline(always)]
    pub fn rest_temperature(&self, ambient: R) -> R {
        let mut temperature = ambient;
        each!(E => temperature += E::wall_excess(E::values(self)));
        temperature
    }

    /// Internal energy over m cv T at a temperature, K: the product of [`Effect::internal_energy`] of the effects in `set`.
    #[inline(always)]
    pub fn internal_energy(&self, set: EffectSet, temperature: R) -> R {
        let mut product = R::ONE;
        each!(E in set => if E::CALORIC { product = product * E::internal_energy(E::values(self), temperature) });
        product
    }

    /// [`Effect::decays`] of the effects in `set`, 1/s; zero for all other own states.
    pub fn decays(&self, set: EffectSet, at: &Conditions<R>) -> [R; OWN_STATES] {
        let mut out = [R::ZERO; OWN_STATES];
        each!(E in set => E::decays(E::values(self), at, E::own_mut(&mut out)));
        out
    }

    /// [`Effect::temperature`] of the effects in `set`, K.
    #[inline(always)]
    pub fn temperature(&self, set: EffectSet, by_energy: R) -> R {
        let mut temperature = by_energy;
        each!(E in set => if E::CALORIC { temperature = E::temperature(E::values(self), temperature) });
        temperature
    }

    /// [`Effect::gas_properties`] of the effects in `set`.
    #[inline(always)]
    pub fn gas_properties(&self, set: EffectSet, at: &mut Conditions<R>) {
        each!(E in set => if E::CALORIC { E::gas_properties(E::values(self), at) });
    }

    /// Sum of [`Effect::excess_enthalpy`] of the effects in `set`.
    #[inline(always)]
    pub fn excess_enthalpy(&self, set: EffectSet, at: &Conditions<R>, flows: &Flows<R>) -> [R; 2] {
        let mut sum = [R::ZERO; 2];
        each!(E in set => if E::CALORIC {
            let [energy, pressure] = E::excess_enthalpy(E::values(self), at, flows);
            sum[0] += energy;
            sum[1] += pressure;
        });
        sum
    }

    /// Whether an effect in `set` with these parameters makes the gas fill a volume other than the geometry's.
    #[inline(always)]
    pub fn is_volumetric(&self, set: EffectSet) -> bool {
        each!(E in set => if E::VOLUMETRIC && E::is_volumetric(E::values(self)) { return true });
        false
    }

    /// [`Effect::volume`] of the effects in `set`.
    #[inline(always)]
    pub fn volume(&self, set: EffectSet, position: R, pressure: R) -> [R; 3] {
        let mut all = [R::ONE, R::ZERO, R::ZERO];
        each!(E in set => if E::VOLUMETRIC {
            let one = E::volume(E::values(self), position, pressure);
            all = [all[0] * one[0], all[1] * one[0] + all[0] * one[1], all[2] * one[0] + all[0] * one[2]];
        });
        all
    }

    /// Heat flow into the gas, W: that from the wall plus [`Effect::heat_flow`] of the effects in `set`.
    #[inline(always)]
    pub fn heat_flow(&self, set: EffectSet, at: &Conditions<R>, from_wall: R) -> R {
        let mut heat = from_wall;
        each!(E in set => E::heat_flow(E::values(self), at, &mut heat));
        heat
    }

    /// [`Effect::conditions`] of the effects in `set` whose own states are among the first `M`.
    #[inline(always)]
    pub fn conditions<const M: usize>(&self, set: EffectSet, own: &[R; M], at: &mut Conditions<R>) {
        each!(E in set => if E::lies_within(M) { E::conditions(E::values(self), E::own(own), at) });
    }

    /// Product of [`Effect::heat_transfer_factor`] of the effects in `set`, times `base`.
    #[inline(always)]
    pub fn heat_transfer_factor(&self, set: EffectSet, at: &Conditions<R>, base: R) -> R {
        let mut product = base;
        each!(E in set => product = product * E::heat_transfer_factor(E::values(self), at));
        product
    }

    /// [`Effect::heat_transfer_area`] of the effects in `set`, starting from the area law's, m².
    #[inline(always)]
    pub fn heat_transfer_area(&self, set: EffectSet, of_law: R) -> R {
        let mut area = of_law;
        each!(E in set => area = E::heat_transfer_area(E::values(self), area));
        area
    }

    /// [`Effect::constant`] of every effect.
    #[inline(always)]
    pub fn constants(&self, gas: &Gas<R>) -> EffectConstants<R> {
        of_each!(E => E::constant(E::values(self), gas))
    }

    /// [`Effect::flows`] of the effects in `set`.
    #[inline(always)]
    pub fn flows(&self, set: EffectSet, constants: &EffectConstants<R>, at: &Conditions<R>, flows: &mut Flows<R>) {
        each!(E in set => E::flows(E::values(self), constants[E::INDEX], at, flows));
    }

    /// Earliest [`Effect::pressure_kink`] of the effects in `set`.
    #[inline(always)]
    pub fn pressure_kink(&self, set: EffectSet, ambient_pressure: R, from: R, to: R) -> R {
        let mut first = to;
        each!(E in set => first = E::pressure_kink(E::values(self), ambient_pressure, from, first));
        first
    }

    /// [`Effect::kink_indicators`] of all effects, in order; one for effects not in `set`.
    pub fn kink_indicators(
        &self,
        set: EffectSet,
        own: &[R; OWN_STATES],
        at: &Conditions<R>,
        rates: &Rates<R>,
    ) -> [R; KINK_INDICATORS] {
        let mut out = [R::ONE; KINK_INDICATORS];
        let mut rest = &mut out[..];
        each!(E => {
            let (part, after) = rest.split_at_mut(E::KINK_INDICATORS);
            if set.has(E::INDEX) {
                E::kink_indicators(E::values(self), E::own(own), at, rates, part);
            }
            rest = after;
        });
        debug_assert!(rest.is_empty());
        out
    }

    /// Adds [`Effect::storage`] of the effects in `set` to the flows.
    #[inline(always)]
    pub fn storage(&self, set: EffectSet, at: &Conditions<R>, trend: &PressureTrend<R>, flows: &mut Flows<R>) {
        each!(E in set => if E::STORES {
            let (flow, temperature) = E::storage(E::values(self), at, trend);
            flows.leave(flow, temperature);
        });
    }

    /// [`Effect::own_rates`] of the effects in `set` whose own states are among the first `M`; zero for the others.
    #[inline(always)]
    pub fn own_rates<const M: usize>(
        &self,
        set: EffectSet,
        own: &[R; M],
        at: &Conditions<R>,
        flows: &Flows<R>,
        rates: &Rates<R>,
    ) -> [R; M] {
        let mut out = [R::ZERO; M];
        each!(E in set => if E::lies_within(M) {
            E::own_rates(E::values(self), E::own(own), at, flows, rates, E::own_mut(&mut out));
        });
        out
    }

    /// [`Effect::heated`] of the effects in `set` whose own states are among the first `M`.
    pub fn heated<const M: usize>(&self, set: EffectSet, at: &Conditions<R>, area: R, heat: R, own: &mut [R; M]) {
        each!(E in set => if E::lies_within(M) { E::heated(E::values(self), at, area, heat, E::own_mut(own)) });
    }

    /// What the sensor shows, Pa, at a gas pressure, Pa: [`Effect::reading`] of the effects in `set`, in order.
    #[inline(always)]
    pub fn reading(&self, set: EffectSet, own: &[R; OWN_STATES], pressure: R, time: R) -> R {
        let mut reading = pressure;
        each!(E in set => reading = E::reading(E::values(self), E::own(own), reading, time));
        reading
    }

    /// Earliest [`Effect::reading_kink`] of the effects in `set`.
    pub fn reading_kink(&self, set: EffectSet, from: R, to: R) -> R {
        let mut first = to;
        each!(E in set => first = E::reading_kink(E::values(self), from, first));
        first
    }

    sums_of![inverse_effusivity lag delay stroke_delay stroke_filter stroke_window];
}
