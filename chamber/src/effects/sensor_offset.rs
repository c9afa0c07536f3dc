//! Sensor offset: the pressure reading is off by a constant, like a gauge with a zero error.
//!
//! b in Pa, added after lag and delay; each record has its own.

use super::Effect;
use crate::card::{ActsOn, Balance, Card, ClosedForm, Normal, Parameter, Prior, Scope, Unit};
use crate::real::Real;

/// Constant error of the pressure reading.
pub struct SensorOffset;

impl Effect for SensorOffset {
    const CARD: Card = Card {
        name: "sensor_offset",
        doc: "The pressure reading is off by a constant",
        equation: "y = P + b",
        source: "zero error of an instrument, e.g. Doebelin, Measurement Systems, chapter 3",
        balance: Balance::Sensor,
        acts_on: ActsOn::Reading,
        scope: Scope::Record,
        closed_form: ClosedForm::Filter,
        parameters: &[Parameter {
            name: "offset",
            unit: Unit::PascalDifference,
            bounds: -1e6..=1e6,
            typical: 1e3,
            prior: Prior::Normal(Normal { mean: 0.0, standard_deviation: 5e3 }),
            doc: "Constant b by which the reading is above the pressure",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn reading<R: Real>(p: &[R], _: &[R], reading: R, _: R) -> R {
        reading + p[0]
    }
}
