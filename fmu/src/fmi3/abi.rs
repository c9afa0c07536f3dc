//! The C functions of FMI 3.0 for Model Exchange and co-simulation: each turns its pointers into slices and hands over to
//! the [`Instance`], as those of FMI 2.0 do. Signatures: fmi3FunctionTypes.h of FMI 3.0.2.
//!
//! Every function is safe to call as the standard has it: with an instance that was made here and has not been freed, from
//! one thread at a time, and with arrays as long as the lengths beside them say. Booleans arrive as bytes.

#![allow(unsafe_code, non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]

use super::host::{Host, LogMessage};
use super::{indicator_references, time_reference};
use crate::boundary::{self, CEnum, Component, Result, elements, elements_mut, place, text};
use crate::plant::corners::CORNERS;
use crate::plant::simulation::Kind;
use crate::plant::states::ALL;
use crate::protocol::instance::Instance;
use crate::protocol::refusal::Refusal;
use std::ffi::{c_char, c_void};
use std::slice;

/// Runs `call` on the instance behind `c`.
unsafe fn guarded(
    c: *mut c_void,
    function: &'static str,
    call: impl FnOnce(&mut Component<Host>) -> Result<()>,
) -> CEnum {
    // SAFETY: the host's instance, as the standard has it.
    unsafe { boundary::guarded::<Host>(c, function, |component| call(component).map_err(in_terms_of_fmi3)) }
}

/// A refusal that names types by FMI 3.0's names.
fn in_terms_of_fmi3(refusal: Refusal) -> Refusal {
    let term = |fmi2: &'static str| match fmi2 {
        "Real" => "Float64",
        "Integer" => "Int64",
        other => other,
    };
    match refusal {
        Refusal::WrongType { name, reference, is, asked } => {
            Refusal::WrongType { name, reference, is: term(is), asked: term(asked) }
        }
        other => other,
    }
}

/// The lengths of references and values, equal as every variable is a scalar.
fn same_length(references: usize, values: usize) -> Result<()> {
    if references == values {
        return Ok(());
    }
    Err(Refusal::WrongLength { argument: "nValues", length: values, expected: references })
}

/// A value of a Float64 variable, the time and the event indicators included.
fn float(instance: &mut Instance, reference: u32) -> Result<f64> {
    if reference == time_reference() {
        return Ok(instance.time());
    }
    if let Some(i) = indicator_references().position(|indicator| indicator == reference) {
        return instance.indicator(i);
    }
    let mut value = [0.0];
    instance.get_real(&[reference], &mut value)?;
    Ok(value[0])
}

/// `fmi3GetVersion`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Makes an instance.
unsafe fn instantiate(
    name: *const c_char,
    token: *const c_char,
    logging_on: u8,
    environment: *mut c_void,
    log: LogMessage,
    kind: std::result::Result<Kind, &'static str>,
) -> *mut c_void {
    // SAFETY: logger and texts are the host's, as the standard has it.
    unsafe { boundary::instantiate(Host { environment, log }, logging_on != 0, text(name), text(token), kind) }
}

/// `fmi3InstantiateModelExchange`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    instance_name: *const c_char,
    instantiation_token: *const c_char,
    _resource_path: *const c_char,
    _visible: u8,
    logging_on: u8,
    environment: *mut c_void,
    log: LogMessage,
) -> *mut c_void {
    // SAFETY: the host's texts and logger.
    unsafe { instantiate(instance_name, instantiation_token, logging_on, environment, log, Ok(Kind::ModelExchange)) }
}

/// `fmi3InstantiateCoSimulation`: no variable changes within a step, so intermediate update is not used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instance_name: *const c_char,
    instantiation_token: *const c_char,
    _resource_path: *const c_char,
    _visible: u8,
    logging_on: u8,
    event_mode_used: u8,
    early_return_allowed: u8,
    _required_intermediate_variables: *const u32,
    n_required_intermediate_variables: usize,
    environment: *mut c_void,
    log: LogMessage,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    let kind = match n_required_intermediate_variables {
        0 => Ok(Kind::CoSimulation),
        _ => Err("intermediate variables are not provided"),
    };
    // SAFETY: the host's texts and logger; what comes back is a fresh instance or NULL.
    unsafe {
        let c = instantiate(instance_name, instantiation_token, logging_on, environment, log, kind);
        if let Some(component) = c.cast::<Component<Host>>().as_mut() {
            component.instance.uses_event_mode = event_mode_used != 0;
            component.instance.returns_early = event_mode_used != 0 && early_return_allowed != 0;
        }
        c
    }
}

