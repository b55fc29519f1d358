//! The drive that tests use: a valve on a 63/40 × 300 mm cylinder; and any other, read from its folder.
#![forbid(unsafe_code)]
// Results are returned: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

use std::path::{Path, PathBuf};

use machine_file::{LoadSource, MachineFile};
use model_core::machine::{Machine, Parameter, Source, Tick};
use recording::seeded_noise::Noise;
use recording::{Column, Recording, Signal};
use simulation::{InputPoint, StartOffset, Stimulus, simulate_f64};

/// The press; a test sets further parameters in addition to its cylinder, the valve's gain and its speed.
pub fn press(further: &[(Parameter, f64)]) -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Valve);
    let always = [
        (Parameter::AreaA, 3.117e-3),
        (Parameter::AreaB, 1.861e-3),
        (Parameter::VolumeA, 5.2e-4),
        (Parameter::VolumeB, 3.3e-4),
        (Parameter::ValveGain, 0.0559),
        (Parameter::TimeConstant1, 0.018),
        (Parameter::RateLimit, 12.0),
    ];
    for (parameter, value) in always.iter().chain(further) {
        machine.set(*parameter, *value);
    }
    machine
}

/// The press with the paper's valve: a dead zone, an offset, two lags and a delay, a light rod and viscous friction.
pub fn with_papers_valve() -> Machine<f64> {
    use Parameter as P;
    press(&[
        (P::ValveOffset, 0.0345),
        (P::DeadZone, 0.105),
        (P::TimeConstant2, 0.0279),
        (P::TransportDelay, 0.007),
        (P::MovingMass, 18.3),
        (P::ViscousFriction, 1.0e5),
    ])
}

/// Two seconds of a machine driven to and fro from 0.12 m, as recorded by sensors with this noise; the same sensors get the same noise.
///
/// # Panics
/// Never: the press and these signals can be simulated.
pub fn recorded(machine: &Machine<f64>, sensors: &[(Signal, f64)]) -> Recording {
    recorded_for(machine, sensors, 2000)
}

/// The same for this many milliseconds.
///
/// # Panics
/// Never: the press and these signals can be simulated.
pub fn recorded_for(machine: &Machine<f64>, sensors: &[(Signal, f64)], rows: u32) -> Recording {
    let time_s: Vec<f64> = (0..rows).map(|row| f64::from(row) * 1e-3).collect();
    let command = time_s.iter().map(|t| 2.5 * (5.0 * t).sin() + 1.5 * (13.0 * t).sin()).collect();
    let driven = vec![
        Column::si(Signal::Time, time_s.clone()),
        Column::si(Signal::Command, command),
        Column::si(Signal::Position, vec![0.12; time_s.len()]),
    ];
    let at_start = Recording::new("driven", driven.clone()).unwrap();
    let stimulus =
        Stimulus::new(&at_start, machine, InputPoint::Command, LoadSource::Constant, Tick::OneMillisecond).unwrap();
    let run = simulate_f64(machine, &stimulus, StartOffset::none()).unwrap();
    let read = |(stream, &(signal, noise)): (u64, &(Signal, f64))| {
        let mut generator = Noise::new(3, stream);
        let values = run.signal(signal).unwrap().iter().map(|value| value + generator.gaussian(noise)).collect();
        Column::si(signal, values)
    };
    let sensors = (1..).zip(sensors).map(read);
    Recording::new("made", driven.into_iter().take(2).chain(sensors).collect()).unwrap()
}

/// The press extending for 1.2 s, its position with noise.
///
/// # Panics
/// Never: the press and these signals can be simulated.
pub fn extending(machine: &Machine<f64>) -> Recording {
    let time_s: Vec<f64> = (0..1200).map(|row| f64::from(row) * 1e-3).collect();
    let command = time_s.iter().map(|time| if *time < 0.1 { 0.0 } else { 4.0 }).collect();
    let columns = |position_m: Vec<f64>| {
        let command: &Vec<f64> = &command;
        let columns =
            [(Signal::Time, time_s.clone()), (Signal::Command, command.clone()), (Signal::Position, position_m)];
        Recording::new("made", columns.map(|(signal, values)| Column::si(signal, values)).to_vec()).unwrap()
    };
    let driven = columns(vec![0.1; time_s.len()]);
    let tick = Tick::OneMillisecond;
    let stimulus = Stimulus::new(&driven, machine, InputPoint::Command, LoadSource::Constant, tick).unwrap();
    let run = simulate_f64(machine, &stimulus, StartOffset::none()).unwrap();
    let mut seed = 7_u32;
    let mut noise = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        4e-4 * (f64::from(seed >> 8) / f64::from(1 << 24) - 0.5)
    };
    columns(run.signal(Signal::Position).unwrap().iter().map(|position| position + noise()).collect())
}

/// A folder's machine file and its recordings, in the order of their names.
///
/// # Panics
/// A file that cannot be read.
#[must_use]
pub fn folder(path: &Path) -> (MachineFile, Vec<Recording>) {
    let file = machine_file::read(&path.join("machine.toml")).unwrap();
    let mut paths: Vec<PathBuf> = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "csv"));
    paths.sort();
    let recordings = paths.iter().map(|path| recording::read(path, &file.channels).unwrap()).collect();
    (file, recordings)
}
