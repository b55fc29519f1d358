//! The functions of FMI 2.0 for co-simulation that FMI 3.0 does not have with the same arguments.

use std::ffi::{c_int, c_void};
use std::ptr;

use super::handle::{at, free, instantiated, on};
use super::log::{Log, Logger, c_text};
use super::pointers::{DISCARD, Reference, Status, Text, places, put, slice, text};
use crate::location::folder;
use crate::{Instance, Refusal};

/// The kind of instance for co-simulation.
pub(super) const CO_SIMULATION: c_int = 1;
/// What a tool asks about a step: how far it came.
pub(super) const LAST_SUCCESSFUL_TIME: c_int = 2;
/// What a tool asks about a step: whether the drive ends the simulation.
pub(super) const TERMINATED: c_int = 3;
/// False, as this version has it.
const FALSE: c_int = 0;

/// A function of the tool that is not called: the memory is the library's own, and a step is done when its call returns.
type Unused = Option<unsafe extern "C" fn()>;

/// What the tool gives an instance.
#[repr(C)]
pub(super) struct Callbacks {
    pub(super) logger: Logger,
    pub(super) allocate: Unused,
    pub(super) free: Unused,
    pub(super) step_finished: Unused,
    pub(super) environment: *mut c_void,
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetTypesPlatform() -> Text {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetVersion() -> Text {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi2Instantiate(
    name: Text,
    kind: c_int,
    token: Text,
    location: Text,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging: c_int,
) -> *mut c_void {
    // SAFETY: what is not null is such a struct, and a text that ends with a zero byte.
    let (callbacks, name) = unsafe { (callbacks.as_ref(), text(name, "instanceName").unwrap_or_default()) };
    let log = Log::Two {
        environment: callbacks.map_or(ptr::null_mut(), |callbacks| callbacks.environment),
        instance: c_text(name),
        logger: callbacks.and_then(|callbacks| callbacks.logger),
    };
    instantiated("fmi2Instantiate", log, || {
        if kind != CO_SIMULATION {
            return Err(Refusal::Kind { found: kind, expected: CO_SIMULATION });
        }
        let resources = folder(unsafe { text(location, "fmuResourceLocation") }?)?;
        Instance::new(&resources, unsafe { text(token, "fmuGUID") }?)
    })
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi2FreeInstance(instance: *mut c_void) {
    unsafe { free(instance) };
}

functions! {
    // The switch has no effect: only errors are logged.
    fmi2SetDebugLogging(_on: c_int, _count: usize, _of: *const Text) = |_| Ok(());
    fmi2SetupExperiment(
        _tolerance_defined: c_int, _tolerance: f64, start_s: f64, _stop_defined: c_int, _stop_s: f64
    ) = |instance| instance.start_at(start_s);
    fmi2EnterInitializationMode() = Instance::enter_initialization;
    fmi2GetReal(references: *const Reference, count: usize, values: *mut f64) =
        |instance| unsafe { instance.get(slice(references, count), places(values, count)) };
    fmi2SetReal(references: *const Reference, count: usize, values: *const f64) =
        |instance| unsafe { instance.set(slice(references, count), slice(values, count)) };
    fmi2DoStep(from_s: f64, step_s: f64, _no_state_before: c_int) = |instance| instance.step(from_s, step_s).map(drop);
}

// Other types of variables, derivatives, and steps that go on while their call has returned.
not_here! {
    fmi2GetInteger(*const Reference, usize, *mut c_int);
    fmi2GetBoolean(*const Reference, usize, *mut c_int);
    fmi2GetString(*const Reference, usize, *mut Text);
    fmi2SetInteger(*const Reference, usize, *const c_int);
    fmi2SetBoolean(*const Reference, usize, *const c_int);
    fmi2SetString(*const Reference, usize, *const Text);
    fmi2GetDirectionalDerivative(*const Reference, usize, *const Reference, usize, *const f64, *mut f64);
    fmi2SetRealInputDerivatives(*const Reference, usize, *const c_int, *const f64);
    fmi2GetRealOutputDerivatives(*const Reference, usize, *const c_int, *mut f64);
    fmi2CancelStep();
}

/// A status that the drive has, where the tool asks for this one. For any other the standard has a status of its own, without a message.
macro_rules! statuses {
    ($($name:ident($asked:ident, $type:ty) = $act:expr;)*) => { $(
        #[unsafe(no_mangle)]
        pub(super) unsafe extern "C" fn $name(instance: *mut c_void, kind: c_int, value: *mut $type) -> Status {
            if kind != $asked {
                return DISCARD;
            }
            // SAFETY: the instance is the tool's, and what is not null is a place for a value.
            on(unsafe { at(instance) }, stringify!($name), |instance| unsafe { put(value, $act(instance)) })
        }
    )* };
}

statuses! {
    fmi2GetRealStatus(LAST_SUCCESSFUL_TIME, f64) = |instance: &mut Instance| instance.time_s();
    fmi2GetBooleanStatus(TERMINATED, c_int) = |_| FALSE;
}

/// No step goes on after its call: there is nothing to say of it.
#[unsafe(no_mangle)]
extern "C" fn fmi2GetStatus(_instance: *mut c_void, _kind: c_int, _value: *mut Status) -> Status {
    DISCARD
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetIntegerStatus(_instance: *mut c_void, _kind: c_int, _value: *mut c_int) -> Status {
    DISCARD
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetStringStatus(_instance: *mut c_void, _kind: c_int, _value: *mut Text) -> Status {
    DISCARD
}
