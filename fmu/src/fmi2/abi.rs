//! The C functions of FMI 2.0 for Model Exchange and co-simulation: each turns its pointers into slices and hands over to
//! the [`Instance`](crate::protocol::instance::Instance). Signatures: fmi2FunctionTypes.h of FMI 2.0.5.
//!
//! Every function is safe to call as the standard has it: with a component that `fmi2Instantiate` made and
//! `fmi2FreeInstance` has not freed, from one thread at a time, and with arrays as long as the lengths beside them say.

#![allow(unsafe_code, non_snake_case, clippy::missing_safety_doc)]

use super::host::{Callbacks, EventInfo, Host};
use crate::boundary::{self, CEnum, Component, Result, elements, elements_mut, place, text};
use crate::plant::simulation::Kind;
use crate::protocol::refusal::Refusal;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::slice;

const FALSE: c_int = 0;
const TRUE: c_int = 1;

/// Runs `call` on the component behind `c`.
unsafe fn guarded(
    c: *mut c_void,
    function: &'static str,
    call: impl FnOnce(&mut Component<Host>) -> Result<()>,
) -> CEnum {
    // SAFETY: the host's component, as the standard has it.
    unsafe { boundary::guarded::<Host>(c, function, call) }
}

/// `fmi2GetTypesPlatform`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// `fmi2GetVersion`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// `fmi2SetDebugLogging`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: *mut c_void,
    logging_on: c_int,
    n_categories: usize,
    categories: *const *const c_char,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetDebugLogging", |component| {
            let mut chosen = Vec::new();
            for &category in elements(categories, n_categories, "categories")? {
                let name = text(category).ok_or(Refusal::Null { argument: "categories[i]" })?;
                chosen.push(name);
            }
            component.choose(logging_on != FALSE, &chosen)
        })
    }
}

/// `fmi2Instantiate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: *const c_char,
    fmu_type: CEnum,
    guid: *const c_char,
    _resource_location: *const c_char,
    functions: *const Callbacks,
    _visible: c_int,
    logging_on: c_int,
) -> *mut c_void {
    // SAFETY: callbacks and texts are the host's, as the standard has it.
    unsafe {
        let Some(callbacks) = functions.as_ref() else { return std::ptr::null_mut() };
        let name = text(instance_name);
        let host = Host::new(*callbacks, name.as_deref().unwrap_or("(no name)"));
        let kind = match fmu_type {
            0 => Ok(Kind::ModelExchange),
            1 => Ok(Kind::CoSimulation),
            _ => Err("fmuType is neither fmi2ModelExchange nor fmi2CoSimulation"),
        };
        boundary::instantiate(host, logging_on != FALSE, name, text(guid), kind)
    }
}

/// `fmi2FreeInstance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: *mut c_void) {
    // SAFETY: the host's component, freed once.
    unsafe { boundary::free::<Host>(c) };
}

/// `fmi2SetupExperiment`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: *mut c_void,
    tolerance_defined: c_int,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: c_int,
    stop_time: f64,
) -> CEnum {
    let tolerance = (tolerance_defined != FALSE).then_some(tolerance);
    let stop = (stop_time_defined != FALSE).then_some(stop_time);
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetupExperiment", |component| component.instance.setup_experiment(tolerance, start_time, stop))
    }
}

/// `fmi2EnterInitializationMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2EnterInitializationMode", |component| component.instance.enter_initialization()) }
}

/// `fmi2ExitInitializationMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2ExitInitializationMode", |component| component.instance.exit_initialization()) }
}

/// `fmi2Terminate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: *mut c_void) -> CEnum {
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2Terminate", |component| component.instance.terminate()) }
}

/// `fmi2Reset`: allowed always, also after a break-down.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: *mut c_void) -> CEnum {
    // SAFETY: the host's component.
    unsafe { boundary::reset::<Host>(c) }
}

/// `fmi2GetReal`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *mut f64) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetReal", |component| {
            component.instance.get_real(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?)
        })
    }
}

