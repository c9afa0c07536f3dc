//! Missing terms without a name, as a diagnosis states them.

use crate::discrepancy::{self, Missing};
use crate::search::Candidate;
use serde::Serialize;

/// A missing term without a name.
#[derive(Clone, Debug, Serialize)]
pub struct Unnamed {
    /// The balance it belongs to.
    pub balance: &'static str,
    /// What is missing, and its unit.
    pub quantity: &'static str,
    /// Unit of [`Unnamed::value`].
    pub unit: &'static str,
    /// What it follows.
    pub variable: &'static str,
    /// Unit of [`Unnamed::at`].
    pub variable_unit: &'static str,
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

/// The families that take away most of what a model leaves, best first.
pub fn unnamed(c: &Candidate, families: &[Missing]) -> Vec<Unnamed> {
    // What takes away most for its number of coefficients comes first.
    let mut best: Vec<&Missing> = families.iter().collect();
    best.sort_by(|a, b| b.worth(&c.fit).total_cmp(&a.worth(&c.fit)));
    best.iter()
        .take(6)
        .map(|m| Unnamed {
            balance: m.term.balance().name(),
            quantity: discrepancy::quantity(m.term),
            unit: m.term.unit(),
            variable: m.variable.name().0,
            variable_unit: m.variable.name().1,
            at: m.at.clone(),
            value: m.value.clone(),
            sd: m.sd.clone(),
            share: m.share(&c.fit),
        })
        .filter(|unnamed| unnamed.share >= LEAST_SHARE)
        .collect()
}
