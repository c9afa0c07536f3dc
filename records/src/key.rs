//! Requirements on the keys of a TOML file, and violations of them, in words.

use crate::names::nearest;
use std::ops::RangeInclusive;

/// Violation of a key's requirements: what was found, in the key's unit, and what is known or expected.
#[allow(missing_docs)]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KeyProblem {
    /// An unknown key.
    #[error("unknown key; {}", offer(near, known))]
    Unknown {
        /// The most similar known key.
        near: Option<String>,
        known: Vec<String>,
    },
    /// A key of another kind of file.
    #[error("belongs to a {kind}, but another kind of file is expected here, with the keys {}", known.join(", "))]
    OtherFile { kind: &'static str, known: Vec<String> },
    /// A required key is missing.
    #[error("missing; expected {expected}")]
    Missing { expected: String },
    /// A value of another type.
    #[error("is {found}, expected {expected}")]
    WrongType { expected: String, found: String },
    /// A number out of its bounds.
    #[error("{value:?} is out of range; expected {expected}")]
    OutOfBounds { value: f64, expected: String },
    /// A whole number out of its bounds.
    #[error("{value} is out of range; expected {expected}")]
    WholeOutOfBounds { value: i64, expected: String },
    /// A word that is not known.
    #[error("unknown value `{value}`; {}", offer(near, known))]
    UnknownName {
        value: String,
        /// The most similar known word.
        near: Option<String>,
        known: Vec<String>,
    },
    /// Values that contradict each other, or a value that needs another.
    #[error("{0}")]
    Contradiction(String),
}

fn offer(near: &Option<String>, known: &[String]) -> String {
    match near {
        Some(near) => format!("did you mean `{near}`?"),
        None if known.is_empty() => "nothing is allowed here".to_owned(),
        None => format!("expected one of: {}", known.iter().map(|word| shown(word)).collect::<Vec<_>>().join(", ")),
    }
}

/// A word for a list, quoted where it is no plain word: a comma would look like part of the list.
fn shown(word: &str) -> String {
    if word.contains(|c: char| c.is_ascii_alphanumeric()) { word.to_owned() } else { format!("{word:?}") }
}

/// The kind of file whose outermost table has this key; where two kinds have it, both.
pub fn kind_of_file(key: &str) -> Option<&'static str> {
    match key {
        "cylinder" | "sensor" | "accuracy" | "tolerance" | "columns" | "format" | "experiment" => Some("rig file"),
        "chamber" | "heat_transfer" | "effect" | "provenance" | "uncertainty" => Some("model file"),
        "study" | "test" | "vary" => Some("study file"),
        "gas" | "ambient" => Some("rig or model file"),
        _ => None,
    }
}

impl KeyProblem {
    /// A word that is not among `known`.
    pub fn unknown_name<'a>(value: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        KeyProblem::UnknownName {
            value: value.to_owned(),
            near: nearest(value, known.iter().copied()).map(str::to_owned),
            known: known.iter().map(|k| (*k).to_owned()).collect(),
        }
    }
}

/// Bounds of a number. NaN and infinity are never allowed.
#[derive(Debug, Clone, PartialEq)]
pub enum Bounds {
    /// Any finite number.
    Finite,
    /// Above zero; zero itself is refused.
    Positive,
    /// Zero or above.
    NotNegative,
    /// Within this range, with its unit or purpose in words.
    Within(RangeInclusive<f64>, &'static str),
}

impl Bounds {
    /// Whether the number is allowed.
    pub fn allow(&self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Bounds::Finite => true,
                Bounds::Positive => value > 0.0,
                Bounds::NotNegative => value >= 0.0,
                Bounds::Within(range, _) => range.contains(&value),
            }
    }

    /// Describes what is allowed.
    pub fn description(&self) -> String {
        match self {
            Bounds::Finite => "a finite number".to_owned(),
            Bounds::Positive => "a positive number".to_owned(),
            Bounds::NotNegative => "zero or a positive number".to_owned(),
            Bounds::Within(range, why) => {
                format!(
                    "a number from {:?} to {:?}{}{why}",
                    range.start(),
                    range.end(),
                    if why.is_empty() { "" } else { ", " }
                )
            }
        }
    }
}
