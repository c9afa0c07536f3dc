//! Life cycle of an FMI 3.0 instance, and its log.

use super::*;

/// Always "3.0".
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Creates an instance.
unsafe fn instantiate(
    name: *const c_char,
    token: *const c_char,
    logging_on: u8,
    environment: *mut c_void,
    log: LogMessage,
    kind: std::result::Result<Kind, &'static str>,
) -> *mut c_void {
    // SAFETY: the host's logger and texts, as the standard requires.
    unsafe { boundary::instantiate(Host { environment, log }, logging_on != 0, text(name), text(token), kind) }
}

/// A new instance for Model Exchange; NULL, with a message in the log, if the name is empty or the token differs.
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

/// `fmi3InstantiateCoSimulation`: no variable changes within a step, so there is no intermediate update.
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
    // SAFETY: the host's texts and logger; the result is a new instance or NULL.
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

/// Frees an instance; NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(c: *mut c_void) {
    // SAFETY: the host's instance, freed once.
    unsafe { boundary::free::<Host>(c) };
}

/// `fmi3Reset`: always allowed, also after a panic.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(c: *mut c_void) -> CEnum {
    // SAFETY: the host's instance.
    unsafe { boundary::reset::<Host>(c) }
}

/// Selects the log categories that the host receives; none means all.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    c: *mut c_void,
    logging_on: u8,
    n: usize,
    categories: *const *const c_char,
) -> CEnum {
    // SAFETY: the host's instance and texts, as the standard requires.
    unsafe { boundary::choose::<Host>(c, "fmi3SetDebugLogging", logging_on != 0, n, categories) }
}

c_functions! {
    /// Announces tolerance, start and stop time, s; from now on outputs are calculated from parameters and inputs.
    extern "C" fn fmi3EnterInitializationMode(
        tolerance_defined: u8,
        tolerance: f64,
        start_time: f64,
        stop_time_defined: u8,
        stop_time: f64,
    ) = |instance| {
        let tolerance = (tolerance_defined != 0).then_some(tolerance);
        let stop = (stop_time_defined != 0).then_some(stop_time);
        instance.setup_experiment(tolerance, start_time, stop)?;
        instance.enter_initialization()
    };

    /// Fills the chamber at initialPressure and initialTemperature; refused if the parameters are inconsistent.
    extern "C" fn fmi3ExitInitializationMode() = |instance| instance.exit_initialization();

    /// Stops continuous time or stepping for an event: parameters can be tuned, and a jump of position is applied.
    extern "C" fn fmi3EnterEventMode() = |instance| instance.enter_event();

    /// Resumes steps of co-simulation after event mode.
    extern "C" fn fmi3EnterStepMode() = |instance| instance.enter_step();

    /// Resumes integration by the host after event mode.
    extern "C" fn fmi3EnterContinuousTimeMode() = |instance| instance.enter_continuous_time();

    /// Ends the simulation; its last values remain readable.
    extern "C" fn fmi3Terminate() = |instance| instance.terminate();
}
