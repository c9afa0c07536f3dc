//! Pressure after the push of section 3.1 with both fits, and the residual of each, over time.

use super::WIDTH;
use anyhow::Result;
use paper::section31::Section31;
use report::{Axis, Chart, Colour, Mark, Series, chart};

const BAR_PER_PA: f64 = 1e-5;
/// Last time shown, s: nothing changes after it.
const SHOWN_S: f64 = 3.0;

/// The figure as SVG.
pub fn draw(found: &Section31) -> Result<String> {
    let c = &found.columns;
    let relaxation = &found.published.relaxation;
    let shown =
        |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> { points.into_iter().filter(|(t, _)| *t <= SHOWN_S).collect() };
    let fitted = |residuals: &[f64]| {
        let rows = relaxation.time_s.iter().zip(&relaxation.pressure_pa).zip(residuals);
        shown(rows.map(|((t, p), r)| (*t, (p - r) * BAR_PER_PA)).collect())
    };
    let left = |residuals: &[f64]| {
        shown(relaxation.time_s.iter().zip(residuals).map(|(t, r)| (*t, r * 1e3 * BAR_PER_PA)).collect())
    };
    let trace = shown(c.time_s.iter().zip(&c.pressure_pa).map(|(t, p)| (*t, p * BAR_PER_PA)).collect());
    // Every row of the push and of the first tenth of a second, then every tenth row.
    let kept = |(i, (t, _)): &(usize, (f64, f64))| *t < 0.1 || i % 10 == 0;
    let dots: Vec<(f64, f64)> = trace.into_iter().enumerate().filter(kept).map(|(_, p)| p).collect();
    let (exponential, exact) = (&found.published.fit.residuals_pa, &found.exact.fit.residuals_pa);
    let title = format!("Section 3.1: push in {} s, then hold", found.timing.push_s);
    let above = Chart {
        title: &title,
        x: Axis::new("").over(0.0, SHOWN_S),
        y: Axis::new("pressure, bar"),
        series: vec![
            Series {
                points: dots,
                colour: Colour::Ink,
                label: "simulated record (of the hold every tenth row)",
                mark: Mark::Rings(3.5),
            },
            Series {
                points: fitted(exact),
                colour: Colour::After,
                label: "1/P = (1/Pf)(1 − a exp(−kt)), exact",
                mark: Mark::Line(3.0),
            },
            Series {
                points: fitted(exponential),
                colour: Colour::Before,
                label: "P = Pf + ΔP exp(−t/τ), as published",
                mark: Mark::Dashed(1.7),
            },
        ],
        size: (WIDTH, 350),
        ..Chart::default()
    };
    let below = Chart {
        x: Axis::new("time, s").over(0.0, SHOWN_S),
        y: Axis::new("residual, mbar"),
        series: vec![
            Series { points: left(exact), colour: Colour::After, label: "", mark: Mark::Line(2.0) },
            Series { points: left(exponential), colour: Colour::Before, label: "", mark: Mark::Dashed(1.7) },
        ],
        size: (WIDTH, 210),
        ..Chart::default()
    };
    Ok(chart::sheet("", &[above, below], 1)?)
}
