//! What both versions of the model description are written with, and the guid that is a hash of everything else in one.

use sha2::{Digest, Sha256};
use std::fmt::Write;

/// A description and its guid.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The file.
    pub xml: String,
    /// Its guid, in braces.
    pub guid: String,
}

/// The description that `document` writes, given the guid, which is a hash of what it writes without one.
pub fn described(document: impl Fn(&str) -> String) -> Description {
    let hash = Sha256::digest(document("").as_bytes());
    let hex: String = hash[..16].iter().map(|byte| format!("{byte:02x}")).collect();
    let guid = format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]);
    Description { xml: document(&guid), guid }
}

/// One opening (or, for a leaf, whole) tag on a line of its own.
pub fn line(xml: &mut String, indent: usize, tag: &str, attributes: &[(&str, String)], leaf: bool) {
    let _ = write!(xml, "{:indent$}<{tag}", "");
    for (name, value) in attributes {
        let _ = write!(xml, " {name}=\"{}\"", escaped(value));
    }
    *xml += if leaf { "/>\n" } else { ">\n" };
}

/// Text as an attribute's value, or as text.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The shortest decimal that reads back to the same number.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-3..1e7).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}
