//! Saved states in FMI 2.0.

use super::*;
use crate::boundary::saved;

c_functions! {
    /// Copies the whole instance behind a handle, a new one or one that is filled anew.
    extern "C" fn fmi2GetFMUstate(state: *mut *mut c_void) = |instance| saved::save(instance, state);

    /// Takes the instance back to a copy; refused for a handle that this instance did not give.
    extern "C" fn fmi2SetFMUstate(state: *mut c_void) = |instance| instance.restore(state.addr());

    /// `fmi2FreeFMUstate`: nothing happens where there is no state.
    extern "C" fn fmi2FreeFMUstate(state: *mut *mut c_void) = |instance| saved::free(instance, state);

    /// Bytes that a copy takes; it grows with the history of a delayed record.
    extern "C" fn fmi2SerializedFMUstateSize(state: *mut c_void, size: *mut usize) =
        |instance| saved::size(instance, state, size);

    /// Writes a copy as bytes that another process can read.
    extern "C" fn fmi2SerializeFMUstate(state: *mut c_void, bytes: *mut c_char, size: usize) =
        |instance| saved::serialize(instance, state, bytes.cast(), size);

    /// Reads a copy from bytes; refused where they are damaged or of another FMU.
    extern "C" fn fmi2DeSerializeFMUstate(bytes: *const c_char, size: usize, state: *mut *mut c_void) =
        |instance| saved::deserialize(instance, bytes.cast(), size, state);
}
