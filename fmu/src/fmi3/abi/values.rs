//! Supported variable types of FMI 3.0, and their derivatives.

use super::*;

/// Value of a Float64 variable, including the time and the event indicators.
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

/// Checks that there are as many values as references, since every variable is a scalar.
fn same_length(references: usize, values: usize) -> Result<()> {
    if references == values {
        return Ok(());
    }
    Err(Refusal::WrongLength { argument: "nValues", length: values, expected: references })
}

c_functions! {
    /// Values of real variables in SI units, including the time and the event indicators: all of them, or none.
    extern "C" fn fmi3GetFloat64(vr: *const u32, nvr: usize, values: *mut f64, n: usize) = |instance| {
        same_length(nvr, n)?;
        let (references, values) = (elements(vr, nvr, "valueReferences")?, elements_mut(values, n, "values")?);
        if references.iter().all(|reference| *reference < time_reference()) {
            return instance.get_real(references, values);
        }
        let found: Result<Vec<f64>> = references.iter().map(|reference| float(instance, *reference)).collect();
        values.copy_from_slice(&found?);
        Ok(())
    };

    /// Sets real inputs and parameters in SI units: all of them, or none if one is refused.
    extern "C" fn fmi3SetFloat64(vr: *const u32, nvr: usize, values: *const f64, n: usize) = |instance| {
        same_length(nvr, n)?;
        instance.set_real(elements(vr, nvr, "valueReferences")?, elements(values, n, "values")?)
    };

    /// `fmi3GetInt64`: enumerations are read as integers.
    extern "C" fn fmi3GetInt64(vr: *const u32, nvr: usize, values: *mut i64, n: usize) = |instance| {
        same_length(nvr, n)?;
        instance.get_integer(elements(vr, nvr, "valueReferences")?, elements_mut(values, n, "values")?)
    };

    /// `fmi3SetInt64`: enumerations are set as integers.
    extern "C" fn fmi3SetInt64(vr: *const u32, nvr: usize, values: *const i64, n: usize) = |instance| {
        same_length(nvr, n)?;
        instance.set_integer(elements(vr, nvr, "valueReferences")?, elements(values, n, "values")?)
    };

    /// Value of externalWall.
    extern "C" fn fmi3GetBoolean(vr: *const u32, nvr: usize, values: *mut u8, n: usize) = |instance| {
        same_length(nvr, n)?;
        instance.get_boolean(elements(vr, nvr, "valueReferences")?, elements_mut(values, n, "values")?)
    };

    /// Sets externalWall, before the end of initialization; any nonzero number is true.
    extern "C" fn fmi3SetBoolean(vr: *const u32, nvr: usize, values: *const u8, n: usize) = |instance| {
        same_length(nvr, n)?;
        instance.set_boolean(elements(vr, nvr, "valueReferences")?, elements(values, n, "values")?)
    };

    /// Exact directional derivatives of outputs, states and rates with respect to inputs, states and parameters.
    extern "C" fn fmi3GetDirectionalDerivative(
        unknowns: *const u32,
        n_unknowns: usize,
        knowns: *const u32,
        n_knowns: usize,
        seed: *const f64,
        n_seed: usize,
        sensitivity: *mut f64,
        n_sensitivity: usize,
    ) = |instance| {
        same_length(n_knowns, n_seed)?;
        same_length(n_unknowns, n_sensitivity)?;
        instance.directional(
            elements(unknowns, n_unknowns, "unknowns")?,
            elements(knowns, n_knowns, "knowns")?,
            elements(seed, n_seed, "seed")?,
            elements_mut(sensitivity, n_sensitivity, "sensitivity")?,
        )
    };

    /// First time derivatives of outputs at the end of the last step, SI units per s.
    extern "C" fn fmi3GetOutputDerivatives(
        vr: *const u32,
        nvr: usize,
        orders: *const i32,
        values: *mut f64,
        n: usize,
    ) = |instance| {
        same_length(nvr, n)?;
        instance.output_derivatives(
            elements(vr, nvr, "valueReferences")?,
            elements(orders, nvr, "orders")?,
            elements_mut(values, n, "values")?,
        )
    };
}
