//! Initial value problems in lanes: many at once ([`advance`]), by adaptive steps ([`step`]) in a clock ([`clock`]).

pub mod advance;
pub mod clock;
pub mod corner;
pub mod expansion;
mod first_step;
pub mod log;
pub mod problem;
pub mod step;
pub mod tableau;
