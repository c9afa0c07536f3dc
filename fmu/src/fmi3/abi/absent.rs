//! Functions of the standard for features that this FMU lacks: variables of other types, clocks, configuration, dependencies by
//! element. Each refuses with a message.

use super::*;

/// Functions for variables of types that do not occur: they refuse any reference.
macro_rules! none_of_type {
    ($($is:literal: $(extern "C" fn $function:ident($($argument:ident: $of:ty),*);)+)+) => {c_functions! {$($(
        #[doc = concat!("`", stringify!($function), "`: there is no variable of type ", $is, ".")]
        extern "C" fn $function(vr: *const u32, nvr: usize, $($argument: $of),*) =
            |instance| instance.none_of_type(elements(vr, nvr, "valueReferences")?, $is);
    )+)+}};
}

/// Functions not offered, with the reason in their refusal.
macro_rules! not_offered {
    ($($what:literal: $(extern "C" fn $function:ident($($argument:ident: $of:ty),*);)+)+) => {c_functions! {$($(
        #[doc = concat!("`", stringify!($function), "`: not offered.")]
        extern "C" fn $function($($argument: $of),*) = |_| Err(Refusal::NotOffered { what: $what });
    )+)+}};
}

none_of_type! {
    "Float32":
    extern "C" fn fmi3GetFloat32(_values: *mut f32, _n: usize);
    extern "C" fn fmi3SetFloat32(_values: *const f32, _n: usize);
    "Int8":
    extern "C" fn fmi3GetInt8(_values: *mut i8, _n: usize);
    extern "C" fn fmi3SetInt8(_values: *const i8, _n: usize);
    "UInt8":
    extern "C" fn fmi3GetUInt8(_values: *mut u8, _n: usize);
    extern "C" fn fmi3SetUInt8(_values: *const u8, _n: usize);
    "Int16":
    extern "C" fn fmi3GetInt16(_values: *mut i16, _n: usize);
    extern "C" fn fmi3SetInt16(_values: *const i16, _n: usize);
    "UInt16":
    extern "C" fn fmi3GetUInt16(_values: *mut u16, _n: usize);
    extern "C" fn fmi3SetUInt16(_values: *const u16, _n: usize);
    "Int32":
    extern "C" fn fmi3GetInt32(_values: *mut i32, _n: usize);
    extern "C" fn fmi3SetInt32(_values: *const i32, _n: usize);
    "UInt32":
    extern "C" fn fmi3GetUInt32(_values: *mut u32, _n: usize);
    extern "C" fn fmi3SetUInt32(_values: *const u32, _n: usize);
    "UInt64":
    extern "C" fn fmi3GetUInt64(_values: *mut u64, _n: usize);
    extern "C" fn fmi3SetUInt64(_values: *const u64, _n: usize);
    "String":
    extern "C" fn fmi3GetString(_values: *mut *const c_char, _n: usize);
    extern "C" fn fmi3SetString(_values: *const *const c_char, _n: usize);
    "Binary":
    extern "C" fn fmi3GetBinary(_sizes: *mut usize, _values: *mut *const u8, _n: usize);
    extern "C" fn fmi3SetBinary(_sizes: *const usize, _values: *const *const u8, _n: usize);
    "Clock":
    extern "C" fn fmi3GetClock(_values: *mut u8);
    extern "C" fn fmi3SetClock(_values: *const u8);
    extern "C" fn fmi3GetIntervalDecimal(_intervals: *mut f64, _qualifiers: *mut CEnum);
    extern "C" fn fmi3GetIntervalFraction(_counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut CEnum);
    extern "C" fn fmi3GetShiftDecimal(_shifts: *mut f64);
    extern "C" fn fmi3GetShiftFraction(_counters: *mut u64, _resolutions: *mut u64);
    extern "C" fn fmi3SetIntervalDecimal(_intervals: *const f64);
    extern "C" fn fmi3SetIntervalFraction(_counters: *const u64, _resolutions: *const u64);
    extern "C" fn fmi3SetShiftDecimal(_shifts: *const f64);
    extern "C" fn fmi3SetShiftFraction(_counters: *const u64, _resolutions: *const u64);
}

not_offered! {
    "dependencies by element are not provided; the model description has those of the variables":
    extern "C" fn fmi3GetNumberOfVariableDependencies(_vr: u32, _n: *mut usize);
    extern "C" fn fmi3GetVariableDependencies(
        _dependent: u32,
        _elements: *mut usize,
        _independents: *mut u32,
        _of: *mut usize,
        _kinds: *mut CEnum,
        _n: usize
    );
    "adjoint derivatives are not provided; fmi3GetDirectionalDerivative is":
    extern "C" fn fmi3GetAdjointDerivative(
        _unknowns: *const u32,
        _n_unknowns: usize,
        _knowns: *const u32,
        _n_knowns: usize,
        _seed: *const f64,
        _n_seed: usize,
        _sensitivity: *mut f64,
        _n_sensitivity: usize
    );
    "there is no structural parameter to configure":
    extern "C" fn fmi3EnterConfigurationMode();
    extern "C" fn fmi3ExitConfigurationMode();
    "discrete states are evaluated by fmi3UpdateDiscreteStates":
    extern "C" fn fmi3EvaluateDiscreteStates();
    "scheduled execution is not offered":
    extern "C" fn fmi3ActivateModelPartition(_clock: u32, _time: f64);
}
