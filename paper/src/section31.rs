//! Section 3.1 of the paper: a simulated push-and-hold test, evaluated as published, and the origin of its 1.3 % error.
//!
//! The paper simulates the cylinder with the lateral area of the swept length ([`AreaLaw::Swept`]) and evaluates with (27)
//! ([`AreaLaw::Total`]). Two relative errors of λ0 therefore combine:
//!
//! - `bias_fit`: an exponential is fitted although 1 − Pf/P is the exponential, with the same area in both places;
//! - `bias_area`: the dead volume's lateral area is counted only in the evaluation.
//!
//! The simulation uses the closed form of ramp and hold ([`chamber::exact`]). The paper prints neither the durations of push and
//! hold nor the sampling rate; [`Timing::default`] has assumed values.

use super::tables::{SECTION_31, Table};
use super::time_constant::{self, Setup, TimeConstant};
use super::{Error, Recording, exact_regression};
use chamber::exact::Closed;
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use serde::Serialize;

/// Timing of the test, which the paper does not print.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Duration of the linear push, s.
    pub push_s: f64,
    /// Duration of the hold, s.
    pub hold_s: f64,
    /// Rows per second.
    pub sample_rate_hz: f64,
}

impl Default for Timing {
    /// A push of 0.04 s, whose regression has the printed ΔP, a hold of 5 s as in the paper's figure, 100 Hz.
    fn default() -> Self {
        Self { push_s: 0.04, hold_s: 5.0, sample_rate_hz: 100.0 }
    }
}

/// The test as described in the paper's table of section 3.1. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Description {
    /// Initial pressure, Pa: that of the surroundings.
    pub ambient_pressure_pa: f64,
    /// Temperature of wall and surroundings, K.
    pub ambient_temperature_k: f64,
    /// Bore of the cylinder, m.
    pub bore_m: f64,
    /// Stroke before the push, m.
    pub initial_stroke_m: f64,
    /// Stroke of the hold, m.
    pub final_stroke_m: f64,
    /// Volume of the gas at position zero, m³.
    pub dead_volume_m3: f64,
    /// Reference pressure P0, Pa.
    pub reference_pressure_pa: f64,
    /// Reference temperature T0, K.
    pub reference_temperature_k: f64,
    /// The true λ0, W/(m² K).
    pub coefficient_w_per_m2_k: f64,
}

impl Description {
    /// From the embedded table.
    ///
    /// # Errors
    /// If the table lacks one of the symbols.
    pub fn of_the_paper() -> Result<Self, Error> {
        let table = Table::parse(SECTION_31)?;
        let value = |symbol: &str| -> Result<f64, Error> {
            for row in 0..table.rows.len() {
                if table.text(row, "symbol")? == symbol {
                    return table.number(row, "value");
                }
            }
            Err(Error::Table { table: table.name, line: 1, reason: format!("no row for the symbol `{symbol}`") })
        };
        Ok(Self {
            ambient_pressure_pa: value("Pamb")?,
            ambient_temperature_k: value("Tamb")?,
            bore_m: value("phi")?,
            initial_stroke_m: value("l")?,
            final_stroke_m: value("l_f")?,
            dead_volume_m3: value("Vd")?,
            reference_pressure_pa: value("P0")?,
            reference_temperature_k: value("T0")?,
            coefficient_w_per_m2_k: value("lambda0")?,
        })
    }

    /// Data known to an evaluation.
    pub fn setup(&self, area_law: AreaLaw) -> Setup {
        let air = Setup::air(self.bore_m, self.ambient_temperature_k);
        Setup {
            geometry: Geometry { area_law, ..air.geometry },
            reference_pressure_pa: self.reference_pressure_pa,
            reference_temperature_k: self.reference_temperature_k,
            ..air
        }
    }

    /// The cylinder with this area law.
    pub fn chamber(&self, area_law: AreaLaw) -> Chamber {
        let heat_transfer = HeatTransfer {
            coefficient: self.coefficient_w_per_m2_k,
            reference_pressure: self.reference_pressure_pa,
            reference_temperature: self.reference_temperature_k,
        };
        Chamber::new(Gas::AIR, Geometry::new(self.bore_m, 0.0, self.dead_volume_m3, area_law), heat_transfer)
    }

