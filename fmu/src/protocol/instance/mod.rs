//! One instance as seen by a host, without C: its life cycle here, the functions of each phase in submodules.

mod exchange;
mod saved;
mod sensitivities;
mod steps;
mod values;

use super::message::{Category, Message, Status};
use super::phases::Phase;
use super::refusal::Refusal;
use super::snapshot::Snapshot;
use super::warning::Warnings;
use crate::plant::rates::Present;
use crate::plant::simulation::{DEFAULT_TOLERANCE, Experiment, Kind, Simulation, TOLERANCES};
use crate::plant::values::Starts;
use crate::table::table;
use crate::table::variable::{Type, Variable};
use std::collections::BTreeMap;

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
    refused: Option<RefusedStep>,
    /// Whether the host wants event messages.
    pub logs_events: bool,
    /// Whether co-simulation has an event mode, in which it starts and which follows an early return.
    pub uses_event_mode: bool,
    /// Whether a step may end early, at an event.
    pub returns_early: bool,
}

/// A refused step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RefusedStep {
    /// Its start, s.
    point: f64,
    /// Its length, s.
    h: f64,
    /// Whether the host has requested the same step again.
    is_repeated: bool,
}

/// Result of an event iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Whether continuous states have new values.
    pub states_changed: bool,
    /// Time of the next event, s, if known.
    pub next: Option<f64>,
}

impl Instance {
    /// A new instance of this kind with these start values; `guid` identifies its serialized states.
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
            refused: None,
            logs_events: false,
            uses_event_mode: false,
            returns_early: false,
        }
    }

    /// Present time, s: for co-simulation, the end of the last successful step.
    pub fn time(&self) -> f64 {
        self.now.time
    }

    /// Whether the simulation cannot continue: the host repeats a refused step instead of a shorter one, and no other input makes
    /// it possible.
    pub fn is_stuck(&self) -> bool {
        self.refused.is_some_and(|step| step.is_repeated)
    }

    /// Phase of the life cycle.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Messages of accepted calls since the last time this was called.
    pub fn messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }

    fn need(&self, phases: &[Phase], advice: &'static str) -> Result<(), Refusal> {
        if phases.contains(&self.phase) {
            return Ok(());
        }
        Err(Refusal::OutOfOrder { phase: self.phase.description(), advice })
    }

    /// Sets the relative tolerance, start and stop time, s, from the host (`fmi2SetupExperiment`).
    ///
    /// # Errors
    /// After initialization has begun; for invalid times or tolerance.
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

    /// From now on outputs are calculated from parameters and inputs (`fmi2EnterInitializationMode`).
    ///
    /// # Errors
    /// Unless newly instantiated or reset.
    pub fn enter_initialization(&mut self) -> Result<(), Refusal> {
        self.need(&[Phase::Instantiated], "an instance is initialized once; call fmi2Reset to do it again")?;
        self.phase = Phase::Initialization;
        self.outputs = None;
        Ok(())
    }

    /// Fills the chamber with its initial state and starts the simulation (`fmi2ExitInitializationMode`).
    ///
    /// # Errors
    /// Outside initialization mode; for inconsistent parameters.
    pub fn exit_initialization(&mut self) -> Result<(), Refusal> {
        self.need(&[Phase::Initialization], "call fmi2EnterInitializationMode first")?;
        self.now.begin()?;
        self.look_at_parameters();
        self.phase = match self.now.kind {
            Kind::CoSimulation if !self.uses_event_mode => Phase::Step,
            _ => Phase::Event,
        };
        self.outputs = None;
        Ok(())
    }

    fn look_at_parameters(&mut self) {
        let messages = &mut self.messages;
        self.warnings.of_parameters(&self.now, &mut |text| messages.push(warning(text)));
    }

    /// Ends the simulation; its last values remain readable (`fmi2Terminate`).
    ///
    /// # Errors
    /// If no simulation is running.
    pub fn terminate(&mut self) -> Result<(), Refusal> {
        self.need(&Phase::RUNNING, "only a running simulation can be terminated")?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// `fmi2Reset`: back to the state after instantiation. Saved states remain valid.
    pub fn reset(&mut self) {
        self.now = Simulation::new(&self.starts, self.now.kind);
        self.phase = Phase::Instantiated;
        self.outputs = None;
        self.warnings = Warnings::default();
        self.refused = None;
    }
}

/// A warning about an accepted call.
fn warning(text: String) -> Message {
    Message { status: Status::Warning, category: Category::Warning, text }
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
