//! One variable of the table: what it stands for, its type, its bounds.

use super::units::Quantity;
use crate::plant::values::Choice;

/// What a variable stands for; indices are places among its like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A continuous input.
    Input(usize),
    /// A continuous output.
    Output(usize),
    /// A real parameter.
    Parameter(usize),
    /// A parameter that is no number.
    Choice(Choice),
    /// A continuous state that is no output.
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
    /// One line for people.
    pub description: &'static str,
    /// Names and descriptions of its items, numbered from one.
    pub items: &'static [(&'static str, &'static str)],
}

/// Type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// A real number with its unit.
    Real,
    /// One of several, by number.
    Enumeration(&'static Enumeration),
    /// True or false.
    Boolean,
}

/// One variable of the FMU.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Structured name, as hosts know it: `leakage.conductance`, `der(mass)`.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// What it stands for in the plant.
    pub role: Role,
    /// Real, an enumeration or Boolean.
    pub is: Type,
    /// Its unit and kind, where it is a number.
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
