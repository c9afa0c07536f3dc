//! Predicted over measured time constant of the six tests, before and after, each actuator predicted from the others.

use super::{BLUE, GRID, INK, VERMILION, axis_style, centred, drawing, failed, label_style, legend, title_style};
use anyhow::{Context, Result};
use paper::geometry_effect::{COLUMN_HALF, GeometryEffect, ONE_LAMBDA0};
use plotters::prelude::*;

/// The figure as SVG.
pub fn draw(effect: &GeometryEffect) -> Result<String> {
    let ratios = |form: &str| -> Result<Vec<f64>> {
        let outcome = effect.outcome(form).with_context(|| format!("the form `{form}` is missing"))?;
        let predicted = outcome.time_constants_left_out_s.as_ref().context("a form has no left-out prediction")?;
        Ok(predicted.iter().zip(&effect.points).map(|(t, p)| t / p.time_constant_s).collect())
    };
    let (before, after) = (ratios(ONE_LAMBDA0)?, ratios(COLUMN_HALF)?);
    let count = effect.points.len() as f64;
    drawing(470, |root| {
        let mut chart = ChartBuilder::on(root)
            .margin(12)
            .caption("Time constant of an actuator predicted from the other two", title_style())
            .x_label_area_size(74)
            .y_label_area_size(70)
            .build_cartesian_2d(-0.5..count - 0.5, 0.4..1.8)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_labels(0)
            .x_desc("experiment and actuator, with the length of its gas column and its measured time constant")
            .y_desc("predicted τ / measured τ")
            .axis_desc_style(axis_style())
            .label_style(label_style())
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(INK)
            .y_labels(7)
            .draw()
            .map_err(failed)?;
        chart.draw_series(LineSeries::new([(-0.5, 1.0), (count - 0.5, 1.0)], INK.stroke_width(2))).map_err(failed)?;
        let at = |ratios: &[f64], shift: f64| -> Vec<(f64, f64)> {
            ratios.iter().enumerate().map(|(i, r)| (i as f64 + shift, *r)).collect()
        };
        let stem = |p: &(f64, f64), colour: RGBColor| PathElement::new([(p.0, 1.0), *p], colour.stroke_width(2));
        let (b, a) = (at(&before, -0.1), at(&after, 0.1));
        chart.draw_series(b.iter().map(|p| stem(p, VERMILION))).map_err(failed)?;
        chart.draw_series(a.iter().map(|p| stem(p, BLUE))).map_err(failed)?;
        chart
            .draw_series(b.iter().map(|p| TriangleMarker::new(*p, 8, VERMILION.filled())))
            .map_err(failed)?
            .label("one λ0, λ ∝ √(PT)")
            .legend(|(x, y)| TriangleMarker::new((x + 12, y), 8, VERMILION.filled()));
        chart
            .draw_series(a.iter().map(|p| Circle::new(*p, 6, BLUE.filled())))
            .map_err(failed)?
            .label("λ ∝ √(PT) l^(−1/2)")
            .legend(|(x, y)| Circle::new((x + 12, y), 6, BLUE.filled()));
        legend(&mut chart)?;
        for (i, p) in effect.points.iter().enumerate() {
            let (x, y) = chart.backend_coord(&(i as f64, 0.4));
            let column = format!("{:.0} mm, {} s", p.column_m * 1e3, p.time_constant_s);
            root.draw(&Text::new(format!("{}{}", p.experiment, p.actuator), (x, y + 16), centred())).map_err(failed)?;
            root.draw(&Text::new(column, (x, y + 35), centred())).map_err(failed)?;
        }
        Ok(())
    })
}