/// `fmi3InstantiateScheduledExecution`: not offered.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    instance_name: *const c_char,
    instantiation_token: *const c_char,
    _resource_path: *const c_char,
    _visible: u8,
    logging_on: u8,
    environment: *mut c_void,
    log: LogMessage,
    _clock_update: *const c_void,
    _lock_preemption: *const c_void,
    _unlock_preemption: *const c_void,
) -> *mut c_void {
    let kind = Err("scheduled execution is not offered");
    // SAFETY: the host's texts and logger.
    unsafe { instantiate(instance_name, instantiation_token, logging_on, environment, log, kind) }
}

/// `fmi3FreeInstance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(c: *mut c_void) {
    // SAFETY: the host's instance, freed once.
    unsafe { boundary::free::<Host>(c) };
}

/// `fmi3Reset`: allowed always, also after a break-down.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance.
    unsafe { boundary::reset::<Host>(c) }
}

/// `fmi3SetDebugLogging`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    c: *mut c_void,
    logging_on: u8,
    n: usize,
    categories: *const *const c_char,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetDebugLogging", |component| {
            let mut chosen = Vec::new();
            for &category in elements(categories, n, "categories")? {
                chosen.push(text(category).ok_or(Refusal::Null { argument: "categories[i]" })?);
            }
            component.choose(logging_on != 0, &chosen)
        })
    }
}

/// `fmi3EnterInitializationMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    c: *mut c_void,
    tolerance_defined: u8,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: u8,
    stop_time: f64,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3EnterInitializationMode", |component| {
            let tolerance = (tolerance_defined != 0).then_some(tolerance);
            let stop = (stop_time_defined != 0).then_some(stop_time);
            component.instance.setup_experiment(tolerance, start_time, stop)?;
            component.instance.enter_initialization()
        })
    }
}

/// `fmi3ExitInitializationMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe { guarded(c, "fmi3ExitInitializationMode", |component| component.instance.exit_initialization()) }
}

/// `fmi3EnterEventMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe { guarded(c, "fmi3EnterEventMode", |component| component.instance.enter_event()) }
}

/// `fmi3EnterStepMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe { guarded(c, "fmi3EnterStepMode", |component| component.instance.enter_step()) }
}

/// `fmi3EnterContinuousTimeMode`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterContinuousTimeMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe { guarded(c, "fmi3EnterContinuousTimeMode", |component| component.instance.enter_continuous_time()) }
}

/// `fmi3Terminate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe { guarded(c, "fmi3Terminate", |component| component.instance.terminate()) }
}

/// `fmi3GetFloat64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    values: *mut f64,
    n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetFloat64", |component| {
            same_length(nvr, n)?;
            let (references, values) = (elements(vr, nvr, "valueReferences")?, elements_mut(values, n, "values")?);
            if references.iter().all(|reference| *reference < time_reference()) {
                return component.instance.get_real(references, values);
            }
            let found: Result<Vec<f64>> =
                references.iter().map(|reference| float(&mut component.instance, *reference)).collect();
            values.copy_from_slice(&found?);
            Ok(())
        })
    }
}

/// `fmi3SetFloat64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    values: *const f64,
    n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetFloat64", |component| {
            same_length(nvr, n)?;
            component.instance.set_real(elements(vr, nvr, "valueReferences")?, elements(values, n, "values")?)
        })
    }
}

/// `fmi3GetInt64`: enumerations are read as integers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt64(c: *mut c_void, vr: *const u32, nvr: usize, values: *mut i64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetInt64", |component| {
            same_length(nvr, n)?;
            let (references, values) = (elements(vr, nvr, "valueReferences")?, elements_mut(values, n, "values")?);
            let mut integers = vec![0; nvr];
            component.instance.get_integer(references, &mut integers)?;
            values.iter_mut().zip(integers).for_each(|(value, integer)| *value = i64::from(integer));
            Ok(())
        })
    }
}

/// `fmi3SetInt64`: enumerations are set as integers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt64(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    values: *const i64,
    n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetInt64", |component| {
            same_length(nvr, n)?;
            let values = elements(values, n, "values")?;
            let integers: Vec<i32> = values.iter().map(|value| i32::try_from(*value).unwrap_or(i32::MAX)).collect();
            component.instance.set_integer(elements(vr, nvr, "valueReferences")?, &integers)
        })
    }
}

