//! Initial value problems in lanes: many at once ([`advance`]), by adaptive steps ([`step`]) in a transformed time
//! ([`time_transformation`]).

pub mod advance;
pub mod corner;
pub mod expansion;
mod first_step;
pub mod log;
pub mod problem;
pub mod step;
pub mod tableau;
pub mod time_transformation;
