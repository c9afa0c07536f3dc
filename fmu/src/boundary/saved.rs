//! Saved states for the host, alike in every version of FMI: a handle is the address of a copy that the instance keeps, and
//! is only ever compared.

use super::{CEnum, Listener, Refusal, guarded, place};
use std::ffi::c_void;
use std::slice;

/// Saves the present state behind a handle, a new one or the one that is there.
///
/// # Safety
/// As for [`guarded`]; `state` is NULL or a place for a handle.
pub unsafe fn save<L: Listener>(c: *mut c_void, function: &'static str, state: *mut *mut c_void) -> CEnum {
    // SAFETY: as the caller promises.
    unsafe {
        guarded::<L>(c, function, &mut |component| {
            let state = place(state, "FMUstate")?;
            *state = component.instance.save(state.addr()) as *mut c_void;
            Ok(())
        })
    }
}

/// Frees a saved state and clears its handle.
///
/// # Safety
/// As for [`save`].
pub unsafe fn free<L: Listener>(c: *mut c_void, function: &'static str, state: *mut *mut c_void) -> CEnum {
    // SAFETY: as the caller promises.
    unsafe {
        guarded::<L>(c, function, &mut |component| {
            if let Some(state) = state.as_mut().filter(|state| !state.is_null()) {
                component.instance.free(state.addr())?;
                *state = std::ptr::null_mut();
            }
            Ok(())
        })
    }
}

/// Length of a saved state as bytes.
///
/// # Safety
/// As for [`guarded`]; `size` is NULL or a place for a number.
pub unsafe fn size<L: Listener>(c: *mut c_void, function: &'static str, state: *mut c_void, size: *mut usize) -> CEnum {
    // SAFETY: as the caller promises.
    unsafe {
        guarded::<L>(c, function, &mut |component| {
            let size = place(size, "size")?;
            *size = component.instance.serialize(state.addr())?.len();
            Ok(())
        })
    }
}

/// Writes a saved state as bytes.
///
/// # Safety
/// As for [`guarded`]; `bytes` is NULL or has `size` bytes.
pub unsafe fn serialize<L: Listener>(
    c: *mut c_void,
    function: &'static str,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> CEnum {
    // SAFETY: as the caller promises.
    unsafe {
        guarded::<L>(c, function, &mut |component| {
            let serialized = component.instance.serialize(state.addr())?;
            if size < serialized.len() {
                return Err(Refusal::BadBytes { why: "size is less than fmi2SerializedFMUstateSize says" });
            }
            if bytes.is_null() {
                return Err(Refusal::Null { argument: "serializedState" });
            }
            slice::from_raw_parts_mut(bytes, serialized.len()).copy_from_slice(&serialized);
            Ok(())
        })
    }
}

/// Reads a state from bytes and keeps it behind a handle.
///
/// # Safety
/// As for [`serialize`]; `state` is NULL or a place for a handle.
pub unsafe fn deserialize<L: Listener>(
    c: *mut c_void,
    function: &'static str,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> CEnum {
    // SAFETY: as the caller promises.
    unsafe {
        guarded::<L>(c, function, &mut |component| {
            let state = place(state, "FMUstate")?;
            if bytes.is_null() || size > isize::MAX as usize {
                return Err(Refusal::Null { argument: "serializedState" });
            }
            *state = component.instance.deserialize(slice::from_raw_parts(bytes, size))? as *mut c_void;
            Ok(())
        })
    }
}
