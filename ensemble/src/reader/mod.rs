//! What is asked of the records of traced rows: peaks and settling ([`answers`]), and samples for the regression ([`regressions`]).
//!
//! A record is monotone between the knots of its trace and the places in between where it turns round; with those at
//! hand, all else is a matter of comparing. Only intervals that turn, the one in which the record settles, and with the
//! regression those that hold samples are looked into, as many at once as there are lanes.

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
