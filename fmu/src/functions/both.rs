//! Functions that both versions have with the same arguments: the end of the initialisation and of the simulation, and states.

use std::ffi::c_void;
use std::ptr;

use super::pointers::{Status, places, put, slice};
use crate::{Instance, Refusal, Snapshot};

/// The state behind a pointer of the tool.
unsafe fn held<'a>(state: *mut c_void) -> Result<&'a Snapshot, Refusal> {
    // SAFETY: it is null, or one that `keep` gave and `free` has not taken back.
    unsafe { state.cast::<Snapshot>().as_ref() }.ok_or(Refusal::NoPlace)
}

/// Gives the tool a state. If it passes one that it already has, that one is overwritten.
unsafe fn keep(state: *mut *mut c_void, snapshot: Snapshot) -> Result<(), Refusal> {
    // SAFETY: what is not null is a place for a state: a null pointer, or a state as in `held`.
    let Some(place) = (unsafe { state.as_mut() }) else { return Err(Refusal::NoPlace) };
    match unsafe { place.cast::<Snapshot>().as_mut() } {
        Some(old) => *old = snapshot,
        None => *place = Box::into_raw(Box::new(snapshot)).cast(),
    }
    Ok(())
}

/// Takes a state back.
unsafe fn free(state: *mut *mut c_void) {
    // SAFETY: as in `keep`; the tool does not use the state any more.
    if let Some(place) = unsafe { state.as_mut() }
        && !place.is_null()
    {
        drop(unsafe { Box::from_raw(place.cast::<Snapshot>()) });
        *place = ptr::null_mut();
    }
}

/// The name in FMI 2.0, and the one in FMI 3.0.
macro_rules! in_both {
    ($($two:ident, $three:ident $arguments:tt = $act:expr;)*) => { $(
        functions! {
            $two $arguments = $act;
            $three $arguments = $act;
        }
    )* };
}

in_both! {
    fmi2ExitInitializationMode, fmi3ExitInitializationMode() = Instance::exit_initialization;
    fmi2Terminate, fmi3Terminate() = Instance::terminate;
    fmi2Reset, fmi3Reset() = |instance| {
        instance.reset();
        Ok(())
    };
    fmi2GetFMUstate, fmi3GetFMUState(state: *mut *mut c_void) = |instance| unsafe { keep(state, instance.snapshot()) };
    fmi2SetFMUstate, fmi3SetFMUState(state: *mut c_void) = |instance| instance.restore(unsafe { held(state) }?);
    fmi2FreeFMUstate, fmi3FreeFMUState(state: *mut *mut c_void) = |_| {
        unsafe { free(state) };
        Ok(())
    };
    fmi2SerializedFMUstateSize, fmi3SerializedFMUStateSize(state: *mut c_void, size: *mut usize) = |instance| {
        let bytes = unsafe { held(state) }?.to_bytes(&instance.token())?;
        unsafe { put(size, bytes.len()) }
    };
    fmi2SerializeFMUstate, fmi3SerializeFMUState(state: *mut c_void, serialized: *mut u8, size: usize) = |instance| {
        let bytes = unsafe { held(state) }?.to_bytes(&instance.token())?;
        let places = unsafe { places(serialized, size) };
        if places.len() != bytes.len() {
            return Err(Refusal::StateSize { found: places.len(), expected: bytes.len() });
        }
        places.copy_from_slice(&bytes);
        Ok(())
    };
    fmi2DeSerializeFMUstate, fmi3DeserializeFMUState(
        serialized: *const u8, size: usize, state: *mut *mut c_void
    ) = |instance| {
        let snapshot = Snapshot::of_bytes(&instance.token(), unsafe { slice(serialized, size) })?;
        unsafe { keep(state, snapshot) }
    };
}
