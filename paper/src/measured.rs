//! Tables 4 and 5 from tables 1 to 3, and the ambient temperature of the experiments, which the paper does not print.
//!
//! One Tamb for all six tests, by weighted least squares over the printed values of table 4 that depend on it: the mean
//! temperatures (∝ Tamb) and the masses (∝ 1/Tamb). Dead volumes, areas and mean pressures do not depend on it. Weights follow
//! from the printed digits (standard deviation 1/√12 of a unit in the last place, for inputs and outputs alike); if the six tests
//! scatter more than that, the interval is widened by √(χ²/(n − 1)), with n the number of tests, because a test's mass adds
//! almost no information to its mean temperature.

use super::Error;
use super::exact_regression;
use super::statistics::{Estimate, NORMAL_95, rounding_deviation, student_95};
use super::tables::{MeasuredTest, TABLE_4, Table, measured_tests, row_of};
use super::time_constant::{Push, Regression, Setup, Steps, Uncertainty, steps_with_intervals};
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

/// The inferred ambient temperature of the experiments.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AmbientTemperature {
    /// Ambient temperature Tamb, K.
    pub temperature_k: Estimate,
    /// Its standard error, K.
    #[serde(skip)]
    pub standard_error_k: f64,
    /// √(χ²/(n − 1)), n the number of tests: scatter of the printed numbers relative to that explained by their digits.
    pub scatter_over_rounding: f64,
    /// Estimate from the mean temperature alone, for each test, K.
    pub by_mean_temperature_k: Vec<f64>,
    /// Estimate from the mass alone, for each test, K.
    pub by_mass_k: Vec<f64>,
}

/// A measured test and its evaluation.
#[derive(Clone, Debug)]
pub struct Row {
    /// What the paper measured.
    pub test: MeasuredTest,
    /// Known data of cylinder and surroundings.
    pub setup: Setup,
    /// Steps 2 to 7; the intervals reflect the printed digits and the inferred ambient temperature.
    pub steps: Steps<Estimate>,
    /// λ0 from the exact decay behind the printed regression, for holds of 5 and of 10 time constants, W/(m² K).
    pub exact_coefficient_0_w_per_m2_k: [f64; 2],
}

/// The six tests, evaluated.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Inferred from table 4.
    pub ambient: AmbientTemperature,
    /// In table 3's order.
    pub rows: Vec<Row>,
}

impl MeasuredTest {
    fn push(&self) -> Push {
        Push {
            initial_pressure_pa: self.initial_pressure_pa,
            initial_position_m: self.initial_stroke_m,
            final_position_m: self.final_stroke_m,
        }
    }

    fn regression(&self) -> Regression {
        Regression {
            final_pressure_pa: self.final_pressure_pa.0,
            pressure_rise_pa: self.pressure_rise_pa.0,
            time_constant_s: self.time_constant_s.0,
        }
    }

    fn uncertainty(&self, ambient_temperature_k: f64) -> Uncertainty {
        let deviations = [self.final_pressure_pa.1, self.pressure_rise_pa.1, self.time_constant_s.1];
        Uncertainty {
            regression: Matrix3::from_diagonal(&Vector3::from(deviations.map(|d| d * d))),
            initial_pressure_pa: self.initial_pressure_rounding_pa,
            ambient_temperature_k,
            quantile_95: NORMAL_95,
        }
    }

    /// Steps with intervals from the printed digits, for an ambient temperature, K, and its standard error, K.
    fn steps(&self, ambient_k: f64, error_k: f64) -> Result<Steps<Estimate>, Error> {
        let setup = Setup::air(self.bore_m, ambient_k);
        steps_with_intervals(&setup, &self.push(), &self.regression(), &self.uncertainty(error_k))
    }
}

/// Infers Tamb from tables 2 to 4.
///
/// # Errors
/// If the tables are inconsistent.
pub fn ambient_temperature(tests: &[MeasuredTest]) -> Result<AmbientTemperature, Error> {
    const GUESS_K: f64 = 300.0;
    let table = Table::parse(TABLE_4)?;
    // For each printed number, the Tamb it implies and that number's relative standard deviation.
    let mut asked: Vec<(f64, f64)> = Vec::new();
    let (mut by_mean_temperature_k, mut by_mass_k) = (Vec::new(), Vec::new());
    for test in tests {
        let row = row_of(&table, &test.experiment, &test.actuator)?;
        let ours = test.steps(GUESS_K, 0.0)?;
        let mut ask = |column: &str, ours: Estimate, power: i32| -> Result<f64, Error> {
            let printed = table.number(row, column)?;
            let rounding = rounding_deviation(table.last_place(row, column)?) / printed;
            let inputs = (ours.ci95[1] - ours.value) / NORMAL_95 / ours.value;
            let temperature = GUESS_K * (printed / ours.value).powi(power);
            asked.push((temperature, rounding.hypot(inputs)));
            Ok(temperature)
        };
        by_mean_temperature_k.push(ask("temperature_av_k", ours.temperature_av_k, 1)?);
        by_mass_k.push(ask("mass_kg", ours.mass_kg, -1)?);
    }
    // Mean of ln Tamb.
    let weights: f64 = asked.iter().map(|(_, s)| s.powi(-2)).sum();
    let mean = asked.iter().map(|(t, s)| t.ln() / (s * s)).sum::<f64>() / weights;
    let freedom = tests.len() as f64 - 1.0;
    let chi2: f64 = asked.iter().map(|(t, s)| ((t.ln() - mean) / s).powi(2)).sum();
    let scatter = (chi2 / freedom).sqrt();
    let value = mean.exp();
    let standard_error_k = value * weights.powf(-0.5) * scatter.max(1.0);
    let quantile = student_95(freedom);
    Ok(AmbientTemperature {
        temperature_k: Estimate::new(value, standard_error_k, quantile),
        standard_error_k,
        scatter_over_rounding: scatter,
        by_mean_temperature_k,
        by_mass_k,
    })
}

