//! Balances of mass and internal energy of the gas: equations (1) to (3) with mass m and internal energy U as states.
//!
//! dm/dt = Σ ṁin − Σ ṁout,  dU/dt = −P dV/dt + Q̇ + cp (Σ ṁin Tin − Σ ṁout T),  Q̇ = λ Aq (Tw − T)
//! P = (γ − 1) U/V,  T = U/(m cv), unless an effect makes the heat capacities vary. Both states are conserved to rounding with
//! any integrator.
//! [`pressure_temperature_rates`] is the paper's own form, for comparison.

pub use crate::parts::{Boundary, Conditions, Contents, Flows, PressureTrend, Rates, Surroundings, Tight};

use crate::effects::{self, EffectConstants, EffectSet, OWN_STATES};
use crate::gas::Gas;
use crate::model::Chamber;
use crate::real::{Real, reciprocals};

/// Number of states: mass, internal energy and every effect's own.
pub const STATES: usize = 2 + OWN_STATES;
/// Index of the mass, kg.
pub const MASS: usize = 0;
/// Index of the internal energy, J.
pub const ENERGY: usize = 1;
/// Index of the first own state of the effects.
pub const OWN: usize = 2;

/// Number of leading states that suffice for most sets of effects: see [`moving_states`].
pub const FEW_STATES: usize = OWN + effects::FEW_OWN_STATES;

/// Number of leading states that change with the effects in `set`: an integration may drop those after them.
pub fn moving_states(set: EffectSet) -> usize {
    OWN + effects::own_states_of(set)
}

/// The effects' own states among the first `N` states; zero for those dropped.
#[inline(always)]
pub fn own_states<R: Real, const N: usize>(state: &[R; N]) -> [R; OWN_STATES] {
    let mut own = [R::ZERO; OWN_STATES];
    own[..N - OWN].copy_from_slice(&state[OWN..]);
    own
}

/// A chamber with precomputed reciprocals, roots and other constants that its balances use repeatedly.
#[derive(Clone, Copy, Debug)]
pub struct Balances<R = f64> {
    /// Its gas, shape, heat transfer and effects.
    pub chamber: Chamber<R>,
    /// γ − 1.
    pub expansion: R,
    /// 1/(γ − 1).
    pub per_expansion: R,
    /// cv, J/(kg K).
    pub cv: R,
    /// 1/cv, kg K/J.
    pub per_cv: R,
    /// cp, J/(kg K).
    pub cp: R,
    /// λ √(m V)/U, W/(m² K) × kg^½ m^1.5/J, before any effect: λ0 (γ − 1)/√(R P0 T0), as P T = U² (γ − 1)²/(R m V).
    pub heat_transfer_factor: R,
    /// Lateral area per volume, 1/m, and area of both ends, m².
    pub area: [R; 2],
    /// [`Effect::constant`](effects::Effect::constant) of each effect.
    pub constants: EffectConstants<R>,
}

/// Conditions from the states: the actual state of the gas, and wall and heat transfer before any effect.
#[inline(always)]
pub fn conditions<R: Real>(chamber: &Chamber<R>, boundary: &Boundary<R>, mass: R, energy: R) -> Conditions<R> {
    let contents = Contents::new(mass, energy, chamber.geometry.volume(boundary.position));
    Balances::of(*chamber).conditions(effects::CALORIC.union(effects::VOLUMETRIC), boundary, &contents)
}

/// [`Balances::state_at`] for a chamber evaluated only once.
pub fn state_at<R: Real>(chamber: &Chamber<R>, boundary: &Boundary<R>, pressure: R, temperature: R) -> [R; STATES] {
    Balances::of(*chamber).state_at(EffectSet::ALL, boundary, pressure, temperature)
}

/// [`Balances::evaluate`] for a chamber evaluated only once.
#[inline(always)]
pub fn evaluate<R: Real>(
    set: EffectSet,
    chamber: &Chamber<R>,
    boundary: &Boundary<R>,
    state: &[R; STATES],
) -> (Conditions<R>, Rates<R>, [R; OWN_STATES]) {
    Balances::of(*chamber).evaluate(set, boundary, state)
}

