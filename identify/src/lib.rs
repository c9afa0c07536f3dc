//! Measured traces in, an identified model out: the fit of a rig, its residual, and the effect that explains it.
//!
//! Each stage uses only those above it, and all report their errors as [`Error`]:
//!
//! | module | holds |
//! |---|---|
//! | [`policy`] | the thresholds of the search and of the verdict, each with its reason |
//! | [`record`] | from rows to blocks: moves, holds, noise, bad input |
//! | [`parameters`], [`forward`] | what is free; the model's pressure along a record, with exact sensitivities |
//! | [`fit`] | least squares over all records, intervals |
//! | [`discrepancy`] | the missing term as a curve |
//! | [`judge`] | evidence, the error on left-out data, what remains |
//! | [`search`] | from the residual to the effects that explain it, or to the statement that none does |
//! | [`outcome`] | results for programs and reports |
//! | [`synthetic`] | rigs with a known truth, for tests and the Monte Carlo study |

mod characteristic;
pub mod discrepancy;
mod error;
pub mod fit;
pub mod forward;
mod isentrope;
pub mod judge;
pub mod outcome;
pub mod parameters;
pub mod policy;
mod rates;
pub mod record;
pub mod search;
pub mod synthetic;

pub use error::Error;
pub use outcome::diagnosis::{Diagnosed, Diagnosis, diagnose};
pub use outcome::identification::{Identification, Method, identify};
pub use outcome::validation::{Predictor, Validated, Validation, validate};
