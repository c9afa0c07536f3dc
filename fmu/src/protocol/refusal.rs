//! Why a call was refused: one sentence for the host's log, and the FMI status that goes with it.
//!
//! `fmi2Discard` is for numbers that cannot be used: the instance stays as it was and can be used on. `fmi2Error` is
//! for a broken protocol (wrong order, NULL, unknown references); it too leaves the instance as it was.

use super::message::{Category, Status};
use crate::plant::fault::Fault;
use crate::table::units::behind;
use thiserror::Error;

/// Why a call was refused. Names are the model description's, arguments the standard's; values are in the variable's unit, times
/// in s.
#[allow(missing_docs)]
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Refusal {
    /// Not in this phase of the life cycle.
    #[error("not allowed {phase}; {advice}")]
    OutOfOrder {
        /// Where in its life the instance is: "before initialization mode" and the like.
        phase: &'static str,
        /// Call that comes first, or that helps.
        advice: &'static str,
    },
    /// A pointer is NULL that must not be.
    #[error("{argument} is NULL")]
    Null { argument: &'static str },
    /// An array length that no host means.
    #[error("{argument} = {length} is too long: this FMU takes at most {limit} elements at once")]
    TooLong { argument: &'static str, length: usize, limit: usize },
    /// Another number of states or indicators than there are.
    #[error("{argument} is {length}; expected {expected}")]
    WrongLength { argument: &'static str, length: usize, expected: usize },
    /// No variable has this reference.
    #[error("value reference {reference} belongs to no variable; the model description lists 0 to {last}")]
    UnknownReference { reference: u32, last: u32 },
    /// A variable that a host can read and use in nothing else.
    #[error("{name} (value reference {reference}) can only be read, with {getter}")]
    OnlyRead { name: &'static str, reference: u32, getter: &'static str },
    /// The variable is of another type.
    #[error("{name} (value reference {reference}) is of type {is}, not {asked}")]
    WrongType { name: &'static str, reference: u32, is: &'static str, asked: &'static str },
    /// A variable that cannot be set now, or ever.
    #[error("{name} = {value} cannot be set: {why}; nothing was set")]
    NotSettable {
        name: &'static str,
        value: f64,
        /// The rule that forbids it, as a clause, with what to do instead.
        why: &'static str,
    },
    /// A variable whose value is not known yet.
    #[error("{name} has no value before initialization mode is entered")]
    NotYetKnown { name: &'static str },
    /// NaN or infinite.
    #[error("{name} = {value}{} is not a finite number; nothing was set", behind(unit))]
    NotFinite { name: &'static str, value: f64, unit: &'static str },
    /// Outside the variable's bounds.
    #[error("{name} = {value}{of} lies outside {min} to {max}{of}; nothing was set", of = behind(unit))]
    OutOfRange { name: &'static str, value: f64, unit: &'static str, min: f64, max: f64 },
    /// Derivatives of a variable that has none for the host.
    #[error("{name} is not an {wanted}: it has no derivatives to {action}")]
    NoDerivative {
        name: &'static str,
        /// Kind of variable that the function is for: "input" or "output".
        wanted: &'static str,
        /// What the host wanted to do: "set" or "get".
        action: &'static str,
    },
    /// An order that is not supported.
    #[error("{name} has no derivative of order {order}: this FMU supports orders 1 to {highest}")]
    DerivativeOrder { name: &'static str, order: i32, highest: i32 },
    /// A directional derivative with a variable in the wrong place.
    #[error("{name} cannot be {place} of a directional derivative; {advice}")]
    NoDirection {
        name: &'static str,
        /// Where the host put the variable: "an unknown" or "a known".
        place: &'static str,
        advice: &'static str,
    },
    /// A number of the experiment or the step is of no use.
    #[error("{argument} = {value}: {expected}")]
    BadArgument {
        argument: &'static str,
        value: f64,
        /// Values that can be used, as a clause.
        expected: &'static str,
    },
    /// The step does not begin where the last one ended.
    #[error(
        "the step begins at t = {asked} s, but the last one ended at t = {reached} s; restore a saved state to go back"
    )]
    WrongPoint { asked: f64, reached: f64 },
    /// Beyond the experiment's end.
    #[error("the step ends at t = {end} s, beyond the stop time {stop} s that the host announced")]
    BeyondStop { end: f64, stop: f64 },
    /// The plant cannot go on.
    #[error(transparent)]
    Plant(#[from] Fault),
    /// Saved state that is none.
    #[error("{why}")]
    BadState {
        /// What is wrong with the handle, as a sentence.
        why: &'static str,
    },
    /// Bytes that are no state of this FMU.
    #[error("the serialized state cannot be used: {why}")]
    BadBytes {
        /// What is wrong with the bytes, as a clause.
        why: &'static str,
    },
    /// What is asked for does not exist in this FMU.
    #[error("{what}")]
    NotOffered {
        /// What there is none of, and what to use instead, as a sentence.
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
