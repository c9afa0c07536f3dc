//! One instance as a host sees it, without C: the life cycle, and batches that are taken whole or not at all.

use crate::derivatives;
use crate::inputs::ORDERS;
use crate::present::Present;
use crate::refusal::Refusal;
use crate::snapshot::{Experiment, Phase, Snapshot, TOLERANCES};
use crate::state_bytes;
use crate::variables::{Role, Starts, Variability, Variable, input, table};
use chamber::AreaLaw;
use chamber::balance::MASS;
use std::collections::BTreeMap;

/// One instance of the FMU.
#[derive(Debug)]
pub struct Instance {
    starts: Starts,
    guid: String,
    now: Snapshot,
    outputs: Option<Present>,
    saved: BTreeMap<usize, Box<Snapshot>>,
}

/// What happened in a step, beside its success.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TakenUp {
    /// Where the last step left the piston, m.
    pub reached: f64,
    /// Where the host says it is, m.
    pub position: f64,
}

impl Instance {
    /// A fresh instance with these start values; `guid` marks its serialized states.
    pub fn new(starts: &Starts, guid: &str) -> Self {
        let now = Snapshot::new(starts);
        Self { starts: *starts, guid: guid.into(), now, outputs: None, saved: BTreeMap::new() }
    }

    /// Present time, s: end of the last successful step.
    pub fn time(&self) -> f64 {
        self.now.time
    }

    /// Phase of the life cycle.
    pub fn phase(&self) -> Phase {
        self.now.phase
    }

    fn need(&self, phases: &[Phase], advice: &'static str) -> Result<(), Refusal> {
        if phases.contains(&self.now.phase) {
            return Ok(());
        }
        let phase = match self.now.phase {
            Phase::Instantiated => "before initialization mode",
            Phase::Initialization => "in initialization mode",
            Phase::Step => "after initialization mode",
            Phase::Terminated => "after fmi2Terminate",
        };
        Err(Refusal::OutOfOrder { phase, advice })
    }

    /// `fmi2SetupExperiment`.
    ///
    /// # Errors
    /// After initialization has begun; times or tolerance of no use.
    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Result<(), Refusal> {
        self.need(&[Phase::Instantiated], "it belongs between fmi2Instantiate and fmi2EnterInitializationMode")?;
        let bad = |argument, value, expected| Err(Refusal::BadArgument { argument, value, expected });
        if !start.is_finite() {
            return bad("startTime", start, "a finite time is expected");
        }
        if let Some(stop) = stop.filter(|stop| !stop.is_finite() || *stop < start) {
            return bad("stopTime", stop, "a finite time not before startTime is expected");
        }
        if let Some(tolerance) = tolerance.filter(|t| !t.is_finite() || *t <= 0.0) {
            return bad("tolerance", tolerance, "a positive relative tolerance is expected");
        }
        let tolerance =
            tolerance.map_or(crate::snapshot::DEFAULT_TOLERANCE, |t| t.clamp(*TOLERANCES.start(), *TOLERANCES.end()));
        self.now.experiment = Experiment { start, stop, tolerance };
        self.now.time = start;
        self.now.rebuild();
        Ok(())
    }

    /// `fmi2EnterInitializationMode`.
    ///
    /// # Errors
    /// When not freshly instantiated or reset.
    pub fn enter_initialization(&mut self) -> Result<(), Refusal> {
        self.need(&[Phase::Instantiated], "initialization happens once; fmi2Reset allows another")?;
        self.now.phase = Phase::Initialization;
        self.outputs = None;
        Ok(())
    }

    /// `fmi2ExitInitializationMode`.
    ///
    /// # Errors
    /// Outside initialization mode; parameters that make no chamber.
    pub fn exit_initialization(&mut self) -> Result<(), Refusal> {
        self.need(&[Phase::Initialization], "call fmi2EnterInitializationMode first")?;
        self.now.begin()?;
        self.now.phase = Phase::Step;
        self.outputs = None;
        Ok(())
    }

    /// `fmi2Terminate`.
    ///
    /// # Errors
    /// When there is nothing to end.
    pub fn terminate(&mut self) -> Result<(), Refusal> {
        self.need(&[Phase::Step], "only a simulation under way can be ended")?;
        self.now.phase = Phase::Terminated;
        Ok(())
    }

    /// `fmi2Reset`: as freshly instantiated. Saved states stay valid.
    pub fn reset(&mut self) {
        self.now = Snapshot::new(&self.starts);
        self.outputs = None;
    }

