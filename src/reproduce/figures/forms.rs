//! Error of every form of λ tried, on the fitted points and on left-out actuators, as dots on a common scale.

use super::WIDTH;
use anyhow::Result;
use paper::geometry_effect::GeometryEffect;
use report::{Axis, Chart, Colour, Mark, Series};

const ROW_HEIGHT: u32 = 21;

/// The figure as SVG.
pub fn draw(effect: &GeometryEffect) -> Result<String> {
    let mut outcomes: Vec<_> = effect.outcomes.iter().collect();
    let judged = |o: &paper::geometry_effect::Outcome| o.rms_held_out.unwrap_or(f64::INFINITY);
    outcomes.sort_by(|a, b| judged(b).total_cmp(&judged(a)).then(b.rms_fitted.total_cmp(&a.rms_fitted)));
    let (mut names, mut fitted, mut held_out, mut between) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (i, o) in outcomes.iter().enumerate() {
        let y = i as f64;
        let parameters = if o.parameters == 1 { "1 value".to_owned() } else { format!("{} values", o.parameters) };
        names.push((y, format!("{}  ({parameters})", o.equation)));
        fitted.push((100.0 * o.rms_fitted, y));
        if let Some(error) = o.rms_held_out {
            held_out.push((100.0 * error, y));
            between.extend([(100.0 * o.rms_fitted, y), (100.0 * error, y)]);
        }
    }
    let rows = outcomes.len();
    let chart = Chart {
        title: "Forms of λ on the paper's six points",
        x: Axis { logarithmic: true, ..Axis::new("rms error of τ, %").over(1.0, 100.0) },
        y: Axis { named: names, ..Axis::new("").over(-0.6, rows as f64 - 0.4) },
        series: vec![
            Series { points: between, colour: Colour::Pale, label: "", mark: Mark::Segments(1.2) },
            Series { points: fitted, colour: Colour::After, label: "fitted", mark: Mark::Dots(4.0) },
            Series { points: held_out, colour: Colour::Before, label: "actuator left out", mark: Mark::Triangles(5.0) },
        ],
        size: (WIDTH, 110 + ROW_HEIGHT * rows as u32),
        ..Chart::default()
    };
    Ok(chart.draw()?)
}
