//! Rules for a host: order of calls, values refused by name, whole batches, discarded steps, reset, logging.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]
#![cfg_attr(miri, feature(c_variadic))]

mod common;

use chamber::card::Card;
use common::{Host, reference};
use fmu::boundary::CEnum;
use fmu::fmi2::abi::*;
use fmu::table::effects::{effects_here, parameter_name};
use std::ffi::CStr;
use std::ptr::{null, null_mut};

const OK: CEnum = 0;
const DISCARD: CEnum = 2;
const ERROR: CEnum = 3;

#[test]
fn version_and_platform_are_those_of_the_standard() {
    let text = |p| unsafe { CStr::from_ptr(p) }.to_str().unwrap();
    assert_eq!((text(fmi2GetVersion()), text(fmi2GetTypesPlatform())), ("2.0", "default"));
}

#[test]
fn a_refused_value_is_named_and_the_whole_batch_is_rejected() {
    let host = Host::started(&[]);
    let references = [reference("massFlowIn"), reference("ambientTemperature"), reference("velocity")];
    for (bad, says) in [
        (f64::NAN, "ambientTemperature = NaN K is not a finite number; nothing was set"),
        (f64::INFINITY, "ambientTemperature = inf K is not a finite number; nothing was set"),
        (-1.0, "ambientTemperature = -1 K lies outside 1 to 100000 K; nothing was set"),
    ] {
        let values = [5e-4, bad, 0.3];
        assert_eq!(unsafe { fmi2SetReal(host.c, references.as_ptr(), 3, values.as_ptr()) }, DISCARD);
        assert_eq!(host.message(), format!("fmi2SetReal refused: {says}"));
        assert_eq!((host.get("massFlowIn"), host.get("velocity")), (0.0, 0.0));
    }
    host.step(0.0, 0.01);
}

#[test]
fn a_refused_number_without_a_unit_is_named_without_one() {
    let host = Host::started(&[]);
    let reference = reference("supplyPortCriticalRatio");
    assert_eq!(unsafe { fmi2SetReal(host.c, &reference, 1, &2.0) }, DISCARD);
    let says = "fmi2SetReal refused: supplyPortCriticalRatio = 2 lies outside 0 to 0.9; nothing was set";
    assert_eq!(host.message(), says);
}

#[test]
fn unknown_references_and_wrong_types_are_refused_by_name() {
    let host = Host::started(&[]);
    let mut value = 0.0;
    assert_eq!(unsafe { fmi2GetReal(host.c, &9999, 1, &mut value) }, ERROR);
    assert!(host.message().contains("value reference 9999 belongs to no variable"));
    assert_eq!(unsafe { fmi2GetReal(host.c, &reference("areaLaw"), 1, &mut value) }, ERROR);
    assert!(host.message().contains("areaLaw"));
    assert_eq!(unsafe { fmi2SetInteger(host.c, &reference("bore"), 1, &1) }, ERROR);
    assert!(host.message().contains("bore (value reference 32) is of type Real, not Integer"));
    assert_eq!(unsafe { fmi2SetBoolean(host.c, &reference("bore"), 1, &1) }, ERROR);
    assert!(host.message().contains("not Boolean"));
    assert_eq!(unsafe { fmi2GetString(host.c, null(), 0, null_mut()) }, OK);
}

#[test]
fn null_pointers_are_refused_by_name_and_no_component_is_an_error() {
    let host = Host::started(&[]);
    let mut value = 0.0;
    unsafe {
        assert_eq!(fmi2GetReal(host.c, null(), 1, &mut value), ERROR);
        assert!(host.message().contains("vr is NULL"));
        assert_eq!(fmi2SetReal(host.c, &0, 1, null()), ERROR);
        assert!(host.message().contains("value is NULL"));
        assert_eq!(fmi2GetReal(host.c, &0, usize::MAX, &mut value), ERROR);
        assert!(host.message().contains("at most"));
        assert_eq!(fmi2GetReal(host.c, null(), 0, null_mut()), OK);
        assert_eq!(fmi2GetFMUstate(host.c, null_mut()), ERROR);
        assert_eq!(fmi2SetFMUstate(host.c, null_mut()), ERROR);
        assert_eq!(fmi2FreeFMUstate(host.c, null_mut()), OK);
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 0.1, 1), ERROR);
        assert_eq!(fmi2Reset(null_mut()), ERROR);
        fmi2FreeInstance(null_mut());
    }
}

