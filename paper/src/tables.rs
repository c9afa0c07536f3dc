//! The paper's tables 1 to 5 and the quantities of its section 3.1, embedded as the CSV files of `paper/data`.

use super::Error;

/// An embedded table as printed: a header and rows of texts.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// File name of the table.
    pub name: &'static str,
    /// Names of the columns, with units.
    pub columns: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
}

/// Table 1: the actuators.
pub const TABLE_1: (&str, &str) = ("table1_actuators.csv", include_str!("../data/table1_actuators.csv"));
/// Table 2: the experiments.
const TABLE_2: (&str, &str) = ("table2_experiments.csv", include_str!("../data/table2_experiments.csv"));
/// Table 3: the regressions.
const TABLE_3: (&str, &str) = ("table3_regression.csv", include_str!("../data/table3_regression.csv"));
/// Table 4: results of the steps.
pub const TABLE_4: (&str, &str) = ("table4_heat_transfer.csv", include_str!("../data/table4_heat_transfer.csv"));
/// Table 5: λ0 over volume/area.
pub const TABLE_5: (&str, &str) = ("table5_trend.csv", include_str!("../data/table5_trend.csv"));
/// The simulated test of section 3.1.
pub const SECTION_31: (&str, &str) = ("section31_simulation.csv", include_str!("../data/section31_simulation.csv"));

impl Table {
    /// Parses an embedded file.
    ///
    /// # Errors
    /// Rows whose number of cells differs from the header's.
    pub fn parse((name, text): (&'static str, &str)) -> Result<Self, Error> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let unreadable = |e: csv::Error| Error::Table {
            table: name,
            line: e.position().map_or(1, |p| p.line() as usize),
            reason: e.to_string(),
        };
        let columns = reader.headers().map_err(unreadable)?.iter().map(str::to_owned).collect();
        let rows = reader
            .records()
            .map(|record| record.map(|r| r.iter().map(str::to_owned).collect()).map_err(unreadable))
            .collect::<Result<_, _>>()?;
        Ok(Self { name, columns, rows })
    }

    /// The text of a cell.
    ///
    /// # Errors
    /// If there is no such column.
    pub fn text(&self, row: usize, column: &str) -> Result<&str, Error> {
        let index = self.columns.iter().position(|c| c == column);
        index.and_then(|i| self.rows.get(row)?.get(i)).map(String::as_str).ok_or_else(|| Error::Table {
            table: self.name,
            line: row + 2,
            reason: format!("no column `{column}`"),
        })
    }

    /// The number in a cell.
    ///
    /// # Errors
    /// If there is no such column, or the text is no number.
    pub fn number(&self, row: usize, column: &str) -> Result<f64, Error> {
        let text = self.text(row, column)?;
        text.parse().map_err(|_| Error::Table {
            table: self.name,
            line: row + 2,
            reason: format!("`{text}` in column `{column}` is not a number"),
        })
    }

    /// The unit in the last place of a printed number.
    ///
    /// # Errors
    /// As [`Table::number`].
    pub fn last_place(&self, row: usize, column: &str) -> Result<f64, Error> {
        self.number(row, column)?;
        Ok(last_place(self.text(row, column)?))
    }
}

/// The unit in the last place of a printed number: 1e-6 for `39.2e-6` is 1e-7.
fn last_place(text: &str) -> f64 {
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, d)| d.len() as i32);
    10f64.powi(exponent.parse::<i32>().unwrap_or(0) - decimals)
}

/// One of the six measured tests, combined from tables 1, 2 and 3. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredTest {
    /// 1 near ambient pressure, 2 near 3 bar.
    pub experiment: String,
    /// A, B or C.
    pub actuator: String,
    /// Bore of the chamber, m.
    pub bore_m: f64,
    /// Absolute pressure before the push, Pa.
    pub initial_pressure_pa: f64,
    /// Position of the piston before the push, m, from the end of the chamber.
    pub initial_stroke_m: f64,
    /// Position of the piston after the push, m, from the end of the chamber.
    pub final_stroke_m: f64,
    /// Pf, Pa, and its standard deviation from the printed digits.
    pub final_pressure_pa: (f64, f64),
    /// ΔP, Pa, likewise.
    pub pressure_rise_pa: (f64, f64),
    /// τ, s, likewise.
    pub time_constant_s: (f64, f64),
    /// Standard deviation of the initial pressure from its printed digits, Pa.
    pub initial_pressure_rounding_pa: f64,
}

