//! From the rows of a record to what a fit sees: the stroke, the readout, the noise, bad input, block means.

mod bends;
pub mod between_rows;
pub mod block;
pub mod checks;
pub mod clock;
pub mod colour;
pub mod data;
mod first_volume;
mod hampel;
mod lattice;
mod level;
pub mod line;
mod moving;
pub mod noise;
pub mod outliers;
mod position_noise;
pub mod positions;
mod prepare;
pub mod ramp;
pub mod readout;
mod scatter;
pub mod spline;
pub mod stroke;
pub mod true_stroke;
mod unfollowed;
pub mod unit;
pub mod unresolved;
