//! Properties of the readers: they never panic, and what is written reads back unchanged.

mod at_hand;

use std::path::PathBuf;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use machine_file::{LoadSource, MachineFile};
use model_core::machine::{Machine, Parameter, Source};
use recording::files::source_error::render;
use recording::{ChannelMap, Column, Recording, Signal, Unit};

/// Text that resembles a recording: its words in any order.
fn nearly_a_recording() -> impl Strategy<Value = String> {
    let words = [
        "time [s]",
        "time [ms]",
        "position [mm]",
        "spool",
        "pressure_a [bar]",
        "x",
        "Name",
        "Data-Type",
        "SampleTime[ms]",
        "0",
        "1",
        "2.5",
        "-3,5",
        "NaN",
        "1e400",
        "EOF",
        "\"",
        "[",
        "]",
        "#",
        ",",
        ",",
        ";",
        "\t",
        "\n",
        "\n",
        "\r\n",
        "\u{feff}",
        "°",
    ];
    prop::collection::vec(prop::sample::select(words.to_vec()), 0..60).prop_map(|words| words.concat())
}

/// Text that resembles a machine file.
fn nearly_a_machine_file() -> impl Strategy<Value = String> {
    let words = [
        "[supply]\n",
        "[valve]\n",
        "[pump]\n",
        "[cylinder]\n",
        "[effects.pump-slip]\n",
        "[fit.sigma]\n",
        "[channels]\n",
        "[load]\n",
        "area_a_m2",
        "area_b_m2",
        "time_constants_s",
        "source",
        "position",
        "\"valve.offset\"",
        "effects",
        " = ",
        "1e-3",
        "-1",
        "nan",
        "[0.1]",
        "{}",
        "\"x\"",
        "\n",
        ".",
        "°",
    ];
    prop::collection::vec(prop::sample::select(words.to_vec()), 0..40).prop_map(|words| words.concat())
}

fn read_recording(bytes: &[u8]) {
    let map = ChannelMap::from_arguments(["position=x [mm]"]).unwrap();
    for map in [ChannelMap::default(), map] {
        match recording::read_from("run.csv", bytes, &map) {
            Ok(recording) => assert!(recording.time_s().windows(2).all(|pair| pair[0] < pair[1])),
            Err(error) => assert!(render(&error).contains("expected")),
        }
    }
}

fn read_machine(text: &str) {
    if let Err(error) = machine_file::read_text("machine.toml", text) {
        assert!(render(&error).contains("expected"));
    }
}

/// A valid machine: each parameter at its default or anywhere in its range.
fn machine() -> impl Strategy<Value = Machine<f64>> {
    let value = |&parameter: &Parameter| {
        let what = parameter.description();
        let (min, max) = (what.min, what.max.min(1e12));
        (0.0..=1.0_f64, any::<bool>()).prop_map(move |(part, given)| {
            let value = min + (max - min) * part;
            given.then_some(if parameter.is_whole() { value.floor() } else { value })
        })
    };
    let values: Vec<_> = Parameter::ALL.iter().map(value).collect();
    (values, any::<bool>()).prop_map(|(values, pump)| {
        let source = if pump { Source::Pump } else { Source::Valve };
        let mut machine = Machine::with_defaults(source);
        for (&parameter, value) in Parameter::ALL.iter().zip(values) {
            let key = parameter.description().key;
            let unused = if pump {
                key.starts_with("valve.")
            } else {
                key.starts_with("pump.") || key.starts_with("directional")
            };
            let required = machine.get(parameter).is_nan().then_some(1e-3);
            if let Some(value) = value.or(required).filter(|_| !unused) {
                machine.set(parameter, value);
            }
        }
        // A file may hold only floors from vacuum to the tank's pressure.
        let (floor, tank) = (Parameter::CavitationFloor, machine.get(Parameter::TankPressure));
        let what = floor.description();
        let part = (machine.get(floor) - what.min) / (what.max - what.min);
        if part > 0.0 {
            machine.set(floor, -1.01e5 + (tank + 1.01e5) * part);
        }
        // Its linkage has to close over the whole stroke: both sides are alike here, and no shorter than that.
        let (base, retracted) = (Parameter::LinkageBase, Parameter::LinkageLengthRetracted);
        let side_m = machine.get(base).max(machine.get(Parameter::Stroke));
        machine.set(base, side_m);
        machine.set(Parameter::LinkageArm, side_m);
        machine.set(retracted, machine.get(retracted).min(side_m));
        machine
    })
}

fn bits(machine: &Machine<f64>) -> Vec<u64> {
    Parameter::ALL.iter().map(|&parameter| machine.get(parameter).to_bits()).collect()
}

