//! Pressure after the push of section 3.1 with both fits, and the residual of each, over time.

use super::{BLUE, GRID, INK, VERMILION, axis_style, drawing, failed, label_style, legend, title_style};
use anyhow::Result;
use paper::section31::Section31;
use plotters::prelude::*;

const BAR_PER_PA: f64 = 1e-5;
/// Last time shown, s: nothing happens after it.
const SHOWN_S: f64 = 3.0;

/// The figure as SVG.
pub fn draw(found: &Section31) -> Result<String> {
    let c = &found.columns;
    let trace: Vec<(f64, f64)> = c.time_s.iter().zip(&c.pressure_pa).map(|(t, p)| (*t, p * BAR_PER_PA)).collect();
    let relaxation = &found.published.relaxation;
    let fitted = |residuals: &[f64]| -> Vec<(f64, f64)> {
        let rows = relaxation.time_s.iter().zip(&relaxation.pressure_pa).zip(residuals);
        rows.map(|((t, p), r)| (*t, (p - r) * BAR_PER_PA)).collect()
    };
    let left = |residuals: &[f64]| -> Vec<(f64, f64)> {
        relaxation.time_s.iter().zip(residuals).map(|(t, r)| (*t, r * 1e3 * BAR_PER_PA)).collect()
    };
    let (exponential, exact) = (&found.published.fit.residuals_pa, &found.exact.fit.residuals_pa);
    drawing(640, |root| {
        let (above, below) = root.split_vertically(380);
        let mut chart = ChartBuilder::on(&above)
            .margin(12)
            .caption(format!("Section 3.1: push in {} s, then hold", found.timing.push_s), title_style())
            .x_label_area_size(28)
            .y_label_area_size(70)
            .build_cartesian_2d(0.0..SHOWN_S, 0.9..2.6)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .y_desc("pressure, bar")
            .axis_desc_style(axis_style())
            .label_style(label_style())
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(INK)
            .y_labels(6)
            .draw()
            .map_err(failed)?;
        let shown = |points: Vec<(f64, f64)>| points.into_iter().filter(|(t, _)| *t <= SHOWN_S);
        // Every row of the push and of the first tenth of a second, then every tenth.
        let kept = |(i, (t, _)): &(usize, (f64, f64))| *t < 0.1 || i % 10 == 0;
        let dots: Vec<(f64, f64)> = shown(trace).enumerate().filter(kept).map(|(_, p)| p).collect();
        chart
            .draw_series(dots.iter().map(|p| Circle::new(*p, 5, INK.stroke_width(2))))
            .map_err(failed)?
            .label("simulated record (of the hold every tenth row)")
            .legend(|(x, y)| Circle::new((x + 12, y), 5, INK.stroke_width(2)));
        chart
            .draw_series(LineSeries::new(shown(fitted(exact)), BLUE.stroke_width(4)))
            .map_err(failed)?
            .label("1/P = (1/Pf)(1 − a exp(−kt)), exact")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 24, y)], BLUE.stroke_width(4)));
        chart
            .draw_series(DashedLineSeries::new(shown(fitted(exponential)), 8, 6, VERMILION.stroke_width(2)))
            .map_err(failed)?
            .label("P = Pf + ΔP exp(−t/τ), as published")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 24, y)], VERMILION.stroke_width(3)));
        legend(&mut chart)?;
        residuals(&below, shown(left(exponential)).collect(), shown(left(exact)).collect())
    })
}

type Area<'a, 'b> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn residuals(area: &Area<'_, '_>, exponential: Vec<(f64, f64)>, exact: Vec<(f64, f64)>) -> Result<()> {
    let largest = exponential.iter().map(|p| p.1.abs()).fold(0.0, f64::max) * 1.15;
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(52)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..SHOWN_S, -largest..largest)
        .map_err(failed)?;
    chart
        .configure_mesh()
        .x_desc("time, s")
        .y_desc("residual, mbar")
        .axis_desc_style(axis_style())
        .label_style(label_style())
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .y_labels(5)
        .draw()
        .map_err(failed)?;
    chart.draw_series(LineSeries::new(exact, BLUE.stroke_width(3))).map_err(failed)?;
    chart.draw_series(DashedLineSeries::new(exponential, 8, 5, VERMILION.stroke_width(2))).map_err(failed)?;
    Ok(())
}
