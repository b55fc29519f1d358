use machine_file::LoadSource;
use model_core::machine::{Machine, Parameter, Tick};
use recording::{Column, Recording, Signal};

use super::{Trajectory, simulate_f64, simulate_fixed};
use crate::initial_state::StartOffset;
use crate::stimulus::{InputPoint, Stimulus};

fn press() -> Machine<f64> {
    test_press::press(&[
        (Parameter::DeadZone, 0.1),
        (Parameter::TimeConstant2, 0.0279),
        (Parameter::TransportDelay, 0.0073),
        (Parameter::ViscousFriction, 4e4),
    ])
}

fn command_at(time_s: f64) -> f64 {
    if time_s < 0.0995 {
        0.0
    } else if time_s < 0.5995 {
        6.0
    } else {
        -5.0
    }
}

fn recording(time_s: Vec<f64>, mut signals: Vec<(Signal, Vec<f64>)>) -> Recording {
    let mut columns = vec![Column::si(Signal::Time, time_s)];
    columns.extend(signals.drain(..).map(|(signal, values)| Column::si(signal, values)));
    Recording::new("made", columns).unwrap()
}

fn commanded(time_s: Vec<f64>) -> Recording {
    let command = time_s.iter().map(|&time| command_at(time)).collect();
    let position = vec![0.15; time_s.len()];
    recording(time_s, vec![(Signal::Command, command), (Signal::Position, position)])
}

fn run(recording: &Recording, input_point: InputPoint, load: LoadSource) -> Trajectory {
    run_of(&press(), recording, input_point, load)
}

fn run_of(machine: &Machine<f64>, recording: &Recording, input_point: InputPoint, load: LoadSource) -> Trajectory {
    let stimulus = Stimulus::new(recording, machine, input_point, load, Tick::OneMillisecond).unwrap();
    simulate_f64(machine, &stimulus, StartOffset::none()).unwrap()
}

/// What sensors without noise would have recorded in a run at 1 kHz, without the command.
fn measured(run: &Trajectory) -> Recording {
    let signals = [Signal::Spool, Signal::PressureA, Signal::PressureB, Signal::Position];
    let series = |signal| (signal, run.signal(signal).unwrap().to_vec());
    let rows = u32::try_from(run.signal(Signal::Position).unwrap().len()).unwrap();
    recording(grid(1e-3, rows), signals.into_iter().map(series).collect())
}

fn grid(interval_s: f64, rows: u32) -> Vec<f64> {
    (0..rows).map(|row| f64::from(row) * interval_s).collect()
}

fn farthest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn recordings_that_enter_the_chain_alike_go_together() {
    let stimulus = |rows: u32, tick: Tick| {
        let recording = commanded(grid(1e-3, rows));
        Stimulus::new(&recording, &press(), InputPoint::Command, LoadSource::Constant, tick).unwrap()
    };
    let [one, shorter] = [800, 500].map(|rows| stimulus(rows, Tick::OneMillisecond));
    assert!(one.goes_with(&shorter));
    assert!(!one.goes_with(&stimulus(800, Tick::TwoMilliseconds)), "a tick of its own");
    let recorded = measured(&run(&commanded(grid(1e-3, 800)), InputPoint::Command, LoadSource::Constant));
    let at_spool =
        Stimulus::new(&recorded, &press(), InputPoint::Spool, LoadSource::Constant, Tick::OneMillisecond).unwrap();
    assert!(!one.goes_with(&at_spool) && at_spool.goes_with(&at_spool));
}

#[test]
fn entered_at_its_own_spool_the_rest_of_the_chain_is_the_same() {
    let whole = run(&commanded(grid(1e-3, 1200)), InputPoint::Command, LoadSource::Constant);
    let series = |signal| whole.signal(signal).unwrap().to_vec();
    let spool = measured(&whole);
    let below = run(&spool, InputPoint::Spool, LoadSource::Constant);
    assert!(farthest(below.signal(Signal::Position).unwrap(), &series(Signal::Position)) < 1e-12);
    assert!(farthest(below.signal(Signal::PressureA).unwrap(), &series(Signal::PressureA)) < 1e-3);
}

