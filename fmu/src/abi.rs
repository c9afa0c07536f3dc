//! The C boundary: the 34 functions of FMI 2.0 for co-simulation, and the only `unsafe` of the project.
//!
//! Each function checks its pointers, turns them into slices, and hands over to [`Instance`]; what comes back is logged
//! and turned into a status. No panic crosses the boundary: an instance that broke down answers `fmi2Error` until it is
//! reset, all others live on. Signatures: fmi2FunctionTypes.h of FMI 2.0.5.

#![allow(unsafe_code, non_snake_case, clippy::missing_safety_doc)]

use crate::block::{self, Block};
use crate::host::{CEnum, Callbacks, Host};
use crate::instance::Instance;
use crate::refusal::{Category, Refusal, Status};
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::NonNull;
use std::slice;

/// The start values; the packager overwrites them in the library's file.
static START_VALUES: [u8; block::LENGTH] = block::AS_BUILT;

/// Elements that one call may have: far more than there are variables.
const LONGEST: usize = 1 << 20;
const TRUE: c_int = 1;
const FALSE: c_int = 0;

/// What the host holds as `fmi2Component`.
pub struct Component {
    host: Host,
    instance: Instance,
    broken: bool,
}

type Result<T> = std::result::Result<T, Refusal>;

/// Runs `call` on the component; logs a refusal; keeps a panic from the host.
unsafe fn guarded(c: *mut c_void, function: &'static str, call: impl FnOnce(&mut Component) -> Result<()>) -> CEnum {
    let Some(component) = (unsafe { c.cast::<Component>().as_mut() }) else { return Status::Error as CEnum };
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let outcome = if component.broken { Err(Refusal::Broken) } else { call(component) };
        match outcome {
            Ok(()) => Status::Ok,
            Err(refusal) => component.host.refused(function, &refusal),
        }
    }));
    let status = outcome.unwrap_or_else(|panic| {
        component.broken = true;
        // Reporting must not fail either: a logger that unwinds is the host's own affair, but never ends the process here.
        let _ = catch_unwind(AssertUnwindSafe(|| component.host.broke_down(function, &*panic)));
        Status::Error
    });
    status as CEnum
}

/// The `length` elements at `data`; none when the length is zero, whatever the pointer.
unsafe fn elements<'a, T>(data: *const T, length: usize, argument: &'static str) -> Result<&'a [T]> {
    if length == 0 {
        return Ok(&[]);
    }
    if length > LONGEST {
        return Err(Refusal::TooLong { argument, length, limit: LONGEST });
    }
    if data.is_null() || !data.is_aligned() {
        return Err(Refusal::Null { argument });
    }
    Ok(unsafe { slice::from_raw_parts(data, length) })
}

/// As [`elements`], to be written.
unsafe fn elements_mut<'a, T>(data: *mut T, length: usize, argument: &'static str) -> Result<&'a mut [T]> {
    unsafe { elements(data, length, argument)? };
    let data = NonNull::new(data).filter(|_| length > 0).unwrap_or(NonNull::dangling());
    Ok(unsafe { slice::from_raw_parts_mut(data.as_ptr(), length) })
}

