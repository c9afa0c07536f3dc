//! An identified chamber with where it comes from.

use chamber::Chamber;

/// A chamber as model files hold it.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Name of the gas, one of [`chamber::Gas::NAMED`], where it has one.
    pub gas_name: Option<String>,
    /// All its constants, effects included.
    pub chamber: Chamber,
    /// Diameter of the rod that runs through the chamber, m: zero on the cap side.
    pub rod_m: f64,
    /// Temperature of the surroundings, K.
    pub ambient_temperature_k: f64,
    /// Pressure of the surroundings, Pa.
    pub ambient_pressure_pa: f64,
    /// Where the numbers come from.
    pub provenance: Provenance,
}

/// Where a model's numbers come from. All of it may be absent in a model written by hand.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Provenance {
    /// The program and its version.
    pub program: Option<String>,
    /// When it was written, UTC, `2026-11-21T12:00:00Z`.
    pub date: Option<String>,
    /// The traces it was identified from.
    pub traces: Vec<SourceTrace>,
    /// Error of the paper's model, before any effect.
    pub rmse_before_pa: Option<Rmse>,
    /// Error of this model.
    pub rmse_after_pa: Option<Rmse>,
}

/// A trace by name and content.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceTrace {
    /// The file's path as it was given.
    pub path: String,
    /// SHA-256 of its bytes, 64 hexadecimal digits.
    pub sha256: String,
}

/// Root mean square error against what the sensor recorded, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rmse {
    /// On the data of the fit.
    pub fit: f64,
    /// On data that took no part in it.
    pub held_out: Option<f64>,
}