/// [`Balances::rates`] for a chamber evaluated only once.
#[inline(always)]
pub fn rates<R: Real>(
    set: EffectSet,
    chamber: &Chamber<R>,
    boundary: &Boundary<R>,
    state: &[R; STATES],
) -> [R; STATES] {
    Balances::of(*chamber).rates(set, boundary, state)
}

impl<R: Real> Balances<R> {
    /// Balances of the given chamber.
    #[inline(always)]
    pub fn of(chamber: Chamber<R>) -> Self {
        let mut balance = Self {
            chamber,
            expansion: R::ZERO,
            per_expansion: R::ZERO,
            cv: R::ZERO,
            per_cv: R::ZERO,
            cp: R::ZERO,
            heat_transfer_factor: R::ZERO,
            area: [R::ZERO; 2],
            constants: [R::ZERO; effects::COUNT],
        };
        balance.recompute_constants();
        balance
    }

    /// Recomputes the constants after its chamber was changed in place: lanes of chambers are too large to move.
    #[inline(always)]
    pub fn recompute_constants(&mut self) {
        let Gas { gas_constant, heat_capacity_ratio } = self.chamber.gas;
        let expansion = heat_capacity_ratio - 1.0;
        let [per_expansion, per_gas_constant] = reciprocals([expansion, gas_constant]);
        let law = &self.chamber.heat_transfer;
        let reference = (gas_constant * law.reference_pressure * law.reference_temperature).sqrt();
        self.expansion = expansion;
        self.per_expansion = per_expansion;
        self.cv = gas_constant * per_expansion;
        self.per_cv = expansion * per_gas_constant;
        self.cp = heat_capacity_ratio * gas_constant * per_expansion;
        self.heat_transfer_factor = law.coefficient * expansion / reference;
        self.area = self.chamber.geometry.area_constants();
        self.constants = self.chamber.effects.constants(&self.chamber.gas);
    }

    /// States of the chamber in internal equilibrium, with the effects in `set`, at a pressure, Pa, and temperature, K.
    pub fn state_at(&self, set: EffectSet, boundary: &Boundary<R>, pressure: R, temperature: R) -> [R; STATES] {
        let values = &self.chamber.effects;
        let [factor, ..] = values.volume(set, boundary.position, pressure);
        let volume = self.chamber.geometry.volume(boundary.position) * factor;
        let mass = pressure * volume / (self.chamber.gas.gas_constant * temperature);
        let energy = pressure * volume / self.expansion * values.internal_energy(set, temperature);
        let mut state = [R::ZERO; STATES];
        (state[MASS], state[ENERGY]) = (mass, energy);
        let contents = self.contents(boundary, &state);
        let mut own = [R::ZERO; OWN_STATES];
        effects::initial(&self.conditions(set, boundary, &contents), &mut own);
        state[OWN..].copy_from_slice(&own);
        state
    }

    /// [`Effect::decays`](effects::Effect::decays) of the effects in `set`, for each of the first `N` states, 1/s.
    pub fn decays<const N: usize>(&self, set: EffectSet, boundary: &Boundary<R>, state: &[R; N]) -> [R; N] {
        let at = self.conditions(set, boundary, &self.contents(boundary, state));
        let own = self.chamber.effects.decays(set, &at);
        core::array::from_fn(|i| i.checked_sub(OWN).map_or(R::ZERO, |index| own[index]))
    }

    /// Contents of the chamber in the given state.
    #[inline(always)]
    pub fn contents<const N: usize>(&self, boundary: &Boundary<R>, state: &[R; N]) -> Contents<R> {
        Contents::new(state[MASS], state[ENERGY], self.chamber.geometry.volume(boundary.position))
    }

