//! Supply leakage: gas that passes a closed valve between the chamber and its supply.
//!
//! The law of [`leakage`](super::leakage) with the supply in place of the surroundings: inflow at ambient temperature
//! while the supply's pressure is above the gas's, outflow where it is below.
//! C  m³/(s Pa)  sonic conductance;  Ps  Pa  supply pressure;  b  1  critical pressure ratio. Source: ISO 6358-1:2013.

use super::Effect;
use super::iso6358::{self, Passage};
use crate::card::{Balance, Card, Fitted, Parameter, Unit};
use crate::gas::Gas;
use crate::parts::{Conditions, Flows, Rates};
use crate::real::Real;

/// ISO 6358 leak between the gas and its supply.
pub struct SupplyLeakage;

impl Effect for SupplyLeakage {
    const CARD: Card = Card {
        name: "supply_leakage",
        doc: "Gas enters from the supply past a closed valve",
        equation: "mdot = C p_up rho0 sqrt(293.15/T_up) psi(p_down/p_up), between Ps at Tamb and the gas",
        source: "ISO 6358-1:2013",
        balance: Balance::Mass,
        parameters: &[
            Parameter {
                name: "conductance",
                unit: Unit::SonicConductance,
                bounds: 0.0..=1e-7,
                typical: 1e-12,
                doc: "Sonic conductance C of the leak; zero means a tight valve",
                ..Parameter::DEFAULT
            },
            Parameter {
                name: "supply_pressure",
                unit: Unit::Pascal,
                bounds: 1e3..=1e8,
                neutral: 7e5,
                typical: 7e5,
                fitted: Fitted::Secondary,
                doc: "Absolute pressure Ps of the supply; of no influence while the conductance is zero",
                ..Parameter::DEFAULT
            },
            iso6358::CRITICAL_RATIO,
        ],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn constant<R: Real>(p: &[R], gas: &Gas<R>) -> R {
        iso6358::constant(p[0], p[2], gas)
    }

    #[inline(always)]
    fn flows<R: Real>(p: &[R], constant: R, at: &Conditions<R>, flows: &mut Flows<R>) {
        let supply = Passage { pressure: p[1], temperature: at.ambient_temperature, critical_ratio: p[2] };
        supply.exchange(constant, at, flows);
    }

    const KINK_INDICATORS: usize = iso6358::KINK_INDICATORS;

    fn kink_indicators<R: Real>(p: &[R], _: &[R], at: &Conditions<R>, _: &Rates<R>, out: &mut [R]) {
        out.copy_from_slice(&iso6358::kink_indicators(at.pressure, p[1], p[2]));
    }

    const HAS_PRESSURE_KINKS: bool = true;

    #[inline(always)]
    fn pressure_kink<R: Real>(p: &[R], _: R, from: R, to: R) -> R {
        iso6358::pressure_kink(p[2], p[1], p[1], from, to)
    }
}
