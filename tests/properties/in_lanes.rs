//! Recordings that are simulated in SIMD lanes give the same results as when each is simulated alone, bit for bit.

use proptest::prelude::*;

use diagnosis::catalogue::{CATALOGUE, EffectParameter, Form, Kind, Scene};
use machine_file::LoadSource;
use model_core::drive::Drive;
use model_core::machine::{Machine, Parameter as P, Source, Tick};
use recording::excitation::signals::Excitation;
use recording::{Column, Recording, Signal};
use simulation::{InputPoint, Run, StartOffset, Stimulus, computed_below, rows_f64, run_in_lanes};
use system_tests::any_effects::any_effects;
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::drives;
use system_tests::simulate::DELAY;

use super::cases;

/// Every drive input of the model, at rows that lie between ticks; load and temperature of the oil only in every other recording.
fn recording(machine: &Machine<f64>, seed: u64, rows: usize, interval_s: f64, from: f64) -> Recording {
    let volts = Excitation::random_steps(seed).sample(interval_s);
    let of = |scale: f64| volts[..rows].iter().map(|volts| scale * volts).collect::<Vec<f64>>();
    let stroke_m = machine.get(P::Stroke);
    let columns = [
        (Signal::Time, (0..rows).map(|row| row as f64 * interval_s).collect()),
        (Signal::Command, of(1.0)),
        (Signal::Spool, of(0.1)),
        (Signal::PumpSpeed, of(4.0)),
        (Signal::Flow, of(1e-5)),
        (Signal::Force, of(100.0)),
        (Signal::LoadForce, of(-200.0)),
        (Signal::OilTemperature, of(3.0)),
        (Signal::Position, vec![from * stroke_m; rows]),
    ];
    let is_there =
        |signal: Signal| seed.is_multiple_of(2) || !matches!(signal, Signal::LoadForce | Signal::OilTemperature);
    let columns = columns.into_iter().filter(|(signal, _)| is_there(*signal));
    Recording::new("any", columns.map(|(signal, values)| Column::si(signal, values)).collect()).unwrap()
}

/// A drawn recording: seed, rows, interval in s, start in strokes, and by how much a fit moved the start, m.
type Drawn = (u64, usize, f64, f64, f64);

/// Simulates them in SIMD lanes and one by one, some of their signals left out, and checks that all bits are equal.
fn as_alone(machine: &Machine<f64>, tick: Tick, input_point: InputPoint, follows: bool, drawn: &[Drawn]) {
    let of_drawn = |&(seed, rows, interval_s, from, shift_m): &Drawn| {
        let recording = recording(machine, seed, rows, interval_s, from);
        let stimulus = Stimulus::new(&recording, machine, input_point, LoadSource::Constant, tick).unwrap();
        let stimulus = if follows { stimulus.following().unwrap_or(stimulus) } else { stimulus };
        (stimulus, StartOffset { level: Some(0.2 + 0.6 * from), shift_m })
    };
    let stimuli: Vec<(Stimulus, StartOffset)> = drawn.iter().map(of_drawn).collect();
    let mut runs: Vec<Run<'_>> = Vec::new();
    let mut expected: Vec<Vec<(usize, Vec<u64>)>> = Vec::new();
    for (index, (stimulus, offset)) in stimuli.iter().enumerate() {
        let signals: Vec<Signal> = computed_below(input_point).iter().copied().skip(index % 2).collect();
        let mut series = Vec::new();
        rows_f64(machine, stimulus, *offset, &mut |row, value| {
            series.push((row, signals.iter().map(|&signal| value(signal).unwrap().to_bits()).collect()));
        })
        .unwrap();
        runs.push(Run { stimulus, offset: *offset, signals });
        expected.push(series);
    }
    let mut in_lanes = vec![Vec::new(); runs.len()];
    run_in_lanes(machine, &runs, &mut |run, row, values| {
        in_lanes[run].push((row, values.iter().map(|value| value.to_bits()).collect::<Vec<u64>>()));
    })
    .unwrap();
    for (found, expected) in in_lanes.iter().zip(&expected) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert_eq!(found, expected);
        }
    }
}

#[test]
fn recordings_of_a_pump_are_simulated_one_by_one() {
    let mut machine = drives::press();
    machine.source = Source::Pump;
    machine.set(P::PumpDisplacement, 1e-5);
    let drawn = [(5, 900, 1e-3, 0.3, 0.0), (6, 700, 1e-3, 0.6, 0.0), (7, 500, 2.5e-3, 0.5, 0.0)];
    as_alone(&machine, Tick::OneMillisecond, InputPoint::Pump, false, &drawn);
}

