//! Preparation of the records for a fit: from the rows of a rig's files to blocks with their noise. Faulty input is refused.
//!
//! In: a [`records::Rig`] with its traces. Out: [`data::Data`], all that later stages know of the measurements. Each part uses
//! only those above it in this table:
//!
//! | module | holds |
//! |---|---|
//! | [unit](mod@unit), [`far_off`] | units that may be confused; the words for rows left out |
//! | `series` | statistics of one column of readings: step, scatter, outliers |
//! | [`sampling`] | the times of the rows, and which of them are readings |
//! | [`stroke`] | the curve through the positions; rest, moves and holds |
//! | [`reconstruction`] | the stroke between rows, in gaps and behind a filter, with its error |
//! | `noise` | the noise as a model; the filter that whitens residuals |
//! | [`blocks`] | means of rows with their uncertainties |
//! | `course`, [`data`] | the results: a record's course, all records of a rig |
//! | `first_volume`, `papers_steps`, `repeats` | of prepared records: a first dead volume, the paper's method, aligned rows |
//! | [`plausibility`] | what is refused or left out as faulty |
//! | `colour` | the coloured noise, from the residuals of a fit |
//! | `prepare` | calls the parts above, except `colour` and what else needs a fit |
//!
//! Order of the calls in `prepare`: `clock`, `positions`, `jitter`, the stroke with its `gaps`, `readout` and `checks`; with all
//! records so far, the white noise; then `start_up` and spikes, blocks with their errors, the first dead volume, and `level`.

pub mod blocks;
pub(crate) mod colour;
pub(crate) mod course;
pub mod data;
pub mod far_off;
mod first_volume;
pub(crate) mod noise;
pub(crate) mod papers_steps;
pub mod plausibility;
mod prepare;
pub mod reconstruction;
pub(crate) mod repeats;
pub mod sampling;
mod series;
pub mod stroke;
pub mod unit;
