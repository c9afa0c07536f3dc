//! Setting and getting variables in all-or-nothing batches.

use super::{Instance, real, typed};
use crate::plant::motion_source::MotionSource;
use crate::plant::rates::Present;
use crate::plant::values::Parameters;
use crate::protocol::phases::Phase;
use crate::protocol::refusal::Refusal;
use crate::table::structure;
use crate::table::variable::{Role, Variability, Variable};

impl Instance {
    /// `fmi2SetReal`: the whole batch, or nothing.
    ///
    /// # Errors
    /// For unknown references or those of another type, values that are not finite or out of bounds, or variables that cannot be
    /// set now.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        self.need(&Phase::SETTABLE, "call fmi2Reset to set variables again")?;
        for (&reference, &value) in references.iter().zip(values) {
            self.settable(real(reference)?, value)?;
        }
        let mut parameters = None;
        for (&reference, &value) in references.iter().zip(values) {
            if let Role::Parameter(index) = real(reference)?.role {
                parameters.get_or_insert(self.now.parameters).real[index] = value;
            }
        }
        let kept = parameters.map(|_| (self.now.motion_source, self.now.inputs.clone()));
        self.hand_over(self.phase.is_started() && !references.is_empty());
        let before = (self.now.motion_source != MotionSource::Host).then_some(self.now.inputs.value);
        for (&reference, &value) in references.iter().zip(values) {
            if let Role::Input(index) = real(reference)?.role {
                self.now.inputs.set(index, value);
            }
        }
        self.outputs = None;
        self.hand_over(before.is_some_and(|before| before != self.now.inputs.value));
        if let Some((parameters, (motion_source, inputs))) = parameters.zip(kept) {
            let taken = self.take_over(parameters);
            if taken.is_err() {
                (self.now.motion_source, self.now.inputs) = (motion_source, inputs);
            }
            taken?;
        }
        Ok(())
    }

    /// A host that sets something moves the piston from then on; before the end of initialization, only if the value differs from
    /// the start value, which many hosts set again.
    pub(super) fn hand_over(&mut self, to_the_host: bool) {
        if to_the_host {
            self.now.hand_over();
        }
    }

    fn take_over(&mut self, parameters: Parameters) -> Result<(), Refusal> {
        if parameters == self.now.parameters {
            return Ok(());
        }
        if self.phase.is_started() {
            self.now.tune(parameters)?;
            self.look_at_parameters();
        } else {
            self.now.parameters = parameters;
            self.now.rebuild();
        }
        self.now.hand_over();
        Ok(())
    }

    /// Checks that the host may set this variable to that value now.
    fn settable(&self, variable: &'static Variable, value: f64) -> Result<(), Refusal> {
        let not = |why| Err(Refusal::NotSettable { name: &variable.name, value, why });
        match (variable.role, variable.variability) {
            (Role::Output(_) | Role::State(_) | Role::Rate(_), _) => return not("it is calculated"),
            (_, Variability::Fixed) if self.phase.is_started() => {
                return not("it is fixed once initialization is over; call fmi2Reset to start another run");
            }
            (_, Variability::Tunable) if self.phase == Phase::Continuous => {
                return not("parameters change in event mode");
            }
            _ => {}
        }
        let (name, unit) = (variable.name.as_str(), variable.quantity.unit);
        if !value.is_finite() {
            return Err(Refusal::NotFinite { name, value, unit });
        }
        if !variable.admits(value) {
            let (min, max) = (variable.min.unwrap_or(f64::MIN), variable.max.unwrap_or(f64::MAX));
            return Err(Refusal::OutOfRange { name, value, unit, min, max });
        }
        Ok(())
    }

    /// `fmi2GetReal`: every value, or none.
    ///
    /// # Errors
    /// For unknown references or those of another type; for outputs before initialization mode, or if the inputs leave the gas no
    /// room.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Refusal> {
        for &reference in references {
            let variable = real(reference)?;
            if matches!(variable.role, Role::Output(_) | Role::State(_) | Role::Rate(_)) {
                self.outputs(variable)?;
            }
        }
        for (&reference, value) in references.iter().zip(values) {
            let variable = real(reference)?;
            *value = match variable.role {
                Role::Input(index) => self.now.inputs.value[index],
                Role::Parameter(index) => self.now.parameters.real[index],
                Role::Choice(_) => f64::NAN,
                role => structure::value(self.outputs(variable)?, role).unwrap_or(f64::NAN),
            };
        }
        Ok(())
    }

    fn outputs(&mut self, variable: &'static Variable) -> Result<&Present, Refusal> {
        if self.phase == Phase::Instantiated {
            return Err(Refusal::NotYetKnown { name: &variable.name });
        }
        self.known()
    }

    pub(super) fn known(&mut self) -> Result<&Present, Refusal> {
        match &mut self.outputs {
            Some(present) => Ok(present),
            none => Ok(none.insert(self.now.present()?)),
        }
    }

    /// `fmi2SetInteger`: a number beyond 32 bits is out of range for every variable.
    ///
    /// # Errors
    /// As for reals.
    pub fn set_integer<T: Copy + TryInto<i32>>(&mut self, references: &[u32], values: &[T]) -> Result<(), Refusal> {
        let values: Vec<i32> = values.iter().map(|value| (*value).try_into().unwrap_or(i32::MAX)).collect();
        self.choose(references, &values, "Integer")
    }

    /// `fmi2SetBoolean`: any nonzero number is true.
    ///
    /// # Errors
    /// As for reals.
    pub fn set_boolean<T: PartialEq + Default>(&mut self, references: &[u32], values: &[T]) -> Result<(), Refusal> {
        let values: Vec<i32> = values.iter().map(|value| i32::from(*value != T::default())).collect();
        self.choose(references, &values, "Boolean")
    }

    fn choose(&mut self, references: &[u32], values: &[i32], asked: &'static str) -> Result<(), Refusal> {
        self.need(&Phase::SETTABLE, "call fmi2Reset to set variables again")?;
        let mut parameters = self.now.parameters;
        for (&reference, &value) in references.iter().zip(values) {
            let variable = typed(reference, asked)?;
            self.settable(variable, f64::from(value))?;
            if let Role::Choice(choice) = variable.role
                && let Some(choices) = parameters.choices.with(choice, value)
            {
                parameters.choices = choices;
            }
        }
        self.take_over(parameters)?;
        self.outputs = None;
        self.hand_over(self.phase.is_started() && !references.is_empty());
        Ok(())
    }

    /// Numbers of the enumerations (`fmi2GetInteger`).
    ///
    /// # Errors
    /// As for reals.
    pub fn get_integer<T: From<i32>>(&self, references: &[u32], values: &mut [T]) -> Result<(), Refusal> {
        self.chosen(references, values, "Integer", T::from)
    }

    /// Whether externalWall is on (`fmi2GetBoolean`).
    ///
    /// # Errors
    /// As for reals.
    pub fn get_boolean<T: From<bool>>(&self, references: &[u32], values: &mut [T]) -> Result<(), Refusal> {
        self.chosen(references, values, "Boolean", |choice| T::from(choice != 0))
    }

    fn chosen<T>(
        &self,
        references: &[u32],
        values: &mut [T],
        asked: &'static str,
        as_type: impl Fn(i32) -> T,
    ) -> Result<(), Refusal> {
        all_of_type(references, asked)?;
        for (&reference, value) in references.iter().zip(values) {
            if let Role::Choice(choice) = typed(reference, asked)?.role {
                *value = as_type(self.now.parameters.choices.get(choice));
            }
        }
        Ok(())
    }

    /// Gets or sets variables of a type that this FMU does not have.
    ///
    /// # Errors
    /// Always, unless no reference is given.
    pub fn none_of_type(&self, references: &[u32], asked: &'static str) -> Result<(), Refusal> {
        all_of_type(references, asked)
    }
}

fn all_of_type(references: &[u32], asked: &'static str) -> Result<(), Refusal> {
    references.iter().try_for_each(|&reference| typed(reference, asked).map(|_| ()))
}
