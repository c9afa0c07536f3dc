//! The paper's steps 2 to 7 on one record, without its outliers, saturated rows and those of a settling filter: the time constant
//! method of Carneiro and Gomes de Almeida (2006).

use crate::record::data::{Data, Prepared};
use paper::time_constant::{self, TimeConstant};
use paper::{Recording, Setup};

/// Applies the steps to a record.
///
/// # Errors
/// A record that is not a single push and hold, and anything else that [`time_constant::evaluate`] refuses.
pub fn of(data: &Data, t: &Prepared) -> Result<TimeConstant, paper::Error> {
    let setup = Setup {
        gas: data.gas,
        geometry: data.cylinder.geometry(0.0),
        ambient_temperature_k: t.initial_temperature_k,
        reference_pressure_pa: chamber::paper::REFERENCE_PRESSURE_PA,
        reference_temperature_k: chamber::paper::REFERENCE_TEMPERATURE_K,
    };
    let left_out = |row: usize| t.readout.is_early(row) || t.readout.is_saturated(row);
    let is_kept = |row: &usize| !left_out(*row) && t.readout.outliers.binary_search(row).is_err();
    let kept = |column: &[f64]| (0..column.len()).filter(is_kept).map(|row| column[row]).collect::<Vec<f64>>();
    let [time_s, pressure_pa, position_m] = [&t.time_s, &t.pressure_pa, &t.position_m].map(|column| kept(column));
    let recording = Recording { time_s: &time_s, pressure_pa: &pressure_pa, position_m: &position_m };
    time_constant::evaluate(&setup, &recording)
}
