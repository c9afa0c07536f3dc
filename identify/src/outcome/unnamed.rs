//! Missing terms without a name, as a diagnosis states them.

use crate::discrepancy::{self, Missing, Variable};
use crate::search::Candidate;
use chamber::effects::empirical::Term;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

/// What is missing, and what it follows; for programs, both in words with their units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subject {
    /// What is missing.
    pub term: Term,
    /// What it follows.
    pub variable: Variable,
}

impl Subject {
    /// What is missing, in words, and its unit.
    pub fn quantity(self) -> (&'static str, &'static str) {
        (discrepancy::quantity(self.term), self.term.unit())
    }
}

impl Serialize for Subject {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let ((quantity, unit), (variable, variable_unit)) = (self.quantity(), self.variable.name());
        let mut out = serializer.serialize_struct("Subject", 4)?;
        out.serialize_field("quantity", quantity)?;
        out.serialize_field("unit", unit)?;
        out.serialize_field("variable", variable)?;
        out.serialize_field("variable_unit", variable_unit)?;
        out.end()
    }
}

/// A missing term without a name.
#[derive(Clone, Debug, Serialize)]
pub struct Unnamed {
    /// The balance it belongs to.
    pub balance: &'static str,
    /// What is missing, and what it follows.
    #[serde(flatten)]
    pub subject: Subject,
    /// Values of the variable.
    pub at: Vec<f64>,
    /// The missing term there.
    pub value: Vec<f64>,
    /// Its standard deviation there.
    pub sd: Vec<f64>,
    /// Share of the residual's squares beyond noise that it takes away, to first order.
    pub share: f64,
}

/// A family that takes away less than this share of what a model leaves explains nothing of it.
const LEAST_SHARE: f64 = 0.01;

/// A place this near to zero, of the farthest one, is zero but for the last digits of its numbers.
const NEXT_TO_ZERO: f64 = 1e-9;

/// Most families that are told.
const MOST: usize = 6;

/// The families that take away most of what a model leaves, best first.
pub fn unnamed(c: &Candidate, families: &[Missing]) -> Vec<Unnamed> {
    // What takes away most for its number of coefficients comes first.
    let mut best: Vec<&Missing> = families.iter().collect();
    best.sort_by(|a, b| b.worth(&c.fit).total_cmp(&a.worth(&c.fit)));
    best.iter()
        .take(MOST)
        .map(|m| Unnamed {
            balance: m.term.balance().name(),
            subject: Subject { term: m.term, variable: m.variable },
            at: places(&m.at),
            value: m.value.clone(),
            sd: m.sd.clone(),
            share: m.share(&c.fit),
        })
        .filter(|unnamed| unnamed.share >= LEAST_SHARE)
        .collect()
}

/// Places of a curve as they are told.
fn places(at: &[f64]) -> Vec<f64> {
    let farthest = at.iter().fold(0.0, |most: f64, at| most.max(at.abs()));
    at.iter().map(|at| if at.abs() < NEXT_TO_ZERO * farthest { 0.0 } else { *at }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_that_is_zero_but_for_round_off_is_told_as_zero() {
        assert_eq!(places(&[-5.684e-14, 6.2e-5, 62.0]), [0.0, 6.2e-5, 62.0]);
        assert_eq!(places(&[-3e-12, 2e-12]), [-3e-12, 2e-12]);
    }
}