    /// Conditions of the given contents: the state of the gas with the effects in `set`, and wall and heat transfer before any
    /// effect.
    #[inline(always)]
    pub fn conditions(&self, set: EffectSet, boundary: &Boundary<R>, contents: &Contents<R>) -> Conditions<R> {
        let chamber = &self.chamber;
        let Contents { mass, energy, volume, per_root, per_energy } = *contents;
        let Boundary { ambient_temperature, ambient_pressure, velocity, .. } = *boundary;
        let per_both = per_root * per_root;
        let (per_mass, per_volume) = (per_both * volume, per_both * mass);
        let temperature = energy * per_mass * self.per_cv;
        let mut at = Conditions {
            mass,
            volume,
            swept_volume: volume - chamber.geometry.dead_volume,
            pressure: self.expansion * energy * per_volume,
            temperature,
            per_mass,
            per_volume,
            energy,
            per_energy,
            eichelberg: self.heat_transfer_factor * energy * per_root,
            gas_temperature_at_wall: temperature,
            wall_temperature: ambient_temperature,
            piston_area: chamber.geometry.piston_area,
            velocity,
            ambient_temperature,
            ambient_pressure,
            gas_constant: chamber.gas.gas_constant,
            heat_capacity_ratio: chamber.gas.heat_capacity_ratio,
            expansion: self.expansion,
            per_expansion: self.per_expansion,
            cv: self.cv,
            cp: self.cp,
            reference_pressure: chamber.heat_transfer.reference_pressure,
            reference_temperature: chamber.heat_transfer.reference_temperature,
        };
        chamber.effects.gas_properties(set, &mut at);
        if chamber.effects.is_volumetric(set) {
            let factor = self.volume_factor(set, volume, at.pressure);
            let per_factor = factor.recip();
            at.volume = volume * factor;
            at.per_volume = per_volume * per_factor;
            at.pressure = at.pressure * per_factor;
            at.eichelberg = at.eichelberg * per_factor.sqrt();
        }
        at
    }

    /// The gas's volume over the geometry's, f, where the gas would have the pressure `alone`, Pa, in the latter. Solves P f(P) =
    /// `alone` by Newton's method: f is close to one, so a few steps reach rounding.
    #[inline(always)]
    fn volume_factor(&self, set: EffectSet, volume: R, alone: R) -> R {
        const STEPS: usize = 6;
        let mut pressure = alone;
        for _ in 0..STEPS {
            let [factor, _, by_pressure] = self.volume_at(set, volume, pressure);
            pressure -= (pressure * factor - alone) / (factor + by_pressure * pressure);
        }
        alone / pressure
    }

    /// [`EffectValues::volume`] at a geometric volume, m³, and pressure, Pa.
    #[inline(always)]
    fn volume_at(&self, set: EffectSet, volume: R, pressure: R) -> [R; 3] {
        let geometry = &self.chamber.geometry;
        let position = (volume - geometry.dead_volume) / geometry.piston_area;
        self.chamber.effects.volume(set, position, pressure)
    }

    /// Pressure of the given contents, Pa, with the effects in `set`.
    #[inline(always)]
    pub fn pressure(&self, set: EffectSet, contents: &Contents<R>) -> R {
        let pressure = if set.intersection(effects::CALORIC).is_empty() {
            self.expansion * contents.energy / contents.volume
        } else {
            let temperature = contents.energy / contents.mass * self.per_cv;
            self.chamber.effects.temperature(set, temperature) * contents.mass * self.chamber.gas.gas_constant
                / contents.volume
        };
        if !self.chamber.effects.is_volumetric(set) {
            return pressure;
        }
        pressure / self.volume_factor(set, contents.volume, pressure)
    }

    /// Conditions, rates, and rates of the effects' own states at one moment. Only effects in `set` take part; `set` must contain
    /// every effect that is not neutral.
    #[inline(always)]
    pub fn evaluate<const N: usize>(
        &self,
        set: EffectSet,
        boundary: &Boundary<R>,
        state: &[R; N],
    ) -> (Conditions<R>, Rates<R>, [R; OWN_STATES]) {
        self.evaluate_within(&(), set, boundary, &self.contents(boundary, state), &own_states(state))
    }

