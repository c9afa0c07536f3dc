//! Derivatives: of inputs and outputs with respect to time, and directional ones.

use super::{Instance, any, real};
use crate::plant::derivatives;
use crate::plant::inputs::ORDERS;
use crate::plant::simulation::Kind;
use crate::plant::tangent::Seed;
use crate::plant::values::input;
use crate::protocol::phases::Phase;
use crate::protocol::refusal::Refusal;
use crate::table::structure;
use crate::table::variable::Role;

impl Instance {
    /// Sets derivatives of inputs for the next step, SI units per s to the order, 1 to 3: all, or none
    /// (`fmi2SetRealInputDerivatives`).
    ///
    /// # Errors
    /// In Model Exchange; for variables that are no inputs, unsupported orders, or values that are not finite.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Refusal> {
        if self.now.kind == Kind::ModelExchange {
            return Err(Refusal::NotOffered {
                what: "this instance is for Model Exchange: its host sets the inputs at each time, not their derivatives",
            });
        }
        self.need(
            &[Phase::Instantiated, Phase::Initialization, Phase::Step],
            "set input derivatives before the simulation begins or before a step",
        )?;
        let input_of = |reference: u32| {
            let variable = real(reference)?;
            match variable.role {
                Role::Input(index) => Ok((variable, index)),
                _ => Err(Refusal::NoDerivative { name: &variable.name, wanted: "input", action: "set" }),
            }
        };
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let (variable, _) = input_of(reference)?;
            let name = variable.name.as_str();
            if !(1..=ORDERS as i32).contains(&order) {
                return Err(Refusal::DerivativeOrder { name, order, highest: ORDERS as i32 });
            }
            if !value.is_finite() {
                return Err(Refusal::NotFinite { name, value, unit: variable.quantity.unit });
            }
        }
        self.hand_over(!references.is_empty());
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let (_, index) = input_of(reference)?;
            if index == input::POSITION && self.now.is_moved_by_velocity() {
                continue;
            }
            self.now.inputs.set_derivative(index, order as usize, value);
        }
        self.outputs = None;
        Ok(())
    }

    /// First time derivatives of outputs at the present time, SI units per s (`fmi2GetRealOutputDerivatives`).
    ///
    /// # Errors
    /// For variables that are no outputs, or orders above the first.
    pub fn output_derivatives(&self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Result<(), Refusal> {
        self.need(&[Phase::Step, Phase::Terminated], "output derivatives are available after initialization")?;
        for (&reference, &order) in references.iter().zip(orders) {
            let variable = real(reference)?;
            if !matches!(variable.role, Role::Output(_)) {
                return Err(Refusal::NoDerivative { name: &variable.name, wanted: "output", action: "get" });
            }
            if order != 1 {
                return Err(Refusal::DerivativeOrder { name: &variable.name, order, highest: 1 });
            }
        }
        let rates = derivatives::in_time(&self.now)?;
        for (&reference, value) in references.iter().zip(values) {
            if let Role::Output(index) = real(reference)?.role {
                *value = rates[index];
            }
        }
        Ok(())
    }

    /// Exact directional derivatives of unknowns with respect to knowns (`fmi2GetDirectionalDerivative`).
    ///
    /// # Errors
    /// For unknowns that are not calculated, or knowns that are.
    pub fn directional(
        &self,
        unknown: &[u32],
        known: &[u32],
        direction: &[f64],
        values: &mut [f64],
    ) -> Result<(), Refusal> {
        self.need(&Phase::KNOWN, "directional derivatives are available from initialization mode on")?;
        let seed = self.seed(known, direction)?;
        for &reference in unknown {
            let variable = real(reference)?;
            if !matches!(variable.role, Role::Output(_) | Role::State(_) | Role::Rate(_)) {
                let advice = "unknowns are outputs, states and their rates";
                return Err(Refusal::NoDirection { name: &variable.name, role: "an unknown", advice });
            }
        }
        let along = derivatives::along(&self.now, &seed)?;
        for (&reference, value) in unknown.iter().zip(values) {
            *value = structure::value(&along, real(reference)?.role).unwrap_or(0.0);
        }
        Ok(())
    }

    /// The host's direction. States are knowns after initialization.
    fn seed(&self, known: &[u32], direction: &[f64]) -> Result<Seed, Refusal> {
        let mut seed = Seed::ZERO;
        for (&reference, &value) in known.iter().zip(direction) {
            let variable = any(reference)?;
            if !value.is_finite() {
                return Err(Refusal::NotFinite { name: &variable.name, value, unit: variable.quantity.unit });
            }
            if !structure::seed(&mut seed, variable.role, self.now.started, value) {
                let advice = if self.phase == Phase::Initialization {
                    "knowns are inputs and parameters in initialization mode"
                } else {
                    "knowns are inputs, continuous states and parameters"
                };
                return Err(Refusal::NoDirection { name: &variable.name, role: "a known", advice });
            }
        }
        Ok(seed)
    }
}
