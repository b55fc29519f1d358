//! Steps under a list of commands, for a trace that weighs each instruction (`tests/on_target/cycles.rs`).

use model_core::drive::DriveState;
use model_core::ports::ChamberState;

use crate::trial::{DELAY, Traced};

/// Ticks of a drive with effects, of which each takes thousands of instructions: three commands.
pub const TICKS: usize = 600;

/// All commands, in V, under a step: the caller that a trace asks for.
#[inline(never)]
pub fn run<D, N: Traced>(
    step: fn(&D, &mut DriveState<N, DELAY>, N),
    drive: &D,
    mut state: DriveState<N, DELAY>,
    commands: &[f32],
) {
    for &volts in commands {
        step(drive, &mut state, N::saturated(f64::from(volts) / 10.0));
    }
}

/// The chambers of a drive that begins.
#[must_use]
pub fn pressures<N: Traced>() -> ChamberState<N> {
    ChamberState { a: N::saturated(0.3), b: N::saturated(0.5) }
}
