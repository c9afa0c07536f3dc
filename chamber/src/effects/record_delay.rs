//! Record delay: the pressure record shows an earlier moment, y(t) = P(t − d), after the sensor's lag.
//!
//! d ≥ 0 in s: acquisition chains that stamp position and pressure at different moments.

use super::Effect;
use crate::card::{ActsOn, Balance, Card, ClosedForm, Parameter, Scope, Unit};
use crate::real::Real;

/// Pure delay of the pressure record.
pub struct RecordDelay;

impl Effect for RecordDelay {
    const CARD: Card = Card {
        name: "record_delay",
        doc: "The pressure record is later than the position record by a fixed time",
        equation: "y(t) = P(t - d)",
        source: "dead time of a sampled acquisition chain, e.g. Ljung, System Identification (1999)",
        balance: Balance::Sensor,
        acts_on: ActsOn::Reading,
        scope: Scope::Record,
        closed_form: ClosedForm::Filter,
        parameters: &[Parameter {
            name: "delay",
            unit: Unit::Second,
            bounds: 0.0..=10.0,
            typical: 0.01,
            doc: "Delay of the recorded pressure behind the gas's",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn delay<R: Real>(p: &[R]) -> R {
        p[0]
    }
}
