//! Tube volume: gas in a tube or fitting joined to the chamber stays at ambient temperature.
//!
//! ṁ = Vt/(R Tamb) dP/dt flows into the tube; it leaves the chamber at T and returns at Tamb, so
//! dP/dt = (dP/dt without tube) / (1 + γ (Vt/V) (Tx/Tamb)), Tx = T while pressure rises, Tamb while it falls.
//! Where the heat capacity depends on temperature, Tamb counts in this as (h(Tamb) − u(T))/cp + T/γ; where the volume V depends
//! on the pressure, V includes that dependence.
//! Vt  m³, not part of V, Aq, mass or dead volume. Source: isothermal volume, ISO 6358-2 annex (discharge tests).

use super::Effect;
use crate::card::{Balance, Card, Parameter, Unit};
use crate::parts::{Conditions, PressureTrend, Rates};
use crate::real::Real;

/// An isothermal volume joined to the chamber.
pub struct TubeVolume;

impl Effect for TubeVolume {
    const CARD: Card = Card {
        name: "tube_volume",
        doc: "A volume joined to the chamber whose gas stays at ambient temperature",
        equation: "mdot = Vt/(R Tamb) dP/dt, leaving at T, returning at Tamb",
        source: "isothermal volume, ISO 6358-2:2013",
        balance: Balance::Volume,
        parameters: &[Parameter {
            name: "volume",
            unit: Unit::CubicMetre,
            bounds: 0.0..=1.0,
            typical: 1e-6,
            doc: "Volume Vt of the tube and fittings whose gas is at ambient temperature",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    const KINK_INDICATORS: usize = 1;

    /// Direction of the flow into the tube: the relative rate of the pressure, 1/s.
    fn kink_indicators<R: Real>(_: &[R], _: &[R], at: &Conditions<R>, rates: &Rates<R>, out: &mut [R]) {
        out[0] = rates.pressure / at.pressure;
    }

    const STORES: bool = true;

    #[inline(always)]
    fn storage<R: Real>(p: &[R], at: &Conditions<R>, trend: &PressureTrend<R>) -> (R, R) {
        let volume = p[0];
        let temperature = trend.rate.where_positive(at.temperature, at.ambient_temperature);
        let as_warm = temperature + trend.rate.where_positive(R::ZERO, trend.excess);
        let ratio =
            trend.compliance_factor * at.heat_capacity_ratio * volume * as_warm / (at.volume * at.ambient_temperature);
        let flow = volume / (at.gas_constant * at.ambient_temperature) * trend.rate / (ratio + 1.0);
        (flow, temperature)
    }
}
