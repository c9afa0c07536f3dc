//! Why a call was refused: one sentence for the host's log, and the FMI status that goes with it.
//!
//! `fmi2Discard` is for numbers that cannot be used: the instance stays as it was and can be used on. `fmi2Error` is
//! for a broken protocol (wrong order, NULL, unknown references); it too leaves the instance as it was.

use thiserror::Error;

/// `fmi2Status`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// All well.
    Ok = 0,
    /// Done, but something is to be looked at.
    Warning = 1,
    /// Refused for its numbers; the instance is as before.
    Discard = 2,
    /// Refused as a breach of the protocol, or the instance is broken.
    Error = 3,
}

/// Log category of a message: its name is declared in the model description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// What happens inside an accepted call.
    Events,
    /// Warnings.
    Warning,
    /// Refused numbers.
    Discard,
    /// Refused calls.
    Error,
}

impl Category {
    /// Every category with what it holds, as the model description declares them.
    pub const ALL: [(Category, &'static str, &'static str); 4] = [
        (
            Category::Events,
            "logEvents",
            "Changes within an accepted call: a stroke taken up to the host's position, an effect switched on",
        ),
        (Category::Warning, "logStatusWarning", "Accepted calls that deserve a look"),
        (
            Category::Discard,
            "logStatusDiscard",
            "Refused values and steps, by name and value; the instance stays as it was",
        ),
        (
            Category::Error,
            "logStatusError",
            "Refused calls: wrong order, NULL, unknown references, damaged state bytes",
        ),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

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
    #[error("{argument} = {length} is more than the {limit} elements that this FMU takes at once")]
    TooLong {
        /// Its name in the standard.
        argument: &'static str,
        /// What the host said.
        length: usize,
        /// What is possible.
        limit: usize,
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
    #[error("{name} is no {wanted}: it has no derivatives to {action}")]
    NoDerivative {
        /// The variable.
        name: &'static str,
        /// "input" or "output".
        wanted: &'static str,
        /// "set" or "get".
        action: &'static str,
    },
    /// An order that is not supported.
    #[error("derivative of order {order} of {name}: this FMU takes orders 1 to {highest}")]
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
    #[error("the step ends at t = {end} s, beyond the stop time {stop} s that fmi2SetupExperiment announced")]
    BeyondStop {
        /// End of the step, s.
        end: f64,
        /// Announced stop, s.
        stop: f64,
    },
    /// Parameters that contradict each other.
    #[error("rodDiameter = {rod} m leaves no piston area in bore = {bore} m")]
    NoPistonArea {
        /// m.
        rod: f64,
        /// m.
        bore: f64,
    },
    /// No room for the gas.
    #[error(
        "position = {position} m leaves the gas a volume of {volume} m3; it must lie between 0 and 1e9 m3 (deadVolume = {dead_volume} m3)"
    )]
    NoVolume {
        /// m.
        position: f64,
        /// m³.
        volume: f64,
        /// m³.
        dead_volume: f64,
    },
    /// More gas leaves than there is.
    #[error(
        "a step of {step} s would empty the chamber: {mass} kg of gas, {outflow} kg/s leave; take a shorter step or a smaller massFlowOut"
    )]
    Emptied {
        /// s.
        step: f64,
        /// kg.
        mass: f64,
        /// Net, kg/s.
        outflow: f64,
    },
    /// No accurate step exists.
    #[error("no accurate step of {step} s from t = {time} s ({cause}); the instance keeps the state of t = {time} s")]
    NoStep {
        /// s.
        step: f64,
        /// s.
        time: f64,
        /// What the integrator says.
        cause: String,
    },
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
    #[error("this instance broke down in an earlier call; fmi2Reset makes it as new")]
    Broken,
}

impl Refusal {
    /// The status the call returns.
    pub fn status(&self) -> Status {
        use Refusal::*;
        match self {
            NotFinite { .. }
            | OutOfRange { .. }
            | BadArgument { .. }
            | NoVolume { .. }
            | Emptied { .. }
            | NoStep { .. } => Status::Discard,
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
