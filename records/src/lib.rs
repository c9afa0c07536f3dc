//! Input and output files: measured traces, rigs and models, in SI units and with absolute pressures after reading.
//!
//! | module | holds |
//! |---|---|
//! | [`trace`] | one record over time: [`Trace`] |
//! | [`rig`] | the measured rig: [`Rig`], its cylinder, gas and experiments |
//! | [`measurement`] | accuracy of its quantities: sensor, accuracy, tolerances |
//! | [`model`] | an identified chamber: [`Model`] |
//! | [`uncertainty`], [`provenance`] | uncertainty and origin of its parameters |
//! | [`layout`], [`units`], [`mod@format`] | quantity and unit of each column of a trace, and the text format |
//! | [`look`] | the contents of a trace, found without a rig file |
//! | [`document`], [`table`], [`field`], [`key`] | TOML files, each error with file, line and key |
//! | [`error`] | errors in files, as sentences |
//!
//! Anything that cannot be right is refused with file, line and key or column; nothing is guessed silently.

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
pub use statistics::{
    DEVIATION_OF_MEDIAN, correlation, extremes, median, noise_of_second_differences, reversal_fraction,
    second_differences,
};
pub use table::Table;
pub use trace::{DroppedRow, LineNumbers, Need, Reading, Trace, Window, fields_of_line, near_column};
pub use uncertainty::Uncertainty;
