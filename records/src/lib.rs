//! Files in and out: measured traces, rigs and models, in SI units and with absolute pressure once they are read.
//!
//! | module | holds |
//! |---|---|
//! | [`trace`] | one record over time: [`Trace`] |
//! | [`rig`] | what was measured on: [`Rig`], its cylinder, gas and experiments |
//! | [`measurement`] | how well its quantities are known: sensor, accuracy, tolerances |
//! | [`model`] | an identified chamber: [`Model`] |
//! | [`uncertainty`], [`provenance`] | how well its parameters are known, where they come from |
//! | [`layout`], [`units`], [`mod@format`] | which column of a trace is what, in which unit, and how its text is written |
//! | [`look`] | what a trace holds, found without a rig file |
//! | [`document`], [`table`], [`field`], [`key`] | TOML files, each complaint with file, line and key |
//! | [`error`] | what can be wrong with a file, in sentences |
//!
//! Whatever cannot be right is refused with file, line and key or column; nothing is guessed silently.

mod ambient;
pub mod atomic;
pub mod document;
mod effect;
pub mod error;
pub mod field;
mod fill;
pub mod format;
pub mod gas;
pub mod key;
pub mod layout;
pub mod limits;
mod line;
pub mod look;
pub mod measurement;
pub mod model;
pub mod names;
mod opened;
pub mod provenance;
pub mod rig;
mod shut;
mod statistics;
pub mod table;
mod toml_text;
pub mod trace;
pub mod uncertainty;
mod unfinished;
pub mod units;
mod value;

pub use atomic::{check_writable, write_atomically};
pub use document::Document;
pub use error::Error;
pub use field::Field;
pub use fill::fill_between;
pub use gas::NamedGas;
pub use layout::Layout;
pub use line::Line;
pub use measurement::{Sensor, Tolerance};
pub use model::Model;
pub use names::{nearest, repeated};
pub use opened::opened_from;
pub use provenance::{LAST_SECOND, OfEachRecord, Provenance, Rmse, SourceTrace, Verdict, as_utc, utc};
pub use rig::{Ambient, Cylinder, DeadVolume, Experiment, Rig, RigFile};
pub use shut::shut_from;
pub use statistics::{DEVIATION_OF_MEDIAN, bends, correlation, extremes, median, noise_of_bends, turned_back};
pub use table::Table;
pub use trace::{LeftOut, LineNumbers, Need, Reading, Trace, Window, fields_of_line, near_column};
pub use uncertainty::Uncertainty;
