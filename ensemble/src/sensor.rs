//! The sensor of a test: a lag of the reading, a delay of the record, an offset and a drift.

use crate::lanes::Lanes;
use chamber::effects::{self, EffectSet, EffectValues, OWN_STATES};

/// A sensor, or one per lane; SI units. Lanes of sensors lag or do not, and are delayed or are not, all alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor<R = f64> {
    /// τ, s; zero for an instantaneous sensor.
    pub lag: R,
    /// Delay of the record behind the gas, s.
    pub delay: R,
    /// Error of the reading at the start of the record, Pa; for lanes of the closed form, at the end of the push.
    pub offset: R,
    /// Rate of the drift, Pa/s.
    pub drift: R,
}

impl Sensor {
    /// The sensor of a chamber with the effects of a set, without the curve of its reading.
    pub fn new(set: EffectSet, values: &EffectValues) -> Self {
        let set = set.intersection(effects::of_sensor());
        if set.is_empty() {
            return Self { lag: 0.0, delay: 0.0, offset: 0.0, drift: 0.0 };
        }
        let shown = |time| values.reading(set, &[0.0; OWN_STATES], 0.0, time);
        let offset = shown(0.0);
        Self { lag: values.lag(set), delay: values.delay(set), offset, drift: shown(1.0) - offset }
    }

    /// What the sensor shows for a (lagged) pressure, Pa, at a time of the record, s.
    pub fn shown(&self, reading: f64, time: f64) -> f64 {
        reading + self.offset + self.drift * time
    }

    /// Whether the record depends on earlier pressures.
    pub fn looks_back(&self) -> bool {
        self.lag > 0.0 || self.delay > 0.0
    }
}

impl Sensor<Lanes> {
    /// Whether the sensors lag.
    #[inline(always)]
    pub fn lags(&self) -> bool {
        self.lag[0] > 0.0
    }

    /// Whether the records are delayed.
    #[inline(always)]
    pub fn is_late(&self) -> bool {
        self.delay[0] > 0.0
    }

    /// Offset and drift, Pa, at a time since the end of the push, s.
    #[inline(always)]
    pub fn beside(&self, time: Lanes) -> Lanes {
        self.offset + self.drift * time
    }
}
