//! Why a call was refused: one sentence for the host's log, and the FMI status that goes with it.
//!
//! `fmi2Discard` is for numbers that cannot be used: the instance stays as it was and can be used on. `fmi2Error` is
//! for a broken protocol (wrong order, NULL, unknown references); it too leaves the instance as it was.

use super::message::{Category, Status};
use crate::plant::fault::Fault;
use thiserror::Error;

/// Why a call was refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Refusal {
    /// Not in this phase of the life cycle.
    #[error("not allowed {phase}; {advice}")]
    OutOfOrder {
        /// "before initialization" and the like.
        phase: &'static str,
        /// What to do instead.
        advice: &'static str,
    },
    /// A pointer is NULL that must not be.
    #[error("{argument} is NULL")]
    Null {
        /// Its name in the standard.
        argument: &'static str,
    },
    /// An array length that no host means.
    #[error("{argument} = {length} is too long: this FMU takes at most {limit} elements at once")]
    TooLong {
        /// Its name in the standard.
        argument: &'static str,
        /// What the host said.
        length: usize,
        /// What is possible.
        limit: usize,
    },
    /// Another number of states or indicators than there are.
    #[error("{argument} = {length} does not match: this FMU has {expected}")]
    WrongLength {
        /// Its name in the standard.
        argument: &'static str,
        /// What the host said.
        length: usize,
        /// What there are.
        expected: usize,
    },
    /// No variable has this reference.
    #[error("value reference {reference} belongs to no variable; the model description lists 0 to {last}")]
    UnknownReference {
        /// What the host said.
        reference: u32,
        /// The largest there is.
        last: u32,
    },
    /// The variable is of another type.
    #[error("{name} (value reference {reference}) is of type {is}, not {asked}")]
    WrongType {
        /// The variable.
        name: &'static str,
        /// Its reference.
        reference: u32,
        /// Its type.
        is: &'static str,
        /// The function's type.
        asked: &'static str,
    },
    /// A variable that cannot be set now, or ever.
    #[error("{name} = {value} cannot be set: {why}; nothing was set")]
    NotSettable {
        /// The variable.
        name: &'static str,
        /// What the host wanted.
        value: f64,
        /// Why not.
        why: &'static str,
    },
    /// A variable whose value is not known yet.
    #[error("{name} has no value before initialization mode is entered")]
    NotYetKnown {
        /// The variable.
        name: &'static str,
    },
    /// NaN or infinite.
    #[error("{name} = {value} {unit} is not a finite number; nothing was set")]
    NotFinite {
        /// The variable.
        name: &'static str,
        /// What the host wanted.
        value: f64,
        /// Unit of the variable.
        unit: &'static str,
    },
    /// Outside the variable's bounds.
    #[error("{name} = {value} {unit} lies outside {min} to {max} {unit}; nothing was set")]
    OutOfRange {
        /// The variable.
        name: &'static str,
        /// What the host wanted.
        value: f64,
        /// Unit of the variable.
        unit: &'static str,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
    /// Derivatives of a variable that has none for the host.
    #[error("{name} is not an {wanted}: it has no derivatives to {action}")]
    NoDerivative {
        /// The variable.
        name: &'static str,
        /// "input" or "output".
        wanted: &'static str,
        /// "set" or "get".
        action: &'static str,
    },
    /// An order that is not supported.
    #[error("{name} has no derivative of order {order}: this FMU supports orders 1 to {highest}")]
    DerivativeOrder {
        /// The variable.
        name: &'static str,
        /// What the host said.
        order: i32,
        /// The highest order.
        highest: i32,
    },
    /// A directional derivative with a variable in the wrong place.
    #[error("{name} cannot be {place} of a directional derivative; {advice}")]
    NoDirection {
        /// The variable.
        name: &'static str,
        /// "an unknown" or "a known".
        place: &'static str,
        /// What can.
        advice: &'static str,
    },
    /// A number of the experiment or the step is of no use.
    #[error("{argument} = {value}: {expected}")]
    BadArgument {
        /// Its name in the standard.
        argument: &'static str,
        /// What the host said.
        value: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// The step does not begin where the last one ended.
    #[error(
        "the step begins at t = {asked} s, but the last one ended at t = {reached} s; restore a saved state to go back"
    )]
    WrongPoint {
        /// What the host said, s.
        asked: f64,
        /// Where the instance is, s.
        reached: f64,
    },
    /// Beyond the experiment's end.
    #[error("the step ends at t = {end} s, beyond the stop time {stop} s that the host announced")]
    BeyondStop {
        /// End of the step, s.
        end: f64,
        /// Announced stop, s.
        stop: f64,
    },
    /// The plant cannot go on.
    #[error(transparent)]
    Plant(#[from] Fault),
    /// Saved state that is none.
    #[error("{why}")]
    BadState {
        /// In a sentence.
        why: &'static str,
    },
    /// Bytes that are no state of this FMU.
    #[error("the serialized state cannot be used: {why}")]
    BadBytes {
        /// In a clause.
        why: &'static str,
    },
    /// What is asked for does not exist in this FMU.
    #[error("{what}")]
    NotOffered {
        /// In a sentence.
        what: &'static str,
    },
    /// The instance broke down before.
    #[error("this instance broke down in an earlier call; call fmi2Reset to use it again")]
    Broken,
}

impl Refusal {
    /// The status the call returns.
    pub fn status(&self) -> Status {
        use Refusal::*;
        match self {
            NotFinite { .. } | OutOfRange { .. } | BadArgument { .. } => Status::Discard,
            Plant(Fault::NoPistonArea { .. }) => Status::Error,
            Plant(_) => Status::Discard,
            NotOffered { .. } => Status::Discard,
            _ => Status::Error,
        }
    }

    /// The category it is logged under.
    pub fn category(&self) -> Category {
        match self.status() {
            Status::Discard => Category::Discard,
            _ => Category::Error,
        }
    }
}
