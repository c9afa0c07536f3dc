//! Status of a row: with results, or the reason for their absence.

use thiserror::Error;

/// Why a row has no results. Few variants without numbers, so that the status column is a small dictionary.
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

/// Status of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// The row has all its results.
    Ok,
    /// Pressure had not settled to 1 % when the test ended.
    NotSettled,
    /// The relaxation deviates from an exponential by over 5 % of its rise, and by more than a closed chamber's.
    NoTimeConstant,
    /// Not solved, because it violates this constraint of the study.
    LeftOut(u8),
    /// No results, with the reason.
    Failed(Failure),
}
