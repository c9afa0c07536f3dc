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
//! | [`quantity`] | every number that can be varied |
//! | [`axis`], [`distribution`] | the values a quantity takes, or how probable they are |
//! | [`constraint`] | which points make sense |
//! | [`copula`], [`uncertain`] | quantities that hang together; a model's parameters as known |
//! | [`design`] | which points a study has |
//! | [`row`] | from a point to a scenario, and what comes out of it |
//! | [`solve`] | rows through the kernel of `ensemble` |
//! | [`columns`] | the table: names, units, encoding |
//! | [`part`], [`new_file`] | one Parquet file, whole or not there |
//! | [`pages`], [`sink`] | its pages' checksums; its hash, and the order of its statistics |
//! | [`earlier`] | rows that a smaller study has solved already |
//! | [`store`] | where that folder is: on a disk or elsewhere |
//! | [`folder`], [`verify`](mod@verify) | a study's folder and its manifest; whether it holds what that says |
//! | [`traces`] | the courses of some rows, as a second table |
//! | [`run`](mod@run) | a study carried out: a shard into a folder, all into a file or memory |
//! | [`statistics`] | what the results come to, with the rows or without |
//! | [`sensitivity`] | first-, second- and total-order indices of a Saltelli study |
//! | [`estimate`] | time and bytes of a study, from a short calibration |
//!
//! A row is a pure function of the study and its number. Shards, threads and interruptions make no difference to it.

pub mod axis;
pub mod columns;
pub mod constraint;
pub mod copula;
pub mod design;
pub mod distribution;
pub mod earlier;
pub mod error;
pub mod estimate;
pub mod folder;
pub mod hash;
pub mod new_file;
pub mod pages;
pub mod part;
pub mod quantity;
pub mod row;
pub mod run;
pub mod sensitivity;
pub mod sink;
pub mod solve;
pub mod statistics;
pub mod store;
pub mod study;
pub mod traces;
pub mod uncertain;
pub mod verify;

pub use earlier::Earlier;
pub use error::Error;
pub use run::{Options, Report, Shard, run, run_in_memory, run_to_file};
pub use store::{Local, Store};
pub use study::Study;
pub use verify::verify;
