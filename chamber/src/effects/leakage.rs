//! Leakage: gas exchanged with the surroundings past a worn seal or a fitting, in whichever direction pressure drives it.
//!
//! ṁ = C p_up ρ0 √(T0/T_up) ψ(p_down/p_up), the law of [`iso6358`]; inflow enters at ambient temperature.
//! C  m³/(s Pa)  sonic conductance;  b  1  critical pressure ratio.
//! Source: ISO 6358-1:2013. Not for a seal whose opening grows with pressure.

use super::Effect;
use super::iso6358::{self, Passage};
use crate::card::{Balance, Card, Parameter, Unit};
use crate::gas::Gas;
use crate::parts::{Conditions, Flows, Rates};
use crate::real::Real;

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
                typical: 1e-12,
                doc: "Sonic conductance C of the leak; zero means a tight chamber",
                ..Parameter::DEFAULT
            },
            iso6358::CRITICAL_RATIO,
        ],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn constant<R: Real>(p: &[R], gas: &Gas<R>) -> R {
        iso6358::constant(p[0], p[1], gas)
    }

    #[inline(always)]
    fn flows<R: Real>(p: &[R], constant: R, at: &Conditions<R>, flows: &mut Flows<R>) {
        let surroundings =
            Passage { pressure: at.ambient_pressure, temperature: at.ambient_temperature, critical_ratio: p[1] };
        surroundings.exchange(constant, at, flows);
    }

    const KINK_INDICATORS: usize = iso6358::KINK_INDICATORS;

    fn kink_indicators<R: Real>(p: &[R], _: &[R], at: &Conditions<R>, _: &Rates<R>, out: &mut [R]) {
        out.copy_from_slice(&iso6358::kink_indicators(at.pressure, at.ambient_pressure, p[1]));
    }

    const HAS_PRESSURE_KINKS: bool = true;

    #[inline(always)]
    fn pressure_kink<R: Real>(p: &[R], ambient_pressure: R, from: R, to: R) -> R {
        iso6358::pressure_kink(p[1], ambient_pressure, ambient_pressure, from, to)
    }
}
