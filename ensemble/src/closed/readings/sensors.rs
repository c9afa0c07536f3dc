//! Sensors of tests, one per lane.

use crate::lanes::Lanes;

/// Sensors, one per lane: lags and delays, s, offsets at the end of the push, Pa, drifts, Pa/s. All of them lag or none, and all of
/// them are delayed or none.
#[derive(Clone, Copy, Debug)]
pub struct Sensors {
    pub lag: Lanes,
    pub delay: Lanes,
    pub offset: Lanes,
    pub drift: Lanes,
}

impl Sensors {
    /// Whether the sensors lag.
    #[inline(always)]
    pub fn lag(&self) -> bool {
        self.lag[0] > 0.0
    }

    /// Whether the records are delayed.
    #[inline(always)]
    pub fn are_late(&self) -> bool {
        self.delay[0] > 0.0
    }

    /// Offset and drift, Pa, at a time since the end of the push, s.
    #[inline(always)]
    pub fn beside(&self, time: Lanes) -> Lanes {
        self.offset + self.drift * time
    }
}
