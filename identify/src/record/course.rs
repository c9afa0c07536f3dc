//! What the piston and the surroundings do along a record: stroke, m, temperature, K, and pressure, Pa, of the surroundings, and
//! the mass flow, kg/s, if one is recorded.

use crate::record::stroke::{Motion, Spline};

/// Course of the piston and the surroundings along a record.
#[derive(Clone, Debug)]
pub struct Course {
    /// Stroke of the piston over time.
    pub motion: Motion,
    /// Temperature of the surroundings over time, K.
    pub ambient_temperature: Spline,
    /// Pressure of the surroundings, Pa.
    pub ambient_pressure: f64,
    /// Mass flow into the chamber over time, kg/s, if the record has one.
    pub mass_flow: Option<Spline>,
}
