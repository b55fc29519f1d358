//! The C functions of FMI 3.0: pointers become arguments of an [`Instance`], and a refusal becomes a line of the tool's log.
//!
//! All functions of the standard are present, because tools look for each; functions that this FMU does not support return an error. A
//! tool guarantees (FMI 3.0, 2.2) that pointers refer to as many values as it states, and that an instance is one that it was given and
//! has not freed; every `unsafe` below relies on this and on nothing else.
#![expect(unsafe_code, reason = "the standard's interface is one of pointers; this is the only file that has them")]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::ptr;

use simulation::number::cpu;

use crate::{Instance, Refusal, Snapshot};

type Status = c_int;
const OK: Status = 0;
const ERROR: Status = 3;
const FATAL: Status = 4;

type Text = *const c_char;
type Reference = u32;
type LogMessage = Option<unsafe extern "C" fn(*mut c_void, Status, Text, Text)>;
type IntermediateUpdate = Option<unsafe extern "C" fn(*mut c_void, f64, bool, bool, bool, bool, *mut bool, *mut f64)>;
type Callback = Option<unsafe extern "C" fn(*mut c_void)>;
type Lock = Option<unsafe extern "C" fn()>;

/// An instance as a tool holds it.
struct Handle {
    instance: Instance,
    log: Log,
}

/// Where messages go.
#[derive(Clone, Copy)]
struct Log {
    environment: *mut c_void,
    message: LogMessage,
}

impl Log {
    /// Logs an error whether or not debug logging is on: without the message nobody learns why a simulation ends.
    fn error(self, refusal: &Refusal) {
        // None of the texts of this program holds a zero byte; a file's name might.
        let text = CString::new(refusal.to_string().replace('\0', " ")).unwrap_or_default();
        if let Some(message) = self.message {
            unsafe { message(self.environment, ERROR, c"logStatusError".as_ptr(), text.as_ptr()) };
        }
    }
}

/// Calls `act` on an instance. A refusal goes to the log.
unsafe fn on(instance: *mut c_void, act: impl FnOnce(&mut Instance) -> Result<(), Refusal>) -> Status {
    let Some(handle) = (unsafe { instance.cast::<Handle>().as_mut() }) else { return ERROR };
    // A panic must not reach the tool, which cannot handle it.
    match catch_unwind(AssertUnwindSafe(|| act(&mut handle.instance))) {
        Ok(Ok(())) => OK,
        Ok(Err(refusal)) => {
            handle.log.error(&refusal);
            ERROR
        }
        Err(_) => FATAL,
    }
}

/// So many values; an empty slice for a null pointer.
unsafe fn slice<'a, T>(values: *const T, count: usize) -> &'a [T] {
    if values.is_null() || count == 0 { &[] } else { unsafe { std::slice::from_raw_parts(values, count) } }
}

/// So many places to write to; an empty slice for a null pointer.
unsafe fn places<'a, T>(values: *mut T, count: usize) -> &'a mut [T] {
    if values.is_null() || count == 0 { &mut [] } else { unsafe { std::slice::from_raw_parts_mut(values, count) } }
}

/// Writes a value to the place that the tool has given.
unsafe fn put<T>(place: *mut T, value: T, call: &'static str) -> Result<(), Refusal> {
    if place.is_null() {
        return Err(Refusal::NoPlace { call });
    }
    unsafe { place.write(value) };
    Ok(())
}

unsafe fn text<'a>(text: Text, what: &'static str) -> Result<&'a str, Refusal> {
    let bytes = if text.is_null() { None } else { Some(unsafe { CStr::from_ptr(text) }) };
    bytes.and_then(|bytes| bytes.to_str().ok()).ok_or(Refusal::NoText { what })
}

