//! Saved states in FMI 2.0.

use super::*;
use crate::boundary::saved;

/// Copies the whole instance behind a handle, a new one or one that is filled anew.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's component and places, as the standard has them.
    unsafe { saved::save::<Host>(c, "fmi2GetFMUstate", state) }
}

/// Takes the instance back to a copy; refused for a handle that this instance did not give.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: *mut c_void, state: *mut c_void) -> CEnum {
    // SAFETY: the host's component.
    unsafe { guarded(c, "fmi2SetFMUstate", |component| component.instance.restore(state.addr())) }
}

/// `fmi2FreeFMUstate`: nothing happens where there is no state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's component and places, as the standard has them.
    unsafe { saved::free::<Host>(c, "fmi2FreeFMUstate", state) }
}

/// Bytes that a copy takes; it grows with the history of a delayed record.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: *mut c_void, state: *mut c_void, size: *mut usize) -> CEnum {
    // SAFETY: the host's component and places, as the standard has them.
    unsafe { saved::size::<Host>(c, "fmi2SerializedFMUstateSize", state, size) }
}

/// Writes a copy as bytes that another process can read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: *mut c_void,
    state: *mut c_void,
    bytes: *mut c_char,
    size: usize,
) -> CEnum {
    // SAFETY: the host's component and array, as the standard has them.
    unsafe { saved::serialize::<Host>(c, "fmi2SerializeFMUstate", state, bytes.cast(), size) }
}

/// Reads a copy from bytes; refused where they are damaged or of another FMU.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: *mut c_void,
    bytes: *const c_char,
    size: usize,
    state: *mut *mut c_void,
) -> CEnum {
    // SAFETY: the host's component and array, as the standard has them.
    unsafe { saved::deserialize::<Host>(c, "fmi2DeSerializeFMUstate", bytes.cast(), size, state) }
}
