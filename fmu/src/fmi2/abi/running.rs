//! A simulation under way in FMI 2.0: steps of co-simulation, time and states of Model Exchange, events.

use super::*;

/// One communication step, s; where no accurate step exists, fmi2Discard and the instance as it was.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: *mut c_void,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: c_int,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2DoStep", |component| {
            component.instance.do_step(current_communication_point, communication_step_size)
        })
    }
}

/// `fmi2CancelStep`: steps are never pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: *mut c_void) -> CEnum {
    let advice = "every step is complete when fmi2DoStep returns, so there is none to cancel";
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2CancelStep", |_| Err(Refusal::OutOfOrder { phase: "while no step is pending", advice })) }
}

/// Steps are done when fmi2DoStep returns: of the status kinds only the times and the wish to end have an answer.
unsafe fn no_status(c: *mut c_void, function: &'static str) -> CEnum {
    let what = "no step is pending; ask for fmi2LastSuccessfulTime or fmi2Terminated";
    // SAFETY: the host's component.
    unsafe { guarded(c, function, |_| Err(Refusal::NotOffered { what })) }
}

/// Always refused: a step is never pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: *mut c_void, _kind: CEnum, _value: *mut CEnum) -> CEnum {
    // SAFETY: the host's component.
    unsafe { no_status(c, "fmi2GetStatus") }
}

/// `fmi2GetRealStatus`: the last successful time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: *mut c_void, kind: CEnum, value: *mut f64) -> CEnum {
    const LAST_SUCCESSFUL_TIME: CEnum = 2;
    if kind != LAST_SUCCESSFUL_TIME {
        // SAFETY: the host's component.
        return unsafe { no_status(c, "fmi2GetRealStatus") };
    }
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetRealStatus", |component| {
            *place(value, "value")? = component.instance.time();
            Ok(())
        })
    }
}

/// Always refused: no status is an Integer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(c: *mut c_void, _kind: CEnum, _value: *mut c_int) -> CEnum {
    // SAFETY: the host's component.
    unsafe { no_status(c, "fmi2GetIntegerStatus") }
}

/// `fmi2GetBooleanStatus`: the FMU never wants to end the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: *mut c_void, kind: CEnum, value: *mut c_int) -> CEnum {
    const TERMINATED: CEnum = 3;
    if kind != TERMINATED {
        // SAFETY: the host's component.
        return unsafe { no_status(c, "fmi2GetBooleanStatus") };
    }
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetBooleanStatus", |_| {
            *place(value, "value")? = FALSE;
            Ok(())
        })
    }
}

/// Always refused: a step is never pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(c: *mut c_void, _kind: CEnum, _value: *mut *const c_char) -> CEnum {
    // SAFETY: the host's component.
    unsafe { no_status(c, "fmi2GetStringStatus") }
}

/// Handles an event; one iteration is all that it needs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(c: *mut c_void, info: *mut EventInfo) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2NewDiscreteStates", |component| {
            let info = place(info, "fmi2eventInfo")?;
            let event = component.instance.new_discrete_states()?;
            let values_of_continuous_states_changed = c_int::from(event.states_changed);
            *info = EventInfo {
                values_of_continuous_states_changed,
                next_event_time_defined: c_int::from(event.next.is_some()),
                next_event_time: event.next.unwrap_or_default(),
                ..EventInfo::default()
            };
            Ok(())
        })
    }
}

/// `fmi2CompletedIntegratorStep`: no event follows from a step's completion, and no end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: *mut c_void,
    _no_set_fmu_state_prior_to_current_point: c_int,
    enter_event_mode: *mut c_int,
    terminate_simulation: *mut c_int,
) -> CEnum {
    // SAFETY: the host's component and places, as the standard has them.
    unsafe {
        boundary::completed_step::<Host, _>(c, "fmi2CompletedIntegratorStep", enter_event_mode, terminate_simulation)
    }
}

/// Sets the time of a host that integrates, s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: *mut c_void, time: f64) -> CEnum {
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2SetTime", |component| component.instance.set_time(time)) }
}

/// Sets the states of a host that integrates, in their order in the model description; all finite, or none is taken.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(c: *mut c_void, x: *const f64, nx: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetContinuousStates", |component| {
            component.instance.set_continuous_states(elements(x, nx, "x")?)
        })
    }
}

/// The continuous states, in their order in the model description.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(c: *mut c_void, x: *mut f64, nx: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetContinuousStates", |component| {
            component.instance.continuous_states(elements_mut(x, nx, "x")?)
        })
    }
}

/// Time derivatives of the continuous states, SI units per s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(c: *mut c_void, derivatives: *mut f64, nx: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetDerivatives", |component| {
            component.instance.derivatives(elements_mut(derivatives, nx, "derivatives")?)
        })
    }
}

/// Functions that change their sign at the corners of the equations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(c: *mut c_void, indicators: *mut f64, ni: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetEventIndicators", |component| {
            component.instance.event_indicators(elements_mut(indicators, ni, "eventIndicators")?)
        })
    }
}

/// Orders of magnitude of the continuous states, constant, SI units.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(c: *mut c_void, x_nominal: *mut f64, nx: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetNominalsOfContinuousStates", |component| {
            component.instance.nominals(elements_mut(x_nominal, nx, "x_nominal")?)
        })
    }
}
