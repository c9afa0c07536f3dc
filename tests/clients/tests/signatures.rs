//! The 44 functions have the types of the official header `fmi2FunctionTypes.h`, as bindgen reads it in `fmi-sys`: this
//! file compiles only if they do.

#![allow(non_upper_case_globals, reason = "the constants are named as the functions")]

use fmi_sys::fmi2::*;
use fmu::fmi2::abi;
use fmu::fmi2::host::{Callbacks, EventInfo};
use std::ffi::c_void;
use std::mem::offset_of;

macro_rules! same {
    ($($function:ident: $kind:ident),* $(,)?) => {
        $(const $function: $kind = Some(abi::$function);)*
        /// The functions above and fmi2Instantiate.
        const CHECKED: usize = [$(stringify!($function), )*].len() + 1;
        /// Used, so that none of them is reported as unused.
        fn all() -> bool { $($function.is_some())&&* }
    };
}

unsafe extern "C" fn types_platform() -> *const std::ffi::c_char {
    abi::fmi2GetTypesPlatform()
}
unsafe extern "C" fn version() -> *const std::ffi::c_char {
    abi::fmi2GetVersion()
}
/// Both are safe functions in our library, which the header cannot express.
const _: (fmi2GetTypesPlatformTYPE, fmi2GetVersionTYPE) = (Some(types_platform), Some(version));

/// Passes all arguments unchanged except the callbacks.
unsafe extern "C" fn instantiate(
    name: fmi2String,
    kind: fmi2Type,
    guid: fmi2String,
    resources: fmi2String,
    functions: *const fmi2CallbackFunctions,
    visible: fmi2Boolean,
    logging_on: fmi2Boolean,
) -> fmi2Component {
    unsafe { abi::fmi2Instantiate(name, kind, guid, resources, functions.cast::<Callbacks>(), visible, logging_on) }
}
const _: fmi2InstantiateTYPE = Some(instantiate);

/// Passes the event information unchanged.
unsafe extern "C" fn new_discrete_states(c: fmi2Component, info: *mut fmi2EventInfo) -> fmi2Status {
    unsafe { abi::fmi2NewDiscreteStates(c, info.cast::<EventInfo>()) }
}
const _: fmi2NewDiscreteStatesTYPE = Some(new_discrete_states);

same! {
    fmi2EnterEventMode: fmi2EnterEventModeTYPE,
    fmi2EnterContinuousTimeMode: fmi2EnterContinuousTimeModeTYPE,
    fmi2CompletedIntegratorStep: fmi2CompletedIntegratorStepTYPE,
    fmi2SetTime: fmi2SetTimeTYPE,
    fmi2SetContinuousStates: fmi2SetContinuousStatesTYPE,
    fmi2GetDerivatives: fmi2GetDerivativesTYPE,
    fmi2GetEventIndicators: fmi2GetEventIndicatorsTYPE,
    fmi2GetContinuousStates: fmi2GetContinuousStatesTYPE,
    fmi2GetNominalsOfContinuousStates: fmi2GetNominalsOfContinuousStatesTYPE,
    fmi2SetDebugLogging: fmi2SetDebugLoggingTYPE,
    fmi2FreeInstance: fmi2FreeInstanceTYPE,
    fmi2SetupExperiment: fmi2SetupExperimentTYPE,
    fmi2EnterInitializationMode: fmi2EnterInitializationModeTYPE,
    fmi2ExitInitializationMode: fmi2ExitInitializationModeTYPE,
    fmi2Terminate: fmi2TerminateTYPE,
    fmi2Reset: fmi2ResetTYPE,
    fmi2GetReal: fmi2GetRealTYPE,
    fmi2GetInteger: fmi2GetIntegerTYPE,
    fmi2GetBoolean: fmi2GetBooleanTYPE,
    fmi2GetString: fmi2GetStringTYPE,
    fmi2SetReal: fmi2SetRealTYPE,
    fmi2SetInteger: fmi2SetIntegerTYPE,
    fmi2SetBoolean: fmi2SetBooleanTYPE,
    fmi2SetString: fmi2SetStringTYPE,
    fmi2GetFMUstate: fmi2GetFMUstateTYPE,
    fmi2SetFMUstate: fmi2SetFMUstateTYPE,
    fmi2FreeFMUstate: fmi2FreeFMUstateTYPE,
    fmi2SerializedFMUstateSize: fmi2SerializedFMUstateSizeTYPE,
    fmi2SerializeFMUstate: fmi2SerializeFMUstateTYPE,
    fmi2DeSerializeFMUstate: fmi2DeSerializeFMUstateTYPE,
    fmi2GetDirectionalDerivative: fmi2GetDirectionalDerivativeTYPE,
    fmi2SetRealInputDerivatives: fmi2SetRealInputDerivativesTYPE,
    fmi2GetRealOutputDerivatives: fmi2GetRealOutputDerivativesTYPE,
    fmi2DoStep: fmi2DoStepTYPE,
    fmi2CancelStep: fmi2CancelStepTYPE,
    fmi2GetStatus: fmi2GetStatusTYPE,
    fmi2GetRealStatus: fmi2GetRealStatusTYPE,
    fmi2GetIntegerStatus: fmi2GetIntegerStatusTYPE,
    fmi2GetBooleanStatus: fmi2GetBooleanStatusTYPE,
    fmi2GetStringStatus: fmi2GetStringStatusTYPE,
}

#[test]
fn every_function_has_the_type_of_the_official_header() {
    assert!(all());
    // Plus fmi2GetTypesPlatform, fmi2GetVersion and fmi2NewDiscreteStates.
    assert_eq!(CHECKED + 3, 44);
}

#[test]
fn the_event_information_lies_where_the_official_header_has_it() {
    assert_eq!(size_of::<EventInfo>(), size_of::<fmi2EventInfo>());
    assert_eq!(offset_of!(EventInfo, next_event_time), offset_of!(fmi2EventInfo, nextEventTime));
}

#[test]
fn the_callbacks_lie_where_the_official_header_has_them() {
    // Each field has the same type as in the header.
    let ours = |theirs: fmi2CallbackFunctions| Callbacks {
        logger: theirs.logger,
        allocate_memory: theirs.allocateMemory,
        free_memory: theirs.freeMemory,
        step_finished: theirs.stepFinished,
        component_environment: theirs.componentEnvironment as *mut c_void,
    };
    let _ = ours;
    assert_eq!(size_of::<Callbacks>(), size_of::<fmi2CallbackFunctions>());
    for (own, theirs) in [
        (offset_of!(Callbacks, logger), offset_of!(fmi2CallbackFunctions, logger)),
        (offset_of!(Callbacks, allocate_memory), offset_of!(fmi2CallbackFunctions, allocateMemory)),
        (offset_of!(Callbacks, free_memory), offset_of!(fmi2CallbackFunctions, freeMemory)),
        (offset_of!(Callbacks, step_finished), offset_of!(fmi2CallbackFunctions, stepFinished)),
        (offset_of!(Callbacks, component_environment), offset_of!(fmi2CallbackFunctions, componentEnvironment)),
    ] {
        assert_eq!(own, theirs);
    }
}
