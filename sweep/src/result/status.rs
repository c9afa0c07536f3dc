//! How a row ended: with its results, or why without them.

use thiserror::Error;

/// Why a row has no results. Few and without numbers, so that the status column is a small dictionary.
#[allow(missing_docs)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum Failure {
    #[error("the rod leaves no piston area")]
    RodFillsBore,
    #[error("without heat transfer there is no time constant to hold for")]
    NoTimeConstant,
    #[error("no bore gives this volume-to-area ratio")]
    NoBore,
    #[error("no length gives this volume-to-area ratio at this bore")]
    NoLength,
    #[error(transparent)]
    Simulation(#[from] ensemble::Failure),
}

/// How a row ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// The row has all its results.
    Ok,
    /// Pressure had not settled to 1 % when the test ended.
    NotSettled,
    /// The relaxation is over 5 % of its rise, and more than a closed chamber's, from an exponential.
    NoTimeConstant,
    /// Not solved, since it breaks this one of the study's constraints.
    LeftOut(u8),
    /// No results, and why.
    Failed(Failure),
}
