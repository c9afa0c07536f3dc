//! Plausibility of the readings: input that is refused, and rows or records that are left out as faulty.
//!
//! In: the columns and the motion of a record, or all records with the residuals of a fit. Out: an error that names the fault,
//! rows that are no data, or a doubt about the declared unit. In the order in which they are called:
//!
//! | module | does |
//! |---|---|
//! | [`checks`] | refuses records that cannot be a test: too few rows, no move, a pressure that does not respond |
//! | `saturation` | finds pressures at an end of the sensor's range, for `checks` |
//! | `start_up` | finds the first readings, which a filter that is still settling falsifies |
//! | [`outliers`] | finds spikes in the readings before a fit, and in its residuals after it |
//! | `level` | doubts the declared unit of absolute pressures, once all records are prepared |
//! | [`unlike_repeats`] | finds records unlike their repeats, in the residuals of a fit |

pub mod checks;
pub(super) mod level;
pub mod outliers;
pub(crate) mod saturation;
pub(super) mod start_up;
pub mod unlike_repeats;
