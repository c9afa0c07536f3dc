//! Heat transfer coefficients from measured traces; residuals traced to the effect that causes them.

pub mod paper;
