//! Unnamed missing terms, as a diagnosis reports them.

use crate::discrepancy::{self, Missing, Variable};
use crate::search::Candidate;
use chamber::effects::empirical::Term;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

/// A missing quantity and its variable; serialised in words with their units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subject {
    /// The missing quantity.
    pub term: Term,
    /// The variable on which it depends.
    pub variable: Variable,
}

impl Subject {
    /// The missing quantity in words, and its unit.
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

/// An unnamed missing term.
#[derive(Clone, Debug, Serialize)]
pub struct Unnamed {
    /// The balance it belongs to.
    pub balance: &'static str,
    /// The missing quantity and its variable.
    #[serde(flatten)]
    pub subject: Subject,
    /// Values of the variable.
    pub at: Vec<f64>,
    /// The missing term at these values.
    pub value: Vec<f64>,
    /// Its standard deviation at these values.
    pub sd: Vec<f64>,
    /// Fraction of the residual's squares beyond noise that it removes, to first order.
    pub share: f64,
}

/// A family that removes less than this fraction of a model's remainder explains nothing of it.
const LEAST_SHARE: f64 = 0.01;

/// A knot below this fraction of the farthest one is zero except for round-off.
const NEXT_TO_ZERO: f64 = 1e-9;

/// Maximum number of families reported.
const MOST: usize = 6;

/// The families that remove most of a model's remainder, best first.
pub fn unnamed(c: &Candidate, families: &[Missing]) -> Vec<Unnamed> {
    // The largest gain for its number of coefficients comes first.
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

/// Knots of a curve as reported.
fn places(at: &[f64]) -> Vec<f64> {
    let farthest = at.iter().fold(0.0, |most: f64, at| most.max(at.abs()));
    at.iter().map(|at| if at.abs() < NEXT_TO_ZERO * farthest { 0.0 } else { *at }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_knot_that_is_zero_but_for_round_off_is_reported_as_zero() {
        assert_eq!(places(&[-5.684e-14, 6.2e-5, 62.0]), [0.0, 6.2e-5, 62.0]);
        assert_eq!(places(&[-3e-12, 2e-12]), [-3e-12, 2e-12]);
    }
}
