//! Who moves the piston: the host, or, while that has set nothing at all, the default experiment.
//!
//! A first run in any tool shows something: as long as every variable is at its start value the piston is pushed to half its
//! position within a tenth of a second, and held. The first value that a host sets ends that: before the end of
//! initialization one that differs from the start value, afterwards any. Lengths in m, times in s.

/// Duration of the push, s: a tenth of a second, as in the paper's tests.
pub const PUSH_S: f64 = 0.1;
/// Duration of push and hold, s.
pub const EXPERIMENT_S: f64 = 2.0;
/// Where the push ends, as a share of the position at the start.
pub const PUSHED_TO: f64 = 0.5;

/// Who moves the piston.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Leader {
    /// The default experiment, in its push.
    Push = 0,
    /// The default experiment, in its hold.
    Hold = 1,
    /// The host: its position and velocity count.
    Host = 2,
}

impl Leader {
    /// All leaders, for saved states.
    pub const ALL: [Leader; 3] = [Leader::Push, Leader::Hold, Leader::Host];

    /// Position and speed that the default experiment gives a piston that began at `from`, `elapsed` seconds ago. The push has
    /// no end of its own: a host that integrates may look beyond the event, and a kink there would spoil its step.
    pub fn stroke(self, from: f64, elapsed: f64) -> Option<(f64, f64)> {
        let way = (PUSHED_TO - 1.0) * from;
        match self {
            Leader::Push => Some((from + way * (elapsed / PUSH_S), way / PUSH_S)),
            Leader::Hold => Some((from + way, 0.0)),
            Leader::Host => None,
        }
    }

    /// Time since the start at which this part of the experiment ends, where it does.
    pub fn until(self) -> Option<f64> {
        (self == Leader::Push).then_some(PUSH_S)
    }
}
