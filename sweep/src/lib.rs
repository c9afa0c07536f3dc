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
//! | [`quantity`], [`names`] | every number that can be varied, and what people may call it |
//! | [`point`] | a value for each of them |
//! | [`axis`], [`distribution`] | the values a quantity takes, or how probable they are |
//! | [`constraint`] | which points make sense |
//! | [`copula`], [`uncertain`] | correlated quantities; a model's parameters as known |
//! | [`design`] | which points a study has |
//! | [`row`], [`geometry`] | from a point to a scenario, bore or strokes solved for |
//! | [`outputs`], [`status`] | what comes out of a row, and how it ended |
//! | [`solve`], [`chunk`], [`progress`] | rows through the kernel of `ensemble`, piece by piece |
//! | [`columns`], [`status_column`], [`encoding`] | the table: names, units, statuses, how it is encoded |
//! | [`part`], [`new_file`], [`reader`] | one Parquet file, whole or not there; read back |
//! | [`pages`], [`sink`] | its pages' checksums; its hash, and the order of its statistics |
//! | [`earlier`] | rows that a smaller study has solved already |
//! | [`store`] | where that folder is: on a disk or elsewhere |
//! | [`folder`], [`file_names`], [`record`] | a study's folder: its manifest, what stands where, what is known of a part |
//! | [`verify`](mod@verify) | whether it holds what its manifest says |
//! | [`traces`] | the courses of some rows, as a second table |
//! | [`run`](mod@run), [`shard`] | a study carried out into its folder, or a share of its parts |
//! | [`whole`] | all of it into a file or memory, or its statistics alone |
//! | [`statistics`] | what the results come to, with the rows or without |
//! | [`sensitivity`] | first-, second- and total-order indices of a Saltelli study |
//! | [`estimate`] | time and bytes of a study, from a short calibration |
//!
//! A row is a pure function of the study and its number. Shards, threads and interruptions make no difference to it.

pub mod axis;
pub mod chunk;
pub mod columns;
pub mod constraint;
pub mod copula;
pub mod design;
pub mod distribution;
pub mod earlier;
pub mod encoding;
pub mod error;
pub mod estimate;
pub mod file_names;
pub mod folder;
pub mod geometry;
pub mod hash;
pub mod names;
pub mod new_file;
pub mod outputs;
pub mod pages;
pub mod part;
pub mod point;
pub mod progress;
mod publish;
pub mod quantity;
pub mod reader;
pub mod record;
pub mod row;
pub mod run;
pub mod sensitivity;
pub mod shard;
pub mod sink;
pub mod solve;
pub mod statistics;
pub mod status;
pub mod status_column;
pub mod store;
pub mod study;
pub mod traces;
pub mod uncertain;
pub mod verify;
pub mod whole;

pub use earlier::Earlier;
pub use error::Error;
pub use run::{Options, Report, run};
pub use shard::Shard;
pub use store::{Local, Store};
pub use study::Study;
pub use verify::verify;
pub use whole::{run_in_memory, run_to_file};
