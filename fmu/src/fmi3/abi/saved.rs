//! Saved states in FMI 3.0.

use super::*;
use crate::boundary::saved;

/// `fmi3GetFMUState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's instance and places, as the standard has them.
    unsafe { saved::save::<Host>(c, "fmi3GetFMUState", state) }
}

/// `fmi3SetFMUState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(c: *mut c_void, state: *mut c_void) -> CEnum {
    // SAFETY: the host's instance.
    unsafe { guarded(c, "fmi3SetFMUState", |component| component.instance.restore(state.addr())) }
}

/// `fmi3FreeFMUState`: nothing happens where there is no state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's instance and places, as the standard has them.
    unsafe { saved::free::<Host>(c, "fmi3FreeFMUState", state) }
}

/// `fmi3SerializedFMUStateSize`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(c: *mut c_void, state: *mut c_void, size: *mut usize) -> CEnum {
    // SAFETY: the host's instance and places, as the standard has them.
    unsafe { saved::size::<Host>(c, "fmi3SerializedFMUStateSize", state, size) }
}

/// `fmi3SerializeFMUState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    c: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> CEnum {
    // SAFETY: the host's instance and array, as the standard has them.
    unsafe { saved::serialize::<Host>(c, "fmi3SerializeFMUState", state, bytes, size) }
}

/// `fmi3DeserializeFMUState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    c: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> CEnum {
    // SAFETY: the host's instance and array, as the standard has them.
    unsafe { saved::deserialize::<Host>(c, "fmi3DeserializeFMUState", bytes, size, state) }
}
