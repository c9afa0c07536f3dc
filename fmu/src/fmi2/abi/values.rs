//! Variables of FMI 2.0 and their derivatives.

use super::*;

c_functions! {
    /// Values of real variables in SI units: all of them, or none if one is refused.
    extern "C" fn fmi2GetReal(vr: *const c_uint, nvr: usize, value: *mut f64) =
        |instance| instance.get_real(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?);

    /// Sets real inputs and parameters in SI units: all of them, or none if one is refused.
    extern "C" fn fmi2SetReal(vr: *const c_uint, nvr: usize, value: *const f64) =
        |instance| instance.set_real(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?);

    /// Values of the enumerations areaLaw and strokeInput.
    extern "C" fn fmi2GetInteger(vr: *const c_uint, nvr: usize, value: *mut c_int) =
        |instance| instance.get_integer(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?);

    /// Sets the enumerations areaLaw and strokeInput, before the end of initialization.
    extern "C" fn fmi2SetInteger(vr: *const c_uint, nvr: usize, value: *const c_int) =
        |instance| instance.set_integer(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?);

    /// Value of externalWall.
    extern "C" fn fmi2GetBoolean(vr: *const c_uint, nvr: usize, value: *mut c_int) =
        |instance| instance.get_boolean(elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?);

    /// `fmi2SetBoolean`: any nonzero number is true.
    extern "C" fn fmi2SetBoolean(vr: *const c_uint, nvr: usize, value: *const c_int) =
        |instance| instance.set_boolean(elements(vr, nvr, "vr")?, elements(value, nvr, "value")?);

    /// `fmi2GetString`: there is no String variable.
    extern "C" fn fmi2GetString(vr: *const c_uint, nvr: usize, _value: *mut *const c_char) =
        |instance| instance.none_of_type(elements(vr, nvr, "vr")?, "String");

    /// `fmi2SetString`: there is no String variable.
    extern "C" fn fmi2SetString(vr: *const c_uint, nvr: usize, _value: *const *const c_char) =
        |instance| instance.none_of_type(elements(vr, nvr, "vr")?, "String");

    /// Exact directional derivatives of outputs, states and rates with respect to inputs, states and parameters.
    extern "C" fn fmi2GetDirectionalDerivative(
        unknown: *const c_uint,
        n_unknown: usize,
        known: *const c_uint,
        n_known: usize,
        direction: *const f64,
        value: *mut f64,
    ) = |instance| instance.directional(
        elements(unknown, n_unknown, "vUnknown_ref")?,
        elements(known, n_known, "vKnown_ref")?,
        elements(direction, n_known, "dvKnown")?,
        elements_mut(value, n_unknown, "dvUnknown")?,
    );

    /// Sets derivatives of inputs, orders 1 to 3, for the next step, in SI units per s to that order.
    extern "C" fn fmi2SetRealInputDerivatives(vr: *const c_uint, nvr: usize, order: *const c_int, value: *const f64) =
        |instance| instance.set_input_derivatives(
            elements(vr, nvr, "vr")?,
            elements(order, nvr, "order")?,
            elements(value, nvr, "value")?,
        );

    /// First time derivatives of outputs at the end of the last step, SI units per s.
    extern "C" fn fmi2GetRealOutputDerivatives(vr: *const c_uint, nvr: usize, order: *const c_int, value: *mut f64) =
        |instance| instance.output_derivatives(
            elements(vr, nvr, "vr")?,
            elements(order, nvr, "order")?,
            elements_mut(value, nvr, "value")?,
        );
}
