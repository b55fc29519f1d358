//! Recordings that the firmware has streamed out.

use super::{MACHINE, done, folder_with, refused, run, streamed, text};

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
    assert!(note.contains(" rows stand behind a gap in the frames"), "{note}");
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