/// A recording of wrong sensors, simulated with the same sensor errors, gives the same drive.
#[test]
fn readings_of_wrong_sensors_are_taken_back_to_the_truth() {
    let mut machine = press();
    for (parameter, value) in [
        (Parameter::PressureAOffset, 2e5),
        (Parameter::PressureBFactor, 0.05),
        (Parameter::SpoolOffset, 0.02),
        (Parameter::SpoolFactor, -0.1),
        (Parameter::PositionFactor, 0.03),
    ] {
        machine.set(parameter, value);
    }
    let whole = run_of(&machine, &commanded(grid(1e-3, 1200)), InputPoint::Command, LoadSource::Constant);
    let right = run(&commanded(grid(1e-3, 1200)), InputPoint::Command, LoadSource::Constant);
    let first = |trajectory: &Trajectory, signal| trajectory.signal(signal).unwrap()[0];
    assert!((first(&whole, Signal::PressureA) - first(&right, Signal::PressureA) - 2e5).abs() < 1e-6);
    assert!((first(&whole, Signal::PressureB) - 1.05 * first(&right, Signal::PressureB)).abs() < 1e-6);
    let below = run_of(&machine, &measured(&whole), InputPoint::Spool, LoadSource::Constant);
    for (signal, tolerance) in [(Signal::Position, 1e-9), (Signal::PressureA, 1.0), (Signal::Force, 1e-2)] {
        assert!(farthest(below.signal(signal).unwrap(), whole.signal(signal).unwrap()) < tolerance, "{signal}");
    }
}

#[test]
fn a_slower_and_an_uneven_recording_of_the_same_command_give_the_same_motion() {
    let fine = run(&commanded(grid(1e-3, 1201)), InputPoint::Command, LoadSource::Constant);
    let fine = fine.signal(Signal::Position).unwrap();
    let slow = run(&commanded(grid(5e-3, 241)), InputPoint::Command, LoadSource::Constant);
    let every_fifth: Vec<f64> = fine.iter().step_by(5).copied().collect();
    assert!(farthest(slow.signal(Signal::Position).unwrap(), &every_fifth) < 1e-12);

    // Rows off the core's grid: the command changes up to a tick early, the position is linear between ticks.
    let uneven: Vec<f64> = (0..1150).map(|row| f64::from(row) * 1e-3 + 0.0004 * f64::from(row % 3)).collect();
    let found = run(&commanded(uneven.clone()), InputPoint::Command, LoadSource::Constant);
    let expected: Vec<f64> = uneven
        .iter()
        .map(|time| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a row")]
            let row = (time * 1e3).floor() as usize;
            fine[row] + (time * 1e3 - (time * 1e3).floor()) * (fine[row + 1] - fine[row])
        })
        .collect();
    // Distance in 2 ms at the largest speed.
    assert!(farthest(found.signal(Signal::Position).unwrap(), &expected) < 2e-3 * 0.16);
}

#[test]
fn a_load_taken_from_the_pressures_brings_them_and_the_motion_back() {
    let whole = run(&commanded(grid(1e-3, 1200)), InputPoint::Command, LoadSource::Constant);
    let series = |signal| whole.signal(signal).unwrap().to_vec();
    let spool = measured(&whole);
    let found = run(&spool, InputPoint::Spool, LoadSource::RecordedPressures);
    let error = farthest(found.signal(Signal::Position).unwrap(), &series(Signal::Position));
    assert!(error < 1e-5, "{error}");
}

#[test]
fn entered_at_its_own_flow_the_rest_of_the_chain_is_nearly_the_same() {
    let whole = run(&commanded(grid(1e-3, 1200)), InputPoint::Command, LoadSource::Constant);
    let series = |signal| whole.signal(signal).unwrap().to_vec();
    let flow = recording(
        grid(1e-3, 1200),
        vec![
            (Signal::Flow, series(Signal::Flow)),
            (Signal::PressureA, series(Signal::PressureA)),
            (Signal::PressureB, series(Signal::PressureB)),
            (Signal::Position, series(Signal::Position)),
        ],
    );
    let below = run(&flow, InputPoint::Flow, LoadSource::Constant);
    // The other edge lags by a part of a tick, and below a hundredth of the full flow it is not used.
    for (signal, tolerance) in [(Signal::Position, 3e-5), (Signal::PressureA, 1e5), (Signal::PressureB, 1.5e5)] {
        let error = farthest(below.signal(signal).unwrap(), &series(signal));
        assert!(error < tolerance, "{signal}: {error}");
    }
}

#[test]
fn without_recorded_pressures_the_chambers_balance_the_load_at_half_the_supply() {
    let found = run(&commanded(grid(1e-3, 50)), InputPoint::Command, LoadSource::Constant);
    let first = |signal| found.signal(signal).unwrap()[0];
    assert!((first(Signal::PressureB) - 3.5e6).abs() < 1.0);
    assert!(first(Signal::Force).abs() < 1e-6);
}

