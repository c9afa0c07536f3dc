//! Numerical methods in lanes that know nothing of chambers.

pub mod elimination;
pub mod gauss;
pub mod hermite;
pub mod root;
pub mod series;
