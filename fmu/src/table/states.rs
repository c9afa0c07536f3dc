//! The continuous states as variables: outputs for the gas and the sums, separate variables for the effects' states and the
//! piston's travel; and the rate of each.

use super::effects::camel;
use super::units::{self, Quantity};
use super::variable::{Role, Type, Variability, Variable};
use crate::plant::states::{ALL, HEAT, TRAVEL, WORK};
use crate::plant::values::output;
use chamber::balance::{ENERGY, MASS, STATES};
use chamber::effects;

/// Role of the variable for a continuous state: an output for those of the gas and the sums.
pub fn role_of_state(state: usize) -> Role {
    match state {
        MASS => Role::Output(output::MASS),
        ENERGY => Role::Output(output::INTERNAL_ENERGY),
        HEAT => Role::Output(output::HEAT_RECEIVED),
        WORK => Role::Output(output::WORK_DONE),
        other => Role::State(other),
    }
}

/// The continuous state that a variable is, if it is one.
pub fn state_of_role(role: Role) -> Option<usize> {
    (0..ALL).find(|&state| role_of_state(state) == role)
}

/// The states that are not outputs, and the rates of all.
pub(super) fn variables(table: &mut Vec<Variable>) {
    let mut own: Vec<(String, String, &'static Quantity, f64)> = Vec::new();
    for (_, card) in effects::all() {
        for s in card.states {
            let name = format!("{}.{}", camel(card.name), camel(s.name));
            own.push((name, s.doc.into(), units::of_state(s.unit), s.nominal));
        }
    }
    let travel = "Travel of the piston since the start: the integral of its velocity";
    own.push(("travel".into(), travel.into(), &units::LENGTH, 0.1));
    for (state, (name, description, quantity, nominal)) in (ENERGY + 1..STATES).chain([TRAVEL]).zip(own) {
        table.push(continuous(name, description, Role::State(state), quantity, nominal));
    }
    for state in 0..ALL {
        let role = role_of_state(state);
        let Some(of) = table.iter().find(|v| v.role == role) else { continue };
        let quantity = units::rate_of(of.quantity);
        let (name, description) = (format!("der({})", of.name), format!("Rate of {}", of.name));
        table.push(continuous(name, description, Role::Rate(state), quantity, quantity.nominal));
    }
}

fn continuous(name: String, description: String, role: Role, quantity: &'static Quantity, nominal: f64) -> Variable {
    Variable {
        name,
        description,
        role,
        is: Type::Real,
        quantity,
        variability: Variability::Continuous,
        min: None,
        max: None,
        nominal,
    }
}
