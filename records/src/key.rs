//! What a key of a TOML file may be, and what can be wrong with it, in words.

use crate::names::nearest;
use std::ops::RangeInclusive;

/// What is wrong with a key: what was found, in the key's unit, and what is known or expected there.
#[allow(missing_docs)]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KeyProblem {
    /// No such key is known here.
    #[error("unknown key; {}", offer(near, known))]
    Unknown {
        /// The known key most like it.
        near: Option<String>,
        known: Vec<String>,
    },
    /// A key of another kind of file.
    #[error("belongs to a {kind}, but another kind of file is expected here, with the keys {}", known.join(", "))]
    OtherFile { kind: &'static str, known: Vec<String> },
    /// A key without which the file says too little.
    #[error("missing; expected {expected}")]
    Missing { expected: String },
    /// A value of another type.
    #[error("is {found}, expected {expected}")]
    WrongType { expected: String, found: String },
    /// A number that cannot be.
    #[error("{value:?} is out of range; expected {expected}")]
    OutOfBounds { value: f64, expected: String },
    /// A whole number that cannot be.
    #[error("{value} is out of range; expected {expected}")]
    WholeOutOfBounds { value: i64, expected: String },
    /// A word that is none of those known.
    #[error("unknown value `{value}`; {}", offer(near, known))]
    UnknownName {
        value: String,
        /// The known word most like it.
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

/// A word of a list, in quotes where it is no plain word: a comma would look like part of the list.
fn shown(word: &str) -> String {
    if word.contains(|c: char| c.is_ascii_alphanumeric()) { word.to_owned() } else { format!("{word:?}") }
}

/// The kind of file whose outermost table has that key; where two kinds have it, both.
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
    /// A word that is none of `known`.
    pub fn unknown_name<'a>(value: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        KeyProblem::UnknownName {
            value: value.to_owned(),
            near: nearest(value, known.iter().copied()).map(str::to_owned),
            known: known.iter().map(|k| (*k).to_owned()).collect(),
        }
    }
}

/// What a number may be. Not-a-number and infinity are never allowed.
#[derive(Debug, Clone, PartialEq)]
pub enum Bounds {
    /// Any finite number.
    Finite,
    /// Above zero; zero itself is refused.
    Positive,
    /// Zero or above.
    NotNegative,
    /// Within these, and in words what for.
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

    /// What is allowed, in words.
    pub fn words(&self) -> String {
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
