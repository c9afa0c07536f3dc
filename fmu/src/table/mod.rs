//! The one table of variables. A variable's value reference is its index in the table. Model description, getters, setters, saved
//! states and derivatives all use this table.
//!
//! | file | contents |
//! |---|---|
//! | [`variable`] | one variable |
//! | `own` | the chamber's real inputs, outputs and parameters, listed by hand |
//! | [`choices`] | non-numerical parameters, listed by hand |
//! | [`effects`] | the effects' parameters, from their cards |
//! | [`states`] | continuous states and their rates; those of the effects from their cards |
//!
//! [`units`] has their quantities, [`structure`] their dependencies.

pub mod choices;
pub mod effects;
mod own;
pub mod states;
pub mod structure;
pub mod units;
pub mod variable;

use crate::plant::states::ALL;
use crate::plant::values::Starts;
use std::sync::LazyLock;
use variable::{Role, Variable};

/// Communication step suggested in the descriptions, s.
pub const STEP_S: f64 = 1e-3;

/// All variables; a variable's value reference is its index.
pub fn table() -> &'static [Variable] {
    static TABLE: LazyLock<Vec<Variable>> = LazyLock::new(build);
    &TABLE
}

/// Index of the variable with this role.
pub fn index_of(role: Role) -> Option<usize> {
    table().iter().position(|v| v.role == role)
}

/// Index of the variable for a continuous state.
pub fn index_of_state(state: usize) -> Option<usize> {
    index_of(states::role_of_state(state))
}

/// Orders of magnitude of the continuous states.
pub fn nominals() -> [f64; ALL] {
    core::array::from_fn(|state| index_of_state(state).map_or(1.0, |index| table()[index].nominal))
}

/// The start or present value of a settable variable.
pub fn settable(starts: &Starts, role: Role) -> Option<f64> {
    match role {
        Role::Input(i) => Some(starts.inputs[i]),
        Role::Parameter(i) => Some(starts.parameters.real[i]),
        Role::Choice(choice) => Some(f64::from(starts.parameters.choices.get(choice))),
        _ => None,
    }
}

/// Whether all settable values lie within their variables' bounds.
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
    fn every_state_is_a_variable_with_a_rate() {
        for state in 0..ALL {
            assert!(index_of_state(state).is_some() && index_of(Role::Rate(state)).is_some(), "{state}");
            assert_eq!(states::state_of_role(states::role_of_state(state)), Some(state));
        }
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
