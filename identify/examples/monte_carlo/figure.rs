//! The figure of detection and naming rates: small panels, one for each effect.

use std::fmt::Write;

/// Strength, share detected, share named (alone or among those that the data cannot tell apart).
pub type Curve = Vec<(f64, f64, f64)>;

/// Panels of rates against strength on a logarithmic axis, as SVG.
pub fn rates(curves: &[(&str, Curve)]) -> String {
    const COLUMNS: usize = 4;
    let (w, h, left, top) = (210.0, 150.0, 38.0, 26.0);
    let rows = curves.len().div_ceil(COLUMNS);
    let (width, height) = (COLUMNS as f64 * (w + 20.0) + 20.0, rows as f64 * (h + 40.0) + 50.0);
    let mut out = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' font-family='sans-serif' font-size='11'>\n\
         <rect width='100%' height='100%' fill='white'/>\n\
         <text x='20' y='18' font-size='13'>Share of rigs in which an effect is detected (grey) and named rightly (blue) against its strength (1 = Recipe::with_strength)</text>\n"
    );
    for (k, (name, curve)) in curves.iter().enumerate() {
        let (x0, y0) = (20.0 + (k % COLUMNS) as f64 * (w + 20.0), 34.0 + (k / COLUMNS) as f64 * (h + 40.0));
        let px = |s: f64| x0 + left + (s / 0.003f64).log10() / (1.0f64 / 0.003).log10() * (w - left - 6.0);
        let py = |r: f64| y0 + top + (1.0 - r) * (h - top - 22.0);
        let _ = writeln!(out, "<text x='{}' y='{}' font-size='12'>{name}</text>", x0 + left, y0 + 16.0);
        for r in [0.0, 0.5, 1.0] {
            let y = py(r);
            let _ = writeln!(
                out,
                "<line x1='{}' x2='{}' y1='{y}' y2='{y}' stroke='#ddd'/><text x='{}' y='{}' text-anchor='end'>{:.0} %</text>",
                px(0.003),
                px(1.0),
                px(0.003) - 4.0,
                y + 4.0,
                100.0 * r
            );
        }
        for s in [0.003, 0.03, 0.3, 1.0] {
            let _ = writeln!(out, "<text x='{}' y='{}' text-anchor='middle'>{s}</text>", px(s), y0 + h - 6.0);
        }
        for (colour, width, pick) in [("#999", 4.0, 1), ("#1f5fa8", 2.0, 2)] {
            let points: Vec<String> =
                curve.iter().map(|c| format!("{:.1},{:.1}", px(c.0), py(if pick == 1 { c.1 } else { c.2 }))).collect();
            let _ = writeln!(
                out,
                "<polyline points='{}' fill='none' stroke='{colour}' stroke-width='{width}'/>",
                points.join(" ")
            );
        }
    }
    out.push_str("</svg>\n");
    out
}
