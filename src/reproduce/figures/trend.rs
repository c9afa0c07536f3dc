//! λ0 against volume/area: the studies' rows as curves for each bore and pressure, the paper's six points on them.

use super::{BLUE, GREEN, GRID, INK, PURPLE, VERMILION, axis_style, drawing, failed, label_style, title_style};
use crate::reproduce::studies::TrendPoint;
use anyhow::Result;
use identify::paper::measured::Measured;
use identify::paper::tables::{TABLE_5, Table, row_of};
use plotters::prelude::*;

const MM: f64 = 1e3;

/// The figure as SVG: `studied` with the column's length in λ, `flat` with one λ0.
pub fn draw(measured: &Measured, studied: &[TrendPoint], flat: &[TrendPoint]) -> Result<String> {
    let table = Table::parse(TABLE_5)?;
    drawing(560, |root| {
        let mut chart = ChartBuilder::on(root)
            .margin(12)
            .margin_right(20)
            .caption("λ0 by the paper's steps, against volume over area", title_style())
            .x_label_area_size(52)
            .y_label_area_size(70)
            .build_cartesian_2d(2.0..9.0, 0.0..80.0)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .x_desc("V/A at the final stroke, mm")
            .y_desc("λ0, W/(m² K)")
            .axis_desc_style(axis_style())
            .label_style(label_style())
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(INK)
            .draw()
            .map_err(failed)?;
        for (bore, colour) in [(0.020, BLUE), (0.032, VERMILION)] {
            for (i, pressure) in pressures(studied).into_iter().enumerate() {
                let line = curve(studied, bore, pressure);
                let name = format!("bore {:.0} mm, {:.1} bar, λ ∝ √(PT) l^(−1/2)", bore * MM, pressure * 1e-5);
                let (width, legend_width) = (2 + 4 * (1 - i as u32), 3 + 3 * (1 - i as u32));
                let style = if i == 0 { colour.mix(0.35) } else { colour.mix(1.0) };
                chart
                    .draw_series(LineSeries::new(line, style.stroke_width(width)))
                    .map_err(failed)?
                    .label(name)
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style.stroke_width(legend_width)));
            }
        }
        let mut all: Vec<(f64, f64)> = flat.iter().map(|p| (p.volume_to_area_m * MM, p.coefficient_0)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        chart
            .draw_series(DashedLineSeries::new(all, 7, 5, INK.mix(0.7).stroke_width(2)))
            .map_err(failed)?
            .label("one λ0, every bore and pressure")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 24, y)], INK.mix(0.7).stroke_width(2)));
        for (actuator, colour, shape) in [("A", BLUE, 0), ("B", VERMILION, 1), ("C", GREEN, 2)] {
            let points: Vec<(f64, f64, bool)> = measured
                .rows
                .iter()
                .filter(|r| r.test.actuator == actuator)
                .map(|r| {
                    let row = row_of(&table, &r.test.experiment, actuator)?;
                    let (x, y) =
                        (table.number(row, "volume_to_area_mm")?, table.number(row, "coefficient_0_w_per_m2_k")?);
                    Ok((x, y, r.test.experiment == "1"))
                })
                .collect::<Result<_, identify::paper::Error>>()?;
            let colour = if shape == 2 { PURPLE } else { colour };
            chart
                .draw_series(points.iter().map(|(x, y, low)| marker((*x, *y), shape, colour, *low)))
                .map_err(failed)?
                .label(format!("paper, actuator {actuator} (open 1 bar, filled 3 bar)"))
                .legend(move |(x, y)| marker((x + 12, y), shape, colour, false));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .label_font(label_style())
            .legend_area_size(32)
            .margin(12)
            .background_style(WHITE.filled())
            .border_style(GRID)
            .draw()
            .map_err(failed)?;
        Ok(())
    })
}

fn marker<C: Clone + 'static, DB: DrawingBackend>(
    at: C,
    shape: usize,
    colour: RGBColor,
    open: bool,
) -> plotters::element::DynElement<'static, DB, C>
where
    plotters::element::Circle<C, i32>: plotters::element::IntoDynElement<'static, DB, C, Element>,
{
    let _ = (at, shape, colour, open);
    todo!()
}
