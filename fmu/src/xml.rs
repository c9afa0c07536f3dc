//! XML as the model descriptions are written: tags line by line, attributes escaped, numbers that read back the same.

use std::fmt::Write;

/// One opening (or, for a leaf, whole) tag on a line of its own.
pub fn line(xml: &mut String, indent: usize, tag: &str, attributes: &[(&str, String)], leaf: bool) {
    let _ = write!(xml, "{:indent$}<{tag}", "");
    for (name, value) in attributes {
        let _ = write!(xml, " {name}=\"{}\"", escaped(value));
    }
    *xml += if leaf { "/>\n" } else { ">\n" };
}

/// Text as an attribute's value, or as text; `\u{fffd}` in the place of each character that XML forbids.
pub fn escaped(text: &str) -> String {
    let is_forbidden =
        |c: char| c.is_control() && !matches!(c, '\t' | '\n' | '\r') || matches!(c, '\u{fffe}' | '\u{ffff}');
    let text = text.replace(is_forbidden, "\u{fffd}");
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The shortest decimal that reads back to the same number.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-3..1e7).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_that_xml_forbids_are_replaced() {
        assert_eq!(escaped("a\u{1}<b>\u{1b}\t\"\u{ffff}"), "a\u{fffd}&lt;b&gt;\u{fffd}\t&quot;\u{fffd}");
    }
}
