//! Saved states in FMI 2.0.

use super::*;
use crate::boundary::saved;

/// `fmi2GetFMUstate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut c_void, state: *mut *mut c_void) -> CEnum {
    // SAFETY: the host's component and places, as the standard has them.
    unsafe { saved::save::<Host>(c, "fmi2GetFMUstate", state) }
}

/// `fmi2SetFMUstate`.
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

/// `fmi2SerializedFMUstateSize`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: *mut c_void, state: *mut c_void, size: *mut usize) -> CEnum {
    // SAFETY: the host's component and places, as the standard has them.
    unsafe { saved::size::<Host>(c, "fmi2SerializedFMUstateSize", state, size) }
}

/// `fmi2SerializeFMUstate`.
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

/// `fmi2DeSerializeFMUstate`.
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
