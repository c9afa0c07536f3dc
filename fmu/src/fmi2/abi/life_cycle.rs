//! Life cycle of an FMI 2.0 component, and its log.

use super::*;

/// Always "default": the standard's own C types.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// Always "2.0".
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// A new instance for Model Exchange (type 0) or co-simulation (type 1); NULL, with a message in the log, if the name is empty or
/// the guid differs.
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
    // SAFETY: the host's callbacks and texts, as the standard requires.
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

/// Frees an instance; NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: *mut c_void) {
    // SAFETY: the host's component, freed once.
    unsafe { boundary::free::<Host>(c) };
}

/// `fmi2Reset`: always allowed, also after a panic.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: *mut c_void) -> CEnum {
    // SAFETY: the host's component.
    unsafe { boundary::reset::<Host>(c) }
}

/// Selects the log categories that the host receives; none means all.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: *mut c_void,
    logging_on: c_int,
    n_categories: usize,
    categories: *const *const c_char,
) -> CEnum {
    // SAFETY: the host's component and texts, as the standard requires.
    unsafe { boundary::choose::<Host>(c, "fmi2SetDebugLogging", logging_on != FALSE, n_categories, categories) }
}

c_functions! {
    /// Announces start and stop time, s, and the relative tolerance of the inner integration.
    extern "C" fn fmi2SetupExperiment(
        tolerance_defined: c_int,
        tolerance: f64,
        start_time: f64,
        stop_time_defined: c_int,
        stop_time: f64,
    ) = |instance| instance.setup_experiment(
        (tolerance_defined != FALSE).then_some(tolerance),
        start_time,
        (stop_time_defined != FALSE).then_some(stop_time),
    );

    /// From now on outputs are calculated from the current parameters and inputs.
    extern "C" fn fmi2EnterInitializationMode() = |instance| instance.enter_initialization();

    /// Fills the chamber at initialPressure and initialTemperature; refused if the parameters are inconsistent.
    extern "C" fn fmi2ExitInitializationMode() = |instance| instance.exit_initialization();

    /// Stops continuous time for an event: parameters can be tuned, and a jump of position is applied adiabatically.
    extern "C" fn fmi2EnterEventMode() = |instance| instance.enter_event();

    /// Resumes integration by the host after event mode.
    extern "C" fn fmi2EnterContinuousTimeMode() = |instance| instance.enter_continuous_time();

    /// Ends the simulation; its last values remain readable.
    extern "C" fn fmi2Terminate() = |instance| instance.terminate();
}
