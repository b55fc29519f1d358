//! The C functions of FMI 2.0 and 3.0: pointers become arguments of an [`Instance`], and a refusal becomes a line of the tool's log.
//!
//! Both versions are functions of one library over one kind of instance. All that a version asks of co-simulation are present, because tools
//! look for each; functions that this FMU does not support return an error. A tool guarantees (FMI 2.0, 2.1; FMI 3.0, 2.2) that pointers refer
//! to as many values as it states, and that an instance or a state is one that it was given and has not freed; every `unsafe` below relies on
//! this and on nothing else.
#![expect(unsafe_code, reason = "the standard's interface is one of pointers; only this module has them")]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use simulation::number::cpu;

use crate::{Instance, Refusal};
use log::Log;

type Status = c_int;
const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;
const FATAL: Status = 4;

type Text = *const c_char;
type Reference = u32;

/// An instance as a tool holds it.
struct Handle {
    instance: Instance,
    log: Log,
}

/// The instance behind a pointer of the tool; `None` for a null pointer.
unsafe fn handle<'a>(instance: *mut c_void) -> Option<&'a mut Handle> {
    // SAFETY: it is null, or one that `instantiated` gave and `free` has not taken back.
    unsafe { instance.cast::<Handle>().as_mut() }
}

/// A function acts on an instance. A refusal goes to the log.
fn on(handle: Option<&mut Handle>, call: &str, act: impl FnOnce(&mut Instance) -> Result<(), Refusal>) -> Status {
    let Some(handle) = handle else { return ERROR };
    // A panic must not reach the tool, which cannot handle it.
    match catch_unwind(AssertUnwindSafe(|| act(&mut handle.instance))) {
        Ok(Ok(())) => OK,
        Ok(Err(refusal)) => {
            handle.log.error(call, &refusal);
            ERROR
        }
        Err(_) => FATAL,
    }
}

/// A new instance for the tool; a null pointer if there is none, and the reason goes to the log.
fn instantiated(call: &str, log: Log, new: impl FnOnce() -> Result<Instance, Refusal>) -> *mut c_void {
    let checked = || {
        cpu::check()?;
        new()
    };
    match catch_unwind(AssertUnwindSafe(checked)) {
        Ok(Ok(instance)) => Box::into_raw(Box::new(Handle { instance, log })).cast(),
        Ok(Err(refusal)) => {
            log.error(call, &refusal);
            ptr::null_mut()
        }
        Err(_) => ptr::null_mut(),
    }
}

/// Takes an instance back.
unsafe fn free(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: it is one that `instantiated` gave; the tool does not use it any more.
        drop(unsafe { Box::from_raw(instance.cast::<Handle>()) });
    }
}

/// So many values; an empty slice for a null pointer.
unsafe fn slice<'a, T>(values: *const T, count: usize) -> &'a [T] {
    // SAFETY: the tool states how many values there are.
    if values.is_null() || count == 0 { &[] } else { unsafe { std::slice::from_raw_parts(values, count) } }
}

/// So many places to write to; an empty slice for a null pointer.
unsafe fn places<'a, T>(values: *mut T, count: usize) -> &'a mut [T] {
    // SAFETY: the tool states how many places there are.
    if values.is_null() || count == 0 { &mut [] } else { unsafe { std::slice::from_raw_parts_mut(values, count) } }
}

/// Writes a value to the place that the tool has given.
unsafe fn put<T>(place: *mut T, value: T) -> Result<(), Refusal> {
    if place.is_null() {
        return Err(Refusal::NoPlace);
    }
    // SAFETY: what is not null is a place for such a value.
    unsafe { place.write(value) };
    Ok(())
}

unsafe fn text<'a>(text: Text, what: &'static str) -> Result<&'a str, Refusal> {
    // SAFETY: what is not null ends with a zero byte.
    let bytes = if text.is_null() { None } else { Some(unsafe { CStr::from_ptr(text) }) };
    bytes.and_then(|bytes| bytes.to_str().ok()).ok_or(Refusal::NoText { what })
}

/// Functions of one version, after their instance: names, arguments, and what an instance does.
macro_rules! functions {
    ($($name:ident($($argument:ident: $type:ty),*) = $act:expr;)*) => { $(
        #[unsafe(no_mangle)]
        pub(super) unsafe extern "C" fn $name(instance: *mut c_void $(, $argument: $type)*) -> Status {
            // SAFETY: the instance is the tool's.
            super::on(unsafe { super::handle(instance) }, stringify!($name), $act)
        }
    )* };
}

/// Functions that this FMU does not support.
macro_rules! not_here {
    ($($name:ident($($argument:ty),*);)*) => { $(
        #[unsafe(no_mangle)]
        pub(super) unsafe extern "C" fn $name(instance: *mut c_void $(, _: $argument)*) -> Status {
            // SAFETY: the instance is the tool's.
            super::on(unsafe { super::handle(instance) }, stringify!($name), |_| Err(Refusal::NotHere))
        }
    )* };
}

mod both;
mod fmi2;
mod fmi3;
mod log;

#[cfg(test)]
mod tests;