    /// [`Balances::evaluate`] within surroundings, from known contents and own states; the boundary's position is not read. The
    /// first `M` own states suffice where the effects in `set` have no others.
    #[inline(always)]
    pub fn evaluate_within<const M: usize, S: Surroundings<R>>(
        &self,
        surroundings: &S,
        set: EffectSet,
        boundary: &Boundary<R>,
        contents: &Contents<R>,
        own: &[R; M],
    ) -> (Conditions<R>, Rates<R>, [R; M]) {
        let chamber = &self.chamber;
        let mut at = self.conditions(set, boundary, contents);
        chamber.effects.conditions(set, own, &mut at);
        surroundings.conditions(&mut at);

        let coefficient = chamber.effects.heat_transfer_factor(set, &at, at.eichelberg);
        let area = self.area_of(set, at.volume);
        let from_wall = coefficient * area * (at.wall_temperature - at.gas_temperature_at_wall);
        let heat_flow = chamber.effects.heat_flow(set, &at, from_wall);

        let mut flows = Flows::NONE;
        if !S::TIGHT {
            flows.outflow = boundary.mass_flow_out;
            flows.enter(boundary.mass_flow_in, boundary.temperature_in);
            chamber.effects.flows(set, &self.constants, &at, &mut flows);
            surroundings.flows(&at, &mut flows);
        }

        let mut volume_rate = at.piston_area * at.velocity;
        // dV/dP, m³/Pa, and the factor by which it reduces the pressure's rate.
        let (mut by_pressure, mut compliance_factor) = (R::ZERO, R::ONE);
        let volumetric = chamber.effects.is_volumetric(set);
        if volumetric {
            let [factor, by_position, factor_by_pressure] = self.volume_at(set, contents.volume, at.pressure);
            volume_rate = volume_rate * factor + contents.volume * by_position * at.velocity;
            by_pressure = contents.volume * factor_by_pressure;
            compliance_factor = (R::ONE + (at.expansion + 1.0) * at.pressure * by_pressure * at.per_volume).recip();
        }
        let mut work = at.pressure * volume_rate;
        if !S::TIGHT && !set.intersection(effects::STORING).is_empty() {
            let [_, for_pressure] = self.enthalpy(set, &at, &flows);
            let unstored = at.pressure_rate(heat_flow + for_pressure, work);
            let rate = if volumetric { unstored * compliance_factor } else { unstored };
            let excess = self.excess_of_ambient(set, &at);
            chamber.effects.storage(set, &at, &PressureTrend { rate, compliance_factor, excess }, &mut flows);
        }

        let [enthalpy_flow, for_pressure] = if S::TIGHT { [R::ZERO; 2] } else { self.enthalpy(set, &at, &flows) };
        let pressure_rate = at.pressure_rate(heat_flow + for_pressure, work);
        let pressure_rate = if volumetric { pressure_rate * compliance_factor } else { pressure_rate };
        if volumetric {
            work += at.pressure * by_pressure * pressure_rate;
        }
        let rates = Rates {
            mass: flows.inflow - flows.outflow,
            energy: heat_flow + enthalpy_flow - work,
            pressure: pressure_rate,
            heat_flow,
            heat_transfer_coefficient: coefficient,
            enthalpy_flow,
            work,
        };
        let own_rates = chamber.effects.own_rates(set, own, &at, &flows, &rates);
        (at, rates, own_rates)
    }

    /// Heat transfer area, m², for a gas volume, m³, with the effects in `set`.
    #[inline(always)]
    pub fn area_of(&self, set: EffectSet, volume: R) -> R {
        let of_law = self.chamber.geometry.wetted_volume(volume) * self.area[0] + self.area[1];
        self.chamber.effects.heat_transfer_area(set, of_law)
    }

