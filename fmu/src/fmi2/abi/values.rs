//! Variables of FMI 2.0 and their derivatives.

use super::*;

/// Values of real variables in SI units: all of them, or none where one is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *mut f64) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetReal", |component| {
            component.instance.get_real(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?)
        })
    }
}

/// Sets real inputs and parameters in SI units: all of them, or none where one is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *const f64) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetReal", |component| {
            component.instance.set_real(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?)
        })
    }
}

/// Values of the enumerations areaLaw and strokeInput.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *mut c_int) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetInteger", |component| {
            component.instance.get_integer(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?)
        })
    }
}

/// Sets the enumerations areaLaw and strokeInput, before the end of initialization.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *const c_int) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetInteger", |component| {
            component.instance.set_integer(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?)
        })
    }
}

/// Value of externalWall.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *mut c_int) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2GetBoolean", |component| {
            component.instance.get_boolean(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?)
        })
    }
}

/// `fmi2SetBoolean`: any number but zero is true.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(c: *mut c_void, vr: *const c_uint, nvr: usize, value: *const c_int) -> CEnum {
    // SAFETY: the host's component and arrays, as the standard has them.
    unsafe {
        guarded(c, "fmi2SetBoolean", |component| {
            component.instance.set_boolean(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?)
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

/// Exact derivatives of outputs, states and rates along a direction of inputs, states and parameters.
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

/// Sets derivatives of inputs, orders 1 to 3, for the next step; SI units per s to that order.
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

/// First time derivatives of outputs at the end of the last step, SI units per s.
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
