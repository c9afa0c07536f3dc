//! Position delay: the position record lags the piston by a fixed time d and a first-order filter of time constant τ: x(t) =
//! x_rec(t + d) + τ dx_rec/dt(t + d).
//!
//! d, τ in s, τ ≥ 0: a digitally read displacement sensor, or one behind a low-pass. A digital low-pass whose output already
//! includes the current sample leads the filter of this equation by half of its step: d is then negative. With only position and
//! pressure recorded, only the difference between d and the delay of the pressure record is observable. For a stroke recorded in
//! rows, the slope at a row is the mean of those on both sides.

use super::Effect;
use crate::card::{ActsOn, Balance, Card, ClosedForm, Fitted, Normal, Parameter, Prior, Scope, Unit};
use crate::real::Real;

/// Delay and low-pass of the position record.
pub struct PositionDelay;

impl Effect for PositionDelay {
    const CARD: Card = Card {
        name: "position_delay",
        doc: "The position record is later than the piston, by a fixed time or by a filter",
        equation: "x(t) = x_rec(t + d) + tau dx_rec/dt(t + d)",
        source: "dead time of a sampled acquisition chain, e.g. Ljung, System Identification (1999)",
        balance: Balance::Volume,
        acts_on: ActsOn::RecordedStroke,
        scope: Scope::Record,
        closed_form: ClosedForm::Kept,
        parameters: &[
            Parameter {
                name: "delay",
                unit: Unit::Second,
                bounds: -1.0..=10.0,
                typical: 0.01,
                prior: Prior::Normal(Normal { mean: 0.0, standard_deviation: 0.2 }),
                doc: "Delay of the recorded position behind the piston's; of a digital low-pass less by half of its step",
                ..Parameter::DEFAULT
            },
            Parameter {
                name: "filter_time_constant",
                unit: Unit::Second,
                bounds: 0.0..=10.0,
                typical: 0.05,
                fitted: Fitted::Secondary,
                doc: "Time constant of a first-order low-pass that the recorded position has passed",
                ..Parameter::DEFAULT
            },
        ],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn stroke_delay<R: Real>(p: &[R]) -> R {
        p[0]
    }

    #[inline(always)]
    fn stroke_filter<R: Real>(p: &[R]) -> R {
        p[1]
    }
}