/// Text of a C string, `None` where it is NULL.
unsafe fn text(data: *const c_char) -> Option<String> {
    if data.is_null() { None } else { Some(unsafe { CStr::from_ptr(data) }.to_string_lossy().into_owned()) }
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
    unsafe {
        guarded(c, "fmi2SetDebugLogging", |component| {
            let mut chosen = Vec::new();
            for &category in elements(categories, n_categories, "categories")? {
                let name = text(category).ok_or(Refusal::Null { argument: "categories[i]" })?;
                chosen.push(name);
            }
            component.host.choose(logging_on != FALSE, &chosen)
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
    let outcome = catch_unwind(AssertUnwindSafe(|| unsafe {
        let callbacks = *functions.as_ref()?;
        let name = text(instance_name);
        let host = Host::new(callbacks, name.as_deref().unwrap_or("(no name)"), logging_on != FALSE);
        let refuse = |why: &str| {
            host.log(Status::Error, Category::Error, &format!("fmi2Instantiate refused: {why}"));
            None
        };
        if name.is_none_or(|name| name.is_empty()) {
            return refuse("instanceName is NULL or empty");
        }
        const CO_SIMULATION: CEnum = 1;
        if fmu_type != CO_SIMULATION {
            return refuse("fmuType is not fmi2CoSimulation, the only one this FMU offers");
        }
        // Volatile: the packager changes these bytes after compilation.
        let block: [u8; block::LENGTH] = std::ptr::read_volatile(&raw const START_VALUES);
        let Some(block) = Block::decode(&block) else {
            return refuse("the start values inside the library are damaged: package the FMU again");
        };
        match text(guid) {
            Some(asked) if asked == block.guid => {}
            Some(asked) => {
                let own = &block.guid;
                return refuse(&format!(
                    "guid {asked} is not the library's {own}: description and library are of different FMUs"
                ));
            }
            None => return refuse("fmuGUID is NULL"),
        }
        let instance = Instance::new(&block.starts, &block.guid);
        Some(Box::into_raw(Box::new(Component { host, instance, broken: false })))
    }));
    outcome.ok().flatten().map_or(std::ptr::null_mut(), <*mut Component>::cast)
}

/// `fmi2FreeInstance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: *mut c_void) {
    if !c.is_null() {
        let _ = catch_unwind(|| drop(unsafe { Box::from_raw(c.cast::<Component>()) }));
    }
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
    unsafe {
        guarded(c, "fmi2SetupExperiment", |component| component.instance.setup_experiment(tolerance, start_time, stop))
    }
}

/// `fmi2EnterInitializationMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: *mut c_void) -> CEnum {
    unsafe { guarded(c, "fmi2EnterInitializationMode", |component| component.instance.enter_initialization()) }
}

/// `fmi2ExitInitializationMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: *mut c_void) -> CEnum {
    unsafe { guarded(c, "fmi2ExitInitializationMode", |component| component.instance.exit_initialization()) }
}

/// `fmi2Terminate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: *mut c_void) -> CEnum {
    unsafe { guarded(c, "fmi2Terminate", |component| component.instance.terminate()) }
}

/// `fmi2Reset`: allowed always, also after a break-down.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: *mut c_void) -> CEnum {
    if let Some(component) = unsafe { c.cast::<Component>().as_mut() } {
        component.broken = false;
    }
    unsafe {
        guarded(c, "fmi2Reset", |component| {
            component.instance.reset();
            Ok(())
        })
    }
}

/// `fmi2GetReal`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *mut f64) -> CEnum {
    unsafe {
        guarded(c, "fmi2GetReal", |component| {
            component.instance.get_real(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?)
        })
    }
}

/// `fmi2GetInteger`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *mut c_int) -> CEnum {
    unsafe {
        guarded(c, "fmi2GetInteger", |component| {
            component.instance.get_integer(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?)
        })
    }
}

/// `fmi2GetBoolean`: there is no Boolean variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(c: *mut c_void, vr: *const c_uint, nvr: usize, _value: *mut c_int) -> CEnum {
    unsafe {
        guarded(c, "fmi2GetBoolean", |component| component.instance.none_of_type(elements(vr, nvr, "vr")?, "Boolean"))
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
    unsafe {
        guarded(c, "fmi2GetString", |component| component.instance.none_of_type(elements(vr, nvr, "vr")?, "String"))
    }
}

/// `fmi2SetReal`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *const f64) -> CEnum {
    unsafe {
        guarded(c, "fmi2SetReal", |component| {
            component.instance.set_real(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?)
        })
    }
}

/// `fmi2SetInteger`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *const c_int) -> CEnum {
    unsafe {
        guarded(c, "fmi2SetInteger", |component| {
            component.instance.set_integer(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?)
        })
    }
}

/// `fmi2SetBoolean`: there is no Boolean variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(c: *mut c_void, vr: *const c_uint, nvr: usize, _value: *const c_int) -> CEnum {
    unsafe {
        guarded(c, "fmi2SetBoolean", |component| component.instance.none_of_type(elements(vr, nvr, "vr")?, "Boolean"))
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
    unsafe {
        guarded(c, "fmi2SetString", |component| component.instance.none_of_type(elements(vr, nvr, "vr")?, "String"))
    }
}