#[test]
fn nothing_is_instantiated_with_a_wrong_guid_name_type_or_without_callbacks() {
    let callbacks = fmu::fmi2::host::Callbacks {
        logger: None,
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: null_mut(),
    };
    let guid = std::ffi::CString::new(fmu::start_values::REFERENCE_GUID).unwrap();
    let attempt = |name: *const _, kind, guid: *const _, callbacks| unsafe {
        let c = fmi2Instantiate(name, kind, guid, c"not a uri".as_ptr(), callbacks, 0, 1);
        fmi2FreeInstance(c);
        !c.is_null()
    };
    let name = c"a".as_ptr();
    assert!(attempt(name, 1, guid.as_ptr(), &callbacks));
    assert!(attempt(name, 0, guid.as_ptr(), &callbacks), "model exchange");
    assert!(!attempt(name, 2, guid.as_ptr(), &callbacks));
    assert!(!attempt(name, 1, c"{0}".as_ptr(), &callbacks));
    assert!(!attempt(name, 1, null(), &callbacks));
    assert!(!attempt(null(), 1, guid.as_ptr(), &callbacks));
    assert!(!attempt(c"".as_ptr(), 1, guid.as_ptr(), &callbacks));
    assert!(!attempt(name, 1, guid.as_ptr(), null()));
}

#[test]
fn calls_in_the_wrong_order_are_refused_with_advice_and_change_nothing() {
    let host = Host::new();
    assert_eq!(host.try_step(0.0, 0.1), ERROR);
    assert_eq!(
        host.message(),
        "fmi2DoStep refused: not allowed before initialization mode; call fmi2ExitInitializationMode first"
    );
    let mut value = 0.0;
    assert_eq!(unsafe { fmi2GetReal(host.c, &reference("pressure"), 1, &mut value) }, ERROR);
    assert!(host.message().contains("pressure has no value before initialization mode"));
    unsafe {
        assert_eq!(fmi2ExitInitializationMode(host.c), ERROR);
        assert_eq!(fmi2Terminate(host.c), ERROR);
        host.messages();
        host.start(&[], None);
        assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 0, 0.0), ERROR);
        assert_eq!(fmi2EnterInitializationMode(host.c), ERROR);
        assert_eq!(fmi2CancelStep(host.c), ERROR);
        host.messages();
        host.step(0.0, 0.1);
        assert_eq!(fmi2Terminate(host.c), OK);
    }
    assert_eq!(host.try_step(0.1, 0.1), ERROR);
    assert!(host.message().contains("after fmi2Terminate; call fmi2Reset first"));
    assert_eq!(host.try_set("position", 0.1), ERROR);
    assert!(host.get("pressure") > 0.0, "results stay readable after the end");
}

#[test]
fn derivatives_of_inputs_can_be_set_from_instantiation_on_and_never_in_model_exchange() {
    let host = Host::new();
    host.set("position", 0.1);
    host.set_derivative("position", 1, -0.5);
    host.start(&[], None);
    host.step(0.0, 0.1);
    assert!((host.get("pistonPosition") - 0.05).abs() < 1e-15);
    let host = Host::exchange();
    let set = || unsafe { fmi2SetRealInputDerivatives(host.c, &reference("position"), 1, &1, &-0.5) };
    assert_eq!(set(), DISCARD);
    assert!(host.message().contains("this instance is for Model Exchange"));
    assert_eq!(unsafe { fmi2EnterInitializationMode(host.c) }, OK);
    assert_eq!(set(), DISCARD);
}

#[test]
fn fixed_parameters_are_refused_after_initialization_and_tunable_ones_taken() {
    let host = Host::started(&[("initialTemperature", 400.0), ("initialPressure", 2e5)]);
    assert_eq!(host.try_set("bore", 0.03), ERROR);
    assert!(host.message().contains("bore = 0.03 cannot be set: it is fixed once initialization is over"));
    assert_eq!(host.try_set("pressure", 1e5), ERROR);
    assert!(host.message().contains("pressure = 100000 cannot be set: it is calculated"));
    let before = host.get("heatFlow");
    host.set("lambda0", 2.0 * host.get("lambda0"));
    assert!((host.get("heatFlow") / before - 2.0).abs() < 1e-14);
    host.set("leakage.conductance", 1e-11);
    let (mass, _) = (host.get("mass"), host.step(0.0, 0.1));
    assert!(host.get("mass") < mass);
}

#[test]
fn steps_of_no_use_are_refused_and_float_noise_in_their_begin_is_not() {
    let host = Host::started(&[]);
    for h in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(host.try_step(0.0, h), DISCARD);
        assert!(host.message().contains("communicationStepSize"));
    }
    assert_eq!(host.try_step(0.5, 0.1), ERROR);
    assert!(host.message().contains("the step begins at t = 0.5 s, but the last one ended at t = 0 s"));
    let mut t = 0.0;
    for k in 0..1000 {
        host.step(t, 1e-3);
        t = (f64::from(k) + 1.0) * 1e-3 + if k % 2 == 0 { 3e-13 } else { -3e-13 };
    }
    let mut reached = 0.0;
    assert_eq!(unsafe { fmi2GetRealStatus(host.c, 2, &mut reached) }, OK);
    assert!((reached - 1.0).abs() < 1e-9);
}

