//! The functions of FMI 3.0 that FMI 2.0 does not have with the same arguments.

use std::ffi::{c_int, c_void};
use std::path::Path;
use std::ptr;

use super::handle::{free, instantiated};
use super::log::{Log, Message};
use super::pointers::{Reference, Status, Text, places, put, slice, text};
use crate::{Instance, Refusal};

type IntermediateUpdate = Option<unsafe extern "C" fn(*mut c_void, f64, bool, bool, bool, bool, *mut bool, *mut f64)>;
type Callback = Option<unsafe extern "C" fn(*mut c_void)>;
type Lock = Option<unsafe extern "C" fn()>;

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> Text {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: Text,
    token: Text,
    resources: Text,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _intermediate: *const Reference,
    _intermediate_count: usize,
    environment: *mut c_void,
    message: Message,
    _update: IntermediateUpdate,
) -> *mut c_void {
    instantiated("fmi3InstantiateCoSimulation", Log::Three { environment, message }, || {
        let resources = unsafe { text(resources, "resourcePath") }?;
        Instance::new(Path::new(resources), unsafe { text(token, "instantiationToken") }?)
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateModelExchange(
    _name: Text,
    _token: Text,
    _resources: Text,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    message: Message,
) -> *mut c_void {
    Log::Three { environment, message }.error("fmi3InstantiateModelExchange", &Refusal::NotHere);
    ptr::null_mut()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _name: Text,
    _token: Text,
    _resources: Text,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    message: Message,
    _update: Callback,
    _lock: Lock,
    _unlock: Lock,
) -> *mut c_void {
    Log::Three { environment, message }.error("fmi3InstantiateScheduledExecution", &Refusal::NotHere);
    ptr::null_mut()
}

#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    unsafe { free(instance) };
}

functions! {
    // The switch has no effect: only errors are logged.
    fmi3SetDebugLogging(_on: bool, _count: usize, _of: *const Text) = |_| Ok(());
    fmi3EnterInitializationMode(
        _tolerance_defined: bool, _tolerance: f64, start_s: f64, _stop_defined: bool, _stop_s: f64
    ) = |instance| {
        instance.start_at(start_s)?;
        instance.enter_initialization()
    };
    fmi3GetFloat64(
        references: *const Reference, reference_count: usize, values: *mut f64, value_count: usize
    ) = |instance| unsafe { instance.get(slice(references, reference_count), places(values, value_count)) };
    fmi3SetFloat64(
        references: *const Reference, reference_count: usize, values: *const f64, value_count: usize
    ) = |instance| unsafe { instance.set(slice(references, reference_count), slice(values, value_count)) };
    fmi3DoStep(
        from_s: f64, step_s: f64, _no_state_before: bool, event_handling_needed: *mut bool,
        terminate_simulation: *mut bool, early_return: *mut bool, last_successful_s: *mut f64
    ) = |instance| {
        let reached_s = instance.step(from_s, step_s)?;
        unsafe {
            put(event_handling_needed, false)?;
            put(terminate_simulation, false)?;
            put(early_return, false)?;
            put(last_successful_s, reached_s)
        }
    };
}

// Other types of variables, events, clocks, derivatives, model exchange.
not_here! {
    fmi3EnterEventMode();
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3EnterStepMode();
    fmi3GetFloat32(*const Reference, usize, *mut f32, usize);
    fmi3GetInt8(*const Reference, usize, *mut i8, usize);
    fmi3GetUInt8(*const Reference, usize, *mut u8, usize);
    fmi3GetInt16(*const Reference, usize, *mut i16, usize);
    fmi3GetUInt16(*const Reference, usize, *mut u16, usize);
    fmi3GetInt32(*const Reference, usize, *mut i32, usize);
    fmi3GetUInt32(*const Reference, usize, *mut u32, usize);
    fmi3GetInt64(*const Reference, usize, *mut i64, usize);
    fmi3GetUInt64(*const Reference, usize, *mut u64, usize);
    fmi3GetBoolean(*const Reference, usize, *mut bool, usize);
    fmi3GetString(*const Reference, usize, *mut Text, usize);
    fmi3GetBinary(*const Reference, usize, *mut usize, *mut *const u8, usize);
    fmi3GetClock(*const Reference, usize, *mut bool);
    fmi3SetFloat32(*const Reference, usize, *const f32, usize);
    fmi3SetInt8(*const Reference, usize, *const i8, usize);
    fmi3SetUInt8(*const Reference, usize, *const u8, usize);
    fmi3SetInt16(*const Reference, usize, *const i16, usize);
    fmi3SetUInt16(*const Reference, usize, *const u16, usize);
    fmi3SetInt32(*const Reference, usize, *const i32, usize);
    fmi3SetUInt32(*const Reference, usize, *const u32, usize);
    fmi3SetInt64(*const Reference, usize, *const i64, usize);
    fmi3SetUInt64(*const Reference, usize, *const u64, usize);
    fmi3SetBoolean(*const Reference, usize, *const bool, usize);
    fmi3SetString(*const Reference, usize, *const Text, usize);
    fmi3SetBinary(*const Reference, usize, *const usize, *const *const u8, usize);
    fmi3SetClock(*const Reference, usize, *const bool);
    fmi3GetNumberOfVariableDependencies(Reference, *mut usize);
    fmi3GetVariableDependencies(Reference, *mut usize, *mut Reference, *mut usize, *mut c_int, usize);
    fmi3GetDirectionalDerivative(
        *const Reference, usize, *const Reference, usize, *const f64, usize, *mut f64, usize
    );
    fmi3GetAdjointDerivative(*const Reference, usize, *const Reference, usize, *const f64, usize, *mut f64, usize);
    fmi3GetIntervalDecimal(*const Reference, usize, *mut f64, *mut c_int);
    fmi3GetIntervalFraction(*const Reference, usize, *mut u64, *mut u64, *mut c_int);
    fmi3GetShiftDecimal(*const Reference, usize, *mut f64);
    fmi3GetShiftFraction(*const Reference, usize, *mut u64, *mut u64);
    fmi3SetIntervalDecimal(*const Reference, usize, *const f64);
    fmi3SetIntervalFraction(*const Reference, usize, *const u64, *const u64);
    fmi3SetShiftDecimal(*const Reference, usize, *const f64);
    fmi3SetShiftFraction(*const Reference, usize, *const u64, *const u64);
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(*mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64);
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool);
    fmi3SetTime(f64);
    fmi3SetContinuousStates(*const f64, usize);
    fmi3GetContinuousStateDerivatives(*mut f64, usize);
    fmi3GetEventIndicators(*mut f64, usize);
    fmi3GetContinuousStates(*mut f64, usize);
    fmi3GetNominalsOfContinuousStates(*mut f64, usize);
    fmi3GetNumberOfEventIndicators(*mut usize);
    fmi3GetNumberOfContinuousStates(*mut usize);
    fmi3GetOutputDerivatives(*const Reference, usize, *const i32, *mut f64, usize);
    fmi3ActivateModelPartition(Reference, f64);
}