/// `fmi2GetFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    unsafe {
        guarded(c, "fmi2GetFMUstate", |component| {
            let state = state.as_mut().ok_or(Refusal::Null { argument: "FMUstate" })?;
            *state = component.instance.save(state.addr()) as *mut c_void;
            Ok(())
        })
    }
}

/// `fmi2SetFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: *mut c_void, state: *mut c_void) -> CEnum {
    unsafe { guarded(c, "fmi2SetFMUstate", |component| component.instance.restore(state.addr())) }
}

/// `fmi2FreeFMUstate`: nothing happens where there is no state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
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
    unsafe {
        guarded(c, "fmi2SerializedFMUstateSize", |component| {
            let size = size.as_mut().ok_or(Refusal::Null { argument: "size" })?;
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
    unsafe {
        guarded(c, "fmi2DeSerializeFMUstate", |component| {
            let state = state.as_mut().ok_or(Refusal::Null { argument: "FMUstate" })?;
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
    unsafe {
        guarded(c, "fmi2DoStep", |component| {
            let taken_up = component.instance.do_step(current_communication_point, communication_step_size)?;
            if let Some(taken_up) = taken_up {
                component.host.event(|| {
                    let (from, to) = (taken_up.reached, taken_up.position);
                    format!("t = {current_communication_point} s: the stroke from {from} m to position = {to} m was taken up adiabatically")
                });
            }
            Ok(())
        })
    }
}

/// `fmi2CancelStep`: steps are never pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: *mut c_void) -> CEnum {
    let advice = "a step is done when fmi2DoStep returns, there is none to cancel";
    unsafe { guarded(c, "fmi2CancelStep", |_| Err(Refusal::OutOfOrder { phase: "while no step is pending", advice })) }
}

/// Steps are done when fmi2DoStep returns: of the status kinds only the times and the wish to end have an answer.
unsafe fn no_status(c: *mut c_void, function: &'static str) -> CEnum {
    let what = "no step is pending; fmi2LastSuccessfulTime and fmi2Terminated can be asked for";
    unsafe { guarded(c, function, |_| Err(Refusal::NotOffered { what })) }
}

/// `fmi2GetStatus`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: *mut c_void, _kind: CEnum, _value: *mut CEnum) -> CEnum {
    unsafe { no_status(c, "fmi2GetStatus") }
}

/// `fmi2GetRealStatus`: the last successful time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: *mut c_void, kind: CEnum, value: *mut f64) -> CEnum {
    const LAST_SUCCESSFUL_TIME: CEnum = 2;
    if kind != LAST_SUCCESSFUL_TIME {
        return unsafe { no_status(c, "fmi2GetRealStatus") };
    }
    unsafe {
        guarded(c, "fmi2GetRealStatus", |component| {
            *value.as_mut().ok_or(Refusal::Null { argument: "value" })? = component.instance.time();
            Ok(())
        })
    }
}

/// `fmi2GetIntegerStatus`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(c: *mut c_void, _kind: CEnum, _value: *mut c_int) -> CEnum {
    unsafe { no_status(c, "fmi2GetIntegerStatus") }
}

/// `fmi2GetBooleanStatus`: the FMU never wants to end the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: *mut c_void, kind: CEnum, value: *mut c_int) -> CEnum {
    const TERMINATED: CEnum = 3;
    if kind != TERMINATED {
        return unsafe { no_status(c, "fmi2GetBooleanStatus") };
    }
    unsafe {
        guarded(c, "fmi2GetBooleanStatus", |_| {
            *value.as_mut().ok_or(Refusal::Null { argument: "value" })? = FALSE;
            Ok(())
        })
    }
}

/// `fmi2GetStringStatus`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(c: *mut c_void, _kind: CEnum, _value: *mut *const c_char) -> CEnum {
    unsafe { no_status(c, "fmi2GetStringStatus") }
}

const _: () = assert!(TRUE == 1 && size_of::<c_uint>() == 4 && size_of::<c_int>() == 4);
