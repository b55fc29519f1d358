use std::ffi::{CStr, CString, c_int, c_void};
use std::mem::transmute;
use std::path::Path;
use std::ptr;

use model_export::fmu::{Contents, Variable};

use super::both::*;
use super::fmi2::*;
use super::fmi3::*;
use super::pointers::{DISCARD, ERROR, OK, Status, Text, text};
use crate::instance::tests::{PRESS, resources};

/// Stores a message of the log; the tool's own environment is passed with it.
unsafe fn remember(environment: *mut c_void, status: Status, category: Text, message: Text) {
    let told = unsafe { &mut *environment.cast::<Vec<String>>() };
    assert_eq!(status, ERROR);
    assert_eq!(unsafe { text(category, "category") }.unwrap(), "logStatusError");
    told.push(unsafe { text(message, "message") }.unwrap().to_owned());
}

unsafe extern "C" fn remember_three(environment: *mut c_void, status: Status, category: Text, message: Text) {
    unsafe { remember(environment, status, category, message) };
}

unsafe extern "C" fn remember_two(environment: *mut c_void, name: Text, status: Status, category: Text, message: Text) {
    assert_eq!(unsafe { text(name, "name") }.unwrap(), "press");
    unsafe { remember(environment, status, category, message) };
}

/// What the tests call, in one version of the standard.
struct Interface {
    instantiate: unsafe fn(&Path, &CStr, *mut c_void) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    /// Up to the initialization mode.
    enter: unsafe fn(*mut c_void) -> Status,
    exit: unsafe extern "C" fn(*mut c_void) -> Status,
    reset: unsafe extern "C" fn(*mut c_void) -> Status,
    terminate: unsafe extern "C" fn(*mut c_void) -> Status,
    /// One value; nowhere to write it to, for a null pointer.
    get: unsafe fn(*mut c_void, Variable, *mut f64) -> Status,
    set: unsafe fn(*mut c_void, Variable, f64) -> Status,
    step: unsafe fn(*mut c_void, f64, f64) -> Status,
    derivative: unsafe fn(*mut c_void) -> Status,
    keep: unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> Status,
    restore: unsafe extern "C" fn(*mut c_void, *mut c_void) -> Status,
    drop: unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> Status,
    size: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut usize) -> Status,
    write: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut u8, usize) -> Status,
    read: unsafe extern "C" fn(*mut c_void, *const u8, usize, *mut *mut c_void) -> Status,
    /// How its functions begin.
    prefix: &'static str,
}

const TWO: Interface = Interface {
    instantiate: |resources, token, environment| unsafe {
        let location = CString::new(format!("file://{}", resources.to_str().unwrap())).unwrap();
        instantiate_two(CO_SIMULATION, &location, token, environment)
    },
    free: fmi2FreeInstance,
    enter: |instance| unsafe {
        assert_eq!(fmi2SetupExperiment(instance, 0, 0.0, 0.0, 0, 0.0), OK);
        fmi2EnterInitializationMode(instance)
    },
    exit: fmi2ExitInitializationMode,
    reset: fmi2Reset,
    terminate: fmi2Terminate,
    get: |instance, variable, value| unsafe { fmi2GetReal(instance, &variable.reference(), 1, value) },
    set: |instance, variable, value| unsafe { fmi2SetReal(instance, &variable.reference(), 1, &raw const value) },
    step: |instance, from_s, step_s| unsafe { fmi2DoStep(instance, from_s, step_s, 1) },
    derivative: |instance| unsafe {
        fmi2GetDirectionalDerivative(instance, ptr::null(), 0, ptr::null(), 0, ptr::null(), ptr::null_mut())
    },
    keep: fmi2GetFMUstate,
    restore: fmi2SetFMUstate,
    drop: fmi2FreeFMUstate,
    size: fmi2SerializedFMUstateSize,
    write: fmi2SerializeFMUstate,
    read: fmi2DeSerializeFMUstate,
    prefix: "fmi2",
};

