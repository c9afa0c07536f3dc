//! The paper's step 1, the least-squares fit of P = Pf + ΔP e^(−t/τ) to the samples of one record per lane, and steps 2 to 7 on its
//! result ([`fit`]). Pressures in Pa, times in s.

pub mod fit;
mod least_squares;
mod records;
pub mod relaxing;
pub mod samples;
mod time_constant;

pub use least_squares::{Guess, Regression, Regressions};
pub use records::{RecordPart, Records};