    /// `fmi2DoStep`.
    ///
    /// # Errors
    /// Out of order; a step of no use, beyond the stop time, from another point than the last one's end; no accurate step.
    pub fn do_step(&mut self, point: f64, h: f64) -> Result<Option<TakenUp>, Refusal> {
        self.need(&[Phase::Step], "steps follow fmi2ExitInitializationMode")?;
        let bad = |argument, value, expected| Err(Refusal::BadArgument { argument, value, expected });
        if !point.is_finite() {
            return bad("currentCommunicationPoint", point, "a finite time is expected");
        }
        if !(h > 0.0 && h.is_finite()) {
            return bad("communicationStepSize", h, "a positive, finite step is expected");
        }
        let reached = self.now.time;
        if (point - reached).abs() > (1e-3 * h).max(1e-9 * reached.abs().max(1.0).min(point.abs().max(1.0))) {
            return Err(Refusal::WrongPoint { asked: point, reached });
        }
        let end = point + h;
        if let Some(stop) = self.now.experiment.stop.filter(|stop| end > stop + 1e-6 * h + 1e-9 * stop.abs().max(1.0)) {
            return Err(Refusal::BeyondStop { end, stop });
        }
        let position = self.now.inputs.value[input::POSITION];
        let taken_up = TakenUp { reached: self.now.gas.position, position };
        // The host's clock counts: rounding in its communication points cannot add up.
        self.now.time = point;
        if let Err(refusal) = self.now.step(h) {
            self.now.time = reached;
            return Err(refusal);
        }
        self.outputs = None;
        Ok((taken_up.reached != taken_up.position).then_some(taken_up))
    }

