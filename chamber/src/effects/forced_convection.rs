//! Forced convection: the moving piston stirs the gas, λ grows with its speed.
//!
//! Factor 1 + k |ẋ|^0.8; k in (s/m)^0.8, ẋ in m/s. Source: Nu ∝ Re^0.8 of turbulent pipe flow (Dittus and Boelter,
//! 1930) with the piston speed as velocity, as Woschni (1967) for engine cylinders.

use super::Effect;
use crate::card::{Balance, Card, ClosedForm, Parameter, Plausible, Unit};
use crate::parts::{Conditions, Rates};
use crate::real::Real;

/// Exponent of the speed.
pub const EXPONENT: f64 = 0.8;
/// Keeps the logarithm finite at rest, m/s.
const SMALLEST_SPEED: f64 = 1e-30;

/// λ raised by the piston's speed.
pub struct ForcedConvection;

impl Effect for ForcedConvection {
    const CARD: Card = Card {
        name: "forced_convection",
        doc: "The heat transfer coefficient grows with the speed of the piston",
        equation: "lambda ~ 1 + k |dx/dt|^0.8",
        source: "Nu ~ Re^0.8, Dittus and Boelter (1930), Woschni (1967)",
        balance: Balance::Energy,
        closed_form: ClosedForm::Kept,
        parameters: &[Parameter {
            name: "coefficient",
            unit: Unit::SpeedPower,
            bounds: 0.0..=1e3,
            plausible: Plausible::Between(0.0, 50.0),
            typical: 1.0,
            doc: "Coefficient k of the speed's share in the heat transfer coefficient",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    const KINK_INDICATORS: usize = 1;

    /// |ẋ| at zero, in m/s.
    fn kink_indicators<R: Real>(_: &[R], _: &[R], at: &Conditions<R>, _: &Rates<R>, out: &mut [R]) {
        out[0] = at.velocity;
    }

    #[inline(always)]
    fn heat_transfer_factor<R: Real>(p: &[R], at: &Conditions<R>) -> R {
        let speed = at.velocity.abs().max(R::from(SMALLEST_SPEED));
        p[0] * (speed.ln() * EXPONENT).exp() + 1.0
    }
}
