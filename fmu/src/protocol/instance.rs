//! One instance as a host sees it, without C: the life cycle, and batches that are taken whole or not at all.

use super::message::{Category, Message, Status};
use super::phases::Phase;
use super::refusal::Refusal;
use super::state_bytes;
use super::warning::Warnings;
use crate::plant::corners::CORNERS;
use crate::plant::derivatives::{self, Seed};
use crate::plant::inputs::ORDERS;
use crate::plant::leader::Leader;
use crate::plant::rates::Present;
use crate::plant::simulation::{DEFAULT_TOLERANCE, Experiment, Kind, Simulation, TOLERANCES};
use crate::plant::states::ALL;
use crate::plant::values::{Parameters, Starts, input};
use crate::table::{Role, Type, Variability, Variable, structure, table};
use std::collections::BTreeMap;

/// What saved states hold: a simulation and its phase.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Phase of the life cycle.
    pub phase: Phase,
    /// The simulation.
    pub simulation: Simulation,
}

/// One instance of the FMU.
#[derive(Debug)]
pub struct Instance {
    starts: Starts,
    guid: String,
    phase: Phase,
    now: Simulation,
    outputs: Option<Present>,
    saved: BTreeMap<usize, Box<Snapshot>>,
    warnings: Warnings,
    messages: Vec<Message>,
    /// Whether the host wants to hear of events.
    pub tells_events: bool,
    /// Whether co-simulation has an event mode, which it begins in and which follows an early return.
    pub uses_event_mode: bool,
    /// Whether a step may end early, at an event.
    pub returns_early: bool,
}

/// What an event's iteration has come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Whether continuous states have new values.
    pub states_changed: bool,
    /// When the next event is, s, where that is known.
    pub next: Option<f64>,
}

impl Instance {
    /// A fresh instance of this kind with these start values; `guid` marks its serialized states.
    pub fn new(starts: &Starts, guid: &str, kind: Kind) -> Self {
        Self {
            starts: *starts,
            guid: guid.into(),
            phase: Phase::Instantiated,
            now: Simulation::new(starts, kind),
            outputs: None,
            saved: BTreeMap::new(),
            warnings: Warnings::default(),
            messages: Vec::new(),
            tells_events: false,
            uses_event_mode: false,
            returns_early: false,
        }
    }

    /// Present time, s: for co-simulation, the end of the last successful step.
    pub fn time(&self) -> f64 {
        self.now.time
    }

