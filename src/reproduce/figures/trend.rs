//! λ0 against volume/area in its two variants, by column length at each bore and by bore at each length: the studies' rows as
//! curves, with the paper's six points.

use super::WIDTH;
use crate::reproduce::studies::TrendPoint;
use anyhow::Result;
use paper::measured::{Measured, Row};
use paper::tables::{TABLE_5, Table, row_of};
use report::{Axis, Chart, Colour, Mark, Series, chart};

const MM: f64 = 1e3;
/// Range of the figure: V/A, mm, and λ0, W/(m² K). It contains all six points.
const X_MM: (f64, f64) = (2.0, 10.0);
const Y: (f64, f64) = (10.0, 70.0);
/// Bores of the paper's actuators, m, and their colours.
const OF_THE_PAPER: [(f64, Colour); 2] = [(0.020, Colour::After), (0.032, Colour::Before)];
/// The paper's actuators: name, colour, legend text.
const ACTUATORS: [(&str, Colour, &str); 3] =
    [("A", Colour::After, "A, 20 mm"), ("B", Colour::Before, "B, 32 mm"), ("C", Colour::Before, "C, 32 mm")];
/// Smallest logarithm of the ratio of two lengths that are both drawn.
const APART: f64 = 0.45;

/// The figure as SVG: `studied` with the column's length in λ, `flat` with one λ0.
///
/// # Errors
/// If a point of table 5 is missing or a drawing fails.
pub fn draw(measured: &Measured, studied: &[TrendPoint], flat: &[TrendPoint]) -> Result<String> {
    let points = points_of_the_paper(measured)?;
    let panel = |title, y, series, texts| Chart {
        title,
        x: Axis::new("V/A at the final stroke, mm").over(X_MM.0, X_MM.1),
        y: Axis::new(y).over(Y.0, Y.1),
        series,
        texts,
        size: (WIDTH / 2, 420),
        ..Chart::default()
    };
    let [low, high] = pressures(studied);
    let [from_low, from_high] = [low, high].map(|pressure| format!("from {:.1} bar", pressure * 1e-5));
    let (mut series, mut texts) = (Vec::new(), Vec::new());
    for (k, bore) in distinct(studied.iter().map(|p| p.bore_m)).into_iter().enumerate() {
        let colour = OF_THE_PAPER.iter().find(|(b, _)| *b == bore).map_or(Colour::Pale, |(_, c)| *c);
        let curves = [low, high].map(|pressure| curve(studied, pressure, |p| p.bore_m == bore));
        texts.extend(curves[0].first().map(|(x, y)| (*x, *y, format!("{:.0}", bore * MM))));
        let label = |text| if k == 0 { text } else { "" };
        let [of_low, of_high] = curves;
        series.push(Series { points: of_low, colour, label: label(&from_low), mark: Mark::Beneath(6.0) });
        series.push(Series { points: of_high, colour, label: label(&from_high), mark: Mark::Line(1.6) });
    }
    series.push(Series { label: "one λ0", ..one_coefficient(flat) });
    series.extend(points.iter().map(|point| Series { label: "", ..point.series.clone() }));
    let by_length = panel("Longer columns at each bore, mm", "λ0 by the paper's steps, W/(m² K)", series, texts);

    let (mut series, mut texts) = (Vec::new(), Vec::new());
    for length in lengths(studied, &points) {
        let near = |point: &&OfThePaper| (point.column_m / length).ln().abs() < 0.1;
        let colour = points.iter().find(near).map_or(Colour::Pale, |point| point.series.colour);
        let line = curve(studied, high, |p| p.column_m == length);
        texts.extend(line.first().map(|(x, y)| (*x, *y, format!("{:.0}", length * MM))));
        series.push(Series { points: line, colour, label: "", mark: Mark::Line(1.6) });
    }
    series.push(one_coefficient(flat));
    series.extend(points.into_iter().map(|point| point.series));
    let by_bore = panel("Wider bores at each length of the column, mm", "", series, texts);
    Ok(chart::sheet("", &[by_length, by_bore], 2)?)
}

