//! Rates of the gas's states at one moment: the most frequent call in an integration along a record.

use crate::isentrope::Isentrope;
use chamber::balance::{Balances, Boundary, ENERGY, MASS, OWN, Tight};
use chamber::effects::{self, EffectSet};
use chamber::real::Scalar;
#[cfg(target_arch = "x86_64")]
use pulp::x86::V3;

/// Balances of a kind of gas, for the first `N` states.
pub trait OfGas<R, const N: usize>: Copy {
    /// Rates of these states, per second.
    fn rates(self, set: EffectSet, balance: &Balances<R>, boundary: &Boundary<R>, state: &[R; N]) -> [R; N];
}

/// Any gas, with the effects' first `M` own states.
#[derive(Clone, Copy)]
pub struct OfAnyGas<const M: usize>;

impl<R: Scalar, const N: usize, const M: usize> OfGas<R, N> for OfAnyGas<M> {
    #[inline(always)]
    fn rates(self, set: EffectSet, balance: &Balances<R>, boundary: &Boundary<R>, state: &[R; N]) -> [R; N] {
        balance.rates_with_own::<N, M>(set, boundary, state)
    }
}

/// Number of own states of a warming wall and of decaying turbulence, the first of all: those that tight gas has most often.
pub const OF_WALL_AND_TURBULENCE: usize = 2;

/// Gas of constant mass: no effect and no flow lets it in or out; with the effects' first `M` own states. A fraction of the work.
#[derive(Clone, Copy)]
pub struct OfTightGas<const M: usize>;

impl<const M: usize> OfTightGas<M> {
    /// Whether gas with the effects in `set` is of this kind, in a record without flow.
    pub fn suits(set: EffectSet) -> bool {
        let of_gas = set.without(effects::of_sensor()).without(effects::of_recorded_stroke());
        effects::KEEP_THE_MASS.contains(of_gas) && effects::own_states_of(of_gas) <= M
    }
}

impl<R: Scalar, const N: usize, const M: usize> OfGas<R, N> for OfTightGas<M> {
    #[inline(always)]
    fn rates(self, set: EffectSet, balance: &Balances<R>, boundary: &Boundary<R>, state: &[R; N]) -> [R; N] {
        const { assert!(N == OWN + M) };
        let set = set.intersection(effects::KEEP_THE_MASS);
        let contents = balance.contents(boundary, state);
        let own: [R; M] = core::array::from_fn(|i| state[OWN + i]);
        let (_, rates, own) = balance.evaluate_within(&Tight, set, boundary, &contents, &own);
        let mut out = [R::ZERO; N];
        out[ENERGY] = rates.energy;
        out[OWN..].copy_from_slice(&own);
        out
    }
}

/// Inputs of the balances at one moment.
pub struct Moving<'a, R, B, const N: usize> {
    /// Kind of gas.
    pub balances: B,
    /// Effects of the gas and its wall.
    pub set: EffectSet,
    /// Balances of the chamber at the coordinates of the fit.
    pub balance: &'a Balances<R>,
    /// Reference of the energy.
    pub isentrope: &'a Isentrope,
    /// Imposed boundary conditions.
    pub boundary: &'a Boundary<R>,
    /// Mass, kg, energy referred to the first volume, J, and the effects' own states.
    pub state: &'a [R; N],
    /// Disturbance, if any: mass flow into the gas, kg/s, heat flow into it, W, change of its volume, m³, and the rate of that
    /// change, m³/s.
    pub disturbance: Option<[R; 4]>,
}

impl<R: Scalar, B: OfGas<R, N>, const N: usize> Moving<'_, R, B, N> {
    /// Rates of the states, the energy referred to the first volume, with a disturbance added; its mass enters or leaves at the
    /// gas's temperature.
    #[inline(always)]
    fn rates(self) -> [R; N] {
        let Self { balances, set, balance, isentrope, boundary, state, disturbance } = self;
        let referred = isentrope.at(balance, boundary);
        let mut state = *state;
        state[ENERGY] = referred.energy(state[ENERGY]);
        let mut rates = match disturbance {
            None => balances.rates(set, balance, boundary, &state),
            Some([mass, heat, volume, volume_rate]) => {
                let chamber = &balance.chamber;
                let area = chamber.geometry.piston_area;
                let mut moved = *boundary;
                moved.position += volume / area;
                moved.velocity += volume_rate / area;
                let mut rates = balances.rates(set, balance, &moved, &state);
                rates[MASS] += mass;
                rates[ENERGY] += heat + mass * chamber.gas.heat_capacity_ratio * state[ENERGY] / state[MASS];
                rates
            }
        };
        rates[ENERGY] = referred.rate(state[ENERGY], rates[ENERGY]);
        rates
    }
}