/// `fmi3GetBoolean`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBoolean(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    values: *mut u8,
    n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetBoolean", |component| {
            same_length(nvr, n)?;
            let (references, values) = (elements(vr, nvr, "valueReferences")?, elements_mut(values, n, "values")?);
            let mut booleans = vec![false; nvr];
            component.instance.get_boolean(references, &mut booleans)?;
            values.iter_mut().zip(booleans).for_each(|(value, boolean)| *value = u8::from(boolean));
            Ok(())
        })
    }
}

/// `fmi3SetBoolean`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBoolean(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    values: *const u8,
    n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetBoolean", |component| {
            same_length(nvr, n)?;
            let values: Vec<bool> = elements(values, n, "values")?.iter().map(|value| *value != 0).collect();
            component.instance.set_boolean(elements(vr, nvr, "valueReferences")?, &values)
        })
    }
}

/// `fmi3GetFloat32`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat32(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *mut f32,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetFloat32", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Float32")
        })
    }
}

/// `fmi3SetFloat32`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat32(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *const f32,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetFloat32", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Float32")
        })
    }
}

/// `fmi3GetInt8`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt8(c: *mut c_void, vr: *const u32, nvr: usize, _values: *mut i8, _n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetInt8", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Int8")
        })
    }
}

/// `fmi3SetInt8`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt8(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *const i8,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetInt8", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Int8")
        })
    }
}

/// `fmi3GetUInt8`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetUInt8(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *mut u8,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetUInt8", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "UInt8")
        })
    }
}

/// `fmi3SetUInt8`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetUInt8(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *const u8,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetUInt8", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "UInt8")
        })
    }
}

/// `fmi3GetInt16`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt16(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *mut i16,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetInt16", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Int16")
        })
    }
}

/// `fmi3SetInt16`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt16(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *const i16,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetInt16", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Int16")
        })
    }
}

/// `fmi3GetUInt16`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetUInt16(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *mut u16,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetUInt16", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "UInt16")
        })
    }
}

/// `fmi3SetUInt16`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetUInt16(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *const u16,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetUInt16", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "UInt16")
        })
    }
}

/// `fmi3GetInt32`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt32(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *mut i32,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetInt32", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Int32")
        })
    }
}

/// `fmi3SetInt32`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt32(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *const i32,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetInt32", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Int32")
        })
    }
}

/// `fmi3GetUInt32`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetUInt32(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *mut u32,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetUInt32", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "UInt32")
        })
    }
}

/// `fmi3SetUInt32`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetUInt32(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *const u32,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetUInt32", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "UInt32")
        })
    }
}

/// `fmi3GetUInt64`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetUInt64(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *mut u64,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetUInt64", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "UInt64")
        })
    }
}

/// `fmi3SetUInt64`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetUInt64(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *const u64,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetUInt64", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "UInt64")
        })
    }
}

/// `fmi3GetString`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetString(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *mut *const c_char,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetString", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "String")
        })
    }
}

/// `fmi3SetString`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetString(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _values: *const *const c_char,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetString", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "String")
        })
    }
}

/// `fmi3GetBinary`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBinary(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _sizes: *mut usize,
    _values: *mut *const u8,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetBinary", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Binary")
        })
    }
}

/// `fmi3SetBinary`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBinary(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _sizes: *const usize,
    _values: *const *const u8,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetBinary", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Binary")
        })
    }
}

