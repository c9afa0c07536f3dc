//! λ0 against volume/area: the studies' rows as curves for each bore and pressure, the paper's six points on them.

use super::{BLUE, GRID, INK, VERMILION, axis_style, beside, centred, drawing, failed, label_style, title_style};
use crate::reproduce::studies::TrendPoint;
use anyhow::Result;
use paper::measured::Measured;
use paper::tables::{TABLE_5, Table, row_of};
use plotters::prelude::*;

const MM: f64 = 1e3;
/// Bores of the paper's actuators, m, and their colours.
const OF_THE_PAPER: [(f64, RGBColor); 2] = [(0.020, BLUE), (0.032, VERMILION)];
/// The paper's actuators: name, bore in mm, colour, marker.
const ACTUATORS: [(&str, u32, RGBColor, Marker); 3] =
    [("A", 20, BLUE, Marker::Circle), ("B", 32, VERMILION, Marker::Square), ("C", 32, VERMILION, Marker::Diamond)];

/// Shape of a marker.
#[derive(Clone, Copy)]
enum Marker {
    Circle,
    Square,
    Diamond,
}

/// The figure as SVG: `studied` with the column's length in λ, `flat` with one λ0.
pub fn draw(measured: &Measured, studied: &[TrendPoint], flat: &[TrendPoint]) -> Result<String> {
    let table = Table::parse(TABLE_5)?;
    let [low, high] = pressures(studied);
    drawing(600, |root| {
        let mut chart = ChartBuilder::on(root)
            .margin(12)
            .margin_right(20)
            .caption("λ0 by the paper's steps, against volume over area", title_style())
            .x_label_area_size(52)
            .y_label_area_size(70)
            .build_cartesian_2d(2.0..10.0, 0.0..100.0)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .x_desc("V/A at the final stroke, mm")
            .y_desc("λ0, W/(m² K)")
            .axis_desc_style(axis_style())
            .label_style(label_style())
            .x_label_formatter(&|v| format!("{v}"))
            .y_label_formatter(&|v| format!("{v}"))
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(INK)
            .draw()
            .map_err(failed)?;
        let mut named = Vec::new();
        for bore in bores(studied) {
            let colour = OF_THE_PAPER.iter().find(|(b, _)| *b == bore).map_or(INK.mix(0.6), |(_, c)| c.mix(1.0));
            let line = curve(studied, bore, low);
            named.push((chart.backend_coord(&line[0]), format!("{:.0} mm", bore * MM)));
            chart.draw_series(LineSeries::new(line, colour.mix(0.35).stroke_width(7))).map_err(failed)?;
            chart.draw_series(LineSeries::new(curve(studied, bore, high), colour.stroke_width(2))).map_err(failed)?;
        }
        let mut all: Vec<(f64, f64)> =
            flat.iter().map(|p| (p.volume_to_area_m * MM, p.coefficient_0_w_per_m2_k)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Thinned: a dashed line through hundreds of points a pixel apart would lose its dashes.
        let thinned: Vec<(f64, f64)> = all.iter().copied().step_by(all.len().div_ceil(60)).collect();
        chart.draw_series(DashedLineSeries::new(thinned, 9, 6, INK.stroke_width(2))).map_err(failed)?;
        for ((x, y), name) in named {
            root.draw(&Text::new(name, (x, y - 12), centred())).map_err(failed)?;
        }
        legend(root, [low, high])?;
        for (actuator, _, colour, marker) in ACTUATORS {
            for row in measured.rows.iter().filter(|r| r.test.actuator == actuator) {
                let at = row_of(&table, &row.test.experiment, actuator)?;
                let point = (table.number(at, "volume_to_area_mm")?, table.number(at, "coefficient_0_w_per_m2_k")?);
                let fill = if row.test.experiment == "1" { WHITE } else { colour };
                draw_marker(root, marker, chart.backend_coord(&point), fill)?;
            }
        }
        Ok(())
    })
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// Says what lines and markers are, in the empty upper right.
fn legend(root: &Area<'_>, [low, high]: [f64; 2]) -> Result<()> {
    let (x, mut y) = (470, 64);
    let line =
        |y: i32, style: ShapeStyle| root.draw(&PathElement::new([(x - 14, y), (x + 14, y)], style)).map_err(failed);
    let text = |y: i32, text: String| root.draw(&Text::new(text, (x + 28, y), beside())).map_err(failed);
    line(y, INK.mix(0.3).stroke_width(7))?;
    text(y, format!("study, λ ∝ √(PT) l^(−1/2), from {:.1} bar; bore at the line", low * 1e-5))?;
    y += 22;
    line(y, INK.stroke_width(2))?;
    text(y, format!("the same from {:.1} bar", high * 1e-5))?;
    y += 22;
    line(y, INK.stroke_width(2))?;
    root.draw(&PathElement::new([(x - 4, y), (x + 4, y)], WHITE.stroke_width(4))).map_err(failed)?;
    text(y, "study with one λ0: every bore and pressure".to_owned())?;
    for (actuator, bore, colour, marker) in ACTUATORS {
        y += 24;
        draw_marker(root, marker, (x - 10, y), WHITE)?;
        draw_marker(root, marker, (x + 10, y), colour)?;
        text(y, format!("paper, actuator {actuator}, bore {bore} mm: from 1 bar, from 3 bar"))?;
    }
    Ok(())
}

fn draw_marker(root: &Area<'_>, marker: Marker, at: (i32, i32), fill: RGBColor) -> Result<()> {
    let mut edge = outline(marker, at);
    root.draw(&Polygon::new(edge.clone(), fill.filled())).map_err(failed)?;
    edge.push(edge[0]);
    root.draw(&PathElement::new(edge, INK.stroke_width(2))).map_err(failed)
}

/// Outline of a marker round a pixel.
fn outline(marker: Marker, (x, y): (i32, i32)) -> Vec<(i32, i32)> {
    match marker {
        Marker::Circle => (0..24)
            .map(|i| {
                let angle = f64::from(i) * core::f64::consts::PI / 12.0;
                (x + (7.0 * angle.cos()).round() as i32, y + (7.0 * angle.sin()).round() as i32)
            })
            .collect(),
        Marker::Square => vec![(x - 6, y - 6), (x + 6, y - 6), (x + 6, y + 6), (x - 6, y + 6)],
        Marker::Diamond => vec![(x, y - 8), (x + 8, y), (x, y + 8), (x - 8, y)],
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