#[test]
fn no_step_goes_beyond_the_announced_stop_time() {
    let host = Host::new();
    unsafe {
        assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 1, 0.3), OK);
        assert_eq!(fmi2EnterInitializationMode(host.c), OK);
        assert_eq!(fmi2ExitInitializationMode(host.c), OK);
    }
    for k in 0..3 {
        host.step(0.1 * f64::from(k), 0.1);
    }
    assert_eq!(host.try_step(0.3, 0.1), ERROR);
    assert!(host.message().contains("beyond the stop time 0.3 s"));
}

#[test]
fn a_step_that_would_empty_the_chamber_names_the_outflow_whatever_else_is_on_and_keeps_the_last_good_state() {
    let alone = |(_, card): (usize, &'static Card)| {
        let variables = card.parameters.iter().filter(|p| p.is_variable());
        variables.map(|p| (parameter_name(card, p), p.typical)).collect::<Vec<_>>()
    };
    let named = |name: &str, value: f64| vec![(name.to_owned(), value)];
    let others = [vec![], named("leakage.conductance", 1e-12), named("exhaustPortConductance", 1e-11)];
    for set in others.into_iter().chain(effects_here().map(alone)) {
        let host = Host::started(&set.iter().map(|(name, value)| (name.as_str(), *value)).collect::<Vec<_>>());
        host.step(0.0, 0.1);
        host.set("massFlowOut", 1e-3);
        let before = (host.serialized(), host.get("pressure"));
        assert_eq!(host.try_step(0.1, 0.1), DISCARD);
        let message = host.message();
        assert!(message.contains("would empty the chamber") && message.contains("massFlowOut"), "{set:?}: {message}");
        assert_eq!((host.serialized(), host.get("pressure")), before);
        let (mut reached, mut ended, mut status) = (0.0, 1, 0);
        unsafe {
            assert_eq!(fmi2GetRealStatus(host.c, 2, &mut reached), OK);
            assert_eq!(fmi2GetBooleanStatus(host.c, 3, &mut ended), OK);
            assert_eq!(fmi2GetStatus(host.c, 0, &mut status), DISCARD);
        }
        assert_eq!((reached, ended), (0.1, 0));
        host.messages();
        host.step(0.1, 1e-3);
        assert!(host.get("pressure") < before.1);
    }
}

#[test]
fn a_host_that_repeats_a_discarded_step_is_asked_to_terminate_and_one_that_shortens_it_is_not() {
    let host = Host::started(&[]);
    let wants_to_end = || {
        let mut ended = -1;
        assert_eq!(unsafe { fmi2GetBooleanStatus(host.c, 3, &mut ended) }, OK);
        ended == 1
    };
    host.set("massFlowOut", 1e-3);
    for h in [0.1, 0.05] {
        assert_eq!(host.try_step(0.0, h), DISCARD);
        assert!(!wants_to_end(), "{h}");
    }
    assert_eq!(host.try_step(0.0, 0.05), DISCARD);
    assert!(wants_to_end());
    host.messages();
    host.step(0.0, 1e-3);
    assert!(!wants_to_end());
}

#[test]
fn a_position_without_volume_is_discarded_at_the_step_and_noise_at_the_end_stop_passes() {
    let host = Host::started(&[("position", 0.01)]);
    host.set("position", -1e-6);
    host.step(0.0, 1e-3);
    host.set("position", -1.0);
    assert_eq!(host.try_step(1e-3, 1e-3), DISCARD);
    let text = host.message();
    assert!(text.contains("position = -1 m leaves the gas a volume of -") && !text.contains("0.0000"), "{text}");
    host.set("position", 0.01);
    host.step(1e-3, 1e-3);
    assert!((host.get("temperature") / 293.15 - 1.0).abs() < 1e-2);
}

#[test]
fn parameters_that_make_no_chamber_are_refused_at_the_end_of_initialization() {
    let host = Host::new();
    host.set("rodDiameter", 0.03);
    unsafe {
        assert_eq!(fmi2EnterInitializationMode(host.c), OK);
        assert_eq!(fmi2ExitInitializationMode(host.c), ERROR);
        assert!(host.message().contains("rodDiameter = 0.03 m leaves no piston area in bore = 0.02 m"));
        host.set("rodDiameter", 0.01);
        assert_eq!(fmi2ExitInitializationMode(host.c), OK);
    }
}

