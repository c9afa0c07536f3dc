//! Reconstruction of the stroke where the rows do not show it, and the error of that.
//!
//! In: the stroke through the rows ([`Motion`](super::stroke::Motion)) and the timing of the sensors. Out: a stroke for the
//! model, and errors in m for the blocks.
//!
//! | module | gives | called |
//! |---|---|---|
//! | [`gaps`] | the stroke on either side of rows that the logger lost, and one across them | for each record, around `stroke` |
//! | `between_rows` | the error of the stroke between two rows, which a late sensor or one that lags sees | with the blocks |
//! | `true_stroke` | the stroke behind a moving average or low-pass of the position sensor, by deconvolution | by the model |
//! | `unresolved` | the error of the deconvolved stroke where it changes within the window | with the blocks |

pub mod between_rows;
pub mod gaps;
pub(crate) mod true_stroke;
pub(super) mod unresolved;
