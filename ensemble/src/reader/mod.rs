//! Reads the records of traced rows: peaks and settling times ([`answers`]), and samples for the regression ([`regressions`]).
//!
//! A record is monotone between the knots of its trace and the turns in between, so that the rest is comparison. Only intervals with a
//! turn, the interval in which the record settles and, for the regression, those that contain samples are interpolated, one per lane.

mod answers;
mod bends;
mod curves;
mod cuts;
mod interpolant;
mod regressions;
mod traces;

pub use answers::RowAnswer;
pub use bends::Bends;
pub use interpolant::Knot;
pub use traces::{Memory, Traces, seen_from};
