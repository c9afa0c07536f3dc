//! The `[ambient]` table of rigs and models: temperature and pressure of the surroundings.

use crate::error::Error;
use crate::limits;
use crate::table::Table;

/// Temperature, K, and pressure, Pa, of the surroundings, each `None` where the file does not state it.
pub(crate) fn read(root: &Table<'_>) -> Result<(Option<f64>, Option<f64>), Error> {
    let table = root.table_or_empty("ambient")?;
    table.allow(&["temperature_k", "pressure_pa"])?;
    Ok((table.number("temperature_k", &limits::TEMPERATURE_K)?, table.number("pressure_pa", &limits::PRESSURE_PA)?))
}
