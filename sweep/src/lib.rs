//! Parameter studies of the push-and-hold test: designs, batches of simulations, partitioned Parquet.
//!
//! ```no_run
//! let study = sweep::Study::read("study.toml".as_ref())?;
//! sweep::run_to_file(&study, "study.parquet".as_ref(), &|_rows| {})?;
//! # Ok::<(), sweep::Error>(())
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`error`], `hash`, [`progress`] | errors, as sentences; SHA-256; progress of a run |
//! | [`file_names`], [`store`] | file names in a study's folder; the folder on a disk or elsewhere |
//! | [`quantity`] | every number that can be varied, and the values it takes |
//! | [`result`] | results of a row, and the columns they become |
//! | [`design`] | the points of a study |
//! | [`study`] | [`Study`]: model, test, design, constraints |
//! | [`row`] | from a point to a scenario, through the kernel of `ensemble`, to its results |
//! | [`study_file`] | study files, read and checked |
//! | [`part`] | rows as a Parquet file |
//! | [`statistics`] | statistics of the results, with the rows or without |
//! | `sensitivity` | first-, second- and total-order indices of a Saltelli study |
//! | [`folder`] | a study's folder and its manifest; rows of an earlier study |
//! | [`run`](mod@run) | executing a study |
//! | [`traces`] | time courses of some rows, as a second table |
//! | [`estimate`] | time and bytes of a study, from a short calibration |
//!
//! Each module uses only those above it.
//!
//! A row is a pure function of the study and its number, independent of shards, threads and interruptions.

pub mod design;
pub mod error;
pub mod estimate;
pub mod file_names;
pub mod folder;
mod hash;
pub mod part;
pub mod progress;
pub mod quantity;
pub mod result;
pub mod row;
pub mod run;
mod sensitivity;
pub mod statistics;
pub mod store;
pub mod study;
pub mod study_file;
pub mod traces;

pub use error::Error;
pub use folder::earlier::Earlier;
pub use folder::verify::verify;
pub use run::shard::Shard;
pub use run::whole::{run_in_memory, run_to_file};
pub use run::{Options, Report, run};
pub use store::{Local, Store};
pub use study::Study;
