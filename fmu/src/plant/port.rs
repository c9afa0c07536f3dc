//! Flow through a valve port, coupled with the gas: ISO 6358, in whichever direction pressure drives it.
//!
//! ṁ = C p_up ρ0 √(T0/T_up) ψ(r),  r = p_down/p_up,  ψ = 1 for r ≤ b, else √(1 − ((r − b)/(1 − b))²), linear above r = 0.999
//! C  m³/(s Pa)  sonic conductance, an input;  b  1  critical pressure ratio;  T0 = 293.15 K, ρ0 = 1.185 kg/m³ for air
//! (times 287/R for another gas). Gas enters at the port's temperature and leaves at its own. Source: ISO 6358-1:2013.

use super::values::{INPUTS, input};
use chamber::balance::{Conditions, Flows, Surroundings};
use chamber::real::Real;

const REFERENCE_TEMPERATURE_K: f64 = 293.15;
/// ρ0 R for any gas at the reference state, Pa/K: 1.185 kg/m³ of air with R = 287 J/(kg K).
const REFERENCE_PRESSURE_PER_KELVIN: f64 = 1.185 * 287.0;
/// Above this pressure ratio ψ is linear, so that its slope at r = 1 is finite.
const LINEAR_ABOVE: f64 = 0.999;

/// A port: a valve's opening to a volume of known state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port<R = f64> {
    /// Pressure on the other side, Pa.
    pub pressure: R,
    /// Temperature on the other side, K.
    pub temperature: R,
    /// Sonic conductance, m³/(s Pa).
    pub conductance: R,
    /// Critical pressure ratio.
    pub critical_ratio: R,
}

impl<R: Real> Port<R> {
    /// Mass flow into the chamber, kg/s, and the enthalpy it carries, W.
    #[inline]
    pub fn flow(&self, at: &Conditions<R>) -> [R; 2] {
        let inward = self.pressure - at.pressure;
        let upstream = inward.where_positive(self.pressure, at.pressure);
        let downstream = inward.where_positive(at.pressure, self.pressure);
        let temperature = inward.where_positive(self.temperature, at.temperature);
        let ratio = downstream / upstream;
        let beyond = (ratio.min(R::from(LINEAR_ABOVE)) - self.critical_ratio).max(R::ZERO);
        let fraction = beyond / (R::ONE - self.critical_ratio);
        let fade = ((R::ONE - ratio) * (1.0 / (1.0 - LINEAR_ABOVE))).min(R::ONE);
        let psi = (R::ONE - fraction * fraction).sqrt() * fade;
        let density = R::from(REFERENCE_PRESSURE_PER_KELVIN) / at.gas_constant;
        let size =
            self.conductance * upstream * density * (R::from(REFERENCE_TEMPERATURE_K) / temperature).sqrt() * psi;
        let mass = inward.where_positive(size, -size);
        [mass, mass * at.cp * temperature]
    }
}

/// The chamber's surroundings: a prescribed wall temperature and both ports, where used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Around<R = f64> {
    /// Wall temperature, K.
    pub wall: Option<R>,
    /// The supply port and the exhaust port.
    pub ports: Option<[Port<R>; 2]>,
}

impl<R: Real> Around<R> {
    /// From these inputs, with the ports' critical ratios.
    #[inline]
    pub fn of(u: &[R; INPUTS], external_wall: bool, [supply, exhaust]: [R; 2]) -> Self {
        let port = |first: usize, critical_ratio: R| Port {
            pressure: u[first],
            temperature: u[first + 1],
            conductance: u[first + 2],
            critical_ratio,
        };
        Self {
            wall: external_wall.then_some(u[input::WALL_TEMPERATURE]),
            ports: Some([port(input::SUPPLY_PORT, supply), port(input::EXHAUST_PORT, exhaust)]),
        }
    }

    /// Mass flow into the chamber, kg/s, and enthalpy flow, W, through the supply port, then through the exhaust port.
    #[inline]
    pub fn port_flows(&self, at: &Conditions<R>) -> [R; 4] {
        let Some([supply, exhaust]) = self.ports else { return [R::ZERO; 4] };
        let ([a, b], [c, d]) = (supply.flow(at), exhaust.flow(at));
        [a, b, c, d]
    }
}

impl<R: Real> Surroundings<R> for Around<R> {
    #[inline(always)]
    fn conditions(&self, at: &mut Conditions<R>) {
        if let Some(wall) = self.wall {
            at.wall_temperature = wall;
        }
    }

    #[inline(always)]
    fn flows(&self, at: &Conditions<R>, flows: &mut Flows<R>) {
        for port in self.ports.iter().flatten() {
            let [mass, _] = port.flow(at);
            flows.outflow += mass.where_positive(R::ZERO, -mass);
            flows.enter(mass.where_positive(mass, R::ZERO), port.temperature);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chamber::balance::{Boundary, conditions, state_at};
    use chamber::effects::Leakage;

    fn at(pressure: f64) -> Conditions<f64> {
        let chamber = super::super::values::Starts::default().parameters.chamber();
        let boundary = Boundary::closed(0.1, 293.15, 1e5);
        let states = state_at(&chamber, &boundary, pressure, 330.0);
        conditions(&chamber, &boundary, states[0], states[1])
    }

    fn port(pressure: f64) -> Port {
        Port { pressure, temperature: 293.15, conductance: 1e-9, critical_ratio: 0.3 }
    }

    #[test]
    fn the_flow_of_a_choked_port_is_given_by_its_conductance() {
        let [mass, enthalpy] = port(7e5).flow(&at(1e5));
        assert!((mass / (1e-9 * 7e5 * 1.185) - 1.0).abs() < 1e-14);
        assert!((enthalpy / (mass * 1.4 * 287.0 / 0.4 * 293.15) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn gas_leaves_at_its_own_temperature() {
        let here = at(7e5);
        let [mass, enthalpy] = port(1e5).flow(&here);
        let size = 1e-9 * here.pressure * 1.185 * (293.15f64 / here.temperature).sqrt();
        assert!((mass / -size - 1.0).abs() < 1e-14);
        assert!((enthalpy / (mass * here.cp * here.temperature) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_port_is_the_leak_of_the_same_conductance() {
        let mut chamber = super::super::values::Starts::default().parameters.chamber();
        let leak = Leakage::INDEX;
        chamber.effects.of_mut(leak).copy_from_slice(&[1e-9, 0.3]);
        for pressure in [0.2e5, 0.9e5, 0.9999e5, 1.0001e5, 1.1e5, 2e5, 7e5] {
            let boundary = Boundary::closed(0.1, 293.15, 1e5);
            let states = state_at(&chamber, &boundary, pressure, 330.0);
            let leaking = chamber::balance::rates(chamber.active(), &chamber, &boundary, &states);
            let [mass, _] = port(1e5).flow(&conditions(&chamber, &boundary, states[0], states[1]));
            assert!((mass / leaking[0] - 1.0).abs() < 1e-11, "{pressure}: {mass} {}", leaking[0]);
        }
    }
}
