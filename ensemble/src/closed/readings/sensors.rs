//! Sensors of tests, one a lane.

use crate::lanes::Lanes;

/// The sensors of as many tests as there are lanes: lags and delays, s, offsets at the end of the push, Pa, drifts, Pa/s.
/// All of them lag or none, and all of them are delayed or none.
#[derive(Clone, Copy, Debug)]
pub struct Sensors {
    pub lag: Lanes,
    pub delay: Lanes,
    pub offset: Lanes,
    pub drift: Lanes,
}

impl Sensors {
    /// Whether they lag.
    #[inline(always)]
    pub fn lag(&self) -> bool {
        self.lag[0] > 0.0
    }

    /// Whether they are delayed.
    #[inline(always)]
    pub fn are_late(&self) -> bool {
        self.delay[0] > 0.0
    }

    /// What they show beside the gas, Pa, at a time since the end of the push, s.
    #[inline(always)]
    pub fn beside(&self, time: Lanes) -> Lanes {
        self.offset + self.drift * time
    }
}
