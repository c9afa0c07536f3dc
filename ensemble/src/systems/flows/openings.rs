//! Laws of the flow through an opening, relative to the mass of the gas: an orifice of ISO 6358 ([`iso6358`]), and a long narrow gap
//! (`laminar_leakage`). Pressures in Pa, temperatures in K, volumes in m³.

use crate::lanes::Lanes;
use crate::scenario::Scenario;
use chamber::effects::{Effect, EffectSet, LaminarLeakage, Leakage, SupplyLeakage, iso6358};
use chamber::real::Real;

/// An opening: the pressure outside and its width.
#[derive(Clone, Copy, Debug)]
pub struct Passage<R = f64> {
    /// Pressure outside, Pa; zero if there is no opening.
    pub pressure: R,
    /// Factor of the flow: see the laws.
    pub width: R,
    /// Critical pressure ratio, if the law has one.
    pub critical_ratio: R,
}

impl<R: Real> Passage<R> {
    /// No opening.
    pub const NONE: Self = Self { pressure: R::ZERO, width: R::ZERO, critical_ratio: R::ZERO };
}

/// The gas at one time.
pub struct GasInside<R> {
    /// √T and T.
    pub root: R,
    pub temperature: R,
    /// P V.
    pub energy: R,
    /// The pressure outside over that of the gas.
    pub ratio: R,
}

/// A law of the flow through an opening to an outside at ambient temperature, relative to the mass of the gas, the width and
/// V^−[`Law::POWER`]: two factors, of which the first takes longer to compute.
pub trait Law: Copy + Default + Sync {
    /// The flow is proportional to the volume to the power of minus this.
    const POWER: i32;
    /// The opening of a scenario.
    fn passage(scenario: &Scenario) -> Passage;
    /// The flow out of the gas.
    fn outflow<R: Real>(passage: &Passage<R>, gas: &GasInside<R>) -> [R; 2];
    /// The flow in, given 1/√T of the outside.
    fn inflow<R: Real>(passage: &Passage<R>, gas: &GasInside<R>, per_root_outside: R) -> [R; 2];
    /// The flow in if `inward` is positive, else the flow out.
    #[inline(always)]
    fn flow<R: Real>(passage: &Passage<R>, gas: &GasInside<R>, inward: R, per_root_outside: R) -> [R; 2] {
        let (into, out) = (Self::inflow(passage, gas, per_root_outside), Self::outflow(passage, gas));
        [inward.where_positive(into[0], out[0]), inward.where_positive(into[1], out[1])]
    }
    /// As [`LaneSystem::kink`](crate::integrator::step::LaneSystem::kink); the flow reverses at the pressure `turn`.
    fn corner(passage: &Passage<Lanes>, turn: Lanes, from: Lanes, to: Lanes) -> Lanes;
    /// A key that tests with flows in the same regimes have in common, by pressures of the gas, Pa: in neighbouring lanes they skip the
    /// same parts of the law.
    fn kind(_: &Passage, _: [f64; 3]) -> u8 {
        0
    }
}

/// An orifice of ISO 6358 towards the surroundings or the supply: o = C ρ0 √T0 R √T ψ/V, [`iso6358`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Orifice;
/// The effects of this kind, of which a test has one.
pub const ORIFICES: [EffectSet; 2] = [Leakage::SET, SupplyLeakage::SET];

impl Law for Orifice {
    const POWER: i32 = 1;

    fn passage(s: &Scenario) -> Passage {
        let effects = &s.chamber.effects;
        let (leak, supply) = (effects.of(Leakage::INDEX), effects.of(SupplyLeakage::INDEX));
        let (conductance, pressure, critical_ratio) =
            if leak[0] != 0.0 { (leak[0], s.ambient_pressure_pa, leak[1]) } else { (supply[0], supply[1], supply[2]) };
        let gas = &s.chamber.gas;
        let width = iso6358::constant(conductance, critical_ratio, gas) * gas.gas_constant;
        Passage { pressure, width, critical_ratio }
    }

    #[inline(always)]
    fn outflow<R: Real>(passage: &Passage<R>, gas: &GasInside<R>) -> [R; 2] {
        [iso6358::relative_outflow(gas.ratio, passage.critical_ratio), gas.root]
    }

    #[inline(always)]
    fn inflow<R: Real>(passage: &Passage<R>, gas: &GasInside<R>, per_root_outside: R) -> [R; 2] {
        [iso6358::relative_inflow(gas.ratio, passage.critical_ratio), gas.temperature * per_root_outside]
    }

    #[inline(always)]
    fn flow<R: Real>(passage: &Passage<R>, gas: &GasInside<R>, inward: R, per_root_outside: R) -> [R; 2] {
        let scale = inward.where_positive(gas.temperature * per_root_outside, gas.root);
        [iso6358::relative_flow(gas.ratio, passage.critical_ratio), scale]
    }

    #[inline(always)]
    fn corner(passage: &Passage<Lanes>, turn: Lanes, from: Lanes, to: Lanes) -> Lanes {
        iso6358::pressure_kink(passage.critical_ratio, passage.pressure, turn, from, to)
    }

    fn kind(passage: &Passage, pressures: [f64; 3]) -> u8 {
        let &Passage { pressure: outside, critical_ratio, .. } = passage;
        let regime = |pressure: f64| -> u8 {
            let chokes = pressure.min(outside) < critical_ratio * pressure.max(outside);
            2 * u8::from(pressure < outside) + u8::from((pressure < outside) != chokes)
        };
        let [before, after, pushed] = pressures.map(regime);
        16 * pushed + 4 * after + before
    }
}

/// A long narrow gap, o = G P (1 − (Pamb/P)²)/(2 V), or no opening: constant flows only.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gap;
/// The effect of this kind.
pub const GAP: EffectSet = LaminarLeakage::SET;

impl Law for Gap {
    const POWER: i32 = 2;

    fn passage(s: &Scenario) -> Passage {
        let conductance = s.chamber.effects.of(LaminarLeakage::INDEX)[0];
        if conductance == 0.0 {
            return Passage::NONE;
        }
        Passage { pressure: s.ambient_pressure_pa, width: 0.5 * conductance, critical_ratio: 0.0 }
    }

    #[inline(always)]
    fn outflow<R: Real>(_: &Passage<R>, gas: &GasInside<R>) -> [R; 2] {
        [R::ONE - gas.ratio * gas.ratio, gas.energy]
    }

    #[inline(always)]
    fn inflow<R: Real>(_: &Passage<R>, gas: &GasInside<R>, per_root_outside: R) -> [R; 2] {
        let warmth = gas.temperature * (per_root_outside * per_root_outside);
        [gas.ratio * gas.ratio - 1.0, gas.energy * warmth]
    }

    #[inline(always)]
    fn corner(passage: &Passage<Lanes>, _: Lanes, from: Lanes, to: Lanes) -> Lanes {
        LaminarLeakage::pressure_kink(&[], passage.pressure, from, to)
    }
}
