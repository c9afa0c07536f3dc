//! A simulation under way in FMI 3.0: steps of co-simulation, time and states of Model Exchange, events of both.

use super::*;

/// One communication step, s, which ends at the first event where the host allows an early return; where no accurate step
/// exists, fmi3Discard and the instance as it was.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    c: *mut c_void,
    point: f64,
    h: f64,
    _no_set_prior: u8,
    event_handling_needed: *mut u8,
    terminate: *mut u8,
    early_return: *mut u8,
    last_successful_time: *mut f64,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3DoStep", |component| {
            let flags = [
                place(event_handling_needed, "eventHandlingNeeded")?,
                place(terminate, "terminateSimulation")?,
                place(early_return, "earlyReturn")?,
            ];
            let last = place(last_successful_time, "lastSuccessfulTime")?;
            let instance = &mut component.instance;
            let outcome = if instance.returns_early {
                instance.do_step_to_event(point, h)
            } else {
                instance.do_step(point, h).map(|()| false)
            };
            *last = instance.time();
            let early = outcome?;
            let [event, end, returned] = flags;
            (*event, *end, *returned) = (u8::from(early), 0, u8::from(early));
            Ok(())
        })
    }
}

/// Handles an event; one iteration is all that it needs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    c: *mut c_void,
    again: *mut u8,
    terminate: *mut u8,
    nominals_changed: *mut u8,
    values_changed: *mut u8,
    next_event_time_defined: *mut u8,
    next_event_time: *mut f64,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3UpdateDiscreteStates", |component| {
            let flags = [
                place(again, "discreteStatesNeedUpdate")?,
                place(terminate, "terminateSimulation")?,
                place(nominals_changed, "nominalsOfContinuousStatesChanged")?,
            ];
            let next_is_known = place(next_event_time_defined, "nextEventTimeDefined")?;
            let (changed, time) =
                (place(values_changed, "valuesOfContinuousStatesChanged")?, place(next_event_time, "nextEventTime")?);
            let event = component.instance.new_discrete_states()?;
            flags.into_iter().for_each(|flag| *flag = 0);
            *next_is_known = u8::from(event.next.is_some());
            (*changed, *time) = (u8::from(event.states_changed), event.next.unwrap_or(0.0));
            Ok(())
        })
    }
}

/// `fmi3CompletedIntegratorStep`: no event follows from a step's completion, and no end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    c: *mut c_void,
    _no_set_prior: u8,
    enter_event_mode: *mut u8,
    terminate: *mut u8,
) -> CEnum {
    // SAFETY: the host's instance and places, as the standard has them.
    unsafe { boundary::completed_step::<Host, _>(c, "fmi3CompletedIntegratorStep", enter_event_mode, terminate) }
}

/// Sets the time of a host that integrates, s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(c: *mut c_void, time: f64) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe { guarded(c, "fmi3SetTime", |component| component.instance.set_time(time)) }
}

/// Sets the states of a host that integrates, in their order in the model description; all finite, or none is taken.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetContinuousStates(c: *mut c_void, values: *const f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetContinuousStates", |component| {
            component.instance.set_continuous_states(elements(values, n, "continuousStates")?)
        })
    }
}

/// The continuous states, in their order in the model description.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStates(c: *mut c_void, values: *mut f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetContinuousStates", |component| {
            component.instance.continuous_states(elements_mut(values, n, "continuousStates")?)
        })
    }
}

/// Time derivatives of the continuous states, SI units per s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStateDerivatives(c: *mut c_void, values: *mut f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetContinuousStateDerivatives", |component| {
            component.instance.derivatives(elements_mut(values, n, "derivatives")?)
        })
    }
}

/// Functions that change their sign at the corners of the equations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetEventIndicators(c: *mut c_void, values: *mut f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetEventIndicators", |component| {
            component.instance.event_indicators(elements_mut(values, n, "eventIndicators")?)
        })
    }
}

/// Orders of magnitude of the continuous states, constant, SI units.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNominalsOfContinuousStates(c: *mut c_void, values: *mut f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetNominalsOfContinuousStates", |component| {
            component.instance.nominals(elements_mut(values, n, "nominals")?)
        })
    }
}

/// Number of event indicators, constant.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfEventIndicators(c: *mut c_void, n: *mut usize) -> CEnum {
    // SAFETY: the host's instance and place.
    unsafe {
        guarded(c, "fmi3GetNumberOfEventIndicators", |_| {
            *place(n, "n")? = CORNERS;
            Ok(())
        })
    }
}

/// Number of continuous states, constant.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfContinuousStates(c: *mut c_void, n: *mut usize) -> CEnum {
    // SAFETY: the host's instance and place.
    unsafe {
        guarded(c, "fmi3GetNumberOfContinuousStates", |_| {
            *place(n, "n")? = ALL;
            Ok(())
        })
    }
}
