//! Position delay: the position record is later than the piston, x(t) = x_rec(t + d).
//!
//! d ≥ 0 in s: a filtered or digitally read displacement sensor. With nothing else recorded than position and pressure,
//! only its difference to the delay of the pressure record shows.

use super::Effect;
use crate::card::{ActsOn, Balance, Card, ClosedForm, Normal, Parameter, Prior, Scope, Unit};
use crate::real::Real;

/// Pure delay of the position record.
pub struct PositionDelay;

impl Effect for PositionDelay {
    const CARD: Card = Card {
        name: "position_delay",
        doc: "The position record is later than the piston by a fixed time",
        equation: "x(t) = x_rec(t + d)",
        source: "dead time of a sampled acquisition chain, e.g. Ljung, System Identification (1999)",
        balance: Balance::Volume,
        acts_on: ActsOn::RecordedStroke,
        scope: Scope::Record,
        closed_form: ClosedForm::Kept,
        parameters: &[Parameter {
            name: "delay",
            unit: Unit::Second,
            bounds: 0.0..=10.0,
            typical: 0.01,
            prior: Prior::Normal(Normal { mean: 0.0, standard_deviation: 0.2 }),
            doc: "Delay of the recorded position behind the piston's",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn stroke_delay<R: Real>(p: &[R]) -> R {
        p[0]
    }
}
