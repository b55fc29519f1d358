//! An instance behind a pointer of the tool, and how a function acts on it.

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use simulation::number::cpu;

use super::log::Log;
use super::pointers::{ERROR, FATAL, OK, Status};
use crate::{Instance, Refusal};

/// An instance as a tool holds it.
pub(super) struct Handle {
    instance: Instance,
    log: Log,
}

/// The instance behind a pointer of the tool; `None` for a null pointer.
pub(super) unsafe fn at<'a>(instance: *mut c_void) -> Option<&'a mut Handle> {
    // SAFETY: it is null, or one that `instantiated` gave and `free` has not taken back.
    unsafe { instance.cast::<Handle>().as_mut() }
}

/// A function acts on an instance. A refusal goes to the log.
pub(super) fn on(
    handle: Option<&mut Handle>,
    call: &str,
    act: impl FnOnce(&mut Instance) -> Result<(), Refusal>,
) -> Status {
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
pub(super) fn instantiated(call: &str, log: Log, new: impl FnOnce() -> Result<Instance, Refusal>) -> *mut c_void {
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
pub(super) unsafe fn free(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: it is one that `instantiated` gave; the tool does not use it any more.
        drop(unsafe { Box::from_raw(instance.cast::<Handle>()) });
    }
}

/// Functions of one version, after their instance: names, arguments, and what an instance does.
macro_rules! functions {
    ($($name:ident($($argument:ident: $type:ty),*) = $act:expr;)*) => { $(
        #[unsafe(no_mangle)]
        pub(super) unsafe extern "C" fn $name(instance: *mut c_void $(, $argument: $type)*) -> Status {
            // SAFETY: the instance is the tool's.
            super::handle::on(unsafe { super::handle::at(instance) }, stringify!($name), $act)
        }
    )* };
}

/// Functions that this FMU does not support.
macro_rules! not_here {
    ($($name:ident($($argument:ty),*);)*) => { $(
        #[unsafe(no_mangle)]
        pub(super) unsafe extern "C" fn $name(instance: *mut c_void $(, _: $argument)*) -> Status {
            // SAFETY: the instance is the tool's.
            super::handle::on(unsafe { super::handle::at(instance) }, stringify!($name), |_| Err(Refusal::NotHere))
        }
    )* };
}