const BAR: f64 = 1e5;
const MILLIMETRE: f64 = 1e-3;

/// The six measured tests, in table 3's order.
///
/// # Errors
/// If the tables are inconsistent.
pub fn measured_tests() -> Result<Vec<MeasuredTest>, Error> {
    let conditions = Table::parse(TABLE_2)?;
    let regressions = Table::parse(TABLE_3)?;
    let printed = |row, column: &str, unit: f64| -> Result<(f64, f64), Error> {
        let deviation = super::statistics::rounding_deviation(regressions.last_place(row, column)?);
        Ok((regressions.number(row, column)? * unit, deviation * unit))
    };
    (0..regressions.rows.len())
        .map(|row| {
            let (experiment, actuator) = (regressions.text(row, "experiment")?, regressions.text(row, "actuator")?);
            let at = row_of(&conditions, experiment, actuator)?;
            Ok(MeasuredTest {
                experiment: experiment.to_owned(),
                actuator: actuator.to_owned(),
                bore_m: conditions.number(at, "bore1_mm")? * MILLIMETRE,
                initial_pressure_pa: conditions.number(at, "initial_pressure_bar")? * BAR,
                initial_stroke_m: conditions.number(at, "initial_stroke_mm")? * MILLIMETRE,
                final_stroke_m: conditions.number(at, "final_stroke_mm")? * MILLIMETRE,
                final_pressure_pa: printed(row, "final_pressure_bar", BAR)?,
                pressure_rise_pa: printed(row, "pressure_rise_bar", BAR)?,
                time_constant_s: printed(row, "time_constant_s", 1.0)?,
                initial_pressure_rounding_pa: super::statistics::rounding_deviation(
                    conditions.last_place(at, "initial_pressure_bar")? * BAR,
                ),
            })
        })
        .collect()
}

/// The row of that experiment and actuator.
///
/// # Errors
/// If there is no such row.
pub fn row_of(table: &Table, experiment: &str, actuator: &str) -> Result<usize, Error> {
    for row in 0..table.rows.len() {
        if table.text(row, "experiment")? == experiment && table.text(row, "actuator")? == actuator {
            return Ok(row);
        }
    }
    Err(Error::Table {
        table: table.name,
        line: 1,
        reason: format!("no row for experiment {experiment}, actuator {actuator}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_embedded_table_is_read() {
        for (source, rows) in [(TABLE_1, 3), (TABLE_2, 6), (TABLE_3, 6), (TABLE_4, 6), (TABLE_5, 6), (SECTION_31, 24)] {
            assert_eq!(Table::parse(source).unwrap().rows.len(), rows, "{}", source.0);
        }
        let tests = measured_tests().unwrap();
        assert_eq!(tests[2].bore_m, 0.032);
        assert!((tests[2].initial_stroke_m - 0.269).abs() < 1e-15);
        assert!((tests[5].final_pressure_pa.0 - 4.436e5).abs() < 1e-9);
    }

    #[test]
    fn the_last_place_of_a_printed_number_follows_from_its_text() {
        for (text, place) in [("39.2e-6", 1e-7), ("0.4292", 1e-4), ("30", 1.0), ("1e5", 1e5), ("1.6e-4", 1e-5)] {
            assert!((last_place(text) / place - 1.0).abs() < 1e-12, "{text}");
        }
    }

    #[test]
    fn a_missing_column_and_text_in_a_number_are_named_with_their_line() {
        let table = Table::parse(("x.csv", "a,b\n1,two\n")).unwrap();
        let error = table.number(0, "b").unwrap_err().to_string();
        assert!(error.contains("x.csv: line 2") && error.contains("two"), "{error}");
        assert!(table.number(0, "c").is_err());
    }
}
