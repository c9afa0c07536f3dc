//! Sensor lag: the pressure sensor follows the gas's pressure with a first-order delay.
//!
//! τs dy/dt = P − y, y(0) = P(0); τs in s, y and P in Pa. τs = 0 means off: y = P. Source: first-order instrument.

use super::Effect;
use crate::balance::{Conditions, Flows, Rates};
use crate::card::{Balance, Card, OwnState, Parameter, Unit};
use crate::real::Real;

/// First-order pressure sensor.
pub struct SensorLag;

impl Effect for SensorLag {
    const CARD: Card = Card {
        name: "sensor_lag",
        doc: "The pressure sensor follows the gas with a first-order lag",
        equation: "tau_s dy/dt = P - y",
        source: "first-order instrument, e.g. Doebelin, Measurement Systems, chapter 3",
        balance: Balance::Sensor,
        parameters: &[Parameter {
            name: "time_constant",
            unit: Unit::Second,
            bounds: 0.0..=100.0,
            neutral: 0.0,
            typical: 0.01,
            fitted: true,
            doc: "Time constant of the pressure sensor; zero means an instantaneous sensor",
        }],
        states: &[OwnState { name: "lagged_pressure", unit: Unit::Pascal, nominal: 1e5, doc: "Pressure the lagging sensor shows" }],
    };

    #[inline(always)]
    fn initial<R: Real>(at: &Conditions<R>, own: &mut [R]) {
        own[0] = at.pressure;
    }

    #[inline(always)]
    fn own_rates<R: Real>(p: &[R], own: &[R], at: &Conditions<R>, _: &Flows<R>, rates: &Rates<R>, out: &mut [R]) {
        let safe_constant = p[0].where_positive(p[0], R::ONE);
        out[0] = p[0].where_positive((at.pressure - own[0]) / safe_constant, rates.pressure);
    }

    #[inline(always)]
    fn reading<R: Real>(p: &[R], own: &[R], reading: R, _: R) -> R {
        p[0].where_positive(own[0], reading)
    }
}
