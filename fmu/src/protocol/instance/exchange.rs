//! Events, and functions for a host that integrates: modes, time, states, rates and event indicators.

use super::{Event, Instance, warning};
use crate::plant::event_indicators::EVENT_INDICATORS;
use crate::plant::simulation::Kind;
use crate::plant::states::ALL;
use crate::protocol::phases::Phase;
use crate::protocol::refusal::Refusal;
use crate::table::{self, index_of_state, table};

impl Instance {
    /// Stops continuous time, or steps that use event mode, for an event (`fmi2EnterEventMode`).
    ///
    /// # Errors
    /// Outside a running Model Exchange simulation.
    pub fn enter_event(&mut self) -> Result<(), Refusal> {
        let step = if self.uses_event_mode { Phase::Step } else { Phase::Continuous };
        self.need(&[Phase::Continuous, Phase::Event, step], "enter event mode from continuous-time mode")?;
        if self.phase == Phase::Continuous {
            self.now.enter_event()?;
        }
        self.phase = Phase::Event;
        Ok(())
    }

    /// `fmi2NewDiscreteStates`: every event needs only one iteration.
    ///
    /// # Errors
    /// Outside event mode; if inputs leave the gas no room.
    pub fn new_discrete_states(&mut self) -> Result<Event, Refusal> {
        self.need(&[Phase::Event], "call fmi2EnterEventMode first")?;
        let states_changed = self.now.kind == Kind::ModelExchange && self.now.handle_event()?;
        self.outputs = None;
        self.warnings.forget_position();
        let next = self.now.default_motion_change().filter(|_| self.now.kind == Kind::ModelExchange);
        Ok(Event { states_changed, next })
    }

    /// Resumes integration by the host after event mode (`fmi2EnterContinuousTimeMode`).
    ///
    /// # Errors
    /// Outside event mode.
    pub fn enter_continuous_time(&mut self) -> Result<(), Refusal> {
        self.need_exchange()?;
        self.need(&[Phase::Event], "enter continuous-time mode from event mode")?;
        self.phase = Phase::Continuous;
        Ok(())
    }

    /// Called when the host's integrator accepted a step: a delayed record stores the sensor's readings within it
    /// (`fmi2CompletedIntegratorStep`).
    ///
    /// # Errors
    /// Outside continuous-time mode; for states impossible for a gas.
    pub fn completed_step(&mut self) -> Result<(), Refusal> {
        self.need(&[Phase::Continuous], "complete integrator steps in continuous-time mode")?;
        self.now.complete_step()?;
        let messages = &mut self.messages;
        self.warnings.at_completed_step(&self.now, &mut |text| messages.push(warning(text)));
        Ok(())
    }

    /// Sets the time for a host that integrates, s (`fmi2SetTime`).
    ///
    /// # Errors
    /// Outside a running Model Exchange simulation; for a time that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<(), Refusal> {
        self.need_exchange()?;
        self.need(&[Phase::Event, Phase::Continuous], "the time is set in event mode or continuous-time mode")?;
        if !time.is_finite() {
            return Err(Refusal::BadArgument { argument: "time", value: time, expected: "a finite time is expected" });
        }
        self.now.time = time;
        self.now.apply_default_motion();
        self.outputs = None;
        Ok(())
    }

    /// Sets the states for a host that integrates, SI units, in the order of [`crate::plant::states`]
    /// (`fmi2SetContinuousStates`).
    ///
    /// # Errors
    /// Outside a running Model Exchange simulation; for a wrong number of states, or states that are not finite.
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Refusal> {
        self.need_exchange()?;
        self.need(
            &[Phase::Event, Phase::Continuous],
            "continuous states are set in event mode or continuous-time mode",
        )?;
        let wrong = |_| Refusal::WrongLength { argument: "nx", length: states.len(), expected: ALL };
        let states: [f64; ALL] = states.try_into().map_err(wrong)?;
        if let Some((value, state)) = states.iter().zip(0..).find(|(value, _)| !value.is_finite()) {
            let variable = index_of_state(state).and_then(|index| table().get(index));
            let (name, unit) = variable.map_or(("state", ""), |v| (v.name.as_str(), v.quantity.unit));
            return Err(Refusal::NotFinite { name, value: *value, unit });
        }
        self.now.gas.states = states;
        self.outputs = None;
        Ok(())
    }

    /// The states, SI units; in initialization mode those given by parameters and inputs (`fmi2GetContinuousStates`).
    ///
    /// # Errors
    /// Outside Model Exchange; for a wrong number of states.
    pub fn continuous_states(&mut self, states: &mut [f64]) -> Result<(), Refusal> {
        self.exchange()?;
        let states: &mut [f64; ALL] = of_length(states, "nx")?;
        *states = if self.now.started { self.now.gas.states } else { self.now.present()?.states };
        Ok(())
    }

    /// Time derivatives of the states, SI units per s (`fmi2GetDerivatives`).
    ///
    /// # Errors
    /// Outside Model Exchange; for a wrong number of states, or states impossible for a gas.
    pub fn derivatives(&mut self, rates: &mut [f64]) -> Result<(), Refusal> {
        self.exchange()?;
        let rates: &mut [f64; ALL] = of_length(rates, "nx")?;
        *rates = self.known()?.rates;
        Ok(())
    }

    /// Functions of order one that change sign at the kinks of the equations (`fmi2GetEventIndicators`).
    ///
    /// # Errors
    /// Outside Model Exchange; for a wrong number of indicators, or states impossible for a gas.
    pub fn event_indicators(&mut self, indicators: &mut [f64]) -> Result<(), Refusal> {
        self.exchange()?;
        let indicators: &mut [f64; EVENT_INDICATORS] = of_length(indicators, "ni")?;
        *indicators = self.now.indicators()?;
        Ok(())
    }

    /// One event indicator, as a variable of FMI 3.0.
    ///
    /// # Errors
    /// Before initialization mode; for states impossible for a gas.
    pub fn indicator(&self, index: usize) -> Result<f64, Refusal> {
        self.need(&Phase::KNOWN, "event indicators are available from initialization mode on")?;
        Ok(self.now.indicators()?[index])
    }

    /// Orders of magnitude of the states, SI units (`fmi2GetNominalsOfContinuousStates`).
    ///
    /// # Errors
    /// Outside Model Exchange; for a wrong number of states.
    pub fn nominals(&self, nominals: &mut [f64]) -> Result<(), Refusal> {
        self.need_exchange()?;
        let nominals: &mut [f64; ALL] = of_length(nominals, "nx")?;
        *nominals = table::nominals();
        Ok(())
    }

    fn need_exchange(&self) -> Result<(), Refusal> {
        if self.now.kind == Kind::CoSimulation {
            return Err(Refusal::NotOffered {
                what: "this instance is for co-simulation: its time, states and indicators are set and read in Model Exchange only",
            });
        }
        Ok(())
    }

    fn exchange(&self) -> Result<(), Refusal> {
        self.need_exchange()?;
        self.need(&Phase::EXCHANGE, "states, derivatives and indicators are available from initialization mode on")
    }
}

/// Checks the length of the host's array, which must be the number of states or indicators.
fn of_length<'a, const N: usize>(array: &'a mut [f64], argument: &'static str) -> Result<&'a mut [f64; N], Refusal> {
    let length = array.len();
    array.try_into().map_err(|_| Refusal::WrongLength { argument, length, expected: N })
}
