//! Converts a host's pointers to slices, references and text, with all possible checks.

use super::Result;
use crate::protocol::refusal::Refusal;
use std::ffi::{CStr, c_char};
use std::ptr::NonNull;
use std::slice;

/// Limit of elements in one call: far more than there are variables.
const LONGEST: usize = 1 << 20;

/// The `length` elements at `data`; empty if the length is zero, whatever the pointer.
///
/// # Safety
/// A `data` that is neither NULL nor misaligned points to `length` elements, which outlive `'a` and are not written to.
pub unsafe fn elements<'a, T>(data: *const T, length: usize, argument: &'static str) -> Result<&'a [T]> {
    if length == 0 {
        return Ok(&[]);
    }
    if length > LONGEST {
        return Err(Refusal::TooLong { argument, length, limit: LONGEST });
    }
    if data.is_null() || !data.is_aligned() {
        return Err(Refusal::Null { argument });
    }
    // SAFETY: not NULL, aligned, and as long as the caller promises.
    Ok(unsafe { slice::from_raw_parts(data, length) })
}

/// As [`elements`], writable.
///
/// # Safety
/// As for [`elements`], and nothing else refers to them.
pub unsafe fn elements_mut<'a, T>(data: *mut T, length: usize, argument: &'static str) -> Result<&'a mut [T]> {
    // SAFETY: as the caller promises.
    unsafe { elements(data, length, argument)? };
    let data = NonNull::new(data).filter(|_| length > 0).unwrap_or(NonNull::dangling());
    // SAFETY: checked above; a slice of length zero may dangle.
    Ok(unsafe { slice::from_raw_parts_mut(data.as_ptr(), length) })
}

/// A reference to where a function writes one value.
///
/// # Safety
/// As for [`elements_mut`] with one element.
pub unsafe fn destination<'a, T>(data: *mut T, argument: &'static str) -> Result<&'a mut T> {
    // SAFETY: as the caller promises.
    let all = unsafe { elements_mut(data, 1, argument)? };
    all.first_mut().ok_or(Refusal::Null { argument })
}

/// Text of a C string, `None` where it is NULL.
///
/// # Safety
/// `data` is NULL or ends in a zero byte.
pub unsafe fn text(data: *const c_char) -> Option<String> {
    // SAFETY: not NULL, and as the caller promises.
    if data.is_null() { None } else { Some(unsafe { CStr::from_ptr(data) }.to_string_lossy().into_owned()) }
}