/// Evaluates the six tests at the inferred ambient temperature.
///
/// # Errors
/// If the tables are inconsistent.
pub fn reproduce() -> Result<Measured, Error> {
    let tests = measured_tests()?;
    let ambient = ambient_temperature(&tests)?;
    let rows = tests
        .into_iter()
        .map(|test| {
            let setup = Setup::air(test.bore_m, ambient.temperature_k.value);
            let steps = test.steps(ambient.temperature_k.value, ambient.standard_error_k)?;
            let exact = |hold: f64| -> Result<f64, Error> {
                let (pf, rate) = exact_regression::decay_of_regression(&test.regression(), hold)?;
                let ambient_k = setup.ambient_temperature_k;
                Ok(exact_regression::quantities(&setup, ambient_k, &test.push(), pf, rate).coefficient_0_w_per_m2_k)
            };
            let exact_coefficient_0_w_per_m2_k = [exact(5.0)?, exact(10.0)?];
            Ok(Row { test, setup, steps, exact_coefficient_0_w_per_m2_k })
        })
        .collect::<Result<_, Error>>()?;
    Ok(Measured { ambient, rows })
}

impl Row {
    /// V/Aq at the final stroke, m.
    pub fn volume_to_area_m(&self) -> f64 {
        self.steps.final_volume_m3.value / self.steps.area_m2.value
    }

    /// Our value for a column of tables 4 and 5, in that column's unit.
    pub fn column(&self, name: &str) -> Option<f64> {
        let s = &self.steps;
        Some(match name {
            "mass_kg" => s.mass_kg.value,
            "area_m2" => s.area_m2.value,
            "dead_volume_m3" => s.dead_volume_m3.value,
            "conductance_av_w_per_k" => s.conductance_av_w_per_k.value,
            "pressure_av_bar" => s.pressure_av_pa.value * 1e-5,
            "temperature_av_k" => s.temperature_av_k.value,
            "coefficient_av_w_per_m2_k" => s.coefficient_av_w_per_m2_k.value,
            "coefficient_0_w_per_m2_k" => s.coefficient_0_w_per_m2_k.value,
            "conductance_0_w_per_k" => s.conductance_0_w_per_k.value,
            "final_volume_m3" => s.final_volume_m3.value,
            "volume_to_area_mm" => self.volume_to_area_m() * 1e3,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::TABLE_5;
    use crate::time_constant::steps;

    fn each_number(source: (&'static str, &str), mut check: impl FnMut(&str, f64, f64, f64)) {
        let table = Table::parse(source).unwrap();
        let measured = reproduce().unwrap();
        let mut seen = 0;
        for row in &measured.rows {
            let at = row_of(&table, &row.test.experiment, &row.test.actuator).unwrap();
            for column in table.columns.iter().skip(2) {
                let ours = row.column(column).unwrap_or_else(|| panic!("{column}"));
                let printed = table.number(at, column).unwrap();
                check(column, ours, printed, 0.5 * table.last_place(at, column).unwrap());
                seen += 1;
            }
        }
        assert_eq!(seen, 6 * (table.columns.len() - 2));
    }

    #[test]
    fn tables_4_and_5_follow_from_tables_1_to_3() {
        for source in [TABLE_4, TABLE_5] {
            each_number(source, |column, ours, printed, half_digit| {
                let allowed = match column {
                    "coefficient_av_w_per_m2_k" | "coefficient_0_w_per_m2_k" => 0.015 * printed,
                    _ => half_digit + 0.03 * printed,
                };
                assert!((ours - printed).abs() < allowed, "{column}: {ours} {printed}");
            });
        }
    }

    #[test]
    fn the_inferred_ambient_temperature_is_near_298_kelvin_and_has_an_uncertainty() {
        let ambient = ambient_temperature(&measured_tests().unwrap()).unwrap();
        let t = ambient.temperature_k;
        assert!((t.value - chamber::paper::EXPERIMENTS_AMBIENT_TEMPERATURE_K).abs() < 1.5, "{t:?}");
        assert!(t.ci95[0] > 296.0 && t.ci95[1] < 301.5 && t.ci95[1] - t.ci95[0] > 1.0, "{t:?}");
    }

    #[test]
    fn at_293_kelvin_the_coefficients_do_not_reproduce() {
        let table = Table::parse(TABLE_4).unwrap();
        for row in reproduce().unwrap().rows {
            let at = row_of(&table, &row.test.experiment, &row.test.actuator).unwrap();
            let printed = table.number(at, "coefficient_0_w_per_m2_k").unwrap();
            let at_293 = steps(&row.setup, 293.0, &row.test.push(), &row.test.regression());
            assert!(at_293.coefficient_0_w_per_m2_k / printed > 1.02);
        }
    }

    #[test]
    fn the_exact_decay_of_a_printed_regression_is_slower_than_that_of_the_paper_s_steps() {
        for row in reproduce().unwrap().rows {
            let published = row.steps.coefficient_0_w_per_m2_k.value;
            let [five, ten] = row.exact_coefficient_0_w_per_m2_k;
            assert!(five < published && five > 0.93 * published, "{five} {published}");
            assert!((ten / five - 1.0).abs() < 0.02, "{five} {ten}");
        }
    }
}
