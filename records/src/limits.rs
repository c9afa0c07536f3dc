//! Bounds on the quantities of rigs and models. Wide enough for any cylinder built, narrow enough to catch millimetres, bar and
//! degrees Celsius typed in place of metres, pascal and kelvin.

use crate::error::Error;
use crate::key::Bounds;
use crate::table::Table;

/// Bore, m.
pub const BORE_M: Bounds = Bounds::Within(1e-4..=5.0, "in m");
/// Rod diameter, m.
pub const ROD_M: Bounds = Bounds::Within(0.0..=5.0, "in m");
/// Piston area, m².
pub const AREA_M2: Bounds = Bounds::Within(1e-8..=20.0, "in m2");
/// Stroke, m.
pub const STROKE_M: Bounds = Bounds::Within(1e-4..=100.0, "in m");
/// Dead volume, m³.
pub const DEAD_VOLUME_M3: Bounds = Bounds::Within(0.0..=100.0, "in m3");
/// Ambient and reference temperature, K.
pub const TEMPERATURE_K: Bounds = Bounds::Within(150.0..=1000.0, "in kelvin (20 degC is 293.15)");
/// Ambient and reference pressure, Pa.
pub const PRESSURE_PA: Bounds = Bounds::Within(1e3..=1e8, "in Pa, absolute (1 bar is 1e5)");
/// Heat transfer coefficient, W/(m² K).
pub const COEFFICIENT: Bounds = Bounds::Within(0.0..=1e6, "in W/(m2 K)");

/// Pressure of the standard atmosphere, Pa: the default ambient pressure of a file.
pub const STANDARD_ATMOSPHERE_PA: f64 = 101_325.0;
/// Default ambient temperature of a model, K.
pub const ROOM_TEMPERATURE_K: f64 = 293.15;

/// Refuses a rod that does not fit into the bore.
pub(crate) fn check_rod(table: &Table<'_>, bore: f64, rod: f64) -> Result<(), Error> {
    if rod < bore {
        return Ok(());
    }
    let problem = format!("{rod:?} m is not less than the bore, {bore:?} m: there would be no piston area");
    Err(table.contradiction("rod_m", problem))
}
