//! Tables 4 and 5 as CSV, with our values beside the paper's, and as a section of the report.

use anyhow::{Context, Result};
use paper::measured::Measured;
use paper::tables::{self, TABLE_4, TABLE_5};
use report::{Section, Table, digits, signed_percent};

/// Table 4 as CSV.
///
/// # Errors
/// If an embedded table is damaged.
pub fn table4(measured: &Measured) -> Result<String> {
    beside(&tables::Table::parse(TABLE_4)?, measured)
}

/// Table 5 as CSV.
///
/// # Errors
/// If an embedded table is damaged.
pub fn table5(measured: &Measured) -> Result<String> {
    beside(&tables::Table::parse(TABLE_5)?, measured)
}

/// Each computed column followed by our values (`_ours`) and the relative difference (`_difference`).
fn beside(paper: &tables::Table, measured: &Measured) -> Result<String> {
    let mut head = Vec::new();
    for (i, column) in paper.columns.iter().enumerate() {
        head.push(column.clone());
        if i >= KEYS {
            head.extend([format!("{column}_ours"), format!("{column}_difference")]);
        }
    }
    let mut out = head.join(",") + "\n";
    for row in 0..paper.rows.len() {
        let cells = row_beside(paper, measured, row)?;
        out.push_str(&(cells.join(",") + "\n"));
    }
    Ok(out)
}

/// Number of columns that identify a row: experiment and actuator.
const KEYS: usize = 2;

fn row_beside(paper: &tables::Table, measured: &Measured, row: usize) -> Result<Vec<String>> {
    let ours = row_of(measured, paper.text(row, "experiment")?, paper.text(row, "actuator")?)?;
    let mut cells = Vec::new();
    for (i, column) in paper.columns.iter().enumerate() {
        cells.push(paper.text(row, column)?.to_owned());
        if i >= KEYS {
            let value = ours.column(column).with_context(|| format!("`{column}` of {} is not computed", paper.name))?;
            cells.extend([digits(value, 5), format!("{:.4}", value / paper.number(row, column)? - 1.0)]);
        }
    }
    Ok(cells)
}

fn row_of<'a>(measured: &'a Measured, experiment: &str, actuator: &str) -> Result<&'a paper::measured::Row> {
    let found = measured.rows.iter().find(|r| r.test.experiment == experiment && r.test.actuator == actuator);
    found.with_context(|| format!("no measured test for experiment {experiment}, actuator {actuator}"))
}

/// The section of the report.
///
/// # Errors
/// If an embedded table is damaged.
pub fn section(measured: &Measured) -> Result<Section> {
    let mut section = Section::new("Tables 4 and 5: six measured tests");
    let t = &measured.ambient.temperature_k;
    section.text(format!(
        "The steps are applied to the regressions of table 3. The paper does not state the ambient temperature. We infer one \
         temperature for all six tests by least squares from the mean temperatures and masses of table 4, which depend on it: \
         {} K, with a 95 % interval of {} to {} K. The weights follow from the printed digits. The tests scatter {} times as much as \
         the digits allow, probably because the room temperature varied, and the interval is widened by this factor. Dead volumes, areas and mean \
         pressures do not depend on the ambient temperature.",
        digits(t.value, 4),
        digits(t.ci95[0], 4),
        digits(t.ci95[1], 4),
        digits(measured.ambient.scatter_over_rounding, 2),
    ));
    section.table(coefficients(measured)?);
    section.text(
        "The 95 % intervals propagate the printed digits of tables 2 and 3 and the inferred temperature through the steps. They do \
         not include the bias of the method. The last two columns remove this bias: they give λ0 of the exact decay whose regression by an \
         exponential is the printed one, for assumed holds of 5 and of 10 time constants. All columns of both tables are in \
         `table4.csv` and `table5.csv`.",
    );
    section.table(largest_differences(measured)?);
    Ok(section)
}

fn coefficients(measured: &Measured) -> Result<Table> {
    let paper = tables::Table::parse(TABLE_4)?;
    let mut table = Table::new(&[
        "test", "V/A, mm", "λav paper, W/(m² K)", "λav ours", "difference", "λ0 paper, W/(m² K)", "λ0 ours",
        "difference", "95 % interval", "λ0 exact, 5 τ", "λ0 exact, 10 τ",
    ]);
    for row in 0..paper.rows.len() {
        let ours = row_of(measured, paper.text(row, "experiment")?, paper.text(row, "actuator")?)?;
        let s = &ours.steps;
        let (average, reference) = (s.coefficient_av_w_per_m2_k, s.coefficient_0_w_per_m2_k);
        let printed_average = paper.number(row, "coefficient_av_w_per_m2_k")?;
        let printed_reference = paper.number(row, "coefficient_0_w_per_m2_k")?;
        let [five, ten] = ours.exact_coefficient_0_w_per_m2_k;
        table.row([
            format!("{}{}", ours.test.experiment, ours.test.actuator),
            digits(ours.volume_to_area_m() * 1e3, 3),
            digits(printed_average, 3),
            digits(average.value, 4),
            signed_percent(average.value / printed_average - 1.0, 1),
            digits(printed_reference, 3),
            digits(reference.value, 4),
            signed_percent(reference.value / printed_reference - 1.0, 1),
            format!("{} to {}", digits(reference.ci95[0], 3), digits(reference.ci95[1], 3)),
            digits(five, 4),
            digits(ten, 4),
        ]);
    }
    Ok(table)
}

/// The largest difference in each column, with the effect of half a unit of the last printed digit.
fn largest_differences(measured: &Measured) -> Result<Table> {
    let mut table = Table::new(&["column", "table", "largest difference", "rounding of the printed digits (that row)"]);
    for (name, source) in [("4", TABLE_4), ("5", TABLE_5)] {
        let paper = tables::Table::parse(source)?;
        for column in &paper.columns[KEYS..] {
            let (mut largest, mut open) = (0.0_f64, 0.0);
            for row in 0..paper.rows.len() {
                let ours = row_of(measured, paper.text(row, "experiment")?, paper.text(row, "actuator")?)?;
                let printed = paper.number(row, column)?;
                let difference = ours.column(column).context("a column is not computed")? / printed - 1.0;
                if difference.abs() > largest.abs() {
                    largest = difference;
                    open = 0.5 * paper.last_place(row, column)? / printed;
                }
            }
            let open = format!("±\u{a0}{:.1}\u{a0}%", 100.0 * open);
            table.row([format!("`{column}`"), name.to_owned(), signed_percent(largest, 1), open]);
        }
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_printed_number_stays_as_printed_and_has_ours_beside_it() {
        let measured = paper::measured::reproduce().unwrap();
        let text = table5(&measured).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 7);
        assert!(
            lines[0].starts_with("experiment,actuator,final_volume_m3,final_volume_m3_ours,final_volume_m3_difference")
        );
        assert!(lines[1].starts_with("1,A,2.45e-5,2.4712e-5,0.008"), "{}", lines[1]);
        assert!(lines.iter().all(|l| l.split(',').count() == 2 + 3 * 4));
        assert_eq!(table4(&measured).unwrap().lines().count(), 7);
    }
}