/// The state behind a pointer of the tool.
unsafe fn held<'a>(state: *mut c_void, call: &'static str) -> Result<&'a Snapshot, Refusal> {
    unsafe { state.cast::<Snapshot>().as_ref() }.ok_or(Refusal::NoPlace { call })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> Text {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetDebugLogging(instance: *mut c_void, _on: bool, _count: usize, _of: *const Text) -> Status {
    // The switch has no effect: only errors are logged.
    unsafe { on(instance, |_| Ok(())) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateCoSimulation(
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
    message: LogMessage,
    _update: IntermediateUpdate,
) -> *mut c_void {
    let log = Log { environment, message };
    let new = || {
        cpu::check()?;
        let resources = unsafe { text(resources, "resourcePath") }?;
        Instance::new(Path::new(resources), unsafe { text(token, "instantiationToken") }?)
    };
    match catch_unwind(AssertUnwindSafe(new)) {
        Ok(Ok(instance)) => Box::into_raw(Box::new(Handle { instance, log })).cast(),
        Ok(Err(refusal)) => {
            log.error(&refusal);
            ptr::null_mut()
        }
        Err(_) => ptr::null_mut(),
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateModelExchange(
    _name: Text,
    _token: Text,
    _resources: Text,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    message: LogMessage,
) -> *mut c_void {
    Log { environment, message }.error(&Refusal::NotHere { call: "fmi3InstantiateModelExchange" });
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
    message: LogMessage,
    _update: Callback,
    _lock: Lock,
    _unlock: Lock,
) -> *mut c_void {
    Log { environment, message }.error(&Refusal::NotHere { call: "fmi3InstantiateScheduledExecution" });
    ptr::null_mut()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        drop(unsafe { Box::from_raw(instance.cast::<Handle>()) });
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _tolerance_defined: bool,
    _tolerance: f64,
    start_s: f64,
    _stop_defined: bool,
    _stop_s: f64,
) -> Status {
    unsafe { on(instance, |instance| instance.enter_initialization(start_s)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> Status {
    unsafe { on(instance, Instance::exit_initialization) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Terminate(instance: *mut c_void) -> Status {
    unsafe { on(instance, Instance::terminate) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> Status {
    let reset = |instance: &mut Instance| {
        instance.reset();
        Ok(())
    };
    unsafe { on(instance, reset) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut c_void,
    references: *const Reference,
    reference_count: usize,
    values: *mut f64,
    value_count: usize,
) -> Status {
    let (references, values) = unsafe { (slice(references, reference_count), places(values, value_count)) };
    unsafe { on(instance, |instance| instance.get(references, values)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut c_void,
    references: *const Reference,
    reference_count: usize,
    values: *const f64,
    value_count: usize,
) -> Status {
    let (references, values) = unsafe { (slice(references, reference_count), slice(values, value_count)) };
    unsafe { on(instance, |instance| instance.set(references, values)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    from_s: f64,
    step_s: f64,
    _no_state_before: bool,
    event_handling_needed: *mut bool,
    terminate_simulation: *mut bool,
    early_return: *mut bool,
    last_successful_s: *mut f64,
) -> Status {
    const CALL: &str = "fmi3DoStep";
    let step = |instance: &mut Instance| {
        let reached_s = instance.step(from_s, step_s)?;
        unsafe {
            put(event_handling_needed, false, CALL)?;
            put(terminate_simulation, false, CALL)?;
            put(early_return, false, CALL)?;
            put(last_successful_s, reached_s, CALL)
        }
    };
    unsafe { on(instance, step) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFMUState(instance: *mut c_void, state: *mut *mut c_void) -> Status {
    const CALL: &str = "fmi3GetFMUState";
    let keep = |instance: &mut Instance| {
        let Some(place) = (unsafe { state.as_mut() }) else { return Err(Refusal::NoPlace { call: CALL }) };
        // If the tool passes a state that it already has, that state is overwritten.
        match unsafe { place.cast::<Snapshot>().as_mut() } {
            Some(old) => *old = instance.snapshot(),
            None => *place = Box::into_raw(Box::new(instance.snapshot())).cast(),
        }
        Ok(())
    };
    unsafe { on(instance, keep) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFMUState(instance: *mut c_void, state: *mut c_void) -> Status {
    unsafe { on(instance, |instance| instance.restore(held(state, "fmi3SetFMUState")?)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeFMUState(instance: *mut c_void, state: *mut *mut c_void) -> Status {
    let free = |_: &mut Instance| {
        if let Some(place) = unsafe { state.as_mut() }
            && !place.is_null()
        {
            drop(unsafe { Box::from_raw(place.cast::<Snapshot>()) });
            *place = ptr::null_mut();
        }
        Ok(())
    };
    unsafe { on(instance, free) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SerializedFMUStateSize(instance: *mut c_void, state: *mut c_void, size: *mut usize) -> Status {
    const CALL: &str = "fmi3SerializedFMUStateSize";
    let measure = |instance: &mut Instance| {
        let bytes = unsafe { held(state, CALL) }?.to_bytes(&instance.token())?;
        unsafe { put(size, bytes.len(), CALL) }
    };
    unsafe { on(instance, measure) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SerializeFMUState(
    instance: *mut c_void,
    state: *mut c_void,
    serialized: *mut u8,
    size: usize,
) -> Status {
    let write = |instance: &mut Instance| {
        let bytes = unsafe { held(state, "fmi3SerializeFMUState") }?.to_bytes(&instance.token())?;
        let places = unsafe { places(serialized, size) };
        if places.len() != bytes.len() {
            return Err(Refusal::StateSize { found: places.len(), expected: bytes.len() });
        }
        places.copy_from_slice(&bytes);
        Ok(())
    };
    unsafe { on(instance, write) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: *mut c_void,
    serialized: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    const CALL: &str = "fmi3DeserializeFMUState";
    let read = |instance: &mut Instance| {
        let snapshot = Snapshot::of_bytes(&instance.token(), unsafe { slice(serialized, size) })?;
        let Some(place) = (unsafe { state.as_mut() }) else { return Err(Refusal::NoPlace { call: CALL }) };
        match unsafe { place.cast::<Snapshot>().as_mut() } {
            Some(old) => *old = snapshot,
            None => *place = Box::into_raw(Box::new(snapshot)).cast(),
        }
        Ok(())
    };
    unsafe { on(instance, read) }
}

/// Functions that this FMU does not support: other types of variables, events, clocks, derivatives, model exchange.
macro_rules! not_here {
    ($($name:ident($($argument:ty),*);)*) => { $(
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(instance: *mut c_void $(, _: $argument)*) -> Status {
            unsafe { on(instance, |_| Err(Refusal::NotHere { call: stringify!($name) })) }
        }
    )* };
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::tests::{PRESS, resources};

    /// Stores the messages of the log, and checks that the tool's own environment is passed with them.
    unsafe extern "C" fn remember(environment: *mut c_void, status: Status, category: Text, message: Text) {
        let told = unsafe { &mut *environment.cast::<Vec<String>>() };
        assert_eq!(status, ERROR);
        assert_eq!(unsafe { text(category, "category") }.unwrap(), "logStatusError");
        told.push(unsafe { text(message, "message") }.unwrap().to_owned());
    }

    fn instantiate(resources: &Path, token: &CStr, told: &mut Vec<String>) -> *mut c_void {
        let path = CString::new(resources.to_str().unwrap()).unwrap();
        let environment = ptr::from_mut(told).cast();
        unsafe {
            fmi3InstantiateCoSimulation(
                c"press".as_ptr(),
                token.as_ptr(),
                path.as_ptr(),
                false,
                false,
                false,
                false,
                ptr::null(),
                0,
                environment,
                Some(remember),
                None,
            )
        }
    }

    /// The token of the FMU with these resources.
    fn token(resources: &Path) -> CString {
        let contents = model_export::fmu::Contents::read(resources).unwrap();
        CString::new(model_export::fmu::token(&contents)).unwrap()
    }

    #[test]
    fn a_tool_gets_values_by_pointers_and_errors_by_its_log() {
        let folder = resources(PRESS, "fixed");
        let token = token(folder.path());
        let mut told = Vec::new();
        assert!(instantiate(folder.path(), c"another", &mut told).is_null());
        assert!(
            told.pop().unwrap().starts_with("the model description has the token \"another\"; expected \"drive-fmu/")
        );
        assert!(instantiate(&folder.path().join("gone"), &token, &mut told).is_null());
        assert!(told.pop().unwrap().contains("machine.toml"));

        let instance = instantiate(folder.path(), &token, &mut told);
        assert!(!instance.is_null() && told.is_empty());
        let position = model_export::fmu::Variable::Position.reference();
        let (mut value, mut flags, mut reached_s) = (0.0, [true; 3], 0.0);
        let [event, terminate, early] = flags.each_mut().map(ptr::from_mut);
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0), OK);
            assert_eq!(fmi3ExitInitializationMode(instance), OK);
            assert_eq!(fmi3DoStep(instance, 0.0, 0.01, true, event, terminate, early, &raw mut reached_s), OK);
            assert_eq!(fmi3GetFloat64(instance, &raw const position, 1, &raw mut value, 1), OK);
            assert_eq!(fmi3GetFloat64(instance, &raw const position, 1, ptr::null_mut(), 1), ERROR);
            assert_eq!(fmi3EnterEventMode(instance), ERROR);
            fmi3FreeInstance(instance);
            assert_eq!(fmi3Terminate(ptr::null_mut()), ERROR);
        }
        assert_eq!((reached_s, flags), (0.01, [false; 3]));
        assert!((value - 0.15).abs() < 0.01, "{value}");
        assert_eq!(told.len(), 2);
        assert!(told[0].starts_with("1 value references and 0 values") && told[1].starts_with("fmi3EnterEventMode"));
    }

    #[test]
    fn a_state_that_was_kept_or_written_down_is_gone_on_from() {
        let folder = resources(PRESS, "float");
        let token = token(folder.path());
        let mut told = Vec::new();
        let instance = instantiate(folder.path(), &token, &mut told);
        let (command, position) =
            (model_export::fmu::Variable::Command.reference(), model_export::fmu::Variable::Position.reference());
        let mut flags = [true; 3];
        let [event, terminate, early] = flags.each_mut().map(ptr::from_mut);
        let (mut state, mut size, mut reached_s) = (ptr::null_mut(), 0, 0.0);
        unsafe {
            let mut step = |from_s| {
                let mut value = 0.0;
                let four = 4.0;
                assert_eq!(fmi3SetFloat64(instance, &raw const command, 1, &raw const four, 1), OK);
                assert_eq!(fmi3DoStep(instance, from_s, 0.05, false, event, terminate, early, &raw mut reached_s), OK);
                assert_eq!(fmi3GetFloat64(instance, &raw const position, 1, &raw mut value, 1), OK);
                value
            };
            assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0), OK);
            assert_eq!(fmi3ExitInitializationMode(instance), OK);
            step(0.0);
            assert_eq!(fmi3GetFMUState(instance, &raw mut state), OK);
            assert_eq!(fmi3SerializedFMUStateSize(instance, state, &raw mut size), OK);
            let mut bytes = vec![0; size];
            assert_eq!(fmi3SerializeFMUState(instance, state, bytes.as_mut_ptr(), size), OK);
            let further = step(0.05);
            assert_eq!(fmi3SetFMUState(instance, state), OK);
            assert_eq!(fmi3FreeFMUState(instance, &raw mut state), OK);
            assert!(state.is_null());
            assert_eq!(step(0.05).to_bits(), further.to_bits());
            assert_eq!(fmi3Reset(instance), OK);
            assert_eq!(fmi3DeserializeFMUState(instance, bytes.as_ptr(), size, &raw mut state), OK);
            assert_eq!(fmi3SetFMUState(instance, state), OK);
            assert_eq!(step(0.05).to_bits(), further.to_bits());
            assert!(told.is_empty(), "{told:?}");
            assert_eq!(fmi3DeserializeFMUState(instance, bytes.as_ptr(), size / 2, &raw mut state), ERROR);
            assert_eq!(fmi3FreeFMUState(instance, &raw mut state), OK);
            fmi3FreeInstance(instance);
        }
        assert!(told[0].starts_with("the serialized state"), "{told:?}");
    }
}