#[test]
fn without_recorded_pressures_the_machine_says_at_which_level_the_chambers_start() {
    let mut machine = press();
    machine.set(Parameter::LevelAtRest, 0.3);
    let first = |input_point, recording: &Recording| {
        run_of(&machine, recording, input_point, LoadSource::Constant).signal(Signal::PressureB).unwrap()[0]
    };
    let commanded = commanded(grid(1e-3, 50));
    assert!((first(InputPoint::Command, &commanded) / machine.get(Parameter::SupplyPressure) - 0.3).abs() < 1e-6);
    // Recorded pressures are used as they are.
    let recorded = measured(&run_of(&press(), &commanded, InputPoint::Command, LoadSource::Constant));
    assert!((first(InputPoint::Spool, &recorded) / machine.get(Parameter::SupplyPressure) - 0.5).abs() < 1e-6);
}

#[test]
fn a_spike_at_rest_moves_no_start_and_a_failed_spool_is_bridged() {
    let whole = measured(&run(&commanded(grid(1e-3, 1200)), InputPoint::Command, LoadSource::Constant));
    let mut failed = whole.clone();
    let mut position = whole.signal(Signal::Position).unwrap().to_vec();
    position[3] += 0.02;
    failed.replace(Signal::Position, &position);
    let mut spool = whole.signal(Signal::Spool).unwrap().to_vec();
    spool[400] = -1.0;
    failed.replace(Signal::Spool, &spool);
    let of = |recording| run(recording, InputPoint::Spool, LoadSource::Constant);
    let series = |trajectory: &Trajectory| trajectory.signal(Signal::Position).unwrap().to_vec();
    assert!(farthest(&series(&of(&failed)), &series(&of(&whole))) < 1e-5);
}

#[test]
fn fixed_point_follows_float_on_a_recording() {
    let machine = press();
    let recording = commanded(grid(1e-3, 1200));
    let stimulus =
        Stimulus::new(&recording, &machine, InputPoint::Command, LoadSource::Constant, Tick::OneMillisecond).unwrap();
    let fixed = simulate_fixed(&machine, &stimulus, StartOffset::none()).unwrap();
    let float = simulate_f64(&machine, &stimulus, StartOffset::none()).unwrap();
    let of = |trajectory: &Trajectory| trajectory.signal(Signal::Position).unwrap().to_vec();
    assert!(farthest(&of(&fixed), &of(&float)) < 1e-4 * 0.3);
}

#[test]
fn a_supply_that_droops_is_computed_where_the_valve_draws_from_it() {
    let mut machine = press();
    machine.set(Parameter::DroopResistance, 1e10);
    let at = |recording: &Recording, input_point| {
        let stimulus =
            Stimulus::new(recording, &machine, input_point, LoadSource::Constant, Tick::OneMillisecond).unwrap();
        simulate_f64(&machine, &stimulus, StartOffset::none()).unwrap()
    };
    let whole = at(&commanded(grid(1e-3, 2000)), InputPoint::Command);
    let (supply, flow) = (whole.signal(Signal::SupplyPressure).unwrap(), whole.signal(Signal::Flow).unwrap());
    assert!((supply[0] - machine.get(Parameter::SupplyPressure)).abs() < 1e-6);
    let lowest = supply.iter().fold(f64::INFINITY, |lowest, &value| lowest.min(value));
    let most = flow.iter().fold(0.0_f64, |most, &value| most.max(value));
    let fall = machine.get(Parameter::SupplyPressure) - lowest;
    assert!(fall > 0.9e10 * most, "{fall} of {most}");
    let below = at(&measured(&whole), InputPoint::Spool);
    let again = below.signal(Signal::SupplyPressure).unwrap();
    assert!(farthest(again, supply) < 0.01 * fall);
}

#[test]
fn a_followed_spool_moves_the_rod_and_the_command_moves_the_valve() {
    let time_s: Vec<f64> = (0..1500).map(|row| f64::from(row) * 1e-3).collect();
    let commanded = commanded(time_s);
    let machine = press();
    let stimulus =
        Stimulus::new(&commanded, &machine, InputPoint::Command, LoadSource::Constant, Tick::OneMillisecond).unwrap();
    let chain = simulate_f64(&machine, &stimulus, StartOffset::none()).unwrap();
    assert!(stimulus.following().is_none(), "no spool was recorded");

    // Rows in which the sensor fails are bridged.
    let mut spool = chain.signal(Signal::Spool).unwrap().to_vec();
    spool[40] = 1.0;
    let recorded = |signal| (signal, commanded.signal(signal).unwrap().to_vec());
    let both = recording(
        commanded.time_s().to_vec(),
        vec![recorded(Signal::Command), (Signal::Spool, spool), recorded(Signal::Position)],
    );
    let stimulus =
        Stimulus::new(&both, &machine, InputPoint::Command, LoadSource::Constant, Tick::OneMillisecond).unwrap();
    let following = stimulus.following().unwrap();
    let mut sluggish = machine;
    sluggish.set(Parameter::TimeConstant1, 0.06);
    let apart = simulate_f64(&sluggish, &following, StartOffset::none()).unwrap();
    let worst = |signal: Signal| {
        let pairs = apart.signal(signal).unwrap().iter().zip(chain.signal(signal).unwrap());
        pairs.map(|(apart, chain)| (apart - chain).abs()).fold(0.0, f64::max)
    };
    assert!(worst(Signal::Position) < 2e-6, "{:e}", worst(Signal::Position));
    assert!(worst(Signal::Spool) > 0.05, "{:e}", worst(Signal::Spool));
}