    /// `fmi2SetReal`: the whole batch, or nothing.
    ///
    /// # Errors
    /// Unknown or foreign references, values that are not finite or out of bounds, variables that cannot be set now.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        self.need(
            &[Phase::Instantiated, Phase::Initialization, Phase::Step],
            "fmi2Reset makes variables settable again",
        )?;
        for (&reference, &value) in references.iter().zip(values) {
            self.settable(real(reference)?, value)?;
        }
        let mut parameters = self.now.parameters;
        for (&reference, &value) in references.iter().zip(values) {
            match real(reference)?.role {
                Role::Input(index) => self.now.inputs.set(index, value),
                Role::Parameter(index) => parameters.real[index] = value,
                _ => {}
            }
        }
        self.outputs = None;
        self.take_over(parameters);
        Ok(())
    }

    fn take_over(&mut self, parameters: crate::variables::Parameters) {
        if parameters == self.now.parameters {
            return;
        }
        if self.now.phase == Phase::Step {
            self.now.tune(parameters);
        } else {
            self.now.parameters = parameters;
            self.now.rebuild();
        }
    }

    /// Whether the host may set this variable to that value now.
    fn settable(&self, variable: &'static Variable, value: f64) -> Result<(), Refusal> {
        let not = |why| Err(Refusal::NotSettable { name: &variable.name, value, why });
        match (variable.role, variable.variability) {
            (Role::Output(_) | Role::State(_) | Role::Rate(_), _) => return not("it is calculated"),
            (_, Variability::Fixed) if self.now.phase == Phase::Step => {
                return not("it is fixed once initialization is over; fmi2Reset allows another run");
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
    /// Unknown or foreign references; outputs before initialization mode, or where the inputs leave the gas no room.
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
                Role::Parameter(index) => self.now.parameter(index),
                Role::Output(index) => self.outputs(variable)?.outputs[index],
                Role::State(index) => self.outputs(variable)?.states[index],
                Role::Rate(index) => self.outputs(variable)?.rates[index],
                Role::AreaLaw => f64::NAN,
            };
        }
        Ok(())
    }

    fn outputs(&mut self, variable: &'static Variable) -> Result<&Present, Refusal> {
        if self.now.phase == Phase::Instantiated {
            return Err(Refusal::NotYetKnown { name: &variable.name });
        }
        match &mut self.outputs {
            Some(present) => Ok(present),
            none => Ok(none.insert(self.now.present()?)),
        }
    }

    /// `fmi2SetInteger`.
    ///
    /// # Errors
    /// As for reals.
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Result<(), Refusal> {
        self.need(
            &[Phase::Instantiated, Phase::Initialization, Phase::Step],
            "fmi2Reset makes variables settable again",
        )?;
        for (&reference, &value) in references.iter().zip(values) {
            self.settable(typed(reference, "Integer")?, f64::from(value))?;
        }
        let mut parameters = self.now.parameters;
        if let Some(&last) = values.last() {
            parameters.area_law = if last == 1 { AreaLaw::Total } else { AreaLaw::Swept };
        }
        self.outputs = None;
        self.take_over(parameters);
        Ok(())
    }

    /// `fmi2GetInteger`.
    ///
    /// # Errors
    /// As for reals.
    pub fn get_integer(&self, references: &[u32], values: &mut [i32]) -> Result<(), Refusal> {
        for &reference in references {
            typed(reference, "Integer")?;
        }
        values.fill(area_law_number(self.now.parameters.area_law));
        Ok(())
    }

    /// Getting or setting variables of a type that this FMU has none of.
    ///
    /// # Errors
    /// Always, unless no reference is given.
    pub fn none_of_type(&self, references: &[u32], asked: &'static str) -> Result<(), Refusal> {
        references.iter().try_for_each(|&reference| typed(reference, asked).map(|_| ()))
    }

    /// `fmi2SetRealInputDerivatives`.
    ///
    /// # Errors
    /// Variables that are no inputs, orders that are not supported, values that are not finite.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Refusal> {
        self.need(&[Phase::Initialization, Phase::Step], "input derivatives belong to the step that follows")?;
        let place = |reference: u32| {
            let variable = real(reference)?;
            match variable.role {
                Role::Input(index) => Ok((variable, index)),
                _ => Err(Refusal::NoDerivative { name: &variable.name, wanted: "input", action: "set" }),
            }
        };
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let (variable, _) = place(reference)?;
            let name = variable.name.as_str();
            if !(1..=ORDERS as i32).contains(&order) {
                return Err(Refusal::DerivativeOrder { name, order, highest: ORDERS as i32 });
            }
            if !value.is_finite() {
                return Err(Refusal::NotFinite { name, value, unit: variable.quantity.unit });
            }
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let (_, index) = place(reference)?;
            self.now.inputs.set_derivative(index, order as usize, value);
        }
        self.outputs = None;
        Ok(())
    }

    /// `fmi2GetRealOutputDerivatives`.
    ///
    /// # Errors
    /// Variables that are no outputs, orders above the first.
    pub fn output_derivatives(&self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Result<(), Refusal> {
        self.need(&[Phase::Step, Phase::Terminated], "output derivatives exist once initialization is over")?;
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

    /// `fmi2GetDirectionalDerivative`.
    ///
    /// # Errors
    /// Unknowns that are not calculated, knowns that are.
    pub fn directional(
        &self,
        unknown: &[u32],
        known: &[u32],
        direction: &[f64],
        values: &mut [f64],
    ) -> Result<(), Refusal> {
        self.need(
            &[Phase::Initialization, Phase::Step, Phase::Terminated],
            "directional derivatives exist from initialization mode on",
        )?;
        let seed = derivatives::Seed::along(self.now.phase, known, direction)?;
        for &reference in unknown {
            let variable = real(reference)?;
            if !matches!(variable.role, Role::Output(_) | Role::State(_) | Role::Rate(_)) {
                let advice = "unknowns are outputs, states and their rates";
                return Err(Refusal::NoDirection { name: &variable.name, place: "an unknown", advice });
            }
        }
        let along = derivatives::along(&self.now, &seed)?;
        for (&reference, value) in unknown.iter().zip(values) {
            *value = match real(reference)?.role {
                Role::Output(index) => along.outputs[index],
                Role::State(index) => along.states[index],
                Role::Rate(index) => along.rates[index],
                _ => 0.0,
            };
        }
        Ok(())
    }

    /// `fmi2GetFMUstate`: a handle to a copy; one that is already a handle is filled anew.
    pub fn save(&mut self, handle: usize) -> usize {
        if let Some(existing) = self.saved.get_mut(&handle) {
            (**existing).clone_from(&self.now);
            return handle;
        }
        self.keep(self.now.clone())
    }

    fn keep(&mut self, snapshot: Snapshot) -> usize {
        let boxed = Box::new(snapshot);
        let handle = std::ptr::from_ref(&*boxed) as usize;
        self.saved.insert(handle, boxed);
        handle
    }

    fn saved(&self, handle: usize) -> Result<&Snapshot, Refusal> {
        let why = "this is no state that fmi2GetFMUstate or fmi2DeSerializeFMUstate of this instance gave out and that is still there";
        self.saved.get(&handle).map(|boxed| &**boxed).ok_or(Refusal::BadState { why })
    }

    /// `fmi2SetFMUstate`.
    ///
    /// # Errors
    /// A handle that is none.
    pub fn restore(&mut self, handle: usize) -> Result<(), Refusal> {
        self.now = self.saved(handle)?.clone();
        self.outputs = None;
        Ok(())
    }

    /// `fmi2FreeFMUstate`.
    ///
    /// # Errors
    /// A handle that is none.
    pub fn free(&mut self, handle: usize) -> Result<(), Refusal> {
        self.saved(handle)?;
        self.saved.remove(&handle);
        Ok(())
    }

    /// `fmi2SerializeFMUstate`.
    ///
    /// # Errors
    /// A handle that is none.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>, Refusal> {
        Ok(state_bytes::encode(self.saved(handle)?, &self.guid))
    }

    /// `fmi2DeSerializeFMUstate`.
    ///
    /// # Errors
    /// Bytes that are no state of this FMU.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<usize, Refusal> {
        let snapshot = state_bytes::decode(bytes, &self.guid)?;
        Ok(self.keep(snapshot))
    }
}

/// Number of the area law in the enumeration.
pub fn area_law_number(law: AreaLaw) -> i32 {
    match law {
        AreaLaw::Total => 1,
        AreaLaw::Swept => 2,
    }
}

fn real(reference: u32) -> Result<&'static Variable, Refusal> {
    typed(reference, "Real")
}

fn typed(reference: u32, asked: &'static str) -> Result<&'static Variable, Refusal> {
    let last = table().len() as u32 - 1;
    let variable = table().get(reference as usize).ok_or(Refusal::UnknownReference { reference, last })?;
    let is = if variable.role == Role::AreaLaw { "Integer" } else { "Real" };
    if is == asked { Ok(variable) } else { Err(Refusal::WrongType { name: &variable.name, reference, is, asked }) }
}

const _: () = assert!(MASS == 0, "the mass is the one state that is an output");
