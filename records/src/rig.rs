//! What was measured on: the cylinder, its surroundings, gas and sensor, and the experiments with their traces.

use crate::trace::Trace;
use chamber::Gas;
use std::path::PathBuf;

/// A rig file with all the traces it names.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The rig file.
    pub path: PathBuf,
    /// The cylinder as seen from the measured chamber.
    pub cylinder: Cylinder,
    /// The dead volume as far as it is known beforehand.
    pub dead_volume: Option<DeadVolume>,
    /// The surroundings.
    pub ambient: Ambient,
    /// The gas.
    pub gas: NamedGas,
    /// The pressure sensor.
    pub sensor: Sensor,
    /// The experiments, in the file's order.
    pub experiments: Vec<Experiment>,
}

/// The cylinder as seen from the measured chamber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Bore, m.
    pub bore_m: f64,
    /// Diameter of the rod that runs through the measured chamber, m: zero on the cap side.
    pub rod_through_m: f64,
    /// Area of the piston face that the measured gas acts on, m².
    pub piston_area_m2: f64,
    /// The cylinder's stroke, m, where it is known.
    pub stroke_m: Option<f64>,
}

/// The gas volume at position zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadVolume {
    /// Its value or estimate, m³.
    pub value_m3: f64,
    /// Whether it is known and stays, rather than an estimate to begin from.
    pub known: bool,
}

/// The surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// Temperature, K; absent where it was not recorded and is to be estimated.
    pub temperature_k: Option<f64>,
    /// Pressure, Pa.
    pub pressure_pa: f64,
}

/// A gas and, where it has one, its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedGas {
    /// One of [`Gas::NAMED`], absent for a gas given by its constants.
    pub name: Option<String>,
    /// Its constants.
    pub gas: Gas,
}

/// What is known of the pressure sensor.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Sensor {
    /// Standard deviation of its noise, Pa.
    pub noise_pa: Option<f64>,
    /// How often it is read out, Hz, where that is less often than the rows say.
    pub sample_rate_hz: Option<f64>,
}

/// One kind of test and its repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Its name.
    pub name: String,
    /// One trace for each repeat; at least one.
    pub traces: Vec<Trace>,
}