/// A point of table 5 in the figure.
struct OfThePaper {
    actuator: &'static str,
    /// Length of its gas column, m.
    column_m: f64,
    series: Series<'static>,
}

/// The six points of table 5; those from 1 bar are hollow.
fn points_of_the_paper(measured: &Measured) -> Result<Vec<OfThePaper>> {
    let table = Table::parse(TABLE_5)?;
    let mut points = Vec::new();
    for (actuator, colour, label) in ACTUATORS {
        for row in measured.rows.iter().filter(|row| row.test.actuator == actuator) {
            let at = row_of(&table, &row.test.experiment, actuator)?;
            let point = (table.number(at, "volume_to_area_mm")?, table.number(at, "coefficient_0_w_per_m2_k")?);
            let filled = row.test.experiment != "1";
            let label = if filled { label } else { "" };
            let series = Series { points: vec![point], colour, label, mark: marker(actuator, filled) };
            points.push(OfThePaper { actuator, column_m: column_of(row), series });
        }
    }
    Ok(points)
}

/// Length of a test's gas column, m.
fn column_of(row: &Row) -> f64 {
    row.steps.final_volume_m3.value / row.setup.geometry.piston_area
}

fn marker(actuator: &str, filled: bool) -> Mark {
    match (actuator, filled) {
        ("A", true) => Mark::Dots(5.0),
        ("A", false) => Mark::Rings(5.0),
        ("B", _) => Mark::Squares(4.5, filled),
        _ => Mark::Diamonds(6.0, filled),
    }
}

/// The rows of the study with one λ0, all bores and pressures.
fn one_coefficient(flat: &[TrendPoint]) -> Series<'static> {
    let mut points: Vec<(f64, f64)> = flat.iter().map(figure_point).filter(inside).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Thinned: a dashed line through hundreds of closely spaced points would lose its dashes.
    let points = points.iter().copied().step_by(points.len().div_ceil(60).max(1)).collect();
    Series { points, colour: Colour::Ink, label: "", mark: Mark::Dashed(1.6) }
}

/// A row in the figure's units.
fn figure_point(point: &TrendPoint) -> (f64, f64) {
    (point.volume_to_area_m * MM, point.coefficient_0_w_per_m2_k)
}

fn inside((x, y): &(f64, f64)) -> bool {
    (X_MM.0..=X_MM.1).contains(x) && (Y.0..=Y.1).contains(y)
}

/// The curve of selected rows at one pressure, within the figure.
fn curve(points: &[TrendPoint], pressure_pa: f64, of: impl Fn(&TrendPoint) -> bool) -> Vec<(f64, f64)> {
    let own = points.iter().filter(|p| p.initial_pressure_pa == pressure_pa && of(p));
    let mut curve: Vec<(f64, f64)> = own.map(figure_point).filter(inside).collect();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve
}

/// Column lengths of the study drawn as lines, m: the nearest to each actuator's, and others sufficiently far apart.
fn lengths(studied: &[TrendPoint], points: &[OfThePaper]) -> Vec<f64> {
    let all = distinct(studied.iter().map(|p| p.column_m));
    let far = |length: f64, other: f64| (length / other).ln().abs();
    let mut drawn = Vec::new();
    for (actuator, ..) in ACTUATORS {
        let own = points.iter().filter(|point| point.actuator == actuator).map(|point| point.column_m.ln());
        let mean = (own.clone().sum::<f64>() / own.count() as f64).exp();
        drawn.extend(all.iter().copied().min_by(|a, b| far(*a, mean).total_cmp(&far(*b, mean))));
    }
    for length in all.iter().copied() {
        if drawn.iter().all(|other| far(length, *other) > APART) {
            drawn.push(length);
        }
    }
    distinct(drawn.into_iter())
}

/// Sorted, without duplicates.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Lowest and highest initial pressure of the study, Pa.
fn pressures(points: &[TrendPoint]) -> [f64; 2] {
    points
        .iter()
        .fold([f64::MAX, f64::MIN], |[low, high], p| [low.min(p.initial_pressure_pa), high.max(p.initial_pressure_pa)])
}
