//! λ0 against volume/area: the studies' rows as curves for each bore and pressure, the paper's six points on them.

use super::WIDTH;
use crate::reproduce::studies::TrendPoint;
use anyhow::Result;
use paper::measured::Measured;
use paper::tables::{TABLE_5, Table, row_of};
use report::{Axis, Chart, Colour, Mark, Series};

const MM: f64 = 1e3;
/// Bores of the paper's actuators, m, and their colours.
const OF_THE_PAPER: [(f64, Colour); 2] = [(0.020, Colour::After), (0.032, Colour::Before)];
/// The paper's actuators: name, colour, what the legend says.
const ACTUATORS: [(&str, Colour, &str); 3] = [
    ("A", Colour::After, "paper, actuator A, bore 20 mm (hollow: from 1 bar)"),
    ("B", Colour::Before, "paper, actuator B, bore 32 mm (hollow: from 1 bar)"),
    ("C", Colour::Before, "paper, actuator C, bore 32 mm (hollow: from 1 bar)"),
];

/// The figure as SVG: `studied` with the column's length in λ, `flat` with one λ0.
pub fn draw(measured: &Measured, studied: &[TrendPoint], flat: &[TrendPoint]) -> Result<String> {
    let table = Table::parse(TABLE_5)?;
    let [low, high] = pressures(studied);
    let from_low = format!("study, λ ∝ √(PT) l^(−1/2), from {:.1} bar; bore at the line", low * 1e-5);
    let from_high = format!("the same from {:.1} bar", high * 1e-5);
    let (mut series, mut texts) = (Vec::new(), Vec::new());
    for (k, bore) in bores(studied).into_iter().enumerate() {
        let colour = OF_THE_PAPER.iter().find(|(b, _)| *b == bore).map_or(Colour::Pale, |(_, c)| *c);
        let line = curve(studied, bore, low);
        texts.extend(line.first().map(|(x, y)| (*x, *y, format!("{:.0} mm", bore * MM))));
        let label = |text| if k == 0 { text } else { "" };
        let points = curve(studied, bore, high);
        series.push(Series { points: line, colour, label: label(from_low.as_str()), mark: Mark::Beneath(6.0) });
        series.push(Series { points, colour, label: label(from_high.as_str()), mark: Mark::Line(1.6) });
    }
    let mut all: Vec<(f64, f64)> = flat.iter().map(|p| (p.volume_to_area_m * MM, p.coefficient_0_w_per_m2_k)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    series.push(Series {
        // Thinned: a dashed line through hundreds of points a pixel apart would lose its dashes.
        points: all.iter().copied().step_by(all.len().div_ceil(60).max(1)).collect(),
        colour: Colour::Ink,
        label: "study with one λ0: every bore and pressure",
        mark: Mark::Dashed(1.6),
    });
    for (actuator, colour, label) in ACTUATORS {
        for row in measured.rows.iter().filter(|r| r.test.actuator == actuator) {
            let at = row_of(&table, &row.test.experiment, actuator)?;
            let point = (table.number(at, "volume_to_area_mm")?, table.number(at, "coefficient_0_w_per_m2_k")?);
            let filled = row.test.experiment != "1";
            series.push(Series {
                points: vec![point],
                colour,
                label: if filled { label } else { "" },
                mark: marker(actuator, filled),
            });
        }
    }
    let chart = Chart {
        title: "λ0 by the paper's steps, against volume over area",
        x: Axis::new("V/A at the final stroke, mm").over(2.0, 10.0),
        y: Axis::new("λ0, W/(m² K)").over(0.0, 100.0),
        series,
        texts,
        size: (WIDTH, 540),
        ..Chart::default()
    };
    Ok(chart.draw()?)
}

fn marker(actuator: &str, filled: bool) -> Mark {
    match (actuator, filled) {
        ("A", true) => Mark::Dots(5.0),
        ("A", false) => Mark::Rings(5.0),
        ("B", _) => Mark::Squares(4.5, filled),
        _ => Mark::Diamonds(6.0, filled),
    }
}

/// The curve of one bore and pressure, in the figure's units.
fn curve(points: &[TrendPoint], bore_m: f64, pressure_pa: f64) -> Vec<(f64, f64)> {
    let own = points.iter().filter(|p| p.bore_m == bore_m && p.initial_pressure_pa == pressure_pa);
    let mut curve: Vec<(f64, f64)> = own.map(|p| (p.volume_to_area_m * MM, p.coefficient_0_w_per_m2_k)).collect();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve
}

/// Bores of the study whose curves fit the figure, m.
fn bores(points: &[TrendPoint]) -> Vec<f64> {
    let mut bores: Vec<f64> = points.iter().map(|p| p.bore_m).filter(|b| (0.012..=0.040).contains(b)).collect();
    bores.sort_by(f64::total_cmp);
    bores.dedup();
    bores
}

/// Lowest and highest initial pressure of the study, Pa.
fn pressures(points: &[TrendPoint]) -> [f64; 2] {
    points
        .iter()
        .fold([f64::MAX, f64::MIN], |[low, high], p| [low.min(p.initial_pressure_pa), high.max(p.initial_pressure_pa)])
}
