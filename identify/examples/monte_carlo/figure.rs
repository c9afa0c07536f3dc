//! The figure of detection and naming rates: a small panel for each effect.

use report::{Axis, Chart, Colour, Error, Mark, Series, chart};

/// Strength, fraction detected, fraction named (alone or among those that the data cannot tell apart).
pub type Curve = Vec<(f64, f64, f64)>;

const WEAKEST: f64 = 0.01;
const COLUMNS: usize = 3;

/// Panels of rates against strength on a logarithmic axis, as SVG.
pub fn rates(curves: &[(&str, Curve)]) -> Result<String, Error> {
    let panels: Vec<Chart> = curves
        .iter()
        .map(|(name, curve)| {
            let detected = curve.iter().map(|c| (c.0, 100.0 * c.1)).collect();
            let named = curve.iter().map(|c| (c.0, 100.0 * c.2)).collect::<Vec<_>>();
            Chart {
                title: name,
                x: Axis { logarithmic: true, ..Axis::new("strength, 1").over(WEAKEST, 1.0) },
                y: Axis::new("rigs, %").over(0.0, 100.0),
                series: vec![
                    Series { points: detected, colour: Colour::Before, label: "", mark: Mark::Dashed(1.8) },
                    Series { points: named.clone(), colour: Colour::After, label: "", mark: Mark::Line(1.8) },
                    Series { points: named, colour: Colour::After, label: "", mark: Mark::Dots(2.4) },
                ],
                size: (320, 210),
                ..Chart::default()
            }
        })
        .collect();
    let title =
        "Dashed: more than noise was seen; solid: named rightly, alone or among those that the data cannot tell apart";
    chart::sheet(title, &panels, COLUMNS)
}
