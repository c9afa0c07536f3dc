//! The page's frame: head, style, table rows, numbers.

use super::svg::escape;

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;color:#1b1b1b;max-width:1320px;margin:2em auto;padding:0 1em}\
h1{font-size:1.6em;margin-bottom:.1em}h2{font-size:1.2em;margin-top:2em;border-bottom:1px solid #ddd}\
table{border-collapse:collapse;margin:.8em 0}th,td{padding:.2em .8em;border-bottom:1px solid #e4e4e4;text-align:left}td+td{font-variant-numeric:tabular-nums}\
.verdict{padding:.7em 1em;border-left:5px solid #888;background:#f6f6f4}.explained{border-color:#1f5fa8}.adequate{border-color:#2e7d32}.unexplained{border-color:#c2410c}\
.small,.source{color:#666;font-size:.88em}.charts{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(400px,100%),1fr));gap:10px}.pair{grid-template-columns:repeat(auto-fill,minmax(min(480px,100%),1fr))}figure{margin:0}\
svg{width:100%;height:auto;font:11px system-ui,sans-serif}.grid{stroke:#e6e6e6}.band{fill:#ececec}.x{text-anchor:middle}.y{text-anchor:end}\
.axis{text-anchor:middle;fill:#333}.title{font-weight:600}.legend{text-anchor:end}\
.chosen td{font-weight:600}@media print{body{margin:0;max-width:none;font-size:11px}figure{break-inside:avoid}h2{break-after:avoid}a{color:inherit}}";

/// Everything up to the body's first element.
pub fn head(title: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>{}</title><style>{STYLE}</style></head><body>",
        escape(title)
    )
}

/// A row of a table.
pub fn row(cells: &[&str]) -> String {
    let cells: String = cells.iter().map(|c| format!("<td>{}</td>", escape(c))).collect();
    format!("<tr>{cells}</tr>")
}

/// A row that stands out.
pub fn chosen_row(cells: &[&str]) -> String {
    row(cells).replacen("<tr>", "<tr class=\"chosen\">", 1)
}

/// A number with that many significant digits, in powers of ten only where it is very large or small.
pub fn number(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let exponent = value.abs().log10().floor();
    if (-4.0..7.0).contains(&exponent) {
        format!("{value:.*}", (digits as f64 - 1.0 - exponent).max(0.0) as usize)
    } else {
        format!("{value:.*e}", digits - 1)
    }
}
