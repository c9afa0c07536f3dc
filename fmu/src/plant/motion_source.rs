//! What moves the piston: the host or, until it sets a value, the default experiment.
//!
//! A first run in any tool thus shows something: while every variable has its start value, the piston is pushed to half its
//! position within a tenth of a second, and held. The first value set by a host ends that: before the end of initialization one
//! that differs from the start value, afterwards any. Lengths in m, times in s.

/// Duration of the push, s: a tenth of a second, as in the paper's tests.
pub const PUSH_S: f64 = 0.1;
/// Duration of push and hold, s.
pub const EXPERIMENT_S: f64 = 2.0;
/// Position at the end of the push, as a fraction of the initial one.
pub const PUSHED_TO: f64 = 0.5;

/// What moves the piston.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum MotionSource {
    /// The default experiment, during its push.
    Push = 0,
    /// The default experiment, during its hold.
    Hold = 1,
    /// The host, through its position and velocity.
    Host = 2,
}

impl MotionSource {
    /// All sources, for saved states.
    pub const ALL: [MotionSource; 3] = [MotionSource::Push, MotionSource::Hold, MotionSource::Host];

    /// Position and speed of the piston in the default experiment, `elapsed` seconds after starting at `from`. The push formula
    /// has no end: a host that integrates may evaluate beyond the event, and a kink there would spoil its step.
    pub fn stroke(self, from: f64, elapsed: f64) -> Option<(f64, f64)> {
        let way = (PUSHED_TO - 1.0) * from;
        match self {
            MotionSource::Push => Some((from + way * (elapsed / PUSH_S), way / PUSH_S)),
            MotionSource::Hold => Some((from + way, 0.0)),
            MotionSource::Host => None,
        }
    }

    /// Time since the start at which this part of the experiment ends, s, if it does.
    pub fn until(self) -> Option<f64> {
        (self == MotionSource::Push).then_some(PUSH_S)
    }
}
