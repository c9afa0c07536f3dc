//! Laminar leakage: gas creeping through a long narrow gap, in whichever direction pressure drives it.
//!
//! ṁ = G (P² − Pamb²)/(2 R T_up): the volume flow at the mean pressure is G times the pressure difference.
//! G in m³/(s Pa). Inflow enters at ambient temperature.
//! Source: compressible Poiseuille flow, isothermal, e.g. White, Viscous Fluid Flow, chapter 3.

use super::Effect;
use super::nearest::nearer;
use crate::card::{Balance, Card, Parameter, Unit};
use crate::gas::Gas;
use crate::parts::{Conditions, Flows, Rates};
use crate::real::Real;

/// Laminar leak between the gas and its surroundings.
pub struct LaminarLeakage;

impl Effect for LaminarLeakage {
    const CARD: Card = Card {
        name: "laminar_leakage",
        doc: "Gas exchanged with the surroundings through a long narrow gap",
        equation: "mdot = G (P^2 - Pamb^2)/(2 R T_up)",
        source: "compressible Poiseuille flow, White, Viscous Fluid Flow, chapter 3",
        balance: Balance::Mass,
        parameters: &[Parameter {
            name: "conductance",
            unit: Unit::SonicConductance,
            bounds: 0.0..=1e-7,
            typical: 1e-12,
            doc: "Volume flow G at the mean pressure for each pascal of difference; zero means a tight chamber",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    /// G/(2 R).
    #[inline(always)]
    fn constant<R: Real>(p: &[R], gas: &Gas<R>) -> R {
        p[0] / (gas.gas_constant * 2.0)
    }

    #[inline(always)]
    fn flows<R: Real>(_: &[R], constant: R, at: &Conditions<R>, flows: &mut Flows<R>) {
        let (inside, outside) = (at.pressure, at.ambient_pressure);
        let out = inside - outside;
        let mut per_upstream = at.per_temperature();
        if (outside - inside).any_positive() {
            per_upstream = out.where_positive(per_upstream, at.ambient_temperature.recip());
        }
        let flow = constant * out * (inside + outside) * per_upstream;
        flows.outflow += out.where_positive(flow, R::ZERO);
        flows.enter(out.where_positive(R::ZERO, -flow), at.ambient_temperature);
    }

    const KINK_INDICATORS: usize = 1;

    /// Direction of the flow.
    fn kink_indicators<R: Real>(_: &[R], _: &[R], at: &Conditions<R>, _: &Rates<R>, out: &mut [R]) {
        out[0] = (at.pressure - at.ambient_pressure) / (at.pressure + at.ambient_pressure);
    }

    const HAS_PRESSURE_KINKS: bool = true;

    /// Where the flow reverses.
    #[inline(always)]
    fn pressure_kink<R: Real>(_: &[R], ambient_pressure: R, from: R, to: R) -> R {
        nearer(ambient_pressure, from, to)
    }
}