    /// The simulated recording, without noise.
    pub fn record(&self, area_law: AreaLaw, timing: &Timing) -> Columns {
        let chamber = self.chamber(area_law);
        let volume = |x: f64| chamber.geometry.volume(x);
        let (x0, x1, tamb) = (self.initial_stroke_m, self.final_stroke_m, self.ambient_temperature_k);
        let closed = Closed::filled(&chamber, self.ambient_pressure_pa, tamb, volume(x0), tamb);
        let peak = closed.ramp(tamb, volume(x0), volume(x1), timing.push_s);
        let rows = ((timing.push_s + timing.hold_s) * timing.sample_rate_hz).round() as usize;
        let mut columns = Columns::default();
        for row in 0..=rows {
            let t = row as f64 / timing.sample_rate_hz;
            let fraction = (t / timing.push_s).min(1.0);
            // A row within rounding of the stop counts as part of the hold.
            let held = fraction >= 1.0 - 1e-12;
            let x = if held { x1 } else { x0 + (x1 - x0) * fraction };
            let temperature = match (row, held) {
                (0, _) => tamb,
                (_, false) => closed.ramp(tamb, volume(x0), volume(x), t),
                (_, true) => closed.held(peak, volume(x1), (t - timing.push_s).max(0.0)),
            };
            columns.time_s.push(t);
            columns.position_m.push(x);
            columns.pressure_pa.push(closed.pressure(temperature, volume(x)));
        }
        columns
    }
}

/// A recording that owns its columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// Time since the start of the recording, s.
    pub time_s: Vec<f64>,
    /// Absolute pressure of the gas, Pa.
    pub pressure_pa: Vec<f64>,
    /// Position of the piston, m.
    pub position_m: Vec<f64>,
}

impl Columns {
    /// The columns as a recording.
    pub fn recording(&self) -> Recording<'_> {
        Recording { time_s: &self.time_s, pressure_pa: &self.pressure_pa, position_m: &self.position_m }
    }
}

/// A quantity of section 3.1, the paper's value and ours, in the paper's unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Symbol as in the paper's table.
    pub symbol: String,
    /// Description.
    pub quantity: String,
    /// Unit of both numbers.
    pub unit: String,
    /// Printed value; `None` if the paper has no such number.
    pub paper: Option<f64>,
    /// Computed value (for inputs, the given one).
    pub ours: f64,
}

/// Section 3.1, reproduced.
#[derive(Clone, Debug)]
pub struct Section31 {
    /// Cylinder and test as stated in the paper.
    pub description: Description,
    /// Durations of push and hold, and the rate of the recording.
    pub timing: Timing,
    /// Sensor readings.
    pub columns: Columns,
    /// The published steps with the paper's choice of areas.
    pub published: TimeConstant,
    /// The published steps with the simulation's area.
    pub same_area: TimeConstant,
    /// The exact regression with the simulation's area.
    pub exact: exact_regression::ExactRegression,
    /// Relative error of λ0 due to the exponential.
    pub bias_fit: f64,
    /// Relative error of λ0 due to the second area.
    pub bias_area: f64,
    /// All quantities of the paper's table, then further ones of ours.
    pub lines: Vec<Line>,
}

/// Simulates and evaluates the test of section 3.1.
///
/// # Errors
/// Only for a damaged table.
pub fn reproduce(timing: &Timing) -> Result<Section31, Error> {
    let description = Description::of_the_paper()?;
    let columns = description.record(AreaLaw::Swept, timing);
    let recording = columns.recording();
    let published = time_constant::evaluate(&description.setup(AreaLaw::Total), &recording)?;
    let same_area = time_constant::evaluate(&description.setup(AreaLaw::Swept), &recording)?;
    let exact = exact_regression::evaluate(&description.setup(AreaLaw::Swept), &recording)?;
    let lambda0 = |t: &TimeConstant| t.steps.coefficient_0_w_per_m2_k.value;
    let bias_fit = lambda0(&same_area) / description.coefficient_w_per_m2_k - 1.0;
    let bias_area = lambda0(&published) / lambda0(&same_area) - 1.0;
    let lines = Vec::new();
    let mut section =
        Section31 { description, timing: *timing, columns, published, same_area, exact, bias_fit, bias_area, lines };
    section.lines = section.compare()?;
    Ok(section)
}

