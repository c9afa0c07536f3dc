//! The columns of a simulation's result.

use chamber::simulate::Sample;

/// A column of the result.
pub struct Column {
    /// Its name, with the unit.
    pub name: &'static str,
    /// Unit of its values.
    pub unit: &'static str,
    /// One-line description for people.
    pub doc: &'static str,
    /// Its value for a sample.
    pub of: fn(&Sample) -> f64,
}

/// The result's columns, in order.
pub const COLUMNS: [Column; 7] = [
    Column { name: "time_s", unit: "s", doc: "Time, as in the motion", of: |s| s.time },
    Column {
        name: "pressure_pa",
        unit: "Pa",
        doc: "Pressure that the sensor would show, sensor effects included",
        of: |s| s.measured_pressure,
    },
    Column { name: "gas_pressure_pa", unit: "Pa", doc: "Pressure of the gas", of: |s| s.gas_pressure },
    Column { name: "temperature_k", unit: "K", doc: "Mean temperature of the gas", of: |s| s.temperature },
    Column { name: "mass_kg", unit: "kg", doc: "Mass of the gas", of: |s| s.mass },
    Column { name: "volume_m3", unit: "m3", doc: "Volume of the gas", of: |s| s.volume },
    Column { name: "heat_flow_w", unit: "W", doc: "Heat flow into the gas", of: |s| s.heat_flow },
];

/// A column with its values.
pub struct Values {
    /// Its name, with the unit.
    pub name: String,
    /// Unit of its values.
    pub unit: &'static str,
    /// One-line description for people.
    pub doc: String,
    /// One value per row.
    pub values: Vec<f64>,
}
