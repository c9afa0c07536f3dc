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
//! | [`study`] | study files, read and checked: [`Study`] |
//! | [`quantity`] | every number that can be varied, and the values it takes |
//! | [`design`] | which points a study has |
//! | [`row`] | from a point to a scenario, through the kernel of `ensemble`, to what comes out of it |
//! | [`part`] | rows as a Parquet file |
//! | [`folder`] | a study's folder and its manifest |
//! | [`run`](mod@run), [`progress`] | a study carried out, and how far it is |
//! | [`traces`] | the courses of some rows, as a second table |
//! | [`statistics`] | what the results come to, with the rows or without |
//! | `sensitivity` | first-, second- and total-order indices of a Saltelli study |
//! | [`estimate`] | time and bytes of a study, from a short calibration |
//! | [`error`], `hash` | what can be wrong, in sentences; SHA-256 |
//!
//! A row is a pure function of the study and its number. Shards, threads and interruptions make no difference to it.

pub mod design;
pub mod error;
pub mod estimate;
pub mod folder;
mod hash;
pub mod part;
pub mod progress;
pub mod quantity;
pub mod row;
pub mod run;
mod sensitivity;
pub mod statistics;
pub mod study;
pub mod traces;

pub use error::Error;
pub use folder::earlier::Earlier;
pub use folder::store::{Local, Store};
pub use folder::verify::verify;
pub use run::shard::Shard;
pub use run::whole::{run_in_memory, run_to_file};
pub use run::{Options, Report, run};
pub use study::Study;
