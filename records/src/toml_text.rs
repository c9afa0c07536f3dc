//! Numbers and texts in TOML notation.

/// The shortest notation that reads back as the same number.
pub(crate) fn number(value: f64) -> String {
    // Rust's `NaN` is `nan` in TOML; reading it back refuses it with its key.
    if value.is_nan() { "nan".to_owned() } else { format!("{value:?}") }
}

/// A text in TOML notation.
pub(crate) fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