const THREE: Interface = Interface {
    instantiate: |resources, token, environment| unsafe {
        let (name, path) = (c"press".as_ptr(), CString::new(resources.to_str().unwrap()).unwrap());
        let (token, path, message) = (token.as_ptr(), path.as_ptr(), Some(remember_three as _));
        let none = ptr::null();
        fmi3InstantiateCoSimulation(name, token, path, false, false, false, false, none, 0, environment, message, None)
    },
    free: fmi3FreeInstance,
    enter: |instance| unsafe { fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0) },
    exit: fmi3ExitInitializationMode,
    reset: fmi3Reset,
    terminate: fmi3Terminate,
    get: |instance, variable, value| unsafe { fmi3GetFloat64(instance, &variable.reference(), 1, value, 1) },
    set: |instance, variable, value| unsafe { fmi3SetFloat64(instance, &variable.reference(), 1, &raw const value, 1) },
    step: |instance, from_s, step_s| unsafe {
        let (mut flags, mut reached_s) = ([true; 3], f64::NAN);
        let [event, terminate, early] = flags.each_mut().map(ptr::from_mut);
        let status = fmi3DoStep(instance, from_s, step_s, true, event, terminate, early, &raw mut reached_s);
        if status == OK {
            assert_eq!((flags, (reached_s - from_s - step_s).abs() < 1e-12), ([false; 3], true));
        }
        status
    },
    derivative: |instance| unsafe {
        fmi3GetDirectionalDerivative(instance, ptr::null(), 0, ptr::null(), 0, ptr::null(), 0, ptr::null_mut(), 0)
    },
    keep: fmi3GetFMUState,
    restore: fmi3SetFMUState,
    drop: fmi3FreeFMUState,
    size: fmi3SerializedFMUStateSize,
    write: fmi3SerializeFMUState,
    read: fmi3DeserializeFMUState,
    prefix: "fmi3",
};

unsafe fn instantiate_two(kind: c_int, location: &CStr, token: &CStr, environment: *mut c_void) -> *mut c_void {
    type Fixed = unsafe extern "C" fn(*mut c_void, Text, Status, Text, Text);
    type Variadic = unsafe extern "C" fn(*mut c_void, Text, Status, Text, Text, ...);
    // SAFETY: no further argument is passed.
    let logger = Some(unsafe { transmute::<Fixed, Variadic>(remember_two) });
    let callbacks = Callbacks { logger, allocate: None, free: None, step_finished: None, environment };
    let (token, location) = (token.as_ptr(), location.as_ptr());
    unsafe { fmi2Instantiate(c"press".as_ptr(), kind, token, location, &raw const callbacks, 0, 0) }
}

/// The token of the FMU with these resources.
fn token(resources: &Path) -> CString {
    let contents = Contents::read(resources).unwrap();
    CString::new(model_export::fmu::token(&contents)).unwrap()
}

#[test]
fn a_tool_gets_values_by_pointers_and_errors_by_its_log() {
    for interface in [TWO, THREE] {
        let folder = resources(PRESS, "fixed");
        let token = token(folder.path());
        let mut told: Vec<String> = Vec::new();
        let environment = ptr::from_mut(&mut told).cast();
        let mut value = 0.0;
        unsafe {
            assert!((interface.instantiate)(folder.path(), c"another", environment).is_null());
            assert!((interface.instantiate)(&folder.path().join("gone"), &token, environment).is_null());
            let instance = (interface.instantiate)(folder.path(), &token, environment);
            assert!(!instance.is_null());
            assert_eq!((interface.step)(instance, 0.0, 0.01), ERROR);
            assert_eq!((interface.set)(instance, Variable::PositionAtStart, 5.0), ERROR);
            assert_eq!((interface.enter)(instance), OK);
            assert_eq!((interface.exit)(instance), OK);
            assert_eq!((interface.step)(instance, 0.0, 0.01), OK);
            assert_eq!((interface.get)(instance, Variable::Position, &raw mut value), OK);
            assert_eq!((interface.get)(instance, Variable::Position, ptr::null_mut()), ERROR);
            assert_eq!((interface.derivative)(instance), ERROR);
            (interface.free)(instance);
            assert_eq!((interface.terminate)(ptr::null_mut()), ERROR);
        }
        assert!((value - 0.15).abs() < 0.01, "{value}");
        let expected = [
            ("Instantiate", "the model description has the token \"another\"; expected \"drive-fmu/"),
            ("Instantiate", "machine.toml"),
            ("DoStep: ", "called in mode Instantiated; expected it in mode Step"),
            ("Set", ": position_start = 5: expected 0 to "),
            ("Get", "1 value references and 0 values"),
            ("GetDirectionalDerivative: ", "not in this FMU"),
        ];
        assert_eq!(told.len(), expected.len(), "{told:?}");
        for (line, (function, reason)) in told.iter().zip(expected) {
            assert!(line.starts_with(&format!("{}{function}", interface.prefix)) && line.contains(reason), "{line}");
        }
    }
}

