//! Gas zones: part of the gas does not touch the wall and exchanges heat only with the rest of the gas.
//!
//! A constant mass fraction z (zone 2) at the common pressure P, with Q12 = H (T1 − T2) from the rest (zone 1).
//! Enthalpy balance of zone 2: z m cp dT2/dt = V2 dP/dt + Q12 + z Σ ṁin cp (Tin − T2), V2 = z m R T2/P.
//! Each zone takes its fraction of the flows. T = (1 − z) T1 + z T2 = P V/(m R) is the mean; T1 is the T of λ and Q̇. Where the
//! heat capacity depends on temperature, both zones have that of the mean temperature.
//! z  1; H  W/K. z = 0 means off. Source: two-zone models of engine cylinders, Heywood (1988), chapter 14.

use super::Effect;
use crate::card::{Balance, Card, OwnState, Parameter, Unit};
use crate::parts::{Conditions, Flows, Rates};
use crate::real::Real;

/// A core of gas away from the wall.
pub struct GasZones;

impl Effect for GasZones {
    const CARD: Card = Card {
        name: "gas_zones",
        doc: "A part of the gas exchanges heat with the rest of the gas only, not with the wall",
        equation: "z m cp dT2/dt = V2 dP/dt + H (T1 - T2) + z sum(mdot_in cp (Tin - T2))",
        source: "two-zone model, Heywood, Internal Combustion Engine Fundamentals (1988), chapter 14",
        balance: Balance::Energy,
        parameters: &[
            Parameter {
                name: "mass_fraction",
                bounds: 0.0..=0.95,
                typical: 0.25,
                doc: "Mass fraction z of the gas that does not touch the wall; zero means one zone",
                ..Parameter::DEFAULT
            },
            Parameter {
                name: "conductance",
                unit: Unit::WattPerKelvin,
                bounds: 0.0..=1e6,
                typical: 0.03,
                doc: "Conductance H between the zones; of no influence while the mass fraction is zero",
                ..Parameter::DEFAULT
            },
        ],
        states: &[OwnState {
            name: "core_temperature",
            unit: Unit::Kelvin,
            nominal: 300.0,
            doc: "Temperature T2 of the gas that does not touch the wall",
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn initial<R: Real>(at: &Conditions<R>, own: &mut [R]) {
        own[0] = at.temperature;
    }

    #[inline(always)]
    fn conditions<R: Real>(p: &[R], own: &[R], at: &mut Conditions<R>) {
        let fraction = p[0];
        at.gas_temperature_at_wall = (at.temperature - fraction * own[0]) / (R::ONE - fraction);
    }

    /// λ follows the temperature of the gas at the wall, not the mean one.
    #[inline(always)]
    fn heat_transfer_factor<R: Real>(_: &[R], at: &Conditions<R>) -> R {
        // Exactly 1 for a single zone.
        (R::ONE + (at.gas_temperature_at_wall - at.temperature) * at.per_temperature()).sqrt()
    }

    #[inline(always)]
    fn own_rates<R: Real>(p: &[R], own: &[R], at: &Conditions<R>, flows: &Flows<R>, rates: &Rates<R>, out: &mut [R]) {
        let (fraction, conductance, core) = (p[0], p[1], own[0]);
        // Multiplied by m cp throughout, because divisions are slow: m R/P = V/T.
        let compression = core * at.volume * at.per_temperature() * rates.pressure;
        let mixing = at.cp * (flows.inflow_kelvin - flows.inflow * core);
        let exchange = conductance * (at.gas_temperature_at_wall - core);
        let safe_fraction = fraction.where_positive(fraction, R::ONE);
        let received = safe_fraction * (compression + mixing) + fraction.where_positive(exchange, R::ZERO);
        out[0] = received * at.per_mass / (safe_fraction * at.cp);
    }

    /// Towards the mean temperature: the rest loses what the core gains.
    fn decays<R: Real>(p: &[R], at: &Conditions<R>, out: &mut [R]) {
        let (fraction, conductance) = (p[0], p[1]);
        let safe_fraction = fraction.where_positive(fraction, R::ONE);
        out[0] =
            fraction.where_positive(conductance * at.per_mass / (safe_fraction * (R::ONE - fraction) * at.cp), R::ZERO);
    }

    /// The core is compressed by the pressure rise of the heat at constant volume.
    fn heated<R: Real>(_: &[R], at: &Conditions<R>, _: R, heat: R, own: &mut [R]) {
        let rise = at.expansion * heat * at.per_volume;
        own[0] += at.gas_constant * own[0] / at.pressure * rise / at.cp;
    }
}
