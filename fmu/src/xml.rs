//! XML writer for the model descriptions: tags line by line, attributes escaped, numbers that read back unchanged.

use report::page::escaped;
use std::fmt::Write;

/// One opening tag (for a leaf, a complete one) on its own line.
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
