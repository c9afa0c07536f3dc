//! Numbers and texts as TOML files write them.

/// The shortest digits that read back as the same number.
pub(crate) fn number(value: f64) -> String {
    // Rust's `NaN` is `nan` in TOML: refused by its key when read back.
    if value.is_nan() { "nan".to_owned() } else { format!("{value:?}") }
}

/// A text as TOML writes it.
pub(crate) fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
