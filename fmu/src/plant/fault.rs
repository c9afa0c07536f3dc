//! Why the plant cannot continue: inconsistent parameters, or no accurate step.

use chamber::integrate::IntegrationError;
use thiserror::Error;

/// Why there is no chamber or no step. SI units.
#[allow(missing_docs)]
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// Inconsistent parameters.
    #[error("rodDiameter = {rod} m leaves no piston area in bore = {bore} m; it must be less than the bore")]
    NoPistonArea { rod: f64, bore: f64 },
    /// No room for the gas.
    #[error(
        "position = {position} m leaves the gas a volume of {volume:.3e} m3; it must lie between 0 and 1e9 m3 (deadVolume = {dead_volume:.3e} m3)"
    )]
    NoVolume { position: f64, volume: f64, dead_volume: f64 },
    /// The step would empty the chamber.
    #[error(
        "a step of {step} s would empty the chamber: of {mass:.3e} kg of gas nothing is left after {after:.3e} s, when {outflow:.3e} kg/s leave (massFlowOut, ports and leaks, less what enters); take a shorter step or let less gas out"
    )]
    Emptied {
        step: f64,
        mass: f64,
        /// Time from the start of the step until it is empty, s.
        after: f64,
        outflow: f64,
    },
    /// No accurate step exists.
    #[error(
        "a step of {step} s from t = {time} s cannot be computed accurately ({cause}); the instance keeps the state of t = {time} s"
    )]
    NoStep {
        step: f64,
        time: f64,
        /// The reason, as a clause.
        cause: &'static str,
    },
    /// A jump of position that cannot be applied to the gas.
    #[error(
        "at t = {time} s the gas cannot be compressed or expanded to position ({cause}); the instance stays as it was"
    )]
    NoStroke {
        time: f64,
        /// The reason, as a clause.
        cause: &'static str,
    },
    /// States set by the host that are impossible for a gas.
    #[error(
        "mass = {mass} kg and internalEnergy = {energy} J make no gas: both must be positive and all states finite"
    )]
    NoGas { mass: f64, energy: f64 },
    /// A finite state with non-finite outputs, such as an enormous sensor reading.
    #[error("the outputs of this state are too large for a number; restore an earlier state or call fmi2Reset")]
    Overflow,
}

impl Fault {
    /// No step of `step` seconds from `time`, s.
    pub fn no_step(step: f64, time: f64, cause: IntegrationError) -> Self {
        Fault::NoStep { step, time, cause: clause(cause) }
    }

    /// No jump of the stroke is possible at `time`, s.
    pub fn no_stroke(time: f64, cause: IntegrationError) -> Self {
        Fault::NoStroke { time, cause: clause(cause) }
    }
}

/// Omits the integrator's times, which are relative to the start of a step or stroke: a host would take them for its own.
fn clause(cause: IntegrationError) -> &'static str {
    match cause {
        IntegrationError::StepTooSmall { .. } => "the state or an input jumps, or is not finite within it",
        IntegrationError::TooManySteps { .. } => "it takes too many integration steps",
    }
}