#[test]
fn recordings_of_a_mass_are_in_lanes_as_alone() {
    let mut machine =
        drives::press().with(&[(P::CoulombFriction, 60.0), (P::BacklashPlay, 1e-4), (P::ViscousFriction, 200.0)]);
    machine.source = Source::Force;
    let drawn = [(1, 900, 1e-3, 0.3, 0.0), (2, 700, 1e-3, 0.6, 1e-6), (4, 800, 2.5e-3, 0.5, 0.0)];
    as_alone(&machine, Tick::OneMillisecond, InputPoint::Force, false, &drawn);
}

/// The press with every form of every effect, and with unnamed tables.
fn with_each_effect() -> Vec<(&'static str, Machine<f64>)> {
    let press = drives::press();
    let scene = Scene {
        machine: &press,
        input_point: InputPoint::Command,
        load: LoadSource::Constant,
        judged: computed_below(InputPoint::Command),
        travel_m: (0.05, 0.25),
        duration_s: 2.0,
        is_sparse: false,
        lowest_pa: -1e6,
        held: &[],
        asks_since: false,
        changeable: &[],
    };
    let strong = |effect_parameter: &EffectParameter| {
        let (low, high) = effect_parameter.range(&scene);
        if matches!(effect_parameter.kind, Kind::Signed(_)) { 0.7 * high } else { low + 0.7 * (high - low) }
    };
    let forms = CATALOGUE.iter().flat_map(|effect| effect.every_form().map(|form| (effect.name, form)));
    let machine = |(name, form): (&'static str, Form)| {
        let mut machine = press;
        for effect_parameter in form {
            machine.set(effect_parameter.parameter, strong(effect_parameter));
        }
        (name, machine)
    };
    let tables = [(1.0, 1.0, 500.0), (2.0, 4.0, 1e-5), (3.0, 3.0, 1e-5), (4.0, 2.0, 0.02)];
    let table = |(quantity, over, value): (f64, f64, f64)| {
        let mut machine = press;
        for (parameter, value) in [
            (P::TableQuantity, quantity),
            (P::TableOver, over),
            (P::TableOver2, 2.0),
            (P::TableFrom, -0.1),
            (P::TableTo, 0.2),
            (P::TableTo2, 0.3),
            (P::TableValue2, value),
            (P::TableValue9, -value),
        ] {
            machine.set(parameter, value);
        }
        ("unnamed", machine)
    };
    let mut between_stops = press;
    for (parameter, value) in [
        (P::StopStiffness, 1e7),
        (P::StopDamping, 1e4),
        (P::StopRetracted, 0.01),
        (P::StopExtended, 0.28),
        (P::StribeckForce, 300.0),
        (P::StribeckExcess, 200.0),
        (P::PreslidingStiffness, 1e7),
        (P::PositionFriction, 100.0),
    ] {
        between_stops.set(parameter, value);
    }
    forms.map(machine).chain(tables.into_iter().map(table)).chain([("stops and friction", between_stops)]).collect()
}

#[test]
fn recordings_of_a_drive_with_any_effect_are_in_lanes_as_alone() {
    let drawn = [
        (1, 2000, 1e-3, 0.3, 0.0),
        (2, 1500, 1e-3, 0.6, 1e-6),
        (3, 700, 2.5e-3, 0.02, 0.0),
        (4, 1900, 1e-3, 0.97, 0.0),
    ];
    for (name, machine) in with_each_effect() {
        for (input_point, follows) in
            [(InputPoint::Command, false), (InputPoint::Command, true), (InputPoint::Spool, false)]
        {
            println!("{name}, {input_point:?}, {follows}");
            as_alone(&machine, Tick::OneMillisecond, input_point, follows, &drawn);
        }
    }
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn recordings_in_lanes_are_each_as_alone(
        machine in any_machine(),
        tick in any_tick(),
        effects in any_effects(),
        input_point in prop::sample::select(vec![InputPoint::Command, InputPoint::Spool, InputPoint::Flow, InputPoint::Force]),
        follows in any::<bool>(),
        drawn in prop::collection::vec((any::<u64>(), 200_usize..900, 0.4e-3..3e-3_f64, 0.0..1.0_f64, -1e-5..1e-5_f64), 1..7),
    ) {
        let machine = effects.on(&machine);
        prop_assume!(machine.source == Source::Valve && Drive::<f64>::new::<DELAY>(&machine, tick).is_ok());
        as_alone(&machine, tick, input_point, follows, &drawn);
    }
}
