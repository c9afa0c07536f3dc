//! Results for programs and reports.

mod at_bound;
pub mod diagnosis;
pub mod estimates;
pub mod identification;
pub mod next_experiment;
pub mod over_sets;
pub mod probability;
pub mod read_off;
pub mod recording;
pub mod remainder;
pub mod rigs;
mod stated_numbers;
pub mod unnamed;
pub mod validation;