/// `fmi3GetClock`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetClock(c: *mut c_void, vr: *const u32, nvr: usize, _values: *mut u8) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetClock", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3SetClock`: there is no such variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetClock(c: *mut c_void, vr: *const u32, nvr: usize, _values: *const u8) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetClock", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3GetIntervalDecimal`: there is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetIntervalDecimal(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _intervals: *mut f64,
    _qualifiers: *mut CEnum,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetIntervalDecimal", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3GetIntervalFraction`: there is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetIntervalFraction(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _counters: *mut u64,
    _resolutions: *mut u64,
    _qualifiers: *mut CEnum,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetIntervalFraction", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3GetShiftDecimal`: there is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetShiftDecimal(c: *mut c_void, vr: *const u32, nvr: usize, _shifts: *mut f64) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetShiftDecimal", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3GetShiftFraction`: there is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetShiftFraction(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _counters: *mut u64,
    _resolutions: *mut u64,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetShiftFraction", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3SetIntervalDecimal`: there is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetIntervalDecimal(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _intervals: *const f64,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetIntervalDecimal", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3SetIntervalFraction`: there is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetIntervalFraction(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _counters: *const u64,
    _resolutions: *const u64,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetIntervalFraction", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3SetShiftDecimal`: there is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetShiftDecimal(c: *mut c_void, vr: *const u32, nvr: usize, _shifts: *const f64) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetShiftDecimal", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3SetShiftFraction`: there is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetShiftFraction(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    _counters: *const u64,
    _resolutions: *const u64,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetShiftFraction", |component| {
            component.instance.none_of_type(elements(vr, nvr, "valueReferences")?, "Clock")
        })
    }
}

/// `fmi3GetNumberOfVariableDependencies`: the model description has them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfVariableDependencies(c: *mut c_void, _vr: u32, _n: *mut usize) -> CEnum {
    // SAFETY: the host's instance.
    unsafe {
        guarded(c, "fmi3GetNumberOfVariableDependencies", |_| {
            Err(Refusal::NotOffered {
                what: "dependencies by element are not provided; the model description has those of the variables",
            })
        })
    }
}

/// `fmi3GetVariableDependencies`: the model description has them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetVariableDependencies(
    c: *mut c_void,
    _dependent: u32,
    _elements: *mut usize,
    _independents: *mut u32,
    _of: *mut usize,
    _kinds: *mut CEnum,
    _n: usize,
) -> CEnum {
    // SAFETY: the host's instance.
    unsafe {
        guarded(c, "fmi3GetVariableDependencies", |_| {
            Err(Refusal::NotOffered {
                what: "dependencies by element are not provided; the model description has those of the variables",
            })
        })
    }
}

/// `fmi3GetAdjointDerivative`: directional derivatives are offered.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetAdjointDerivative(
    c: *mut c_void,
    _unknowns: *const u32,
    _n_unknowns: usize,
    _knowns: *const u32,
    _n_knowns: usize,
    _seed: *const f64,
    _n_seed: usize,
    _sensitivity: *mut f64,
    _n_sensitivity: usize,
) -> CEnum {
    // SAFETY: the host's instance.
    unsafe {
        guarded(c, "fmi3GetAdjointDerivative", |_| {
            Err(Refusal::NotOffered { what: "adjoint derivatives are not provided; fmi3GetDirectionalDerivative is" })
        })
    }
}

/// `fmi3EnterConfigurationMode`: there is nothing to configure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterConfigurationMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance.
    unsafe {
        guarded(c, "fmi3EnterConfigurationMode", |_| {
            Err(Refusal::NotOffered { what: "there is no structural parameter to configure" })
        })
    }
}

/// `fmi3ExitConfigurationMode`: there is nothing to configure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitConfigurationMode(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance.
    unsafe {
        guarded(c, "fmi3ExitConfigurationMode", |_| {
            Err(Refusal::NotOffered { what: "there is no structural parameter to configure" })
        })
    }
}

/// `fmi3EvaluateDiscreteStates`: not provided.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EvaluateDiscreteStates(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance.
    unsafe {
        guarded(c, "fmi3EvaluateDiscreteStates", |_| {
            Err(Refusal::NotOffered { what: "discrete states are evaluated by fmi3UpdateDiscreteStates" })
        })
    }
}

/// `fmi3ActivateModelPartition`: there is no clock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ActivateModelPartition(c: *mut c_void, _clock: u32, _time: f64) -> CEnum {
    // SAFETY: the host's instance.
    unsafe {
        guarded(c, "fmi3ActivateModelPartition", |_| {
            Err(Refusal::NotOffered { what: "scheduled execution is not offered" })
        })
    }
}

/// `fmi3GetFMUState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetFMUState", |component| {
            let state = place(state, "FMUState")?;
            *state = component.instance.save(state.addr()) as *mut c_void;
            Ok(())
        })
    }
}

/// `fmi3SetFMUState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(c: *mut c_void, state: *mut c_void) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe { guarded(c, "fmi3SetFMUState", |component| component.instance.restore(state.addr())) }
}

/// `fmi3FreeFMUState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3FreeFMUState", |component| {
            if let Some(state) = state.as_mut().filter(|state| !state.is_null()) {
                component.instance.free(state.addr())?;
                *state = std::ptr::null_mut();
            }
            Ok(())
        })
    }
}

