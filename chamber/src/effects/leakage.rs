//! Leakage: gas exchanged with the surroundings past a worn seal or a fitting, in whichever direction pressure drives it.
//!
//! ṁ = C p_up ρ0 √(T0/T_up) ψ(r),  r = p_down/p_up,  ψ = 1 for r ≤ b, else √(1 − ((r − b)/(1 − b))²)
//! C  m³/(s Pa)  sonic conductance;  b  1  critical pressure ratio;  ψ linear in r above r = 0.999.
//! T0 = 293.15 K, ρ0 = 1.185 kg/m³ for air (times 287/R for another gas). Inflow enters at ambient temperature.
//! Source: ISO 6358-1:2013. Not for a seal whose opening grows with pressure.

use super::Effect;
use crate::balance::{Conditions, Flows};
use crate::card::{Balance, Card, Parameter, Unit};
use crate::real::{Real, reciprocals};

const REFERENCE_TEMPERATURE_K: f64 = 293.15;
const REFERENCE_DENSITY_OF_AIR_KG_PER_M3: f64 = 1.185;
const GAS_CONSTANT_OF_AIR: f64 = 287.0;
/// Above this pressure ratio ψ is linear, so that its slope at r = 1 is finite.
const LINEAR_ABOVE: f64 = 0.999;

/// ISO 6358 leak between the gas and its surroundings.
pub struct Leakage;

impl Effect for Leakage {
    const CARD: Card = Card {
        name: "leakage",
        doc: "Gas exchanged with the surroundings past a seal or fitting",
        equation: "mdot = C p_up rho0 sqrt(293.15/T_up) psi(p_down/p_up)",
        source: "ISO 6358-1:2013",
        balance: Balance::Mass,
        parameters: &[
            Parameter {
                name: "conductance",
                unit: Unit::SonicConductance,
                bounds: 0.0..=1e-7,
                neutral: 0.0,
                typical: 1e-12,
                fitted: true,
                doc: "Sonic conductance C of the leak; zero means a tight chamber",
            },
            Parameter {
                name: "critical_pressure_ratio",
                unit: Unit::One,
                bounds: 0.0..=0.9,
                neutral: 0.3,
                typical: 0.3,
                fitted: false,
                doc: "Critical pressure ratio b; of no influence while the conductance is zero",
            },
        ],
        states: &[],
    };

    #[inline(always)]
    fn flows<R: Real>(p: &[R], at: &Conditions<R>, flows: &mut Flows<R>) {
        let (conductance, critical) = (p[0], p[1]);
        let out = at.pressure - at.ambient_pressure;
        let upstream = at.pressure.max(at.ambient_pressure);
        let downstream = at.pressure.min(at.ambient_pressure);
        let upstream_temperature = out.where_positive(at.temperature, at.ambient_temperature);
        let [per_upstream, per_temperature, per_gas_constant, per_unchoked] =
            reciprocals([upstream, upstream_temperature, at.gas_constant, R::ONE - critical]);
        let [psi_squared, fade] = flow_function(downstream * per_upstream, critical, per_unchoked);
        let density = per_gas_constant * (REFERENCE_DENSITY_OF_AIR_KG_PER_M3 * GAS_CONSTANT_OF_AIR);
        let root = (per_temperature * REFERENCE_TEMPERATURE_K * psi_squared).sqrt();
        let flow = conductance * upstream * density * root * fade;
        flows.outflow += out.where_positive(flow, R::ZERO);
        flows.enter(out.where_positive(R::ZERO, flow), at.ambient_temperature);
    }
}

/// ψ(r) of ISO 6358, continued linearly to zero at r = 1: its square without, and the factor with which it is continued.
/// `per_unchoked` is 1/(1 − b).
#[inline(always)]
fn flow_function<R: Real>(ratio: R, critical: R, per_unchoked: R) -> [R; 2] {
    let x = ((ratio.min(R::from(LINEAR_ABOVE)) - critical) * per_unchoked).max(R::ZERO);
    let fade = ((R::ONE - ratio) * (1.0 / (1.0 - LINEAR_ABOVE))).min(R::ONE);
    [R::ONE - x * x, fade]
}

#[cfg(test)]
mod tests {
    fn flow_function(ratio: f64, critical: f64) -> f64 {
        let [squared, fade] = super::flow_function(ratio, critical, 1.0 / (1.0 - critical));
        squared.sqrt() * fade
    }

    #[test]
    fn a_choked_leak_does_not_depend_on_the_downstream_pressure() {
        assert_eq!(flow_function(0.29, 0.3), 1.0);
        assert_eq!(flow_function(0.01, 0.3), 1.0);
        assert!(flow_function(0.5, 0.3) < 1.0);
    }

    #[test]
    fn the_flow_function_is_continuous_where_it_turns_linear_and_vanishes_at_equal_pressures() {
        let (below, above) = (flow_function(0.999 - 1e-12, 0.3), flow_function(0.999 + 1e-12, 0.3));
        assert!((below - above).abs() < 1e-8);
        assert_eq!(flow_function(1.0, 0.3), 0.0);
    }
}
