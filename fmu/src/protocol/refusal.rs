//! Why a call was refused: one sentence for the host's log, and the FMI status that goes with it.
//!
//! `fmi2Discard` is for numbers that cannot be used: the instance stays as it was and can be used on. `fmi2Error` is
//! for a broken protocol (wrong order, NULL, unknown references); it too leaves the instance as it was.

use super::message::{Category, Status};
use crate::plant::fault::Fault;
use crate::table::units::behind;
use thiserror::Error;

/// Why a call was refused.
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
    Null {
        /// Name of the argument in the standard.
        argument: &'static str,
    },
    /// An array length that no host means.
    #[error("{argument} = {length} is too long: this FMU takes at most {limit} elements at once")]
    TooLong {
        /// Name of the argument in the standard.
        argument: &'static str,
        /// Number of elements that the host announced.
        length: usize,
        /// Most elements that one call may have.
        limit: usize,
    },
    /// Another number of states or indicators than there are.
    #[error("{argument} is {length}; expected {expected}")]
    WrongLength {
        /// Name of the argument in the standard.
        argument: &'static str,
        /// Number of elements that the host announced.
        length: usize,
        /// Number of elements that the function takes.
        expected: usize,
    },
    /// No variable has this reference.
    #[error("value reference {reference} belongs to no variable; the model description lists 0 to {last}")]
    UnknownReference {
        /// Value reference that the host gave.
        reference: u32,
        /// The largest value reference of a variable.
        last: u32,
    },
    /// A variable that a host can read and use in nothing else.
    #[error("{name} (value reference {reference}) can only be read, with {getter}")]
    OnlyRead {
        /// Name of the variable in the model description.
        name: &'static str,
        /// Its value reference.
        reference: u32,
        /// Function that reads it.
        getter: &'static str,
    },
    /// The variable is of another type.
    #[error("{name} (value reference {reference}) is of type {is}, not {asked}")]
    WrongType {
        /// Name of the variable in the model description.
        name: &'static str,
        /// Its value reference.
        reference: u32,
        /// Type that the variable has in FMI 2.0.
        is: &'static str,
        /// Type that the called function is for.
        asked: &'static str,
    },
    /// A variable that cannot be set now, or ever.
    #[error("{name} = {value} cannot be set: {why}; nothing was set")]
    NotSettable {
        /// Name of the variable in the model description.
        name: &'static str,
        /// Value that the host wanted to set, in the variable's unit.
        value: f64,
        /// The rule that forbids it, as a clause, with what to do instead.
        why: &'static str,
    },
    /// A variable whose value is not known yet.
    #[error("{name} has no value before initialization mode is entered")]
    NotYetKnown {
        /// Name of the variable in the model description.
        name: &'static str,
    },
    /// NaN or infinite.
    #[error("{name} = {value}{} is not a finite number; nothing was set", behind(unit))]
    NotFinite {
        /// Name of the variable in the model description.
        name: &'static str,
        /// Value that the host wanted to set, in the variable's unit.
        value: f64,
        /// SI unit of the value and its bounds.
        unit: &'static str,
    },
    /// Outside the variable's bounds.
    #[error("{name} = {value}{of} lies outside {min} to {max}{of}; nothing was set", of = behind(unit))]
    OutOfRange {
        /// Name of the variable in the model description.
        name: &'static str,
        /// Value that the host wanted to set, in the variable's unit.
        value: f64,
        /// SI unit of the value and its bounds.
        unit: &'static str,
        /// Smallest value that the variable takes.
        min: f64,
        /// Largest value that the variable takes.
        max: f64,
    },
    /// Derivatives of a variable that has none for the host.
    #[error("{name} is not an {wanted}: it has no derivatives to {action}")]
    NoDerivative {
        /// Name of the variable in the model description.
        name: &'static str,
        /// Kind of variable that the function is for: "input" or "output".
        wanted: &'static str,
        /// What the host wanted to do: "set" or "get".
        action: &'static str,
    },
    /// An order that is not supported.
    #[error("{name} has no derivative of order {order}: this FMU supports orders 1 to {highest}")]
    DerivativeOrder {
        /// Name of the variable in the model description.
        name: &'static str,
        /// Order of the derivative that the host asked for.
        order: i32,
        /// Highest order that this FMU has.
        highest: i32,
    },
    /// A directional derivative with a variable in the wrong place.
    #[error("{name} cannot be {place} of a directional derivative; {advice}")]
    NoDirection {
        /// Name of the variable in the model description.
        name: &'static str,
        /// Where the host put the variable: "an unknown" or "a known".
        place: &'static str,
        /// Which variables can stand there.
        advice: &'static str,
    },
    /// A number of the experiment or the step is of no use.
    #[error("{argument} = {value}: {expected}")]
    BadArgument {
        /// Name of the argument in the standard.
        argument: &'static str,
        /// Value that the host gave, in the argument's SI unit.
        value: f64,
        /// Values that can be used, as a clause.
        expected: &'static str,
    },
    /// The step does not begin where the last one ended.
    #[error(
        "the step begins at t = {asked} s, but the last one ended at t = {reached} s; restore a saved state to go back"
    )]
    WrongPoint {
        /// Begin of the step that the host gave, s.
        asked: f64,
        /// End of the last step, s.
        reached: f64,
    },
    /// Beyond the experiment's end.
    #[error("the step ends at t = {end} s, beyond the stop time {stop} s that the host announced")]
    BeyondStop {
        /// End of the step, s.
        end: f64,
        /// Stop time that the host announced, s.
        stop: f64,
    },
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