    /// Phase of the life cycle.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// What accepted calls had to say since the last time this was asked.
    pub fn messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }

    fn need(&self, phases: &[Phase], advice: &'static str) -> Result<(), Refusal> {
        if phases.contains(&self.phase) {
            return Ok(());
        }
        Err(Refusal::OutOfOrder { phase: self.phase.told(), advice })
    }

    /// `fmi2SetupExperiment`.
    ///
    /// # Errors
    /// After initialization has begun; times or tolerance of no use.
    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Result<(), Refusal> {
        self.need(&[Phase::Instantiated], "set up the experiment before initialization mode")?;
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
        let tolerance = tolerance.map_or(DEFAULT_TOLERANCE, |t| t.clamp(*TOLERANCES.start(), *TOLERANCES.end()));
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
        self.need(&[Phase::Instantiated], "an instance is initialized once; call fmi2Reset to do it again")?;
        self.phase = Phase::Initialization;
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
        self.phase = match self.now.kind {
            Kind::CoSimulation if !self.uses_event_mode => Phase::Step,
            _ => Phase::Event,
        };
        self.outputs = None;
        Ok(())
    }

    /// `fmi2Terminate`.
    ///
    /// # Errors
    /// When there is nothing to end.
    pub fn terminate(&mut self) -> Result<(), Refusal> {
        self.need(&Phase::RUNNING, "only a running simulation can be terminated")?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// `fmi2Reset`: as freshly instantiated. Saved states stay valid.
    pub fn reset(&mut self) {
        self.now = Simulation::new(&self.starts, self.now.kind);
        self.phase = Phase::Instantiated;
        self.outputs = None;
        self.warnings = Warnings::default();
    }

    /// `fmi2DoStep`.
    ///
    /// # Errors
    /// Out of order; a step of no use, beyond the stop time, from another point than the last one's end; no accurate step.
    pub fn do_step(&mut self, point: f64, h: f64) -> Result<(), Refusal> {
        self.need(&[Phase::Step], "call fmi2ExitInitializationMode first; only a co-simulation instance makes steps")?;
        let bad = |argument, value, expected| Err(Refusal::BadArgument { argument, value, expected });
        if !point.is_finite() {
            return bad("currentCommunicationPoint", point, "a finite time is expected");
        }
        if !(h > 0.0 && h.is_finite()) {
            return bad("communicationStepSize", h, "a positive, finite step is expected");
        }
        let time = self.now.time;
        if (point - time).abs() > (1e-3 * h).max(1e-9 * time.abs().max(1.0).min(point.abs().max(1.0))) {
            return Err(Refusal::WrongPoint { asked: point, reached: time });
        }
        let end = point + h;
        if let Some(stop) = self.now.experiment.stop.filter(|stop| end > stop + 1e-6 * h + 1e-9 * stop.abs().max(1.0)) {
            return Err(Refusal::BeyondStop { end, stop });
        }
        let by_velocity = self.now.is_moved_by_velocity();
        let reached = self.now.gas.position;
        let said = if by_velocity { reached } else { self.now.inputs.value[input::POSITION] };
        let (begin, _) = self.now.plant.limits.apply(said, 0.0);
        // The host's clock counts: rounding in its communication points cannot add up.
        self.now.time = point;
        if let Err(fault) = self.now.step(h) {
            self.now.time = time;
            return Err(fault.into());
        }
        self.outputs = None;
        let messages = &mut self.messages;
        if self.tells_events && begin != reached {
            let text = format!(
                "t = {point} s: the stroke from {reached} m to position = {begin} m was taken up adiabatically"
            );
            messages.push(Message { status: Status::Ok, category: Category::Events, text });
        }
        self.warnings.after_step(&self.now, reached, begin, &mut |text| messages.push(warning(text)));
        Ok(())
    }

    /// `fmi2EnterEventMode`.
    ///
    /// # Errors
    /// Outside Model Exchange under way.
    pub fn enter_event(&mut self) -> Result<(), Refusal> {
        let step = if self.uses_event_mode { Phase::Step } else { Phase::Continuous };
        self.need(&[Phase::Continuous, Phase::Event, step], "enter event mode from continuous-time mode")?;
        if self.phase == Phase::Continuous {
            self.now.enter_event()?;
        }
        self.phase = Phase::Event;
        Ok(())
    }

    /// `fmi2NewDiscreteStates`: one iteration is all that an event needs.
    ///
    /// # Errors
    /// Outside event mode; where inputs leave the gas no room.
    pub fn new_discrete_states(&mut self) -> Result<Event, Refusal> {
        self.need(&[Phase::Event], "call fmi2EnterEventMode first")?;
        let states_changed = self.now.kind == Kind::ModelExchange && self.now.handle_event()?;
        self.outputs = None;
        self.warnings.lose_track();
        let next = self.now.turn().filter(|_| self.now.kind == Kind::ModelExchange);
        Ok(Event { states_changed, next })
    }

    /// `fmi2EnterContinuousTimeMode`.
    ///
    /// # Errors
    /// Outside event mode.
    pub fn enter_continuous_time(&mut self) -> Result<(), Refusal> {
        self.need_exchange()?;
        self.need(&[Phase::Event], "enter continuous-time mode from event mode")?;
        self.phase = Phase::Continuous;
        Ok(())
    }

    /// `fmi3EnterStepMode`.
    ///
    /// # Errors
    /// Outside event mode of co-simulation.
    pub fn enter_step(&mut self) -> Result<(), Refusal> {
        if self.now.kind == Kind::ModelExchange {
            return Err(Refusal::NotOffered { what: "this instance is for Model Exchange: it has no step mode" });
        }
        self.need(&[Phase::Event], "enter step mode from event mode")?;
        self.phase = Phase::Step;
        Ok(())
    }

    /// As [`Instance::do_step`], but no further than to the first event; whether there was one. An event is located to a
    /// billionth of the step, on its far side.
    ///
    /// # Errors
    /// As for a step.
    pub fn do_step_to_event(&mut self, point: f64, h: f64) -> Result<bool, Refusal> {
        let mut before = self.now.clone();
        before.time = point;
        let sides = self.now.signs();
        self.do_step(point, h)?;
        let (Ok(sides), Ok(after)) = (sides, self.now.signs()) else { return Ok(false) };
        if sides == after {
            return Ok(false);
        }
        let (mut low, mut high) = (0.0, h);
        while high - low > 1e-9 * h {
            let middle = 0.5 * (low + high);
            let mut trial = before.clone();
            let passed = trial.step(middle).is_err() || trial.signs().is_ok_and(|there| there != sides);
            if passed { high = middle } else { low = middle }
        }
        // The whole step was possible, and so is its part, but for rounding: then the step ends where it was to end.
        if before.step(high).is_err() {
            return Ok(false);
        }
        self.now = before;
        self.outputs = None;
        self.warnings.lose_track();
        Ok(true)
    }

    /// `fmi2CompletedIntegratorStep`.
    ///
    /// # Errors
    /// Outside continuous-time mode; where the states make no gas.
    pub fn completed_step(&mut self) -> Result<(), Refusal> {
        self.need(&[Phase::Continuous], "complete integrator steps in continuous-time mode")?;
        self.now.complete_step()?;
        let messages = &mut self.messages;
        self.warnings.at_completed_step(&self.now, &mut |text| messages.push(warning(text)));
        Ok(())
    }

    /// `fmi2SetTime`.
    ///
    /// # Errors
    /// Outside Model Exchange under way; a time that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<(), Refusal> {
        self.need(&[Phase::Event, Phase::Continuous], "the time is set in event mode or continuous-time mode")?;
        if !time.is_finite() {
            return Err(Refusal::BadArgument { argument: "time", value: time, expected: "a finite time is expected" });
        }
        self.now.time = time;
        self.now.lead();
        self.outputs = None;
        Ok(())
    }

    /// `fmi2SetContinuousStates`.
    ///
    /// # Errors
    /// Outside Model Exchange under way; another number of states, states that are not finite.
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Refusal> {
        self.need(
            &[Phase::Event, Phase::Continuous],
            "continuous states are set in event mode or continuous-time mode",
        )?;
        let states: [f64; ALL] = states.try_into().map_err(|_| wrong_length("nx", states.len(), ALL))?;
        if let Some((value, state)) = states.iter().zip(0..).find(|(value, _)| !value.is_finite()) {
            let variable = crate::table::place_of_state(state).and_then(|place| table().get(place));
            let (name, unit) = variable.map_or(("state", ""), |v| (v.name.as_str(), v.quantity.unit));
            return Err(Refusal::NotFinite { name, value: *value, unit });
        }
        self.now.gas.states = states;
        self.outputs = None;
        Ok(())
    }

    /// `fmi2GetContinuousStates`.
    ///
    /// # Errors
    /// Outside Model Exchange; another number of states.
    pub fn continuous_states(&mut self, states: &mut [f64]) -> Result<(), Refusal> {
        self.exchange()?;
        let length = states.len();
        let states: &mut [f64; ALL] = states.try_into().map_err(|_| wrong_length("nx", length, ALL))?;
        *states = if self.now.started { self.now.gas.states } else { self.now.present()?.states };
        Ok(())
    }

    /// `fmi2GetDerivatives`.
    ///
    /// # Errors
    /// Outside Model Exchange; another number of states; states that make no gas.
    pub fn derivatives(&mut self, rates: &mut [f64]) -> Result<(), Refusal> {
        self.exchange()?;
        let length = rates.len();
        let rates: &mut [f64; ALL] = rates.try_into().map_err(|_| wrong_length("nx", length, ALL))?;
        *rates = self.known()?.rates;
        Ok(())
    }

    /// `fmi2GetEventIndicators`.
    ///
    /// # Errors
    /// Outside Model Exchange; another number of indicators; states that make no gas.
    pub fn event_indicators(&mut self, indicators: &mut [f64]) -> Result<(), Refusal> {
        self.exchange()?;
        let length = indicators.len();
        let indicators: &mut [f64; CORNERS] = indicators.try_into().map_err(|_| wrong_length("ni", length, CORNERS))?;
        *indicators = self.now.indicators()?;
        Ok(())
    }

    /// One event indicator, as a variable of FMI 3.0.
    ///
    /// # Errors
    /// Before initialization mode; states that make no gas.
    pub fn indicator(&self, index: usize) -> Result<f64, Refusal> {
        self.need(&Phase::KNOWN, "event indicators are available from initialization mode on")?;
        Ok(self.now.indicators()?[index])
    }

    /// `fmi2GetNominalsOfContinuousStates`.
    ///
    /// # Errors
    /// Outside Model Exchange; another number of states.
    pub fn nominals(&self, nominals: &mut [f64]) -> Result<(), Refusal> {
        self.need_exchange()?;
        let length = nominals.len();
        let nominals: &mut [f64; ALL] = nominals.try_into().map_err(|_| wrong_length("nx", length, ALL))?;
        *nominals = crate::table::nominals();
        Ok(())
    }

    fn need_exchange(&self) -> Result<(), Refusal> {
        if self.now.kind == Kind::CoSimulation {
            return Err(Refusal::NotOffered {
                what: "this instance is for co-simulation: states and indicators belong to Model Exchange",
            });
        }
        Ok(())
    }

    fn exchange(&self) -> Result<(), Refusal> {
        self.need_exchange()?;
        self.need(&Phase::EXCHANGE, "states, derivatives and indicators are available from initialization mode on")
    }

    /// `fmi2SetReal`: the whole batch, or nothing.
    ///
    /// # Errors
    /// Unknown or foreign references, values that are not finite or out of bounds, variables that cannot be set now.
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
        let kept = parameters.map(|_| (self.now.leader, self.now.inputs.clone()));
        self.hand_over(self.phase.is_started() && !references.is_empty());
        let before = (self.now.leader != Leader::Host).then_some(self.now.inputs.value);
        for (&reference, &value) in references.iter().zip(values) {
            if let Role::Input(index) = real(reference)?.role {
                self.now.inputs.set(index, value);
            }
        }
        self.outputs = None;
        self.hand_over(before.is_some_and(|before| before != self.now.inputs.value));
        if let Some((parameters, (leader, inputs))) = parameters.zip(kept) {
            let taken = self.take_over(parameters);
            if taken.is_err() {
                (self.now.leader, self.now.inputs) = (leader, inputs);
            }
            taken?;
        }
        Ok(())
    }

    /// A host that sets something moves the piston from then on: before the end of initialization, something else than the
    /// start values, which many set again.
    fn hand_over(&mut self, to_the_host: bool) {
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
        } else {
            self.now.parameters = parameters;
            self.now.rebuild();
        }
        self.now.hand_over();
        Ok(())
    }

    /// Whether the host may set this variable to that value now.
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

    fn known(&mut self) -> Result<&Present, Refusal> {
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
        self.choose(references, values, "Integer")
    }

    /// `fmi2SetBoolean`: any number but zero is true.
    ///
    /// # Errors
    /// As for reals.
    pub fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Result<(), Refusal> {
        let values: Vec<i32> = values.iter().map(|value| i32::from(*value)).collect();
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

    /// `fmi2GetInteger`.
    ///
    /// # Errors
    /// As for reals.
    pub fn get_integer(&self, references: &[u32], values: &mut [i32]) -> Result<(), Refusal> {
        self.chosen(references, "Integer")?;
        for (&reference, value) in references.iter().zip(values) {
            *value = self.choice(reference, "Integer")?;
        }
        Ok(())
    }

    /// `fmi2GetBoolean`.
    ///
    /// # Errors
    /// As for reals.
    pub fn get_boolean(&self, references: &[u32], values: &mut [bool]) -> Result<(), Refusal> {
        self.chosen(references, "Boolean")?;
        for (&reference, value) in references.iter().zip(values) {
            *value = self.choice(reference, "Boolean")? != 0;
        }
        Ok(())
    }

    fn chosen(&self, references: &[u32], asked: &'static str) -> Result<(), Refusal> {
        references.iter().try_for_each(|&reference| typed(reference, asked).map(|_| ()))
    }

    fn choice(&self, reference: u32, asked: &'static str) -> Result<i32, Refusal> {
        match typed(reference, asked)?.role {
            Role::Choice(choice) => Ok(self.now.parameters.choices.get(choice)),
            _ => Ok(0),
        }
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
        self.need(
            &[Phase::Initialization, Phase::Step],
            "set input derivatives in initialization mode or before a step",
        )?;
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
        self.hand_over(!references.is_empty());
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let (_, index) = place(reference)?;
            if index == input::POSITION && self.now.is_moved_by_velocity() {
                continue;
            }
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
        self.need(&Phase::KNOWN, "directional derivatives are available from initialization mode on")?;
        let seed = self.seed(known, direction)?;
        for &reference in unknown {
            let variable = real(reference)?;
            if !matches!(variable.role, Role::Output(_) | Role::State(_) | Role::Rate(_)) {
                let advice = "unknowns are outputs, states and their rates";
                return Err(Refusal::NoDirection { name: &variable.name, place: "an unknown", advice });
            }
        }
        let along = derivatives::along(&self.now, &seed)?;
        for (&reference, value) in unknown.iter().zip(values) {
            *value = structure::value(&along, real(reference)?.role).unwrap_or(0.0);
        }
        Ok(())
    }

    /// The direction that a host gives. States are knowns once initialization is over.
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
                return Err(Refusal::NoDirection { name: &variable.name, place: "a known", advice });
            }
        }
        Ok(seed)
    }

    /// `fmi2GetFMUstate`: a handle to a copy; one that is already a handle is filled anew.
    pub fn save(&mut self, handle: usize) -> usize {
        if let Some(existing) = self.saved.get_mut(&handle) {
            existing.phase = self.phase;
            existing.simulation.clone_from(&self.now);
            return handle;
        }
        self.keep(Snapshot { phase: self.phase, simulation: self.now.clone() })
    }

    fn keep(&mut self, snapshot: Snapshot) -> usize {
        let boxed = Box::new(snapshot);
        let handle = std::ptr::from_ref(&*boxed) as usize;
        self.saved.insert(handle, boxed);
        handle
    }

    fn saved(&self, handle: usize) -> Result<&Snapshot, Refusal> {
        let why = "there is no state that this handle stands for: it was never saved by this instance, or it was freed";
        self.saved.get(&handle).map(|boxed| &**boxed).ok_or(Refusal::BadState { why })
    }

    /// `fmi2SetFMUstate`.
    ///
    /// # Errors
    /// A handle that is none.
    pub fn restore(&mut self, handle: usize) -> Result<(), Refusal> {
        let Snapshot { phase, simulation } = self.saved(handle)?.clone();
        (self.phase, self.now) = (phase, simulation);
        self.outputs = None;
        self.warnings.lose_track();
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
        if snapshot.simulation.kind != self.now.kind {
            return Err(Refusal::BadBytes {
                why: "they are of an instance of the other kind, Model Exchange or co-simulation",
            });
        }
        Ok(self.keep(snapshot))
    }
}

/// A warning.
fn warning(text: String) -> Message {
    Message { status: Status::Warning, category: Category::Warning, text }
}

fn wrong_length(argument: &'static str, length: usize, expected: usize) -> Refusal {
    Refusal::WrongLength { argument, length, expected }
}

fn any(reference: u32) -> Result<&'static Variable, Refusal> {
    let last = table().len() as u32 - 1;
    table().get(reference as usize).ok_or(Refusal::UnknownReference { reference, last })
}

fn real(reference: u32) -> Result<&'static Variable, Refusal> {
    typed(reference, "Real")
}

fn typed(reference: u32, asked: &'static str) -> Result<&'static Variable, Refusal> {
    let variable = any(reference)?;
    let is = match variable.is {
        Type::Real => "Real",
        Type::Enumeration(_) => "Integer",
        Type::Boolean => "Boolean",
    };
    if is == asked { Ok(variable) } else { Err(Refusal::WrongType { name: &variable.name, reference, is, asked }) }
}
