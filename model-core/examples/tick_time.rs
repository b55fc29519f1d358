//! Time of one tick of the whole drive on this computer: `cargo run --release -p model-core --features std --example tick_time`.

use std::hint::black_box;
use std::time::Instant;

use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::machine::{Machine, MachineError, Parameter as P, Source, Tick};
use model_core::number::{PerUnit, Scalar};
use model_core::ports::ChamberState;

const TICKS: u32 = 2_000_000;

fn main() -> Result<(), MachineError> {
    let mut machine = Machine::with_defaults(Source::Valve);
    for (parameter, value) in [
        (P::AreaA, 3.117e-3),
        (P::AreaB, 1.861e-3),
        (P::VolumeA, 5.2e-4),
        (P::VolumeB, 3.3e-4),
        (P::RateLimit, 12.0),
        (P::TimeConstant1, 0.018),
        (P::TimeConstant2, 0.0279),
        (P::TransportDelay, 0.007),
    ] {
        machine.set(parameter, value);
    }
    println!("fixed point {:.0} ns a tick, f64 {:.0} ns", tick_ns::<PerUnit>(&machine)?, tick_ns::<f64>(&machine)?);
    Ok(())
}

/// Shortest of five runs.
fn tick_ns<N: Scalar<Real = f64>>(machine: &Machine<f64>) -> Result<f64, MachineError> {
    let drive = Drive::<N>::new::<64>(machine, Tick::OneMillisecond)?;
    let pressures = ChamberState { a: N::saturated(0.4), b: N::saturated(0.6) };
    let mut state: DriveState<N> = drive.at_rest(N::ZERO, pressures, N::travel(0.5));
    let commands = [N::saturated(0.5), N::ZERO, N::saturated(-0.5), N::ZERO];
    let mut shortest_ns = f64::INFINITY;
    for _ in 0..5 {
        let clock = Instant::now();
        for &command in commands.iter().cycle().take(TICKS as usize / 500) {
            for _ in 0..500 {
                black_box(drive.step(&mut state, DriveInput::Command(black_box(command)), Load::NONE));
            }
        }
        shortest_ns = shortest_ns.min(clock.elapsed().as_secs_f64() * 1e9 / f64::from(TICKS));
    }
    Ok(shortest_ns)
}
