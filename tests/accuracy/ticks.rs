//! The effects of the valve and the flow link have no oracle here: their action must not depend on the tick.

use model_core::effects::{Effect, Link};
use model_core::machine::{Form, Machine, Tick};
use recording::excitation::signals::Excitation;
use system_tests::drives;
use system_tests::simulate::{Distance, Row, core, distance};
use virtual_plant::InitialState;

/// Largest difference of a run at 1 kHz from one at 2 kHz: of the position, strokes, and of the pressures, supply pressures.
///
/// Without effects it is 2e-6 and 4e-4, about three quarters of the error at 1 kHz; the largest is 6e-6 with a flow force, which depends
/// on the pressures at the start of a tick. Stiction is left out: its jumps end where a tick ends.
const POSITION: f64 = 1e-5;
const PRESSURE: f64 = 1e-3;

/// No effect, then the strong forms of every effect of the valve and the flow link but stiction; a valve-controlled drive has no pump.
fn forms() -> impl Iterator<Item = Form> {
    let without = Form { name: "none", values: &[] };
    let effects = Effect::ALL.iter().filter(|effect| matches!(effect.link(), Link::Valve | Link::Flow));
    let effects = effects.filter(|effect| !matches!(effect, Effect::SpoolStiction | Effect::PumpSlip));
    std::iter::once(without).chain(effects.flat_map(|effect| effect.strong().iter().copied()))
}

fn at_two_ticks(machine: &Machine<f64>, excitation: &Excitation) -> Distance {
    let initial = InitialState::at_rest(machine, 0.15);
    let volts = excitation.sample(1e-3);
    let twice: Vec<f64> = volts.iter().flat_map(|&volts| [volts, volts]).collect();
    let coarse = core::<f64>(machine, Tick::OneMillisecond, &volts, &initial);
    let fine: Vec<Row> = core::<f64>(machine, Tick::HalfMillisecond, &twice, &initial).into_iter().step_by(2).collect();
    let rows = coarse.len().min(fine.len());
    distance(&coarse[..rows], &fine[..rows])
}

#[test]
fn what_an_effect_does_hardly_depends_on_the_tick() {
    let mut missed = Vec::new();
    for drive in drives::named() {
        for Form { name, values } in forms() {
            let machine = drive.machine.with(values);
            let signals = [Excitation::paper_steps(10.0), Excitation::paper_sweep(), Excitation::random_steps(1)];
            let found =
                signals.iter().map(|signal| at_two_ticks(&machine, signal)).fold(Distance::default(), Distance::or);
            println!("{:<8} {name:<24} position {:.1e}, pressure {:.1e}", drive.name, found.position, found.pressure);
            if found.position > POSITION || found.pressure > PRESSURE {
                missed.push((drive.name, name, found));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}