fn rows() -> impl Strategy<Value = Vec<(f64, f64, f64)>> {
    let number = || prop_oneof![-1e9..1e9_f64, -1.0..1.0_f64, Just(0.0), Just(-0.0), Just(1e-300)];
    prop::collection::vec((1e-4..10.0_f64, number(), number()), 2..50)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, rng_seed: RngSeed::Fixed(20_200), ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_make_the_reader_of_recordings_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        read_recording(&bytes);
        let mut table = b"time [s],position [mm]\n".to_vec();
        table.extend(bytes);
        read_recording(&table);
    }

    #[test]
    fn no_text_makes_the_reader_of_recordings_panic(text in nearly_a_recording()) {
        read_recording(text.as_bytes());
        read_recording(format!("time [s];spool\n0;1\n{text}").as_bytes());
        read_recording(format!("Name\tspool\nData-Type\tREAL\n{text}").as_bytes());
    }

    #[test]
    fn no_text_makes_the_reader_of_machine_files_panic(text in nearly_a_machine_file(), any in "\\PC{0,200}") {
        read_machine(&text);
        read_machine(&any);
        read_machine(&format!("[supply]\n[cylinder]\narea_a_m2 = 1\narea_b_m2 = 1\n[valve]\n{text}"));
    }

    #[test]
    fn a_written_recording_reads_back(rows in rows()) {
        let mut time = 0.0;
        let times = rows.iter().map(|row| { time += row.0; time }).collect();
        let mut columns = vec![
            Column::si(Signal::Time, times),
            Column::si(Signal::Position, rows.iter().map(|row| row.1).collect()),
            Column::si(Signal::PressureA, rows.iter().map(|row| row.2).collect()),
        ];
        columns[2].unit = Unit::parse("psi").unwrap();
        columns[2].header = "p, \"A\" [psi]".into();
        let recording = Recording::new("made.csv", columns).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        let measured = recording.signal(Signal::PressureA).unwrap();
        recording.write_csv(&path, &[(Signal::Position, measured)], &[]).unwrap();
        let map = ChannelMap::from_arguments(["pressure_a=p, \"A\" [psi]"]).unwrap();
        let again = recording::read(&path, &map).unwrap();
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(again.time_s()), bits(recording.time_s()));
        prop_assert_eq!(bits(again.signal(Signal::Position).unwrap()), bits(measured));
        for (again, once) in again.signal(Signal::PressureA).unwrap().iter().zip(measured) {
            prop_assert!((again - once).abs() <= 2e-14 * once.abs(), "{} {}", again, once);
        }
    }

    #[test]
    fn a_written_machine_file_reads_back_bit_for_bit(first in machine(), second in machine(), pressures: bool, sigma in 1e-9..1e9_f64) {
        let mut file = MachineFile::from_machine("made", first);
        let text = file.to_text("m").unwrap();
        let mut again = machine_file::read_text("m", &text).unwrap();
        prop_assert_eq!(bits(&again.machine), bits(&first));
        prop_assert_eq!(&again.effects, &file.effects);
        // The same through a text that holds other values, and comments.
        file = machine_file::read_text("m", &text.replace('\n', " # c\n")).unwrap();
        let source = file.machine.source;
        file.machine = second;
        file.load_source = if pressures { LoadSource::RecordedPressures } else { LoadSource::Constant };
        file.sigma.insert(Parameter::AreaA, sigma);
        let text = file.to_text("m").unwrap();
        again = machine_file::read_text("m", &text).unwrap();
        prop_assert_eq!(bits(&again.machine), bits(&second));
        prop_assert_eq!(again.load_source, file.load_source);
        prop_assert_eq!(&again.sigma, &file.sigma);
        prop_assert_eq!(text.contains("# c"), source == second.source);
    }
}

/// Every file of the shared recordings can be read; skipped where that folder is not there.
#[test]
fn the_shared_recordings_are_read() {
    let mut folders: Vec<PathBuf> = at_hand::shared("data/eha").into_iter().collect();
    for set in ["concealed", "concealed-hard"] {
        let entries = at_hand::shared(set).map(|set| std::fs::read_dir(set).unwrap().flatten());
        folders.extend(entries.into_iter().flatten().map(|entry| entry.path()));
    }
    let any = !folders.is_empty();
    let mut files = 0;
    for path in
        folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten().map(|entry| entry.path())
    {
        let extension = path.extension().and_then(|extension| extension.to_str());
        let outcome = match extension {
            Some("csv") => recording::read(&path, &ChannelMap::default()).map(drop).map_err(|error| render(&error)),
            Some("toml") => machine_file::read(&path).map(drop).map_err(|error| render(&error)),
            _ => continue,
        };
        assert_eq!(outcome, Ok(()), "{}", path.display());
        files += 1;
    }
    assert!(files > 0 || !any, "folders without files");
    println!("{files} files read");
}
