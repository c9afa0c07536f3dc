//! Pressure and temperature exponents: λ ∝ (P/P0)^nP (T/T0)^nT instead of equation (5)'s square roots.
//!
//! Factor (P/P0)^(nP − ½) (T/T0)^(nT − ½) on Eichelberg's √(P T/(P0 T0)); nP, nT dimensionless, ½ in the paper. Source: exponents
//! between 0.25 and 0.8 are in use, see Annand (1963) and Woschni (1967) for engine cylinders.

use super::Effect;
use crate::card::{Balance, Card, Fitted, Parameter, Plausible};
use crate::parts::Conditions;
use crate::real::Real;

/// Free exponents of pressure and temperature in λ.
pub struct PressureExponent;

impl Effect for PressureExponent {
    const CARD: Card = Card {
        name: "pressure_exponent",
        doc: "The heat transfer coefficient follows other powers of pressure and temperature than the square root",
        equation: "lambda ~ (P/P0)^nP (T/T0)^nT",
        source: "generalises Eichelberg (1939); exponents of Annand (1963), Woschni (1967)",
        balance: Balance::Energy,
        parameters: &[
            Parameter {
                name: "pressure_exponent",
                bounds: -2.0..=3.0,
                plausible: Plausible::Between(-0.5, 1.5),
                neutral: 0.5,
                typical: 0.4,
                doc: "Exponent nP of pressure in the heat transfer coefficient; 0.5 by Eichelberg",
                ..Parameter::DEFAULT
            },
            Parameter {
                name: "temperature_exponent",
                bounds: -5.0..=5.0,
                neutral: 0.5,
                typical: 0.5,
                fitted: Fitted::Secondary,
                doc: "Exponent nT of temperature in the heat transfer coefficient; 0.5 by Eichelberg",
                ..Parameter::DEFAULT
            },
        ],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn heat_transfer_factor<R: Real>(p: &[R], at: &Conditions<R>) -> R {
        let by_pressure = (p[0] - 0.5) * (at.pressure / at.reference_pressure).ln();
        let by_temperature = (p[1] - 0.5) * (at.gas_temperature_at_wall / at.reference_temperature).ln();
        (by_pressure + by_temperature).exp()
    }
}
