//! A scenario as written by the driver.

use std::path::Path;

/// Temperature of the surroundings, as in `../model.toml`.
pub const AMBIENT_TEMPERATURE_K: f64 = 293.0;
/// Pressure of the surroundings, as in `../model.toml`.
#[cfg(feature = "peers")]
pub const AMBIENT_PRESSURE_PA: f64 = 101_325.0;

/// One push-and-hold test.
#[derive(Clone, Copy)]
pub struct Case {
    pub bore_m: f64,
    pub dead_volume_m3: f64,
    pub initial_pressure_pa: f64,
    pub initial_stroke_m: f64,
    pub final_stroke_m: f64,
    pub coefficient: f64,
    pub push_time_s: f64,
    pub duration_s: f64,
    pub inflow_kg_per_s: f64,
    /// Parameters of effects, in the order of [`EFFECTS`]; zero is neutral.
    pub effects: [f64; EFFECTS.len()],
}

/// Effects and the indices of the parameters that a scenario sets.
pub const EFFECTS: [(&str, usize); 5] =
    [("leakage", 0), ("natural_convection", 0), ("wall_heating", 0), ("wall_heating", 1), ("gas_column_length", 0)];
/// Numbers per scenario.
const COLUMNS: usize = 9 + EFFECTS.len();

/// Results by which the contenders are compared.
#[derive(Clone, Copy, Default)]
pub struct Answer {
    pub peak_pa: f64,
    pub final_pa: f64,
}

impl Case {
    /// All scenarios of a file: [`COLUMNS`] 64-bit floats each, as in `../contenders/scenario.py`.
    pub fn read(path: &Path) -> Vec<Self> {
        let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let numbers: Vec<f64> =
            bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("eight bytes"))).collect();
        let one = |n: &[f64]| Case {
            bore_m: n[0],
            dead_volume_m3: n[1],
            initial_pressure_pa: n[2],
            initial_stroke_m: n[3],
            final_stroke_m: n[4],
            coefficient: n[5],
            push_time_s: n[6],
            duration_s: n[7],
            inflow_kg_per_s: n[8],
            effects: std::array::from_fn(|i| n[9 + i]),
        };
        numbers.chunks_exact(COLUMNS).map(one).collect()
    }
}
