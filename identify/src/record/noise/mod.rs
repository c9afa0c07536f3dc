//! The noise of the pressure readings as a stochastic model, and the filter that makes residuals with such noise independent.
//!
//! In: the readings in quiet parts of the records. Out: the [`Noise`] (white, coloured, hum, step of the readings) and, for the
//! blocks of each record, a `Whitener`. In the order in which they are called:
//!
//! | module | does |
//! |---|---|
//! | `model` | states the noise, and determines its white part before anything is fitted |
//! | `whiten` | turns residuals of blocks into independent innovations of unit variance, by a Kalman filter |
//!
//! The coloured part is estimated from the residuals of a fit, hence at a later stage: [`super::colour`].

mod model;
pub(super) mod whiten;

pub(in crate::record) use model::polynomial_residual;
pub use model::{Colour, FLICKER_COLOURS, Hum, Noise, Quiet, least};
