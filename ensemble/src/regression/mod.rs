//! Step 1 of the paper, P = Pf + ΔP e^(−t/τ) by least squares over the samples, for as many records as there are lanes, and steps
//! 2 to 7 on what it finds ([`fit`]). Pressures in Pa, times in s.

pub mod fit;
mod least_squares;
mod records;
pub mod relaxing;
pub mod samples;
mod time_constant;

pub use least_squares::{Guess, Regression, Regressions};
pub use records::{RecordPart, Records};