/// `fmi2GetInteger`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *mut c_int) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetInteger", |component| {
            component.instance.get_integer(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?)
        })
    }
}

/// `fmi2GetBoolean`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *mut c_int) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetBoolean", |component| {
            let (references, values) = (elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?);
            let mut booleans = vec![false; nvr];
            component.instance.get_boolean(references, &mut booleans)?;
            for (value, boolean) in values.iter_mut().zip(booleans) {
                *value = if boolean { TRUE } else { FALSE };
            }
            Ok(())
        })
    }
}

/// `fmi2GetString`: there is no String variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: *mut c_void,
    vr: *const c_uint,
    nvr: usize,
    _value: *mut *const c_char,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetString", |component| component.instance.none_of_type(elements(vr, nvr, "vr")?, "String"))
    }
}

/// `fmi2SetReal`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *const f64) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetReal", |component| {
            component.instance.set_real(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?)
        })
    }
}

/// `fmi2SetInteger`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *const c_int) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetInteger", |component| {
            component.instance.set_integer(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?)
        })
    }
}

/// `fmi2SetBoolean`: any number but zero is true.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *const c_int) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetBoolean", |component| {
            let values: Vec<bool> = elements(value, nvr, "value")?.iter().map(|value| *value != FALSE).collect();
            component.instance.set_boolean(elements(vr, nvr, "vr")?, &values)
        })
    }
}

/// `fmi2SetString`: there is no String variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: *mut c_void,
    vr: *const c_uint,
    nvr: usize,
    _value: *const *const c_char,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetString", |component| component.instance.none_of_type(elements(vr, nvr, "vr")?, "String"))
    }
}

/// `fmi2GetFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetFMUstate", |component| {
            let state = place(state, "FMUstate")?;
            *state = component.instance.save(state.addr()) as *mut c_void;
            Ok(())
        })
    }
}

/// `fmi2SetFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: *mut c_void, state: *mut c_void) -> CEnum {
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2SetFMUstate", |component| component.instance.restore(state.addr())) }
}

/// `fmi2FreeFMUstate`: nothing happens where there is no state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2FreeFMUstate", |component| {
            if let Some(state) = state.as_mut().filter(|state| !state.is_null()) {
                component.instance.free(state.addr())?;
                *state = std::ptr::null_mut();
            }
            Ok(())
        })
    }
}

/// `fmi2SerializedFMUstateSize`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: *mut c_void, state: *mut c_void, size: *mut usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SerializedFMUstateSize", |component| {
            let size = place(size, "size")?;
            *size = component.instance.serialize(state.addr())?.len();
            Ok(())
        })
    }
}

/// `fmi2SerializeFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: *mut c_void,
    state: *mut c_void,
    bytes: *mut c_char,
    size: usize,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SerializeFMUstate", |component| {
            let serialized = component.instance.serialize(state.addr())?;
            if size < serialized.len() {
                return Err(Refusal::BadBytes { why: "size is less than fmi2SerializedFMUstateSize says" });
            }
            if bytes.is_null() {
                return Err(Refusal::Null { argument: "serializedState" });
            }
            slice::from_raw_parts_mut(bytes.cast::<u8>(), serialized.len()).copy_from_slice(&serialized);
            Ok(())
        })
    }
}

/// `fmi2DeSerializeFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: *mut c_void,
    bytes: *const c_char,
    size: usize,
    state: *mut *mut c_void,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2DeSerializeFMUstate", |component| {
            let state = place(state, "FMUstate")?;
            if bytes.is_null() || size > isize::MAX as usize {
                return Err(Refusal::Null { argument: "serializedState" });
            }
            *state = component.instance.deserialize(slice::from_raw_parts(bytes.cast::<u8>(), size))? as *mut c_void;
            Ok(())
        })
    }
}

