//! The trials use what they name: the shipped drive, its recordings, every effect that exists.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use model_core::machine::Parameter;
use mps2::trial::{RECORDED, press};
use recording::{ChannelMap, Signal, read};

fn of_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

#[test]
fn the_press_is_the_preset() {
    let preset = machine_file::read(&of_repository("presets/press-63-40.toml")).unwrap();
    for &parameter in Parameter::ALL {
        let (here, there) = (press().get(parameter), preset.machine.get(parameter));
        assert_eq!(here.to_bits(), there.to_bits(), "{}", parameter.description().key);
    }
}

#[test]
fn the_recorded_input_is_the_command_of_the_shipped_case() {
    let mut runs: Vec<(u32, i64)> = Vec::new();
    for file in ["train-1", "train-2", "train-3", "train-4"] {
        let path = of_repository(&format!("examples/press-63-40/{file}.csv"));
        let recording = read(&path, &ChannelMap::default()).unwrap();
        for volts in recording.signal(Signal::Command).unwrap() {
            #[expect(clippy::cast_possible_truncation, reason = "a command is some volts")]
            let tenths = (volts * 1e4).round() as i64;
            // A row every 2 ms.
            match runs.last_mut() {
                Some((ticks, last)) if *last == tenths => *ticks += 2,
                _ => runs.push((2, tenths)),
            }
        }
    }
    let mut text = String::new();
    for (ticks, tenths) in runs {
        writeln!(text, "{ticks} {tenths}").unwrap();
    }
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(of_repository("firmware/boards/mps2/src/trial/recorded.txt"), &text).unwrap();
        return;
    }
    assert!(RECORDED == text, "RENEW=1 writes it anew");
}
