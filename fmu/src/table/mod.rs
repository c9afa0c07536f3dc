//! The one table of variables. A variable's value reference is its place in the table. Model description, getters, setters,
//! saved states and derivatives all read this table.
//!
//! | file | variables |
//! |---|---|
//! | `own` | the chamber's real inputs, outputs and parameters, by hand |
//! | [`choices`] | parameters that are no numbers, by hand |
//! | [`effects`] | the effects' parameters, from their cards |
//! | [`states`] | continuous states and their rates, the effects' from their cards |
//!
//! [`units`] has the quantities that they declare, [`structure`] what depends on what.

pub mod choices;
pub mod effects;
mod own;
pub mod states;
pub mod structure;
pub mod units;

use crate::plant::values::{Choice, Starts};
use choices::Enumeration;
use std::sync::LazyLock;
use units::Quantity;

/// Communication step that the descriptions propose, s.
pub const STEP_S: f64 = 1e-3;

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

/// Every variable; a variable's value reference is its place here.
pub fn table() -> &'static [Variable] {
    static TABLE: LazyLock<Vec<Variable>> = LazyLock::new(build);
    &TABLE
}

/// Place of the variable with this role.
pub fn place(role: Role) -> Option<usize> {
    table().iter().position(|v| v.role == role)
}

/// A start value, or the present value of a variable that a host can set.
pub fn settable(starts: &Starts, role: Role) -> Option<f64> {
    match role {
        Role::Input(i) => Some(starts.inputs[i]),
        Role::Parameter(i) => Some(starts.parameters.real[i]),
        Role::Choice(choice) => Some(f64::from(starts.parameters.choices.get(choice))),
        _ => None,
    }
}

/// Whether every value that a host can set lies within its variable's bounds.
pub fn admits(starts: &Starts) -> bool {
    table().iter().all(|v| settable(starts, v.role).is_none_or(|value| v.admits(value)))
}

fn build() -> Vec<Variable> {
    let mut table = Vec::new();
    own::inputs(&mut table);
    own::outputs(&mut table);
    own::parameters(&mut table);
    choices::parameters(&mut table);
    effects::parameters(&mut table);
    states::variables(&mut table);
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_each_role_has_one_variable() {
        let names: std::collections::HashSet<_> = table().iter().map(|v| &v.name).collect();
        assert_eq!(names.len(), table().len());
        for v in table() {
            assert_eq!(table().iter().filter(|w| w.role == v.role).count(), 1, "{}", v.name);
        }
        assert!(names.contains(&"wallHeating.outerConductance".to_owned()));
        assert!(names.contains(&"leakage.criticalPressureRatio".to_owned()));
    }

    #[test]
    fn start_values_lie_within_their_bounds() {
        assert!(admits(&Starts::default()));
    }

    #[test]
    fn orders_of_magnitude_are_positive() {
        assert!(table().iter().all(|v| v.nominal > 0.0));
    }
}
