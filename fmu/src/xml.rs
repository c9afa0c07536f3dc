//! XML as the model descriptions are written: tags line by line, attributes escaped, numbers that read back the same.

use report::page::escaped;
use std::fmt::Write;

/// One opening (or, for a leaf, whole) tag on a line of its own.
pub fn line(xml: &mut String, indent: usize, tag: &str, attributes: &[(&str, String)], leaf: bool) {
    let _ = write!(xml, "{:indent$}<{tag}", "");
    for (name, value) in attributes {
        let _ = write!(xml, " {name}=\"{}\"", escaped(value));
    }
    *xml += if leaf { "/>\n" } else { ">\n" };
}

/// The shortest decimal that reads back to the same number.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-3..1e7).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}