impl Section31 {
    /// Excess of the peak over the settled pressure, in percent of the latter.
    fn peak_percent(&self) -> f64 {
        let peak = self.columns.pressure_pa.iter().copied().fold(0.0, f64::max);
        100.0 * (peak / self.exact.final_pressure_pa.value - 1.0)
    }

    fn compare(&self) -> Result<Vec<Line>, Error> {
        let table = Table::parse(SECTION_31)?;
        let mut lines = Vec::new();
        for row in 0..table.rows.len() {
            let (symbol, quantity) = (table.text(row, "symbol")?, table.text(row, "quantity")?);
            let paper = table.number(row, "value")?;
            let ours = self.value(symbol, quantity).ok_or_else(|| Error::Table {
                table: table.name,
                line: row + 2,
                reason: format!("`{quantity}` is not computed here"),
            })?;
            let unit = table.text(row, "unit")?;
            lines.push(Line {
                symbol: symbol.to_owned(),
                quantity: quantity.to_owned(),
                unit: unit.to_owned(),
                paper: Some(paper),
                ours,
            });
        }
        let own = [
            ("lambda0_exact", "coefficient at P0 T0 by the exact regression", "W/m2/K", self.lambda0_exact()),
            ("bias_fit", "relative error of lambda0 from fitting an exponential", "1", self.bias_fit),
            ("bias_area", "relative error of lambda0 from a second area law", "1", self.bias_area),
        ];
        lines.extend(own.map(|(symbol, quantity, unit, ours)| Line {
            symbol: symbol.to_owned(),
            quantity: quantity.to_owned(),
            unit: unit.to_owned(),
            paper: None,
            ours,
        }));
        Ok(lines)
    }

    /// λ0 from the exact regression, W/(m² K).
    pub fn lambda0_exact(&self) -> f64 {
        self.exact.quantities.coefficient_0_w_per_m2_k.value
    }