    /// Transfers a heat, J, instantaneously from the wall into the gas; `state` holds the first `N` states.
    pub fn heat<const N: usize>(&self, set: EffectSet, boundary: &Boundary<R>, state: &mut [R; N], heat: R) {
        let values = &self.chamber.effects;
        let mut own = own_states(state);
        let mut at = self.conditions(set, boundary, &self.contents(boundary, state));
        values.conditions(set, &own, &mut at);
        values.heated(set, &at, self.area_of(set, at.volume), heat, &mut own);
        state[ENERGY] += heat;
        state[OWN..].copy_from_slice(&own[..N - OWN]);
    }

    /// Enthalpy flow, W, of the flows: for the rate of the energy and for the rate of P V/(γ − 1).
    #[inline(always)]
    fn enthalpy(&self, set: EffectSet, at: &Conditions<R>, flows: &Flows<R>) -> [R; 2] {
        let [for_energy, for_pressure] = self.chamber.effects.excess_enthalpy(set, at, flows);
        let enthalpy = at.cp * (flows.inflow_kelvin - flows.outflow * at.temperature);
        [enthalpy + for_energy, enthalpy + for_pressure]
    }

    /// Excess temperature, K, of gas that enters from the surroundings, as it acts on the pressure's rate.
    #[inline(always)]
    fn excess_of_ambient(&self, set: EffectSet, at: &Conditions<R>) -> R {
        if set.intersection(effects::CALORIC).is_empty() {
            return R::ZERO;
        }
        let mut unit = Flows::NONE;
        unit.enter(R::ONE, at.ambient_temperature);
        self.chamber.effects.excess_enthalpy(set, at, &unit)[1] / at.cp
    }

    /// Rates of the first `N` states, per second, for an integrator.
    #[inline(always)]
    pub fn rates<const N: usize>(&self, set: EffectSet, boundary: &Boundary<R>, state: &[R; N]) -> [R; N] {
        self.rates_with_own::<N, OWN_STATES>(set, boundary, state)
    }

    /// As [`Balances::rates`], computed with only the first `M` own states, at least `N` - 2: the others cost nothing.
    #[inline(always)]
    pub fn rates_with_own<const N: usize, const M: usize>(
        &self,
        set: EffectSet,
        boundary: &Boundary<R>,
        state: &[R; N],
    ) -> [R; N] {
        let mut own = [R::ZERO; M];
        own[..N - OWN].copy_from_slice(&state[OWN..]);
        let (_, rates, own) = self.evaluate_within(&(), set, boundary, &self.contents(boundary, state), &own);
        let mut out = [R::ZERO; N];
        out[MASS] = rates.mass;
        out[ENERGY] = rates.energy;
        out[OWN..].copy_from_slice(&own[..N - OWN]);
        out
    }
}

