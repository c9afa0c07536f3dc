//! Sensor lag: the pressure sensor follows the gas's pressure with a first-order delay.
//!
//! τs dy/dt = P − y, y(0) = P(0); τs in s, y and P in Pa. τs = 0 means off: y = P. Source: first-order instrument.

use super::Effect;
use crate::card::{ActsOn, Balance, Card, ClosedForm, OwnState, Parameter, Unit};
use crate::parts::{Conditions, Flows, Rates};
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
        acts_on: ActsOn::Reading,
        closed_form: ClosedForm::Filter,
        parameters: &[Parameter {
            name: "time_constant",
            unit: Unit::Second,
            bounds: 0.0..=100.0,
            typical: 0.01,
            doc: "Time constant of the pressure sensor; zero means an instantaneous sensor",
            ..Parameter::DEFAULT
        }],
        states: &[OwnState {
            name: "lagged_pressure",
            unit: Unit::Pascal,
            nominal: 1e5,
            doc: "Pressure the lagging sensor shows",
        }],
        ..Card::DEFAULT
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
    fn lag<R: Real>(p: &[R]) -> R {
        p[0]
    }

    #[inline(always)]
    fn reading<R: Real>(p: &[R], own: &[R], reading: R, _: R) -> R {
        p[0].where_positive(own[0], reading)
    }
}

/// Reading of the lagging sensor a time `elapsed` after it showed `reading`, while the pressure is p0 + p1 t + p2 t² (Pa, Pa/s,
/// Pa/s²): the exact solution, for any τs > 0 however small, so that a fast sensor does not force small steps.
///
/// y = q(t) + (y0 − q(0)) e^(−t/τs) with q = p − τs p′ + τs² p″.
#[inline]
pub fn follow<R: Real>(time_constant: R, reading: R, pressure: [R; 3], elapsed: R) -> R {
    let [p0, p1, p2] = pressure;
    let curvature = p2 * 2.0;
    let at_begin = p0 - time_constant * (p1 - time_constant * curvature);
    let slope = p1 + curvature * elapsed;
    let at_end = p0 + elapsed * (p1 + p2 * elapsed) - time_constant * (slope - time_constant * curvature);
    at_end + (reading - at_begin) * (-elapsed / time_constant).max(R::from(-700.0)).exp()
}

#[cfg(test)]
mod tests {
    use super::follow;

    #[test]
    fn following_a_parabola_solves_the_sensor_equation() {
        let (tau, pressure) = (0.02, [1e5, 3e6, -2e7]);
        let y = |t: f64| follow(tau, 0.9e5, pressure, t);
        let p = |t: f64| pressure[0] + t * (pressure[1] + t * pressure[2]);
        assert!((y(0.0) - 0.9e5).abs() < 1e-9);
        for k in 1..20 {
            let (t, h) = (f64::from(k) * 0.005, 1e-6);
            let rate = (y(t + h) - y(t - h)) / (2.0 * h);
            assert!((tau * rate - (p(t) - y(t))).abs() < 1e-3, "{t}");
        }
        assert!((follow(1e-9, 0.9e5, pressure, 0.01) - p(0.01)).abs() < 0.01);
    }
}
