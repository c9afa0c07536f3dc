//! A saved state.

use super::phases::Phase;
use crate::plant::simulation::Simulation;

/// Contents of a saved state: a simulation and its phase.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Phase of the instance's life cycle.
    pub phase: Phase,
    /// Time, states, inputs and parameters, with the history of a delayed record.
    pub simulation: Simulation,
}
