//! Saved states in FMI 3.0.

use super::*;
use crate::boundary::saved;

c_functions! {
    /// Copies the whole instance, under a new or an existing handle.
    extern "C" fn fmi3GetFMUState(state: *mut *mut c_void) = |instance| saved::save(instance, state);

    /// Restores the instance from a copy; refuses a handle that this instance did not issue.
    extern "C" fn fmi3SetFMUState(state: *mut c_void) = |instance| instance.restore(state.addr());

    /// `fmi3FreeFMUState`: does nothing if there is no state.
    extern "C" fn fmi3FreeFMUState(state: *mut *mut c_void) = |instance| saved::free(instance, state);

    /// Size of a copy, bytes; it grows with the history of a delayed record.
    extern "C" fn fmi3SerializedFMUStateSize(state: *mut c_void, size: *mut usize) =
        |instance| saved::size(instance, state, size);

    /// Writes a copy as bytes readable by another process.
    extern "C" fn fmi3SerializeFMUState(state: *mut c_void, bytes: *mut u8, size: usize) =
        |instance| saved::serialize(instance, state, bytes, size);

    /// Reads a copy from bytes; refuses damaged ones and those of another FMU.
    extern "C" fn fmi3DeserializeFMUState(bytes: *const u8, size: usize, state: *mut *mut c_void) =
        |instance| saved::deserialize(instance, bytes, size, state);
}