/// `fmi3SerializedFMUStateSize`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(c: *mut c_void, state: *mut c_void, size: *mut usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SerializedFMUStateSize", |component| {
            let size = place(size, "size")?;
            *size = component.instance.serialize(state.addr())?.len();
            Ok(())
        })
    }
}

/// `fmi3SerializeFMUState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    c: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SerializeFMUState", |component| {
            let serialized = component.instance.serialize(state.addr())?;
            if size < serialized.len() {
                return Err(Refusal::BadBytes { why: "size is less than fmi3SerializedFMUStateSize says" });
            }
            if bytes.is_null() {
                return Err(Refusal::Null { argument: "serializedState" });
            }
            slice::from_raw_parts_mut(bytes, serialized.len()).copy_from_slice(&serialized);
            Ok(())
        })
    }
}

/// `fmi3DeserializeFMUState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    c: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3DeserializeFMUState", |component| {
            let state = place(state, "FMUState")?;
            if bytes.is_null() || size > isize::MAX as usize {
                return Err(Refusal::Null { argument: "serializedState" });
            }
            *state = component.instance.deserialize(slice::from_raw_parts(bytes, size))? as *mut c_void;
            Ok(())
        })
    }
}

/// `fmi3GetDirectionalDerivative`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    c: *mut c_void,
    unknowns: *const u32,
    n_unknowns: usize,
    knowns: *const u32,
    n_knowns: usize,
    seed: *const f64,
    n_seed: usize,
    sensitivity: *mut f64,
    n_sensitivity: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetDirectionalDerivative", |component| {
            same_length(n_knowns, n_seed)?;
            same_length(n_unknowns, n_sensitivity)?;
            component.instance.directional(
                elements(unknowns, n_unknowns, "unknowns")?,
                elements(knowns, n_knowns, "knowns")?,
                elements(seed, n_seed, "seed")?,
                elements_mut(sensitivity, n_sensitivity, "sensitivity")?,
            )
        })
    }
}

/// `fmi3GetOutputDerivatives`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetOutputDerivatives(
    c: *mut c_void,
    vr: *const u32,
    nvr: usize,
    orders: *const i32,
    values: *mut f64,
    n: usize,
) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetOutputDerivatives", |component| {
            same_length(nvr, n)?;
            component.instance.output_derivatives(
                elements(vr, nvr, "valueReferences")?,
                elements(orders, nvr, "orders")?,
                elements_mut(values, n, "values")?,
            )
        })
    }
}

/// `fmi3UpdateDiscreteStates`.
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
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3CompletedIntegratorStep", |component| {
            let (enter, end) = (place(enter_event_mode, "enterEventMode")?, place(terminate, "terminateSimulation")?);
            component.instance.completed_step()?;
            (*enter, *end) = (0, 0);
            Ok(())
        })
    }
}

/// `fmi3SetTime`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(c: *mut c_void, time: f64) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe { guarded(c, "fmi3SetTime", |component| component.instance.set_time(time)) }
}

/// `fmi3SetContinuousStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetContinuousStates(c: *mut c_void, values: *const f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3SetContinuousStates", |component| {
            component.instance.set_continuous_states(elements(values, n, "continuousStates")?)
        })
    }
}

/// `fmi3GetContinuousStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStates(c: *mut c_void, values: *mut f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetContinuousStates", |component| {
            component.instance.continuous_states(elements_mut(values, n, "continuousStates")?)
        })
    }
}

/// `fmi3GetContinuousStateDerivatives`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStateDerivatives(c: *mut c_void, values: *mut f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetContinuousStateDerivatives", |component| {
            component.instance.derivatives(elements_mut(values, n, "derivatives")?)
        })
    }
}

/// `fmi3GetEventIndicators`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetEventIndicators(c: *mut c_void, values: *mut f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetEventIndicators", |component| {
            component.instance.event_indicators(elements_mut(values, n, "eventIndicators")?)
        })
    }
}

/// `fmi3GetNominalsOfContinuousStates`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNominalsOfContinuousStates(c: *mut c_void, values: *mut f64, n: usize) -> CEnum {
    // SAFETY: the host's instance and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi3GetNominalsOfContinuousStates", |component| {
            component.instance.nominals(elements_mut(values, n, "nominals")?)
        })
    }
}

/// `fmi3GetNumberOfEventIndicators`.
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

/// `fmi3GetNumberOfContinuousStates`.
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

/// `fmi3DoStep`.
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