#[test]
fn no_spool_is_followed_where_the_chain_is_entered_below_the_valve() {
    let time_s: Vec<f64> = (0..50).map(|row| f64::from(row) * 1e-3).collect();
    let spool = vec![0.1; time_s.len()];
    let recording = recording(time_s, vec![(Signal::Spool, spool), (Signal::Position, vec![0.1; 50])]);
    let stimulus =
        Stimulus::new(&recording, &press(), InputPoint::Spool, LoadSource::Constant, Tick::OneMillisecond).unwrap();
    assert!(stimulus.following().is_none());
}

#[test]
fn other_consumers_bring_the_supply_down_by_the_size_of_their_flows_from_the_first_row_on() {
    let plain = commanded(grid(1e-3, 1500));
    let rows = plain.time_s().len();
    let machine = press().with(&[(Parameter::DroopResistance, 5e9), (Parameter::DroopTime, 0.02)]);
    let supply = |others: &[(Signal, f64)]| {
        let own = [Signal::Command, Signal::Position].map(|signal| (signal, plain.signal(signal).unwrap().to_vec()));
        let others = others.iter().map(|&(signal, flow)| (signal, vec![flow; rows]));
        let recording = recording(plain.time_s().to_vec(), own.into_iter().chain(others).collect());
        let run = run_of(&machine, &recording, InputPoint::Command, LoadSource::Constant);
        run.signal(Signal::SupplyPressure).unwrap().to_vec()
    };
    let alone = supply(&[]);
    let shared = supply(&[(Signal::OtherFlow, -1e-4), (Signal::OtherFlow3, 2e-4)]);
    assert!((alone[0] - shared[0] - 3e-4 * 5e9).abs() < 1.0, "{} {}", alone[0], shared[0]);
    // What the drive itself draws is less from a lower supply.
    assert!(alone.iter().zip(&shared).all(|(alone, shared)| alone > shared));
}

#[test]
fn a_recorded_oil_temperature_thins_the_oil_and_without_one_it_is_at_the_reference() {
    let plain = commanded(grid(1e-3, 1500));
    let rows = plain.time_s().len();
    let columns = [Signal::Command, Signal::Position].map(|signal| (signal, plain.signal(signal).unwrap().to_vec()));
    let warm = columns.into_iter().chain([(Signal::OilTemperature, vec![65.0; rows])]).collect();
    let warm = recording(plain.time_s().to_vec(), warm);
    let set = |changes: &[(Parameter, f64)]| {
        let mut machine = press();
        machine.set(Parameter::InternalLeakage, 2e-12);
        for &(parameter, value) in changes {
            machine.set(parameter, value);
        }
        machine
    };
    let position = |machine: &Machine<f64>, recording: &Recording| {
        let run = run_of(machine, recording, InputPoint::Command, LoadSource::Constant);
        run.signal(Signal::Position).unwrap().to_vec()
    };
    let apart =
        |one: &[f64], other: &[f64]| one.iter().zip(other).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    let thins = set(&[(Parameter::ViscosityLossPerKelvin, 0.04), (Parameter::ReferenceTemperature, 40.0)]);
    let thinned = (-0.04_f64 * 25.0).exp();
    let thin = set(&[(Parameter::ViscousFriction, 4e4 * thinned), (Parameter::InternalLeakage, 2e-12 / thinned)]);
    // The step's mass is adapted to the oil spring with the file's friction, whatever the oil.
    assert!(apart(&position(&thins, &warm), &position(&thin, &plain)) < 1e-5);
    assert!(apart(&position(&thins, &warm), &position(&thins, &plain)) > 1e-3);
    assert!(apart(&position(&thins, &plain), &position(&set(&[]), &plain)) < 1e-9);
    assert_eq!(position(&set(&[]), &warm), position(&set(&[]), &plain));
}
