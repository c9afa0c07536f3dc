//! Results for programs and reports.

mod at_bound;
pub mod diagnosis;
pub mod empirical;
pub mod estimates;
pub(crate) mod identification;
pub(crate) mod next_experiment;
mod other_gas;
pub(crate) mod over_sets;
pub(crate) mod probability;
pub mod recording;
pub(crate) mod remainder;
pub(crate) mod rigs;
mod stated_numbers;
pub mod unnamed;
pub mod validation;