/// `fmi2GetDirectionalDerivative`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: *mut c_void,
    unknown: *const c_uint,
    n_unknown: usize,
    known: *const c_uint,
    n_known: usize,
    direction: *const f64,
    value: *mut f64,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetDirectionalDerivative", |component| {
            component.instance.directional(
                elements(unknown, n_unknown, "vUnknown_ref")?,
                elements(known, n_known, "vKnown_ref")?,
                elements(direction, n_known, "dvKnown")?,
                elements_mut(value, n_unknown, "dvUnknown")?,
            )
        })
    }
}

/// `fmi2SetRealInputDerivatives`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: *mut c_void,
    vr: *const c_uint,
    nvr: usize,
    order: *const c_int,
    value: *const f64,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetRealInputDerivatives", |component| {
            component.instance.set_input_derivatives(
                elements(vr, nvr, "vr")?,
                elements(order, nvr, "order")?,
                elements(value, nvr, "value")?,
            )
        })
    }
}

/// `fmi2GetRealOutputDerivatives`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: *mut c_void,
    vr: *const c_uint,
    nvr: usize,
    order: *const c_int,
    value: *mut f64,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetRealOutputDerivatives", |component| {
            component.instance.output_derivatives(
                elements(vr, nvr, "vr")?,
                elements(order, nvr, "order")?,
                elements_mut(value, nvr, "value")?,
            )
        })
    }
}

/// `fmi2DoStep`.
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

/// `fmi2GetStatus`.
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

/// `fmi2GetIntegerStatus`.
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

/// `fmi2GetStringStatus`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(c: *mut c_void, _kind: CEnum, _value: *mut *const c_char) -> CEnum {
    // SAFETY: the host's component.
    unsafe { no_status(c, "fmi2GetStringStatus") }
}

/// `fmi2EnterEventMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2EnterEventMode", |component| component.instance.enter_event()) }
}

/// `fmi2NewDiscreteStates`.
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

/// `fmi2EnterContinuousTimeMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2EnterContinuousTimeMode", |component| component.instance.enter_continuous_time()) }
}

/// `fmi2CompletedIntegratorStep`: no event follows from a step's completion, and no end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: *mut c_void,
    _no_set_fmu_state_prior_to_current_point: c_int,
    enter_event_mode: *mut c_int,
    terminate_simulation: *mut c_int,
) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2CompletedIntegratorStep", |component| {
            let (enter, end) =
                (place(enter_event_mode, "enterEventMode")?, place(terminate_simulation, "terminateSimulation")?);
            component.instance.completed_step()?;
            (*enter, *end) = (FALSE, FALSE);
            Ok(())
        })
    }
}

/// `fmi2SetTime`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: *mut c_void, time: f64) -> CEnum {
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2SetTime", |component| component.instance.set_time(time)) }
}

/// `fmi2SetContinuousStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(c: *mut c_void, x: *const f64, nx: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetContinuousStates", |component| {
            component.instance.set_continuous_states(elements(x, nx, "x")?)
        })
    }
}

/// `fmi2GetDerivatives`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(c: *mut c_void, derivatives: *mut f64, nx: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetDerivatives", |component| {
            component.instance.derivatives(elements_mut(derivatives, nx, "derivatives")?)
        })
    }
}

/// `fmi2GetEventIndicators`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(c: *mut c_void, indicators: *mut f64, ni: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetEventIndicators", |component| {
            component.instance.event_indicators(elements_mut(indicators, ni, "eventIndicators")?)
        })
    }
}

/// `fmi2GetContinuousStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(c: *mut c_void, x: *mut f64, nx: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetContinuousStates", |component| {
            component.instance.continuous_states(elements_mut(x, nx, "x")?)
        })
    }
}

/// `fmi2GetNominalsOfContinuousStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(c: *mut c_void, x_nominal: *mut f64, nx: usize) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetNominalsOfContinuousStates", |component| {
            component.instance.nominals(elements_mut(x_nominal, nx, "x_nominal")?)
        })
    }
}

const _: () = assert!(size_of::<c_uint>() == 4 && size_of::<c_int>() == 4);
