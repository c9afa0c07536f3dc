//! Saved states for the host, the same for all FMI versions: a handle is the address of a copy kept by the instance, and is only
//! ever compared.

use super::{Instance, Refusal, Result, destination};
use std::ffi::c_void;
use std::slice;

/// Saves the present state under a new or the given handle.
///
/// # Safety
/// `state` is NULL or a destination for a handle.
pub unsafe fn save(instance: &mut Instance, state: *mut *mut c_void) -> Result<()> {
    // SAFETY: as the caller promises.
    let state = unsafe { destination(state, "FMUstate")? };
    *state = instance.save(state.addr()) as *mut c_void;
    Ok(())
}

/// Frees a saved state and clears its handle.
///
/// # Safety
/// As for [`save`].
pub unsafe fn free(instance: &mut Instance, state: *mut *mut c_void) -> Result<()> {
    // SAFETY: as the caller promises.
    if let Some(state) = unsafe { state.as_mut() }.filter(|state| !state.is_null()) {
        instance.free(state.addr())?;
        *state = std::ptr::null_mut();
    }
    Ok(())
}

/// Length of a saved state in bytes.
///
/// # Safety
/// `size` is NULL or a destination for a number.
pub unsafe fn size(instance: &Instance, state: *mut c_void, size: *mut usize) -> Result<()> {
    // SAFETY: as the caller promises.
    let size = unsafe { destination(size, "size")? };
    *size = instance.serialize(state.addr())?.len();
    Ok(())
}

/// Writes a saved state as bytes.
///
/// # Safety
/// `bytes` is NULL or has `size` bytes.
pub unsafe fn serialize(instance: &Instance, state: *mut c_void, bytes: *mut u8, size: usize) -> Result<()> {
    let serialized = instance.serialize(state.addr())?;
    if size < serialized.len() {
        return Err(Refusal::BadBytes { why: "its size is less than fmi2SerializedFMUstateSize says" });
    }
    if bytes.is_null() {
        return Err(Refusal::Null { argument: "serializedState" });
    }
    // SAFETY: not NULL, and as long as the caller promises.
    unsafe { slice::from_raw_parts_mut(bytes, serialized.len()) }.copy_from_slice(&serialized);
    Ok(())
}

/// Restores a state from bytes and keeps it under a handle.
///
/// # Safety
/// As for [`serialize`]; `state` is NULL or a destination for a handle.
pub unsafe fn deserialize(
    instance: &mut Instance,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Result<()> {
    // SAFETY: as the caller promises.
    let state = unsafe { destination(state, "FMUstate")? };
    if bytes.is_null() || size > isize::MAX as usize {
        return Err(Refusal::Null { argument: "serializedState" });
    }
    // SAFETY: not NULL, and as long as the caller promises.
    *state = instance.deserialize(unsafe { slice::from_raw_parts(bytes, size) })? as *mut c_void;
    Ok(())
}
