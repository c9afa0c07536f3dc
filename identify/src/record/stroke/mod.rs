//! The piston's stroke: a smooth curve through the recorded positions, divided into rest, moves and holds.
//!
//! In: times, s, and positions, m, of a record's rows. Out: a [`Motion`], whose [`Segment`]s each hold a [`Spline`]. In the order
//! in which they are called:
//!
//! | module | does |
//! |---|---|
//! | [`positions`] | finds the rows that are readings of the position, without disturbed ones |
//! | `position_noise` | gives the standard deviation of the positions, from their step and scatter |
//! | `motion` | calls all that follow, and joins their curves to a [`Motion`] |
//! | `moving`, `turn` | tell rows in motion from rows at rest, and a stop from a turning point |
//! | `corner` | finds the time between rows at which a move begins or ends abruptly |
//! | `ramp` | a move at constant speed: one straight line |
//! | `smoothed`, `thinned` | the curve of a short move, and of a long one |
//! | `spline` | the cubic spline that all of these give |
//! | `unfollowed` | moves with too few readings to show their course |
//! | `turning_points` | rows at which the piston turns, for the pressure's outliers and blocks |

mod corner;
mod motion;
mod moving;
pub(super) mod position_noise;
pub mod positions;
mod ramp;
pub(super) mod smoothed;
mod spline;
mod thinned;
mod turn;
pub(super) mod turning_points;
mod unfollowed;

pub use motion::{Motion, Phase, Segment};
pub use spline::Spline;
