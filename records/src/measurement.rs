//! Accuracy of a rig's quantities as stated in its file: `[sensor]`, `[accuracy]` and `[tolerance]`.

use crate::error::Error;
use crate::key::Bounds;
use crate::table::Table;

/// Default standard deviation of the bore, relative.
const BORE_SHARE: f64 = 0.005;
/// Default standard deviation of the position sensor's scale factor.
const POSITION_SCALE: f64 = 0.005;
/// Default standard deviation of the waves in the position sensor's nonlinearity, as a fraction of the range of motion in the
/// records.
const POSITION_LINEARITY: f64 = 2e-4;
/// Default standard deviation of the position's zero, m.
const POSITION_OFFSET_M: f64 = 0.5e-3;
/// Default relative standard deviation of the gas's heat capacity ratio: that of dry air is 0.07 % above that of air at half its
/// saturation humidity.
const HEAT_CAPACITY_RATIO: f64 = 0.0005;
/// Default standard deviation of a stated or recorded ambient temperature, K.
const STATED_TEMPERATURE_K: f64 = 2.0;
/// Default standard deviation of an ambient temperature neither stated nor recorded, K.
const UNSTATED_TEMPERATURE_K: f64 = 5.0;

// Wide enough for any rig; narrow enough to catch millimetres and per cent.
const BORE_BOUNDS: Bounds = Bounds::Within(0.0..=1.0, "in m");
const SCALE_BOUNDS: Bounds = Bounds::Within(0.0..=0.5, "as a share (0.005 is 0.5 %)");
const OFFSET_BOUNDS: Bounds = Bounds::Within(0.0..=10.0, "in m");
const TEMPERATURE_BOUNDS: Bounds = Bounds::Within(0.0..=200.0, "in K");

/// Properties of the pressure sensor. Absent ones are estimated from the traces.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Sensor {
    /// Standard deviation of its white noise, Pa.
    pub noise_pa: Option<f64>,
    /// Spacing of the pressures it can show, Pa.
    pub step_pa: Option<f64>,
    /// Readout rate, Hz, where lower than the row rate.
    pub readout_hz: Option<f64>,
}

impl Sensor {
    pub(crate) fn read(root: &Table<'_>) -> Result<Self, Error> {
        let Some(table) = root.table("sensor")? else { return Ok(Self::default()) };
        // `sample_rate_hz`, the logger's row rate, is for readers only: the times in the traces are more accurate.
        table.allow(&["noise_pa", "step_pa", "readout_hz", "sample_rate_hz"])?;
        table.number("sample_rate_hz", &Bounds::Positive)?;
        // Zero is impossible for a real sensor: treated as absent.
        let size = |key| Ok(table.number(key, &Bounds::NotNegative)?.filter(|value| *value > 0.0));
        Ok(Self {
            noise_pa: size("noise_pa")?,
            step_pa: size("step_pa")?,
            readout_hz: table.number("readout_hz", &Bounds::Positive)?,
        })
    }
}

/// Negligible misfit, Pa rms; `None` if the file does not state it.
pub(crate) fn read_accuracy(root: &Table<'_>) -> Result<Option<f64>, Error> {
    let Some(table) = root.table("accuracy")? else { return Ok(None) };
    table.allow(&["pressure_pa"])?;
    table.number("pressure_pa", &Bounds::Positive)
}

/// Standard deviations of the stated geometry, ambient temperature and gas.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tolerance<T = f64> {
    /// Of the bore, m: 0.5 % of it unless stated.
    pub bore_m: T,
    /// Of the position sensor's scale factor, 1: 0.005 unless stated.
    pub position_scale: T,
    /// Of each of the four waves of the position sensor's nonlinearity, as a fraction of the range of motion in the records:
    /// 0.0002 unless stated.
    pub position_linearity: T,
    /// Of the position's zero, m: 0.5 mm unless stated.
    pub position_offset_m: T,
    /// Of the ambient temperature, K. Unless stated: 2 K where the temperature is stated or recorded, else 5 K.
    pub ambient_temperature_k: T,
    /// Of the gas's heat capacity ratio γ, relative: 0.0005 unless stated, as for air of unknown humidity.
    pub heat_capacity_ratio: T,
}

impl Tolerance {
    /// Defaults for a cylinder of a bore, m.
    pub fn default_of(bore_m: f64, ambient_known: bool) -> Self {
        Self {
            bore_m: BORE_SHARE * bore_m,
            position_scale: POSITION_SCALE,
            position_linearity: POSITION_LINEARITY,
            position_offset_m: POSITION_OFFSET_M,
            ambient_temperature_k: if ambient_known { STATED_TEMPERATURE_K } else { UNSTATED_TEMPERATURE_K },
            heat_capacity_ratio: HEAT_CAPACITY_RATIO,
        }
    }
}

/// `[tolerance]` as in the file, each key optional.
pub type StatedTolerance = Tolerance<Option<f64>>;

impl StatedTolerance {
    pub(crate) fn read(root: &Table<'_>, bore_m: f64) -> Result<Self, Error> {
        let Some(table) = root.table("tolerance")? else { return Ok(Self::default()) };
        table.allow(&[
            "bore_m", "position_scale", "position_linearity", "position_offset_m", "ambient_temperature_k",
            "heat_capacity_ratio",
        ])?;
        let bore = table.number("bore_m", &BORE_BOUNDS)?;
        if let Some(tolerance) = bore.filter(|tolerance| *tolerance >= 0.5 * bore_m) {
            let problem =
                format!("{tolerance:?} m is half of the bore, {bore_m:?} m, or more: it is a standard deviation in m");
            return Err(table.contradiction("bore_m", problem));
        }
        Ok(Self {
            bore_m: bore,
            position_scale: table.number("position_scale", &SCALE_BOUNDS)?,
            position_linearity: table.number("position_linearity", &SCALE_BOUNDS)?,
            position_offset_m: table.number("position_offset_m", &OFFSET_BOUNDS)?,
            ambient_temperature_k: table.number("ambient_temperature_k", &TEMPERATURE_BOUNDS)?,
            heat_capacity_ratio: table.number("heat_capacity_ratio", &SCALE_BOUNDS)?,
        })
    }

    /// Completed with the defaults.
    pub fn or(&self, default: Tolerance) -> Tolerance {
        Tolerance {
            bore_m: self.bore_m.unwrap_or(default.bore_m),
            position_scale: self.position_scale.unwrap_or(default.position_scale),
            position_linearity: self.position_linearity.unwrap_or(default.position_linearity),
            position_offset_m: self.position_offset_m.unwrap_or(default.position_offset_m),
            ambient_temperature_k: self.ambient_temperature_k.unwrap_or(default.ambient_temperature_k),
            heat_capacity_ratio: self.heat_capacity_ratio.unwrap_or(default.heat_capacity_ratio),
        }
    }
}