    fn value(&self, symbol: &str, quantity: &str) -> Option<f64> {
        let (d, r, s) = (&self.description, &self.published.regression, &self.published.steps);
        Some(match symbol {
            "Pamb" => d.ambient_pressure_pa,
            "Tamb" => d.ambient_temperature_k,
            "phi" => d.bore_m,
            "l" => d.initial_stroke_m,
            "l_f" => d.final_stroke_m,
            "Vd" => d.dead_volume_m3,
            "P0" => d.reference_pressure_pa,
            "T0" => d.reference_temperature_k,
            "lambda0" => d.coefficient_w_per_m2_k,
            "Pf" => r.final_pressure_pa.value * 1e-5,
            "dP" => r.pressure_rise_pa.value * 1e-5,
            "tau" => r.time_constant_s.value,
            "m" => s.mass_kg.value,
            "Vd_hat" => s.dead_volume_m3.value,
            "k_av" => s.conductance_av_w_per_k.value,
            "Aq" => s.area_m2.value,
            "lambda_av" => s.coefficient_av_w_per_m2_k.value,
            "t_ss" => s.settling_time_s.value,
            "P_av" => s.pressure_av_pa.value,
            "T_av" => s.temperature_av_k.value,
            "T_f" => s.final_temperature_k.value,
            "lambda0_hat" => s.coefficient_0_w_per_m2_k.value,
            "k0_hat" => s.conductance_0_w_per_k.value,
            "" if quantity == "peak over steady state" => self.peak_percent(),
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chamber::EffectSet;
    use chamber::signals::Signals;
    use chamber::simulate::{Start, simulate};

    #[test]
    fn every_quantity_of_section_3_1_is_within_half_a_percent() {
        let section = reproduce(&Timing::default()).unwrap();
        for line in &section.lines {
            let Some(paper) = line.paper else { continue };
            let difference = line.ours / paper - 1.0;
            // The paper's "approximately 30 %" is 28 % here.
            let limit = if line.symbol.is_empty() { 0.1 } else { 5e-3 };
            assert!(difference.abs() < limit, "{}: {} {paper}", line.symbol, line.ours);
        }
    }

    #[test]
    fn the_exact_regression_recovers_the_truth_to_1e_6() {
        for law in [AreaLaw::Swept, AreaLaw::Total] {
            let d = Description::of_the_paper().unwrap();
            let columns = d.record(law, &Timing::default());
            let exact = exact_regression::evaluate(&d.setup(law), &columns.recording()).unwrap().quantities;
            assert!((exact.coefficient_0_w_per_m2_k.value / 26.5 - 1.0).abs() < 1e-6);
            assert!((exact.dead_volume_m3.value / 1.57e-6 - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_exact_regression_also_evaluates_an_expansion() {
        let mut d = Description::of_the_paper().unwrap();
        (d.initial_stroke_m, d.final_stroke_m) = (0.05, 0.1);
        let columns = d.record(AreaLaw::Total, &Timing::default());
        let exact = exact_regression::evaluate(&d.setup(AreaLaw::Total), &columns.recording()).unwrap().quantities;
        assert!((exact.coefficient_0_w_per_m2_k.value / 26.5 - 1.0).abs() < 1e-6);
        assert!((exact.dead_volume_m3.value / 1.57e-6 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn two_errors_of_about_seven_percent_cancel() {
        let s = reproduce(&Timing::default()).unwrap();
        assert!((s.bias_fit - 0.067).abs() < 1.5e-3, "{}", s.bias_fit);
        assert!((s.bias_area + 0.076).abs() < 5e-4, "{}", s.bias_area);
        let both = s.published.steps.coefficient_0_w_per_m2_k.value / 26.5;
        assert!(((1.0 + s.bias_fit) * (1.0 + s.bias_area) - both).abs() < 1e-12);
        assert!(s.published.fit.residuals_pa.iter().any(|r| r.abs() > 1.2e3));
        assert!(s.exact.fit.residuals_pa.iter().all(|r| r.abs() < 1e-3));
    }

    #[test]
    fn the_recording_is_that_of_the_integrator() {
        let d = Description::of_the_paper().unwrap();
        let timing = Timing { hold_s: 1.0, ..Timing::default() };
        let columns = d.record(AreaLaw::Swept, &timing);
        let motion = [(0.0, d.initial_stroke_m), (timing.push_s, d.final_stroke_m), (1.04, d.final_stroke_m)];
        let signals = Signals::closed(&motion, d.ambient_temperature_k, d.ambient_pressure_pa);
        let start = Start { pressure: d.ambient_pressure_pa, temperature: d.ambient_temperature_k };
        let chamber = d.chamber(AreaLaw::Swept);
        let samples = simulate(&chamber, EffectSet::NONE, start, &signals, &columns.time_s, 1e-10).unwrap();
        for (sample, pressure) in samples.iter().zip(&columns.pressure_pa) {
            assert!((sample.gas_pressure / pressure - 1.0).abs() < 1e-8, "at {}", sample.time);
        }
    }

    #[test]
    fn noise_widens_the_intervals_to_hold_the_truth() {
        let d = Description::of_the_paper().unwrap();
        let mut columns = d.record(AreaLaw::Total, &Timing::default());
        let mut state = 3u64;
        for p in &mut columns.pressure_pa {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                sum += (state >> 11) as f64 / (1u64 << 53) as f64;
            }
            *p += 150.0 * sum;
        }
        let setup = d.setup(AreaLaw::Total);
        let exact = exact_regression::evaluate(&setup, &columns.recording()).unwrap();
        let [low, high] = exact.rate_per_s.ci95;
        let truth = 1.0 / 0.42286;
        assert!(high - low > 1e-3 * truth && high - low < 0.05 * truth, "{low} {high}");
        // The initial pressure is a single row here, whose error is unknown; the rate does not depend on it.
        let noise_free = d.record(AreaLaw::Total, &Timing::default());
        let rate = exact_regression::evaluate(&setup, &noise_free.recording()).unwrap().rate_per_s.value;
        assert!(low < rate && rate < high, "{low} {rate} {high}");
    }
}
