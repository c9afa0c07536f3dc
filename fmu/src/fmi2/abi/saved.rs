//! Saved states in FMI 2.0.

use super::*;
use crate::boundary::saved;

c_functions! {
    /// Copies the whole instance, under a new or an existing handle.
    extern "C" fn fmi2GetFMUstate(state: *mut *mut c_void) = |instance| saved::save(instance, state);

    /// Restores the instance from a copy; refuses a handle that this instance did not issue.
    extern "C" fn fmi2SetFMUstate(state: *mut c_void) = |instance| instance.restore(state.addr());

    /// `fmi2FreeFMUstate`: does nothing if there is no state.
    extern "C" fn fmi2FreeFMUstate(state: *mut *mut c_void) = |instance| saved::free(instance, state);

    /// Size of a copy, bytes; it grows with the history of a delayed record.
    extern "C" fn fmi2SerializedFMUstateSize(state: *mut c_void, size: *mut usize) =
        |instance| saved::size(instance, state, size);

    /// Writes a copy as bytes readable by another process.
    extern "C" fn fmi2SerializeFMUstate(state: *mut c_void, bytes: *mut c_char, size: usize) =
        |instance| saved::serialize(instance, state, bytes.cast(), size);

    /// Reads a copy from bytes; refuses damaged ones and those of another FMU.
    extern "C" fn fmi2DeSerializeFMUstate(bytes: *const c_char, size: usize, state: *mut *mut c_void) =
        |instance| saved::deserialize(instance, bytes.cast(), size, state);
}