#[test]
fn a_state_that_was_kept_or_written_down_is_gone_on_from_in_both_versions() {
    let folder = resources(PRESS, "float");
    let token = token(folder.path());
    let mut positions = Vec::new();
    for interface in [TWO, THREE] {
        let mut told: Vec<String> = Vec::new();
        let environment = ptr::from_mut(&mut told).cast();
        let (mut state, mut size) = (ptr::null_mut(), 0);
        unsafe {
            let instance = (interface.instantiate)(folder.path(), &token, environment);
            let step = |from_s| {
                let mut value = f64::NAN;
                assert_eq!((interface.set)(instance, Variable::Command, 4.0), OK);
                assert_eq!((interface.step)(instance, from_s, 0.05), OK);
                assert_eq!((interface.get)(instance, Variable::Position, &raw mut value), OK);
                value.to_bits()
            };
            assert_eq!((interface.enter)(instance), OK);
            assert_eq!((interface.exit)(instance), OK);
            step(0.0);
            assert_eq!((interface.keep)(instance, &raw mut state), OK);
            assert_eq!((interface.size)(instance, state, &raw mut size), OK);
            let mut bytes = vec![0; size];
            assert_eq!((interface.write)(instance, state, bytes.as_mut_ptr(), size), OK);
            let further = step(0.05);
            assert_eq!((interface.restore)(instance, state), OK);
            assert_eq!((interface.drop)(instance, &raw mut state), OK);
            assert!(state.is_null());
            assert_eq!(step(0.05), further);
            assert_eq!((interface.reset)(instance), OK);
            assert_eq!((interface.read)(instance, bytes.as_ptr(), size, &raw mut state), OK);
            assert_eq!((interface.restore)(instance, state), OK);
            assert_eq!(step(0.05), further);
            assert!(told.is_empty(), "{told:?}");
            assert_eq!((interface.read)(instance, bytes.as_ptr(), size / 2, &raw mut state), ERROR);
            assert_eq!((interface.drop)(instance, &raw mut state), OK);
            (interface.free)(instance);
            positions.push((further, bytes));
        }
        assert!(told[0].contains(": the serialized state"), "{told:?}");
    }
    assert!(positions[0] == positions[1], "one state for both versions");
}

#[test]
fn version_2_tells_how_far_it_came_and_has_no_other_status() {
    let folder = resources(PRESS, "fixed");
    let mut told: Vec<String> = Vec::new();
    let (mut reached_s, mut terminated) = (f64::NAN, 1);
    unsafe {
        let instance = (TWO.instantiate)(folder.path(), &token(folder.path()), ptr::from_mut(&mut told).cast());
        assert_eq!((TWO.enter)(instance), OK);
        assert_eq!((TWO.exit)(instance), OK);
        assert_eq!((TWO.step)(instance, 0.0, 0.003), OK);
        assert_eq!(fmi2GetRealStatus(instance, LAST_SUCCESSFUL_TIME, &raw mut reached_s), OK);
        assert_eq!(fmi2GetBooleanStatus(instance, TERMINATED, &raw mut terminated), OK);
        assert_eq!(fmi2GetRealStatus(instance, TERMINATED, &raw mut reached_s), DISCARD);
        assert!(told.is_empty(), "{told:?}");
        assert_eq!(fmi2CancelStep(instance), ERROR);
        fmi2FreeInstance(instance);
    }
    assert_eq!((reached_s.to_bits(), terminated), (0.003_f64.to_bits(), 0));
    assert!(told[0].starts_with("fmi2CancelStep: not in this FMU"), "{told:?}");
}

#[test]
fn version_2_asks_for_co_simulation_and_a_uri_and_its_messages_are_formats() {
    let folder = resources(PRESS, "fixed");
    let token = token(folder.path());
    let mut told: Vec<String> = Vec::new();
    let environment = ptr::from_mut(&mut told).cast();
    unsafe {
        assert!(instantiate_two(0, c"file:///", &token, environment).is_null());
        assert!(instantiate_two(CO_SIMULATION, c"/tmp/100 %s #r1#", &token, environment).is_null());
    }
    assert_eq!(told[0], "fmi2Instantiate: an instance of kind 0; expected 1, for co-simulation");
    assert!(told[1].starts_with("fmi2Instantiate: the resources at \"/tmp/100 %%s ##r1##\""), "{told:?}");
}
