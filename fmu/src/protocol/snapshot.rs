//! A saved state.

use super::phases::Phase;
use crate::plant::simulation::Simulation;

/// What saved states hold: a simulation and its phase.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Where in its life cycle the instance was.
    pub phase: Phase,
    /// Time, states, inputs and parameters, with the history of a delayed record.
    pub simulation: Simulation,
}
