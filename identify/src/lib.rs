//! Measured traces in, an identified model out: the fit of a rig, its residual, and the effect that explains it.
//!
//! | module | holds |
//! |---|---|
//! | [`motion`], [`spline`], [`noise`], [`checks`], [`prepare`] | from rows to blocks: moves, holds, noise, bad input |
//! | [`forward`] | the model's pressure along a record, with exact sensitivities |
//! | [`hypothesis`], [`fit`], [`whiten`], [`uncertainty`] | what is free, the least squares over all traces, intervals |
//! | [`candidates`], [`evidence`], [`held_out`] | fits with effects added, and how much they are worth |
//! | [`missing`], [`adequacy`], [`sanity`] | what remains, whether it is noise, what has no physics behind it |
//! | [`tracing`] | from the residual to the effect that explains it, or to the statement that none does |
//! | [`diagnosis`], [`separate`] | the result for programs and reports; what to measure next |
//! | [`identification`] | the paper's model alone, by either method |
//! | [`gas_spring`] | the study of a measured gas spring |
//! | [`synthetic`] | rigs with a known truth, for tests and the Monte Carlo study |

pub mod adequacy;
pub mod candidates;
pub mod checks;
pub mod diagnosis;
pub mod error;
pub mod evidence;
pub mod fit;
pub mod forward;
pub mod gas_spring;
pub mod held_out;
pub mod hypothesis;
pub mod identification;
pub mod missing;
pub mod motion;
pub mod noise;
pub mod prepare;
pub mod ramp;
pub mod report;
pub mod sanity;
pub mod separate;
pub mod spline;
pub mod synthetic;
pub mod tracing;
pub mod uncertainty;
pub mod whiten;

pub use diagnosis::{Diagnosed, Diagnosis, diagnose};
pub use error::Error;
pub use identification::{Identification, Method, identify};
