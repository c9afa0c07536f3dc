//! Files in and out: measured traces, rigs and models, in SI units and with absolute pressure once they are read.
//!
//! | module | holds |
//! |---|---|
//! | [`trace`] | one record over time: [`Trace`] |
//! | [`rig`] | what was measured on: [`Rig`], its cylinder, gas and experiments |
//! | [`model`] | an identified chamber: [`Model`] |
//! | [`error`] | what can be wrong with a file, in sentences |
//!
//! Whatever cannot be right is refused with file, line and key or column; nothing is guessed silently.

pub mod atomic;
pub mod error;
pub mod model;
pub mod names;
pub mod rig;
pub mod trace;

pub use atomic::write_atomically;
pub use error::Error;
pub use model::{Model, Provenance, Rmse, SourceTrace};
pub use names::nearest;
pub use rig::{Ambient, Cylinder, DeadVolume, Experiment, NamedGas, Rig, Sensor};
pub use trace::Trace;
