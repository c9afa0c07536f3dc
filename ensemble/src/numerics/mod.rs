//! General numerical methods in lanes.

pub mod elimination;
pub mod gauss;
pub mod hermite;
pub mod root;
pub mod series;
