//! Loads, and friction far above the printed value, at each tick.

use model_core::machine::Parameter::{LoadForce, ViscousFriction};
use model_core::machine::{Machine, Tick};
use model_core::number::PerUnit;
use recording::excitation::signals::Excitation;
use system_tests::drives;
use system_tests::simulate::{Distance, core, distance, oracle};
use virtual_plant::InitialState;

use crate::tolerances::{Case, of};

fn worst(machine: &Machine<f64>, tick: Tick) -> Distance {
    let signals = [Excitation::paper_steps(10.0), Excitation::paper_sweep(), Excitation::random_steps(1)];
    signals.iter().fold(Distance::default(), |worst, signal| {
        let volts = signal.sample(tick.seconds());
        let initial = InitialState::at_rest(machine, 0.15);
        let truth = oracle(machine, tick, &volts, &initial);
        let real = distance(&core::<f64>(machine, tick, &volts, &initial), &truth);
        let fixed = distance(&core::<PerUnit>(machine, tick, &volts, &initial), &truth);
        worst.or(real).or(fixed)
    })
}

#[test]
fn under_load_and_heavy_friction_every_tick_stays_accurate() {
    let mut misses = Vec::new();
    for drive in drives::named() {
        let friction = 10.0 * drives::printed().get(ViscousFriction);
        let cases = [
            ("  +8 kN", LoadForce, 8e3),
            ("  -8 kN", LoadForce, -8e3),
            (" +12 kN", LoadForce, 12e3),
            (" -12 kN", LoadForce, -12e3),
            ("D = 1e6", ViscousFriction, friction),
        ];
        for (name, parameter, value) in cases {
            let machine = drive.machine.with(&[(parameter, value)]);
            for (tick, case) in [
                (Tick::HalfMillisecond, Case::LoadedHalfMillisecond),
                (Tick::OneMillisecond, Case::LoadedOneMillisecond),
                (Tick::TwoMilliseconds, Case::LoadedTwoMilliseconds),
            ] {
                let found = worst(&machine, tick);
                let (position, pressure) = (100.0 * found.position, 100.0 * found.pressure);
                let text = format!(
                    "{:<8} {name} {:>3} ms: position {position:.5} %, pressure {pressure:.4} %",
                    drive.name,
                    1e3 * tick.seconds()
                );
                println!("{text}");
                if !of(case).holds(found) {
                    misses.push(text);
                }
            }
        }
    }
    assert!(misses.is_empty(), "{misses:#?}");
}
