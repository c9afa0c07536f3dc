//! Decaying turbulence: the moving piston stirs the gas, and the turbulence outlasts the move.
//!
//! Factor 1 + k u with τ du/dt = |ẋ| − u, u(0) = 0.
//! u  m/s, the steady piston speed that would sustain the turbulence; k  s/m; τ  s.
//! [`forced_convection`](super::forced_convection) has no memory. Source: zero-dimensional turbulence of engine cylinders,
//! produced by the piston and decaying at its own rate, Borgnakke, Arpaci and Tabaczynski, A Model for the Instantaneous Heat
//! Transfer and Turbulence in a Spark Ignition Engine, SAE 800287 (1980); both linear here.

use super::Effect;
use crate::card::{Balance, Card, OwnState, Parameter, Plausible, Tried, Unit};
use crate::parts::{Conditions, Flows, Rates};
use crate::real::Real;

/// λ raised by decaying turbulence.
pub struct DecayingTurbulence;

impl Effect for DecayingTurbulence {
    const CARD: Card = Card {
        name: "decaying_turbulence",
        doc: "The piston stirs the gas: the heat transfer coefficient is larger during a move and, less and less, after it",
        equation: "lambda ~ 1 + k u, tau du/dt = |dx/dt| - u, u(0) = 0",
        source: "zero-dimensional turbulence of engine cylinders, Borgnakke, Arpaci and Tabaczynski, SAE 800287 (1980), made linear",
        balance: Balance::Energy,
        tried: Tried::BesideOthers,
        parameters: &[
            Parameter {
                name: "coefficient",
                unit: Unit::SecondPerMetre,
                bounds: 0.0..=1e3,
                plausible: Plausible::Between(0.0, 50.0),
                typical: 2.0,
                doc: "Coefficient k of the turbulence's share in the heat transfer coefficient",
                ..Parameter::DEFAULT
            },
            Parameter {
                name: "decay_time",
                unit: Unit::Second,
                bounds: 0.01..=100.0,
                neutral: 0.3,
                typical: 0.5,
                doc: "Time constant tau with which the turbulence decays; of no influence while the coefficient is zero",
                ..Parameter::DEFAULT
            },
        ],
        states: &[OwnState {
            name: "turbulence_speed",
            unit: Unit::MetrePerSecond,
            nominal: 0.5,
            doc: "Steady piston speed u that would keep the turbulence up",
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn conditions<R: Real>(p: &[R], own: &[R], at: &mut Conditions<R>) {
        at.eichelberg = at.eichelberg * (p[0] * own[0] + 1.0);
    }

    const KINK_INDICATORS: usize = 1;

    /// |ẋ| at zero, in m/s.
    fn kink_indicators<R: Real>(_: &[R], _: &[R], at: &Conditions<R>, _: &Rates<R>, out: &mut [R]) {
        out[0] = at.velocity;
    }

    #[inline(always)]
    fn own_rates<R: Real>(p: &[R], own: &[R], at: &Conditions<R>, _: &Flows<R>, _: &Rates<R>, out: &mut [R]) {
        out[0] = (at.velocity.abs() - own[0]) / p[1];
    }

    fn decays<R: Real>(p: &[R], _: &Conditions<R>, out: &mut [R]) {
        out[0] = p[1].recip();
    }
}

#[cfg(test)]
mod tests {
    use super::DecayingTurbulence;
    use crate::papers_chamber::section_31;
    use crate::signals::Signals;
    use crate::simulate::{Start, simulate};
    use crate::{AreaLaw, Chamber};

    const AMBIENT_K: f64 = 293.0;

    /// Pressures, Pa, and temperatures, K, at these times, s, along a piecewise linear motion through (s, m).
    fn along(chamber: &Chamber, start: Start, motion: &[(f64, f64)], times: &[f64]) -> Vec<[f64; 2]> {
        let signals = Signals::closed(motion, AMBIENT_K, 1.013e5);
        let samples = simulate(chamber, chamber.active(), start, &signals, times, 1e-11).unwrap();
        samples.iter().map(|sample| [sample.gas_pressure, sample.temperature]).collect()
    }

    #[test]
    fn a_hold_is_that_of_calm_gas_by_a_clock_that_the_turbulence_sets_forward() {
        let (coefficient, decay_s, push_s, speed) = (3.0, 0.4, 0.1, 0.5);
        let calm = section_31(AreaLaw::Total);
        let stirred = calm.with(DecayingTurbulence::INDEX, &[coefficient, decay_s]);
        assert_eq!(stirred.active(), DecayingTurbulence::SET);
        let end_m = 0.1 - speed * push_s;
        let held_s = [0.0, 0.05, 0.3, 1.0, 3.0];
        let start = Start { pressure: 2e5, temperature: AMBIENT_K };
        let times = held_s.map(|t| push_s + t);
        let found = along(&stirred, start, &[(0.0, 0.1), (push_s, end_m), (5.0, end_m)], &times);
        // dT/dt = (1 + k u) f(T), with u(t) = u(end of push) exp(-t/tau).
        let at_end = speed * -(-push_s / decay_s).exp_m1();
        let clock = held_s.map(|t| t - coefficient * at_end * decay_s * (-t / decay_s).exp_m1());
        let [pressure, temperature] = found[0];
        let expected = along(&calm, Start { pressure, temperature }, &[(0.0, end_m), (9.0, end_m)], &clock);
        assert!(clock[4] - held_s[4] > 0.1);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found[0] / expected[0] - 1.0).abs() < 1e-9, "{found:?} {expected:?}");
        }
    }
}
