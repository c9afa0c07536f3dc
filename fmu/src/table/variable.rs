//! One variable of the table: its role, type and bounds.

use super::units::Quantity;
use crate::plant::values::Choice;

/// Role of a variable; indices count within each role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A continuous input.
    Input(usize),
    /// A continuous output.
    Output(usize),
    /// A real parameter.
    Parameter(usize),
    /// A non-numerical parameter.
    Choice(Choice),
    /// A continuous state that is not an output.
    State(usize),
    /// Rate of a continuous state.
    Rate(usize),
}

/// When a variable may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Not after initialisation.
    Fixed,
    /// Between steps, or in event mode.
    Tunable,
    /// At any time, as inputs, outputs and states do.
    Continuous,
}

/// An enumeration: a type definition of the model description.
#[derive(Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// Name of the type.
    pub name: &'static str,
    /// One-line description for people.
    pub description: &'static str,
    /// Names and descriptions of its items, numbered from one.
    pub items: &'static [(&'static str, &'static str)],
}

/// Type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// A real number with its unit.
    Real,
    /// One of several items, by number.
    Enumeration(&'static Enumeration),
    /// True or false.
    Boolean,
}

/// One variable of the FMU.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Structured name for hosts: `leakage.conductance`, `der(mass)`.
    pub name: String,
    /// One-line description for people.
    pub description: String,
    /// Its role in the plant.
    pub role: Role,
    /// Real, an enumeration or Boolean.
    pub is: Type,
    /// Its quantity and unit, if numerical.
    pub quantity: &'static Quantity,
    /// When it may change.
    pub variability: Variability,
    /// Smallest value accepted.
    pub min: Option<f64>,
    /// Largest value accepted.
    pub max: Option<f64>,
    /// Order of magnitude.
    pub nominal: f64,
}

impl Variable {
    /// Whether the value lies within the bounds.
    pub fn admits(&self, value: f64) -> bool {
        self.min.is_none_or(|min| value >= min) && self.max.is_none_or(|max| value <= max)
    }
}