#[test]
fn a_reset_instance_is_as_a_fresh_one() {
    let values = [("initialPressure", 3e5), ("lambda0", 70.0), ("recordDelay.delay", 0.02), ("areaLaw", 2.0)];
    let run = |host: &Host| {
        host.start(&[("initialPressure", 2e5), ("initialTemperature", 330.0)], None);
        host.step(0.0, 0.1);
        host.serialized()
    };
    let fresh = run(&Host::new());
    let host = Host::new();
    host.start(&values, Some(1e-4));
    host.set("velocity", -0.1);
    host.set_derivative("massFlowIn", 1, 1e-3);
    host.step(0.0, 0.2);
    host.try_step(7.0, 0.1);
    assert_eq!(unsafe { fmi2Reset(host.c) }, OK);
    assert_eq!(run(&host), fresh);
    assert_eq!(unsafe { fmi2Terminate(host.c) }, OK);
    assert_eq!(unsafe { fmi2Reset(host.c) }, OK);
    assert_eq!(run(&host), fresh, "a second run is like the first");
}

#[test]
fn the_log_follows_the_categories_that_the_host_chooses() {
    let host = Host::started(&[]);
    let choose = |on, categories: &[&CStr]| {
        let pointers: Vec<_> = categories.iter().map(|c| c.as_ptr()).collect();
        unsafe { fmi2SetDebugLogging(host.c, on, pointers.len(), pointers.as_ptr()) }
    };
    host.set("position", 0.09);
    host.step(0.0, 1e-3);
    assert!(host.messages().is_empty(), "no events while logging is off");
    assert_eq!(choose(1, &[]), OK);
    host.set("position", 0.08);
    host.step(1e-3, 1e-3);
    let messages = host.messages();
    let events: Vec<_> = messages.iter().filter(|m| m.category == "logEvents").collect();
    assert_eq!((events.len(), events[0].category.as_str(), events[0].status), (1, "logEvents", OK));
    assert!(events[0].text.contains("the stroke from 0.09 m to position = 0.08 m was taken up adiabatically"));
    host.set("position", 0.08 * (1.0 + f64::EPSILON));
    host.step(2e-3, 1e-3);
    assert!(host.messages().is_empty(), "rounding is no stroke");
    assert_eq!(choose(1, &[c"logStatusError"]), OK);
    assert_eq!(host.try_set("position", f64::NAN), DISCARD);
    assert!(host.messages().is_empty());
    assert_eq!(choose(1, &[c"logStatusDiscard"]), OK);
    assert_eq!(host.try_set("position", f64::NAN), DISCARD);
    assert_eq!(host.messages()[0].category, "logStatusDiscard");
    assert_eq!(choose(1, &[c"nonsense"]), DISCARD);
    assert!(host.message().contains("none of those that the model description declares"));
    assert_eq!(choose(0, &[]), OK);
    assert_eq!(host.try_step(9.0, 1.0), ERROR);
    assert_eq!(host.messages().len(), 1, "refusals are reported even with logging off");
}

/// A logger that requests a value from the reporting instance, and counts its calls.
unsafe extern "C" fn calls_back(
    environment: *mut std::ffi::c_void,
    _name: *const std::ffi::c_char,
    _status: CEnum,
    _category: *const std::ffi::c_char,
    _format: *const std::ffi::c_char,
    _text: *const std::ffi::c_char,
) {
    let heard = unsafe { &*environment.cast::<(std::cell::Cell<*mut std::ffi::c_void>, std::cell::Cell<f64>)>() };
    let mut pressure = f64::NAN;
    assert_eq!(unsafe { fmi2GetReal(heard.0.get(), &reference("pressure"), 1, &mut pressure) }, OK);
    heard.1.set(pressure);
}

#[test]
#[cfg_attr(miri, ignore = "Miri asks for a function with variable arguments")]
fn a_logger_may_call_back_into_the_instance_that_it_hears_of() {
    use std::cell::Cell;
    use std::ffi::{c_char, c_void};
    type Fixed = unsafe extern "C" fn(*mut c_void, *const c_char, CEnum, *const c_char, *const c_char, *const c_char);
    type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, CEnum, *const c_char, *const c_char, ...);
    let heard = (Cell::new(null_mut::<c_void>()), Cell::new(0.0_f64));
    let callbacks = fmu::fmi2::host::Callbacks {
        logger: Some(unsafe { std::mem::transmute::<Fixed, Logger>(calls_back) }),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: std::ptr::from_ref(&heard).cast_mut().cast(),
    };
    let guid = std::ffi::CString::new(fmu::start_values::REFERENCE_GUID).unwrap();
    unsafe {
        let c = fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &callbacks, 0, 0);
        heard.0.set(c);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        assert_eq!(fmi2SetReal(c, &reference("position"), 1, &f64::NAN), DISCARD);
        assert!(f64::abs(heard.1.get() / 101_325.0 - 1.0) < 1e-12);
        fmi2FreeInstance(c);
    }
}
