//! Natural convection: λ grows with the driving temperature difference, λ ∝ |T − Tw|^n.
//!
//! Factor (|T − Tw|/20 K)^n; n = ¼ for laminar flow along a wall, ⅓ for turbulent. Q̇ = λ Aq (Tw − T) is then a signed power of
//! Tw − T, finite at Tw = T. Source: Nu ∝ Ra^n, e.g. Incropera et al., chapter 9.

use super::Effect;
use crate::card::{Balance, Card, Parameter, Plausible};
use crate::parts::{Conditions, Rates};
use crate::real::Real;

/// The temperature difference to which λ0 refers, K.
pub const REFERENCE_DIFFERENCE_K: f64 = 20.0;
/// Keeps the logarithm finite at Tw = T, K: smaller differences count as this one.
pub const SMALLEST_DIFFERENCE_K: f64 = 1e-12;

/// λ as a power of the temperature difference.
pub struct NaturalConvection;

impl Effect for NaturalConvection {
    const CARD: Card = Card {
        name: "natural_convection",
        doc: "The heat transfer coefficient grows with the temperature difference between gas and wall",
        equation: "lambda ~ (|T - Tw|/20 K)^n",
        source: "Nu ~ Ra^n, Incropera et al., Fundamentals of Heat and Mass Transfer, chapter 9",
        balance: Balance::Energy,
        parameters: &[Parameter {
            name: "exponent",
            bounds: -0.5..=2.0,
            plausible: Plausible::Between(-0.25, 1.0),
            typical: 0.25,
            doc: "Exponent n of the temperature difference in the heat transfer coefficient; 1/4 by theory",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    const SINGULAR: bool = true;
    const KINK_INDICATORS: usize = 1;

    /// |T − Tw| at zero.
    fn kink_indicators<R: Real>(_: &[R], _: &[R], at: &Conditions<R>, _: &Rates<R>, out: &mut [R]) {
        out[0] = (at.gas_temperature_at_wall - at.wall_temperature) / at.wall_temperature;
    }

    #[inline(always)]
    fn heat_transfer_factor<R: Real>(p: &[R], at: &Conditions<R>) -> R {
        let difference = (at.gas_temperature_at_wall - at.wall_temperature).abs().max(R::from(SMALLEST_DIFFERENCE_K));
        (p[0] * (difference * (1.0 / REFERENCE_DIFFERENCE_K)).ln()).exp()
    }
}
