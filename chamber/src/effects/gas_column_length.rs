//! Gas column length: λ depends on the length of the gas column in front of the piston, λ ∝ (l/l_ref)^a.
//!
//! l = V/(piston area), m; a dimensionless, −½ if heat diffuses along the column. Source: hypothesis on the paper's six
//! measured points (design finding 4), where a = −½ cuts the error of τ from 26 % to 5 %; three actuators only.

use super::Effect;
use crate::card::{Balance, Card, ClosedForm, Fitted, Parameter, Plausible, Unit};
use crate::parts::Conditions;
use crate::real::Real;

/// λ as a power of the gas column's length.
pub struct GasColumnLength;

impl Effect for GasColumnLength {
    const CARD: Card = Card {
        name: "gas_column_length",
        doc: "The heat transfer coefficient depends on the length of the gas column in front of the piston",
        equation: "lambda ~ (l/l_ref)^a, l = V/(piston area)",
        source: "hypothesis on tables 1 to 5 of Carneiro and Gomes de Almeida (2006)",
        balance: Balance::Energy,
        closed_form: ClosedForm::Kept,
        parameters: &[
            Parameter {
                name: "exponent",
                bounds: -3.0..=3.0,
                plausible: Plausible::Between(-1.5, 0.25),
                typical: -0.5,
                doc: "Exponent a of the gas column's length in the heat transfer coefficient; -1/2 by theory",
                ..Parameter::DEFAULT
            },
            Parameter {
                name: "reference_length",
                unit: Unit::Metre,
                bounds: 1e-4..=100.0,
                neutral: 0.1,
                typical: 0.1,
                fitted: Fitted::Never,
                doc: "Length at which the coefficient is lambda0; of no influence while the exponent is zero",
                ..Parameter::DEFAULT
            },
        ],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn heat_transfer_factor<R: Real>(p: &[R], at: &Conditions<R>) -> R {
        (at.volume / (at.piston_area * p[1])).powf(p[0])
    }
}
