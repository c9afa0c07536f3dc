//! Sensor drift: the pressure reading wanders by r t from the start of each record.
//!
//! r in Pa/s, added after lag and delay.

use super::Effect;
use crate::card::{ActsOn, Balance, Card, ClosedForm, Parameter, Scope, Unit};
use crate::real::Real;

/// Linear drift of the pressure reading.
pub struct SensorDrift;

impl Effect for SensorDrift {
    const CARD: Card = Card {
        name: "sensor_drift",
        doc: "The pressure reading drifts linearly from the start of each record",
        equation: "y = P + r t",
        source: "linear zero drift, e.g. Doebelin, Measurement Systems, chapter 3",
        balance: Balance::Sensor,
        acts_on: ActsOn::Reading,
        scope: Scope::Record,
        closed_form: ClosedForm::Filter,
        parameters: &[Parameter {
            name: "rate",
            unit: Unit::PascalPerSecond,
            bounds: -1e6..=1e6,
            typical: 50.0,
            doc: "Rate of the drift, counted from the start of the record",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn reading<R: Real>(p: &[R], _: &[R], reading: R, time: R) -> R {
        reading + p[0] * time
    }
}
