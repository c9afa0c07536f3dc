//! The figure of detection and naming rates: a small panel for each effect.

use std::fmt::Write;

/// Strength, share detected, share named (alone or among those that the data cannot tell apart).
pub type Curve = Vec<(f64, f64, f64)>;

const WEAKEST: f64 = 0.01;
const COLUMNS: usize = 4;
const DETECTED: (&str, &str) = ("#b45309", "6 4");
const NAMED: (&str, &str) = ("#1f5fa8", "none");

/// Panels of rates against strength on a logarithmic axis, as SVG.
pub fn rates(curves: &[(&str, Curve)]) -> String {
    let (w, h, left, top) = (215.0, 165.0, 44.0, 24.0);
    let rows = curves.len().div_ceil(COLUMNS);
    let (width, height) = (COLUMNS as f64 * (w + 14.0) + 14.0, rows as f64 * (h + 14.0) + 66.0);
    let mut out = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' font-family='sans-serif' font-size='11' role='img' \
         aria-label='Detection and naming rates of every effect against its strength'>\n\
         <rect width='100%' height='100%' fill='white'/>\n\
         <text x='14' y='20' font-size='14'>How often an effect is detected and rightly named, against its strength</text>\n"
    );
    for (k, ((colour, dash), label)) in [
        (DETECTED, "more than noise was seen"),
        (NAMED, "named rightly, alone or among those the data cannot tell apart"),
    ]
    .into_iter()
    .enumerate()
    {
        let x = 14.0 + 200.0 * k as f64;
        let _ = writeln!(
            out,
            "<line x1='{x}' x2='{}' y1='36' y2='36' stroke='{colour}' stroke-width='2' stroke-dasharray='{dash}'/><text x='{}' y='40'>{label}</text>",
            x + 24.0,
            x + 30.0
        );
    }
    for (k, (name, curve)) in curves.iter().enumerate() {
        let (x0, y0) = (14.0 + (k % COLUMNS) as f64 * (w + 14.0), 48.0 + (k / COLUMNS) as f64 * (h + 14.0));
        let px = |s: f64| x0 + left + (s / WEAKEST).log10() / (1.0 / WEAKEST).log10() * (w - left - 10.0);
        let py = |r: f64| y0 + top + (1.0 - r) * (h - top - 40.0);
        let _ =
            writeln!(out, "<text x='{}' y='{}' font-size='12' font-weight='600'>{name}</text>", px(WEAKEST), y0 + 14.0);
        for r in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let y = py(r);
            let label = if r == 0.25 || r == 0.75 { String::new() } else { format!("{:.0}", 100.0 * r) };
            let _ = writeln!(
                out,
                "<line x1='{}' x2='{}' y1='{y}' y2='{y}' stroke='#ddd'/><text x='{}' y='{}' text-anchor='end'>{label}</text>",
                px(WEAKEST),
                px(1.0),
                px(WEAKEST) - 4.0,
                y + 4.0
            );
        }
        for s in [0.01, 0.03, 0.1, 0.3, 1.0] {
            let _ = writeln!(out, "<text x='{}' y='{}' text-anchor='middle'>{s}</text>", px(s), py(0.0) + 14.0);
        }
        let _ = writeln!(
            out,
            "<text x='{}' y='{}' text-anchor='middle' fill='#444'>strength, 1</text><text transform='translate({} {}) rotate(-90)' text-anchor='middle' fill='#444'>rigs, %</text>",
            px(0.1),
            py(0.0) + 28.0,
            x0 + 10.0,
            py(0.5)
        );
        for ((colour, dash), pick) in [(DETECTED, 1), (NAMED, 2)] {
            let at = |c: &(f64, f64, f64)| (px(c.0), py(if pick == 1 { c.1 } else { c.2 }));
            let points: Vec<String> = curve.iter().map(at).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
            let _ = writeln!(
                out,
                "<polyline points='{}' fill='none' stroke='{colour}' stroke-width='2' stroke-dasharray='{dash}'/>",
                points.join(" ")
            );
            for (x, y) in curve.iter().map(at) {
                let _ = writeln!(out, "<circle cx='{x:.1}' cy='{y:.1}' r='2.4' fill='{colour}'/>");
            }
        }
    }
    out.push_str("</svg>\n");
    out
}
