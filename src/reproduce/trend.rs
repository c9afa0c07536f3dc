//! The trend of table 5 as a section of the report, from the studies' rows.

use super::figures;
use super::studies::{Law, TrendPoint};
use anyhow::Result;
use paper::measured::Measured;
use records::Model;
use report::{Block, Section, Table, digits, percent};

/// The section of the report; `studied` with the column length in λ, `flat` with a single λ0.
///
/// # Errors
/// If a drawing fails.
pub fn section(
    measured: &Measured,
    models: [&Model; 2],
    studied: &[TrendPoint],
    flat: &[TrendPoint],
) -> Result<Section> {
    let mut section = Section::new("The trend of table 5: λ0 falls with volume over area");
    let [column, one] = models.map(|m| m.chamber.heat_transfer.coefficient);
    section.text(format!(
        "Table 5 orders the tests by V/A and finds that λ0 falls, with almost no difference between the two pressures. A study of \
         the same test with {} rows over bore, stroke and pressure shows the reason. V/A can vary in two ways. \
         With λ = {} W/(m² K) · √(P T/(P0 T0)) · (l/0.1 m)^(−1/2), the paper's steps give a λ0 that falls along the curve of each bore, equally \
         for all pressures, because a longer gas column has a larger V/A (left). At a given column length a wider bore also has a larger V/A, \
         but λ0 does not change (right). A second study with one λ0 = {} W/(m² K) is flat in both directions. So V/A itself is not the \
         cause: the six points follow the lengths of their gas columns. The coefficients are those of the exact decay behind each printed \
         regression (geometric mean of six).",
        studied.len(),
        digits(column, 4),
        digits(one, 4),
    ));
    section.blocks.push(Block::Figure {
        file: "lambda0_trend.svg",
        svg: figures::trend::draw(measured, studied, flat)?,
        caption: "λ0 by the paper's steps against V/A at the final stroke. Left: longer columns at each bore. Right: wider bores at each \
                  column length. Lines: rows of the two studies. Points: table 5 (hollow: from 1 bar, filled: from 3 bar)."
            .to_owned(),
    });
    let mut table = Table::new(&["study", "rows", "λ0, W/(m² K)", "spread between pressures", "bias of the steps"]);
    for (law, points, coefficient) in [(Law::Column, studied, column), (Law::Flat, flat, one)] {
        let all = points.iter().map(|p| p.coefficient_0_w_per_m2_k);
        let (low, high) = (all.clone().fold(f64::MAX, f64::min), all.fold(f64::MIN, f64::max));
        let bias = match law {
            Law::Flat => format!("{} to {}", percent(low / coefficient - 1.0, 1), percent(high / coefficient - 1.0, 1)),
            Law::Column => "–".to_owned(),
        };
        table.row([
            format!("`{}.parquet`", law.study()),
            points.len().to_string(),
            format!("{} to {}", digits(low, 3), digits(high, 3)),
            percent(spread_between_pressures(points), 2),
            bias,
        ]);
    }
    section.table(table);
    section.text(
        "All rows have the same proportions (final stroke half the initial one, a push of one time constant, a hold of ten), so that \
         the bias of the paper's fit in the last column adds no trend. The remaining spread between pressures is due to the sampling at \
         100 Hz: a shorter time constant has fewer rows. `pneutherm sweep table5_sweep.toml -o DIR` in this folder repeats the study.",
    );
    Ok(section)
}

/// Largest relative difference of λ0 between pressures at one bore and stroke.
fn spread_between_pressures(points: &[TrendPoint]) -> f64 {
    let mut largest = 0.0_f64;
    for p in points {
        let same =
            |q: &&TrendPoint| q.bore_m == p.bore_m && (q.volume_to_area_m / p.volume_to_area_m - 1.0).abs() < 1e-9;
        for q in points.iter().filter(same) {
            largest = largest.max((q.coefficient_0_w_per_m2_k / p.coefficient_0_w_per_m2_k - 1.0).abs());
        }
    }
    largest
}
