//! Predicted over measured time constant of the six tests, before and after; each actuator is predicted from the others.

use super::WIDTH;
use anyhow::{Context, Result};
use paper::geometry_effect::{COLUMN_HALF, GeometryEffect, ONE_LAMBDA0};
use report::{Axis, Chart, Colour, Mark, Series};

/// The figure as SVG.
pub fn draw(effect: &GeometryEffect) -> Result<String> {
    let ratios = |form: &str, shift: f64| -> Result<Vec<(f64, f64)>> {
        let outcome = effect.outcome(form).with_context(|| format!("the form `{form}` is missing"))?;
        let predicted = outcome.time_constants_held_out_s.as_ref().context("a form has no left-out prediction")?;
        let of_each = predicted.iter().zip(&effect.points).enumerate();
        Ok(of_each.map(|(i, (t, p))| (i as f64 + shift, t / p.time_constant_s)).collect())
    };
    let (before, after) = (ratios(ONE_LAMBDA0, -0.1)?, ratios(COLUMN_HALF, 0.1)?);
    let stems = |points: &[(f64, f64)]| points.iter().flat_map(|p| [(p.0, 1.0), *p]).collect::<Vec<_>>();
    let last = effect.points.len() as f64 - 0.5;
    let tests = effect
        .points
        .iter()
        .enumerate()
        .map(|(i, p)| (i as f64, format!("{}{}: {:.0} mm", p.experiment, p.actuator, p.column_m * 1e3)));
    let chart = Chart {
        title: "Time constant of an actuator predicted from the other two",
        x: Axis {
            named: tests.collect(),
            ..Axis::new("experiment and actuator, with the length of its gas column").over(-0.5, last)
        },
        y: Axis::new("predicted τ / measured τ"),
        series: vec![
            Series { points: vec![(-0.5, 1.0), (last, 1.0)], colour: Colour::Ink, label: "", mark: Mark::Line(1.5) },
            Series { points: stems(&before), colour: Colour::Before, label: "", mark: Mark::Segments(1.5) },
            Series { points: stems(&after), colour: Colour::After, label: "", mark: Mark::Segments(1.5) },
            Series {
                points: before, colour: Colour::Before, label: "one λ0, λ ∝ √(PT)", mark: Mark::Triangles(6.0)
            },
            Series { points: after, colour: Colour::After, label: "λ ∝ √(PT) l^(−1/2)", mark: Mark::Dots(4.5) },
        ],
        size: (WIDTH, 380),
        ..Chart::default()
    };
    Ok(chart.draw()?)
}
