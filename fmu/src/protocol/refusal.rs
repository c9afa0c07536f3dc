//! Why a call was refused: one sentence for the host's log, and the corresponding FMI status.
//!
//! `fmi2Discard` is for unusable values: the instance is unchanged and remains usable. `fmi2Error` is for protocol violations
//! (wrong order, NULL, unknown references); it also leaves the instance unchanged.

use super::message::{Category, Status};
use crate::plant::fault::Fault;
use crate::table::units::unit_suffix;
use thiserror::Error;

/// Why a call was refused. Names are those of the model description, arguments those of the standard; values are in the
/// variable's unit, times in s.
#[allow(missing_docs)]
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Refusal {
    /// Not allowed in this phase of the life cycle.
    #[error("not allowed {phase}; {advice}")]
    OutOfOrder {
        /// Phase of the instance, such as "before initialization mode".
        phase: &'static str,
        /// The call to make first, or the remedy.
        advice: &'static str,
    },
    /// A pointer is NULL but must not be.
    #[error("{argument} is NULL")]
    Null { argument: &'static str },
    /// An implausible array length.
    #[error("{argument} = {length} is too long: this FMU takes at most {limit} elements at once")]
    TooLong { argument: &'static str, length: usize, limit: usize },
    /// A wrong number of states or indicators.
    #[error("{argument} is {length}; expected {expected}")]
    WrongLength { argument: &'static str, length: usize, expected: usize },
    /// No variable has this reference.
    #[error("value reference {reference} belongs to no variable; the model description lists 0 to {last}")]
    UnknownReference { reference: u32, last: u32 },
    /// A variable that can only be read.
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
        /// The violated rule, as a clause, with the alternative.
        why: &'static str,
    },
    /// A variable whose value is not known yet.
    #[error("{name} has no value before initialization mode is entered")]
    NotYetKnown { name: &'static str },
    /// NaN or infinite.
    #[error("{name} = {value}{} is not a finite number; nothing was set", unit_suffix(unit))]
    NotFinite { name: &'static str, value: f64, unit: &'static str },
    /// Outside the variable's bounds.
    #[error("{name} = {value}{of} lies outside {min} to {max}{of}; nothing was set", of = unit_suffix(unit))]
    OutOfRange { name: &'static str, value: f64, unit: &'static str, min: f64, max: f64 },
    /// A variable without derivatives for the host.
    #[error("{name} is not an {wanted}: it has no derivatives to {action}")]
    NoDerivative {
        name: &'static str,
        /// Kind of variable required by the function: "input" or "output".
        wanted: &'static str,
        /// The attempted action: "set" or "get".
        action: &'static str,
    },
    /// An order that is not supported.
    #[error("{name} has no derivative of order {order}: this FMU supports orders 1 to {highest}")]
    DerivativeOrder { name: &'static str, order: i32, highest: i32 },
    /// A directional derivative with a variable in the wrong role.
    #[error("{name} cannot be {role} of a directional derivative; {advice}")]
    NoDirection {
        name: &'static str,
        /// Role given to the variable by the host: "an unknown" or "a known".
        role: &'static str,
        advice: &'static str,
    },
    /// An invalid number of the experiment or step.
    #[error("{argument} = {value}: {expected}")]
    BadArgument {
        argument: &'static str,
        value: f64,
        /// Valid values, as a clause.
        expected: &'static str,
    },
    /// The step does not start where the last one ended.
    #[error(
        "the step begins at t = {asked} s, but the last one ended at t = {reached} s; restore a saved state to go back"
    )]
    WrongPoint { asked: f64, reached: f64 },
    /// Beyond the stop time.
    #[error("the step ends at t = {end} s, beyond the stop time {stop} s that the host announced")]
    BeyondStop { end: f64, stop: f64 },
    /// The plant cannot continue.
    #[error(transparent)]
    Plant(#[from] Fault),
    /// An invalid saved state.
    #[error("{why}")]
    BadState {
        /// The problem with the handle, as a sentence.
        why: &'static str,
    },
    /// Bytes that are not a state of this FMU.
    #[error("the serialized state cannot be used: {why}")]
    BadBytes {
        /// The problem with the bytes, as a clause.
        why: &'static str,
    },
    /// A feature that this FMU does not have.
    #[error("{what}")]
    NotOffered {
        /// What is missing, and the alternative, as a sentence.
        what: &'static str,
    },
    /// The instance panicked in an earlier call.
    #[error("this instance broke down in an earlier call; call fmi2Reset to use it again")]
    Broken,
}

impl Refusal {
    /// The status returned by the call.
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

    /// The log category.
    pub fn category(&self) -> Category {
        match self.status() {
            Status::Discard => Category::Discard,
            _ => Category::Error,
        }
    }
}
