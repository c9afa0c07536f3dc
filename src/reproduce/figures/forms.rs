//! Error of every form of λ that was tried, on the fitted points and on left-out actuators, as dots on a common scale.

use super::{BLUE, GRID, INK, VERMILION, axis_style, before, drawing, failed, label_style, legend, title_style};
use anyhow::Result;
use paper::geometry_effect::GeometryEffect;
use plotters::prelude::*;

const ROW_HEIGHT: u32 = 24;

/// The figure as SVG.
pub fn draw(effect: &GeometryEffect) -> Result<String> {
    let mut outcomes: Vec<_> = effect.outcomes.iter().collect();
    let judged = |o: &paper::geometry_effect::Outcome| o.rms_left_out.unwrap_or(f64::INFINITY);
    outcomes.sort_by(|a, b| judged(b).total_cmp(&judged(a)).then(b.rms_fitted.total_cmp(&a.rms_fitted)));
    let rows = outcomes.len();
    drawing(120 + ROW_HEIGHT * rows as u32, |root| {
        let mut chart = ChartBuilder::on(root)
            .margin(12)
            .margin_right(24)
            .caption("Forms of λ on the paper's six points", title_style())
            .x_label_area_size(52)
            .y_label_area_size(370)
            .build_cartesian_2d((1.0..100.0_f64).log_scale(), -0.6..rows as f64 - 0.4)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .y_labels(0)
            .x_desc("rms error of τ, %")
            .x_label_formatter(&|v| format!("{v}"))
            .axis_desc_style(axis_style())
            .label_style(label_style())
            .light_line_style(GRID)
            .bold_line_style(GRID)
            .axis_style(INK)
            .draw()
            .map_err(failed)?;
        for (i, o) in outcomes.iter().enumerate() {
            let y = i as f64;
            let fitted = 100.0 * o.rms_fitted;
            let left_out = o.rms_left_out.map(|r| 100.0 * r);
            if let Some(left_out) = left_out {
                chart
                    .draw_series([PathElement::new([(fitted, y), (left_out, y)], INK.mix(0.3).stroke_width(2))])
                    .map_err(failed)?;
            }
            let (x, pixel) = chart.backend_coord(&(1.0, y));
            let parameters = if o.parameters == 1 { "1 value".to_owned() } else { format!("{} values", o.parameters) };
            let label = format!("{}  ({parameters})", o.equation);
            root.draw(&Text::new(label, (x - 10, pixel), before())).map_err(failed)?;
        }
        let fitted: Vec<(f64, f64)> =
            outcomes.iter().enumerate().map(|(i, o)| (100.0 * o.rms_fitted, i as f64)).collect();
        let left_out: Vec<(f64, f64)> =
            outcomes.iter().enumerate().filter_map(|(i, o)| Some((100.0 * o.rms_left_out?, i as f64))).collect();
        chart
            .draw_series(fitted.iter().map(|p| Circle::new(*p, 5, BLUE.filled())))
            .map_err(failed)?
            .label("fitted")
            .legend(|(x, y)| Circle::new((x + 12, y), 5, BLUE.filled()));
        chart
            .draw_series(left_out.iter().map(|p| TriangleMarker::new(*p, 7, VERMILION.filled())))
            .map_err(failed)?
            .label("actuator left out")
            .legend(|(x, y)| TriangleMarker::new((x + 12, y), 7, VERMILION.filled()));
        legend(&mut chart)?;
        Ok(())
    })
}
