//! Position averaging: the position record is a centred moving average of the stroke over a time w.
//!
//! x_rec(t) = (1/w) ∫ x(t + s) ds, s from −w/2 to w/2; w ≥ 0 in s. The stroke is recovered by least squares
//! ([`unaveraged`](crate::unaveraged)). A filter's delay belongs to `position_delay`. The gas spring of design finding 5 has w
//! near 0.6 s.

use super::Effect;
use crate::card::{ActsOn, Balance, Card, ClosedForm, Normal, Parameter, Prior, Scope, Unit};
use crate::real::Real;

/// Centred moving average of the position record.
pub struct PositionAveraging;

impl Effect for PositionAveraging {
    const CARD: Card = Card {
        name: "position_averaging",
        doc: "The position record is a moving average of the stroke",
        equation: "x_rec(t) = (1/w) integral of x from t - w/2 to t + w/2",
        source: "definition of a centred moving average; Tikhonov (1963) for its inverse",
        balance: Balance::Volume,
        acts_on: ActsOn::RecordedStroke,
        scope: Scope::Record,
        closed_form: ClosedForm::Kept,
        parameters: &[Parameter {
            name: "window",
            unit: Unit::Second,
            bounds: 0.0..=10.0,
            typical: 0.05,
            prior: Prior::Normal(Normal { mean: 0.0, standard_deviation: 0.3 }),
            doc: "Time w over which the recorded position is averaged; zero means the position itself",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn stroke_window<R: Real>(p: &[R]) -> R {
        p[0]
    }
}
