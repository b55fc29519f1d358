//! A baked drive for C: the functions that `drive.h` declares, which `host-sim export --bake --out drive.h` writes.
//!
//! Signals are words of fixed point, so that nothing is converted here and no floating point is linked. A C program holds the state as words and never
//! looks into it.
//!
//! # Safety
//! The functions take references, of which C knows pointers: each is null, or points to what the header says, aligned, for the duration of the call, and to
//! nothing that is written by anybody else meanwhile. A null pointer is harmless: nothing is done. Every bit pattern is a state and an input, so words that
//! C has overwritten give a wrong result and no undefined behaviour.
#![cfg_attr(target_os = "none", no_std)]

use core::mem::MaybeUninit;

use model_core::drive::{BakedDrive, DriveInput, DriveState, Load};
use model_core::flow::PumpDrive;
use model_core::machine::Source;
use model_core::number::{Number, PerUnit};
use model_core::ports::ChamberState;

#[allow(dead_code, unreachable_pub, reason = "an exported file is for anybody, and not all of it is needed")]
mod exported {
    include!(concat!(env!("OUT_DIR"), "/drive.rs"));
}

/// `drive_state_t`
type State = DriveState<PerUnit, { exported::DELAY_LINE }>;

const DRIVE: BakedDrive<exported::Exported> = BakedDrive::new();

/// A position.
type Position = <PerUnit as Number>::Travel;

const _: () = assert!(size_of::<State>() == exported::STATE_BYTES, "the header has the state's size");

/// Words of `drive_input_t`: what drives it, and the load.
const INPUTS: usize = match exported::SOURCE {
    Source::Valve => 2,
    Source::Pump => 3,
    Source::Force => 1,
} + DRIVE.measures_oil() as usize;

/// `drive_rest_t`
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    position_q56: i64,
    command_q28: i32,
    pressure_a_q28: i32,
    pressure_b_q28: i32,
}

/// `drive_reading_t`
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    position_q56: i64,
    velocity_q28: i32,
    spool_q28: i32,
    pressure_a_q28: i32,
    pressure_b_q28: i32,
}

/// The checksum of the coefficients: that of the header.
#[expect(unsafe_code, reason = "the name is the header's")]
#[unsafe(no_mangle)]
pub extern "C" fn drive_fingerprint() -> u32 {
    exported::FINGERPRINT
}

/// A drive at rest.
#[expect(unsafe_code, reason = "the name is the header's")]
#[unsafe(no_mangle)]
pub extern "C" fn drive_init(state: Option<&mut MaybeUninit<State>>, rest: Option<&Rest>) {
    let (Some(state), Some(rest)) = (state, rest) else { return };
    let [a, b] = [rest.pressure_a_q28, rest.pressure_b_q28].map(PerUnit::from_bits);
    let (command, position) = (PerUnit::from_bits(rest.command_q28), Position::from_bits(rest.position_q56));
    state.write(DRIVE.at_rest(command, ChamberState { a, b }, position));
}

/// One tick.
#[expect(unsafe_code, reason = "the name is the header's")]
#[unsafe(no_mangle)]
pub extern "C" fn drive_step(state: Option<&mut State>, input: Option<&[i32; INPUTS]>) {
    let (Some(state), Some(input)) = (state, input) else { return };
    let mut words = input.iter().copied();
    let mut next = || words.next().map_or(PerUnit::ZERO, PerUnit::from_bits);
    let drive_input = match exported::SOURCE {
        Source::Valve => DriveInput::Command(next()),
        Source::Pump => {
            let (speed, way) = (next(), next());
            DriveInput::Pump(PumpDrive {
                speed,
                direction: i8::from(way > PerUnit::ZERO) - i8::from(way < PerUnit::ZERO),
            })
        }
        // The load is the force.
        Source::Force => DriveInput::Force { from: PerUnit::ZERO, to: PerUnit::ZERO },
    };
    let load = next();
    if DRIVE.measures_oil() {
        state.oil_temperature = next();
    }
    DRIVE.step(state, drive_input, Load { from: load, to: load });
}

/// What the sensors read.
#[expect(unsafe_code, reason = "the name is the header's")]
#[unsafe(no_mangle)]
pub extern "C" fn drive_read(state: Option<&State>, reading: Option<&mut MaybeUninit<Reading>>) {
    let (Some(state), Some(reading)) = (state, reading) else { return };
    let sensed = DRIVE.sensed(state);
    reading.write(Reading {
        position_q56: sensed.position.to_bits(),
        velocity_q28: sensed.velocity.to_bits(),
        spool_q28: sensed.spool.to_bits(),
        pressure_a_q28: sensed.pressure_a.to_bits(),
        pressure_b_q28: sensed.pressure_b.to_bits(),
    });
}

/// Nothing here panics; where the compiler cannot see that, the program stands still, and its watchdog ends it.
#[cfg(target_os = "none")]
#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
