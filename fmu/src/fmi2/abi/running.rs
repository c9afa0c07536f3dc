//! Running a simulation in FMI 2.0: steps of co-simulation, time and states of Model Exchange, events.

use super::*;

/// Steps are complete when fmi2DoStep returns: only the time and termination status kinds can be queried.
const NO_STATUS: Refusal =
    Refusal::NotOffered { what: "no step is pending; ask for fmi2LastSuccessfulTime or fmi2Terminated" };
/// `fmi2LastSuccessfulTime`.
const LAST_SUCCESSFUL_TIME: CEnum = 2;
/// `fmi2Terminated`.
const TERMINATED: CEnum = 3;

c_functions! {
    /// One communication step, s; if no accurate step exists, returns fmi2Discard and leaves the instance unchanged.
    extern "C" fn fmi2DoStep(
        current_communication_point: f64,
        communication_step_size: f64,
        _no_set_fmu_state_prior_to_current_point: c_int,
    ) = |instance| instance.do_step(current_communication_point, communication_step_size);

    /// `fmi2CancelStep`: steps are never pending.
    extern "C" fn fmi2CancelStep() = |_| Err(Refusal::OutOfOrder {
        phase: "while no step is pending",
        advice: "every step is complete when fmi2DoStep returns, so there is none to cancel",
    });

    /// Always refused: a step is never pending.
    extern "C" fn fmi2GetStatus(_kind: CEnum, _value: *mut CEnum) = |_| Err(NO_STATUS);

    /// `fmi2GetRealStatus`: the last successful time.
    extern "C" fn fmi2GetRealStatus(kind: CEnum, value: *mut f64) = |instance| {
        if kind != LAST_SUCCESSFUL_TIME {
            return Err(NO_STATUS);
        }
        *destination(value, "value")? = instance.time();
        Ok(())
    };

    /// Always refused: no status is an Integer.
    extern "C" fn fmi2GetIntegerStatus(_kind: CEnum, _value: *mut c_int) = |_| Err(NO_STATUS);

    /// `fmi2GetBooleanStatus`: asks to terminate if the host repeats a discarded step, which FMPy would do forever.
    extern "C" fn fmi2GetBooleanStatus(kind: CEnum, value: *mut c_int) = |instance| {
        if kind != TERMINATED {
            return Err(NO_STATUS);
        }
        *destination(value, "value")? = c_int::from(instance.is_stuck());
        Ok(())
    };

    /// Always refused: a step is never pending.
    extern "C" fn fmi2GetStringStatus(_kind: CEnum, _value: *mut *const c_char) = |_| Err(NO_STATUS);

    /// Handles an event, always in one iteration.
    extern "C" fn fmi2NewDiscreteStates(info: *mut EventInfo) = |instance| {
        let info = destination(info, "fmi2eventInfo")?;
        let event = instance.new_discrete_states()?;
        *info = EventInfo {
            values_of_continuous_states_changed: c_int::from(event.states_changed),
            next_event_time_defined: c_int::from(event.next.is_some()),
            next_event_time: event.next.unwrap_or_default(),
            ..EventInfo::default()
        };
        Ok(())
    };

    /// `fmi2CompletedIntegratorStep`: never causes an event or the end of the simulation.
    extern "C" fn fmi2CompletedIntegratorStep(
        _no_set_fmu_state_prior_to_current_point: c_int,
        enter_event_mode: *mut c_int,
        terminate_simulation: *mut c_int,
    ) = |instance| boundary::completed_step(instance, enter_event_mode, terminate_simulation);

    /// Sets the time for a host that integrates, s.
    extern "C" fn fmi2SetTime(time: f64) = |instance| instance.set_time(time);

    /// Sets the states for a host that integrates, in the order of the model description; all must be finite, or none is set.
    extern "C" fn fmi2SetContinuousStates(x: *const f64, nx: usize) =
        |instance| instance.set_continuous_states(elements(x, nx, "x")?);

    /// The continuous states, in the order of the model description.
    extern "C" fn fmi2GetContinuousStates(x: *mut f64, nx: usize) =
        |instance| instance.continuous_states(elements_mut(x, nx, "x")?);

    /// Time derivatives of the continuous states, SI units per s.
    extern "C" fn fmi2GetDerivatives(derivatives: *mut f64, nx: usize) =
        |instance| instance.derivatives(elements_mut(derivatives, nx, "derivatives")?);

    /// Functions that change sign at the kinks of the equations.
    extern "C" fn fmi2GetEventIndicators(indicators: *mut f64, ni: usize) =
        |instance| instance.event_indicators(elements_mut(indicators, ni, "eventIndicators")?);

    /// Orders of magnitude of the continuous states, constant, SI units.
    extern "C" fn fmi2GetNominalsOfContinuousStates(x_nominal: *mut f64, nx: usize) =
        |instance| instance.nominals(elements_mut(x_nominal, nx, "x_nominal")?);
}
