//! What C's types and pointers are here.

use std::ffi::{CStr, c_char, c_int};

use crate::Refusal;

pub(super) type Status = c_int;
pub(super) const OK: Status = 0;
pub(super) const DISCARD: Status = 2;
pub(super) const ERROR: Status = 3;
pub(super) const FATAL: Status = 4;

pub(super) type Text = *const c_char;
pub(super) type Reference = u32;

/// So many values; an empty slice for a null pointer.
pub(super) unsafe fn slice<'a, T>(values: *const T, count: usize) -> &'a [T] {
    // SAFETY: the tool states how many values there are.
    if values.is_null() || count == 0 { &[] } else { unsafe { std::slice::from_raw_parts(values, count) } }
}

/// So many places to write to; an empty slice for a null pointer.
pub(super) unsafe fn places<'a, T>(values: *mut T, count: usize) -> &'a mut [T] {
    // SAFETY: the tool states how many places there are.
    if values.is_null() || count == 0 { &mut [] } else { unsafe { std::slice::from_raw_parts_mut(values, count) } }
}

/// Writes a value to the place that the tool has given.
pub(super) unsafe fn put<T>(place: *mut T, value: T) -> Result<(), Refusal> {
    if place.is_null() {
        return Err(Refusal::NoPlace);
    }
    // SAFETY: what is not null is a place for such a value.
    unsafe { place.write(value) };
    Ok(())
}

pub(super) unsafe fn text<'a>(text: Text, what: &'static str) -> Result<&'a str, Refusal> {
    // SAFETY: what is not null ends with a zero byte.
    let bytes = if text.is_null() { None } else { Some(unsafe { CStr::from_ptr(text) }) };
    bytes.and_then(|bytes| bytes.to_str().ok()).ok_or(Refusal::NoText { what })
}
