//! Recordings that the firmware has streamed out.

use firmware::recorder::frame::FrameWriter;
use firmware::recorder::{Channel, Progress, Range, Recorder, Stream};
use model_core::number::{Number, PerUnit};

use super::{MACHINE, done, folder_with, refused, run, text};

/// A second of recording: the command rises, and the rod stays in place.
pub(super) fn streamed() -> Vec<u8> {
    let channel = |name, unit, base| Channel { name, unit, base, range: Range::One };
    let channels = [channel("command", "V", 10.0), channel("position", "m", 0.3)];
    let mut recorder: Recorder<2, 1000> = Recorder::new(channels, 999).unwrap();
    for tick in 0..1000 {
        if tick == 999 {
            recorder.trigger();
        }
        recorder.record(&[Some(PerUnit::saturated(f64::from(tick) * 2e-4)), Some(PerUnit::saturated(0.5))]);
    }
    let (mut bytes, mut stream, mut frames) = (Vec::new(), Stream::new(), FrameWriter::default());
    while stream.write(&recorder, "press", 1_000_000, &mut frames, &mut bytes).unwrap() == Progress::More {}
    bytes
}

const IMPORT: [&str; 5] = ["import", "--frames", "frames.bin", "--out", "taken.csv"];

#[test]
fn what_the_firmware_recorded_can_be_simulated() {
    let folder = folder_with(MACHINE, "");
    std::fs::write(folder.path().join("frames.bin"), streamed()).unwrap();
    assert_eq!(done(folder.path(), &IMPORT), "");
    let taken = std::fs::read_to_string(folder.path().join("taken.csv")).unwrap();
    assert!(taken.starts_with("time [s],command [V],position [m]\n0,0,0.15"), "{}", &taken[..60]);
    assert_eq!(taken.lines().count(), 1001);
    done(
        folder.path(),
        &["simulate", "--machine", "machine.toml", "--recording", "taken.csv", "--out", "simulated.csv"],
    );
}

#[test]
fn rows_that_the_line_lost_are_told() {
    let folder = folder_with(MACHINE, "");
    let mut bytes = streamed();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(folder.path().join("frames.bin"), bytes).unwrap();
    let output = run(folder.path(), &IMPORT);
    assert_eq!(output.status.code(), Some(0));
    let note = text(&output.stderr);
    assert!(note.contains("of 1000 rows are lost (1 frames missing, 1 damaged or foreign)"), "{note}");
}

#[test]
fn bytes_that_are_no_recording_are_refused() {
    let folder = folder_with(MACHINE, "");
    std::fs::write(folder.path().join("frames.bin"), b"boot ok\r\n").unwrap();
    let message = refused(folder.path(), &IMPORT);
    assert!(message.contains("frames.bin: no recording in 9 bytes"), "{message}");
    let message = refused(folder.path(), &["import", "--frames", "nothing.bin", "--out", "taken.csv"]);
    assert!(
        message.contains("nothing.bin: cannot be read") && message.contains("expected a readable file"),
        "{message}"
    );
}
