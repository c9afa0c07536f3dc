//! Running a simulation in FMI 3.0: steps of co-simulation, time and states of Model Exchange, events of both.

use super::*;

c_functions! {
    /// One communication step, s, which ends at the first event if the host allows an early return; if no accurate step exists,
    /// returns fmi3Discard and leaves the instance unchanged.
    extern "C" fn fmi3DoStep(
        point: f64,
        h: f64,
        _no_set_prior: u8,
        event_handling_needed: *mut u8,
        terminate: *mut u8,
        early_return: *mut u8,
        last_successful_time: *mut f64,
    ) = |instance| {
        let event = destination(event_handling_needed, "eventHandlingNeeded")?;
        let end = destination(terminate, "terminateSimulation")?;
        let returned = destination(early_return, "earlyReturn")?;
        let last = destination(last_successful_time, "lastSuccessfulTime")?;
        let outcome = if instance.returns_early {
            instance.do_step_to_event(point, h)
        } else {
            instance.do_step(point, h).map(|()| false)
        };
        *last = instance.time();
        let early = u8::from(outcome?);
        (*event, *end, *returned) = (early, 0, early);
        Ok(())
    };

    /// Handles an event, always in one iteration.
    extern "C" fn fmi3UpdateDiscreteStates(
        again: *mut u8,
        terminate: *mut u8,
        nominals_changed: *mut u8,
        values_changed: *mut u8,
        next_event_time_defined: *mut u8,
        next_event_time: *mut f64,
    ) = |instance| {
        let again = destination(again, "discreteStatesNeedUpdate")?;
        let end = destination(terminate, "terminateSimulation")?;
        let nominals = destination(nominals_changed, "nominalsOfContinuousStatesChanged")?;
        let next_is_known = destination(next_event_time_defined, "nextEventTimeDefined")?;
        let changed = destination(values_changed, "valuesOfContinuousStatesChanged")?;
        let time = destination(next_event_time, "nextEventTime")?;
        let event = instance.new_discrete_states()?;
        (*again, *end, *nominals) = (0, 0, 0);
        (*next_is_known, *time) = (u8::from(event.next.is_some()), event.next.unwrap_or(0.0));
        *changed = u8::from(event.states_changed);
        Ok(())
    };

    /// `fmi3CompletedIntegratorStep`: never causes an event or the end of the simulation.
    extern "C" fn fmi3CompletedIntegratorStep(_no_set_prior: u8, enter_event_mode: *mut u8, terminate: *mut u8) =
        |instance| boundary::completed_step(instance, enter_event_mode, terminate);

    /// Sets the time for a host that integrates, s.
    extern "C" fn fmi3SetTime(time: f64) = |instance| instance.set_time(time);

    /// Sets the states for a host that integrates, in the order of the model description; all must be finite, or none is set.
    extern "C" fn fmi3SetContinuousStates(values: *const f64, n: usize) =
        |instance| instance.set_continuous_states(elements(values, n, "continuousStates")?);

    /// The continuous states, in the order of the model description.
    extern "C" fn fmi3GetContinuousStates(values: *mut f64, n: usize) =
        |instance| instance.continuous_states(elements_mut(values, n, "continuousStates")?);

    /// Time derivatives of the continuous states, SI units per s.
    extern "C" fn fmi3GetContinuousStateDerivatives(values: *mut f64, n: usize) =
        |instance| instance.derivatives(elements_mut(values, n, "derivatives")?);

    /// Functions that change sign at the kinks of the equations.
    extern "C" fn fmi3GetEventIndicators(values: *mut f64, n: usize) =
        |instance| instance.event_indicators(elements_mut(values, n, "eventIndicators")?);

    /// Orders of magnitude of the continuous states, constant, SI units.
    extern "C" fn fmi3GetNominalsOfContinuousStates(values: *mut f64, n: usize) =
        |instance| instance.nominals(elements_mut(values, n, "nominals")?);

    /// Number of event indicators, constant.
    extern "C" fn fmi3GetNumberOfEventIndicators(n: *mut usize) = |_| {
        *destination(n, "n")? = EVENT_INDICATORS;
        Ok(())
    };

    /// Number of continuous states, constant.
    extern "C" fn fmi3GetNumberOfContinuousStates(n: *mut usize) = |_| {
        *destination(n, "n")? = ALL;
        Ok(())
    };
}