/// Instruction set for derivatives, four at a time: AVX2 where the processor has it. Wider ones gain little, as there are few
/// derivatives, and would need as much code again.
#[derive(Clone, Copy)]
pub struct Instructions {
    #[cfg(target_arch = "x86_64")]
    wide: Option<V3>,
}

impl Instructions {
    /// Detects those of this processor.
    pub fn new() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            wide: V3::try_new(),
        }
    }

    /// Rates of the states at a moment: see [`Moving`].
    #[inline(always)]
    pub fn rates<R: Scalar, B: OfGas<R, N>, const N: usize>(self, moving: Moving<'_, R, B, N>) -> [R; N] {
        #[cfg(target_arch = "x86_64")]
        if R::DERIVATIVES > 0
            && let Some(wide) = self.wide
        {
            // The instructions apply to the function into which the closure is inlined.
            return wide.vectorize(
                #[inline(always)]
                || moving.rates(),
            );
        }
        moving.rates()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chamber::balance::FEW_STATES;
    use chamber::effects::{CARDS, FEW_OWN_STATES, find};
    use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};

    /// Rates of tight gas and of any gas with these effects at their typical values, for all states of the former.
    fn tight_and_any<const N: usize, const M: usize>(names: &[&str]) -> [[f64; N]; 2] {
        let geometry = Geometry::new(0.02, 0.0, 1.57e-6, AreaLaw::Total);
        let mut chamber = Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(26.5));
        let set: EffectSet = names.iter().map(|name| find(name).unwrap().0).collect();
        for effect in set.iter() {
            let typical = CARDS[effect].parameters.iter().map(|parameter| parameter.typical);
            chamber.effects.of_mut(effect).iter_mut().zip(typical).for_each(|(to, typical)| *to = typical);
        }
        assert!(OfTightGas::<M>::suits(set));
        let boundary = Boundary { velocity: -0.5, ..Boundary::closed(0.05, 293.0, 1.013e5) };
        let balance = Balances::of(chamber);
        let mut state = balance.state_at(EffectSet::ALL, &boundary, 8e5, 350.0);
        state[OWN..].iter_mut().for_each(|own| *own += 0.25);
        let tight: [f64; N] = OfTightGas::<M>.rates(set, &balance, &boundary, &core::array::from_fn(|i| state[i]));
        let few: [f64; FEW_STATES] = core::array::from_fn(|i| state[i]);
        let any = OfAnyGas::<FEW_OWN_STATES>.rates(set, &balance, &boundary, &few);
        [tight, core::array::from_fn(|i| any[i])]
    }

    #[test]
    fn tight_gas_has_the_same_rates_as_any_gas_to_the_last_bit() {
        let without_states = ["natural_convection", "dead_volume_surface", "record_delay", "position_averaging"];
        let [tight, any] = tight_and_any::<OWN, 0>(&without_states);
        assert_eq!(tight, any);
        let with_states = ["wall_heating", "decaying_turbulence", "natural_convection"];
        let [tight, any] = tight_and_any::<{ OWN + OF_WALL_AND_TURBULENCE }, OF_WALL_AND_TURBULENCE>(&with_states);
        assert_eq!(tight, any);
        assert!(tight[OWN..].iter().all(|rate| *rate != 0.0));
    }

    #[test]
    fn gas_with_mass_flow_or_with_more_states_does_not_count_as_tight() {
        let suits = |name: &str| OfTightGas::<0>::suits(EffectSet::one(find(name).unwrap().0));
        assert!(!["leakage", "tube_volume", "gas_zones", "wall_heating"].into_iter().any(suits));
    }
}
