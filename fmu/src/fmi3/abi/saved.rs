//! Saved states in FMI 3.0.

use super::*;
use crate::boundary::saved;

/// Copies the whole instance behind a handle, a new one or one that is filled anew.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's instance and places, as the standard has them.
    unsafe { saved::save::<Host>(c, "fmi3GetFMUState", state) }
}

/// Takes the instance back to a copy; refused for a handle that this instance did not give.
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

/// Bytes that a copy takes; it grows with the history of a delayed record.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(c: *mut c_void, state: *mut c_void, size: *mut usize) -> CEnum {
    // SAFETY: the host's instance and places, as the standard has them.
    unsafe { saved::size::<Host>(c, "fmi3SerializedFMUStateSize", state, size) }
}

/// Writes a copy as bytes that another process can read.
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

/// Reads a copy from bytes; refused where they are damaged or of another FMU.
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
