//! Blocks: the pressures that a fit compares, each the mean of a few rows, with its uncertainties.
//!
//! In: readings, stroke and the errors of the stroke. Out: the [`Block`]s of a record, whose uncertainties
//! `whiten` combines with the noise. Called in this order:
//!
//! | module | does |
//! |---|---|
//! | `block` | divides the rows into blocks; the errors that each block has on its own |
//! | `common_errors` | the errors that the blocks of one rest or hold share through the position of the piston |
//! | `convection_errors` | the same through the heat of forced convection, once a fit has shown the response to it |

mod block;
pub(super) mod common_errors;
pub(super) mod convection_errors;

pub use block::{Block, blocks};
