//! One of the measured tests, with the quantities whose powers λ may contain.

use serde::Serialize;

/// One measured test. SI units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Experiment of the paper.
    pub experiment: String,
    /// Actuator of the paper.
    pub actuator: String,
    /// Mean pressure, Pa.
    pub pressure_pa: f64,
    /// Mean temperature, K.
    pub temperature_k: f64,
    /// Mean temperature above ambient, K.
    pub excess_k: f64,
    /// Gas volume at the final stroke, m³.
    pub volume_m3: f64,
    /// Heat transfer area, m².
    pub area_m2: f64,
    /// Bore of the actuator, m.
    pub bore_m: f64,
    /// Length of the gas column, V/(piston area), m.
    pub column_m: f64,
    /// Measured time constant, s.
    pub time_constant_s: f64,
    /// λ_av = m cv/(τ Aq), W/(m² K).
    pub coefficient_av_w_per_m2_k: f64,
}