/// dP/dt and dT/dt of the paper's equations (1) and (2), without effects, for states P, Pa, and T, K.
pub fn pressure_temperature_rates<R: Real>(
    chamber: &Chamber<R>,
    boundary: &Boundary<R>,
    pressure: R,
    temperature: R,
) -> [R; 2] {
    let (p, t) = (pressure, temperature);
    let g = chamber.gas.heat_capacity_ratio;
    let r = chamber.gas.gas_constant;
    let volume = chamber.geometry.volume(boundary.position);
    let volume_rate = chamber.geometry.piston_area * boundary.velocity;
    let (inflow, outflow) = (boundary.mass_flow_in, boundary.mass_flow_out);
    let heat_flow = chamber.heat_transfer.coefficient_at(p, t)
        * chamber.geometry.heat_transfer_area(volume)
        * (boundary.ambient_temperature - t);
    let pressure_rate = -g * p / volume * volume_rate
        + g * r / volume * (inflow * boundary.temperature_in - outflow * t)
        + (g - 1.0) / volume * heat_flow;
    let temperature_rate = t / volume * volume_rate * (R::ONE - g) - outflow * r * t * t / (volume * p) * (g - 1.0)
        + inflow * r * t / (volume * p) * (g * boundary.temperature_in - t)
        + (g - 1.0) * t / (p * volume) * heat_flow;
    [pressure_rate, temperature_rate]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AreaLaw;
    use crate::effects::{GasZones, WallHeating};
    use crate::papers_chamber::section_31;

    #[test]
    fn heat_that_comes_out_of_the_wall_at_once_is_missing_there() {
        let (wall, zones) = (WallHeating::INDEX, GasZones::INDEX);
        let chamber = section_31(AreaLaw::Total).with(wall, &[2.0, 0.0]).with(zones, &[0.3, 0.1]);
        let (set, at) = (chamber.active(), Boundary::closed(0.05, 293.0, 1.013e5));
        let balance = Balances::of(chamber);
        let before = balance.state_at(set, &at, 3e5, 293.0);
        let mut after = before;
        balance.heat(set, &at, &mut after, 0.1);
        let change = |i: usize| after[i] - before[i];
        assert!((change(ENERGY) - 0.1).abs() < 1e-12 && change(MASS) == 0.0);
        let own = |e: usize| OWN + effects::STATE_OFFSETS[e];
        assert!((change(own(wall)) + 0.05).abs() < 1e-12);
        // The core gains no heat: only the compression work heats it.
        let [p, q] = [before, after].map(|state| balance.pressure(set, &balance.contents(&at, &state)));
        let core = before[own(zones)];
        let isentropic = core * (q / p).powf(1.0 - 1.0 / chamber.gas.heat_capacity_ratio);
        assert!((after[own(zones)] / isentropic - 1.0).abs() < 1e-3);
    }

    /// A chamber with the effects in `set` at typical values, a boundary with flows and a moving piston, and its states.
    fn with_flow_and_motion(set: EffectSet) -> (Chamber, Boundary, [f64; STATES]) {
        let chamber = section_31(AreaLaw::Total).with_typical(set);
        let boundary = Boundary {
            velocity: -0.5,
            mass_flow_in: 1e-5,
            temperature_in: 310.0,
            mass_flow_out: 2e-6,
            ..Boundary::closed(0.05, 293.0, 1.013e5)
        };
        let state = Balances::of(chamber).state_at(set, &boundary, 8e5, 350.0);
        (chamber, boundary, state)
    }

    #[test]
    fn one_over_the_mean_temperature_is_that_whatever_the_gas_is_like() {
        let like = effects::CALORIC.union(effects::VOLUMETRIC);
        for set in like.iter().map(EffectSet::one).chain([EffectSet::NONE, like]) {
            let (chamber, boundary, state) = with_flow_and_motion(set);
            let (at, ..) = Balances::of(chamber).evaluate(set, &boundary, &state);
            assert!((at.per_temperature() * at.temperature - 1.0).abs() < 1e-13, "{set:?}");
        }
    }

    #[test]
    fn the_core_of_the_gas_keeps_its_balance_of_enthalpy_while_gas_flows_and_the_piston_moves() {
        let zones = GasZones::INDEX;
        for set in [GasZones::SET, GasZones::SET.union(effects::CALORIC)] {
            let (chamber, boundary, mut state) = with_flow_and_motion(set);
            let index = OWN + effects::STATE_OFFSETS[zones];
            state[index] = 330.0;
            let (at, rates, own) = Balances::of(chamber).evaluate(set, &boundary, &state);
            let (core, rate) = (state[index], own[index - OWN]);
            let [fraction, conductance] = [chamber.effects.of(zones)[0], chamber.effects.of(zones)[1]];
            let rest = (at.temperature - fraction * core) / (1.0 - fraction);
            let volume = fraction * at.mass * at.gas_constant * core / at.pressure;
            let inflow = boundary.mass_flow_in * at.cp * (boundary.temperature_in - core);
            let received = volume * rates.pressure + conductance * (rest - core) + fraction * inflow;
            assert!((fraction * at.mass * at.cp * rate / received - 1.0).abs() < 1e-12, "{rate} {received}");
        }
    }
}
