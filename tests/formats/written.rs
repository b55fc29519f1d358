//! What is written reads back unchanged.

use std::fs;

use recording::{ChannelMap, RecordingError, Signal};

use crate::{fixture, read};

#[test]
pub(crate) fn what_is_written_reads_back_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let recording = read("run.csv");
    let simulated: Vec<f64> =
        recording.signal(Signal::Position).unwrap().iter().map(|position| position / 3.0).collect();
    for name in ["out.csv", "out.mat", "out.parquet", "OUT.MAT", "out.data"] {
        let path = folder.path().join(name);
        recording.write(&path, &[(Signal::Position, &simulated)], &[(Signal::Velocity, &simulated)]).unwrap();
        let again = recording::read(&path, &ChannelMap::default()).unwrap();
        assert_eq!(again.columns().len(), 7, "{name}");
        for column in again.columns() {
            let expected = match column.signal {
                Signal::Position | Signal::Velocity => simulated.as_slice(),
                signal => recording.signal(signal).unwrap(),
            };
            for (found, expected) in column.values.iter().zip(expected) {
                assert!((found - expected).abs() <= 2e-14 * expected.abs(), "{name}: {} {found}", column.signal);
            }
        }
        // All formats hold the same numbers: those of the text, to the bit.
        let text = recording::read(&folder.path().join("out.csv"), &ChannelMap::default()).unwrap();
        for signal in [Signal::Position, Signal::PressureA, Signal::Time] {
            assert_eq!(again.signal(signal), text.signal(signal), "{name}");
            assert_eq!(again.column(signal).unwrap().header, text.column(signal).unwrap().header, "{name}");
        }
        // The same input gives the same bytes.
        let bytes = fs::read(&path).unwrap();
        recording.write(&path, &[(Signal::Position, &simulated)], &[(Signal::Velocity, &simulated)]).unwrap();
        assert!(bytes == fs::read(&path).unwrap(), "{name}");
    }
}

#[test]
pub(crate) fn what_was_left_out_is_written_as_no_value() {
    let folder = tempfile::tempdir().unwrap();
    let text = "time [s],spool,position [mm]\n0,0,1\n0.5,,2\n1,1,3\n1,1,4\n1.5,0,5\n";
    let recording = recording::read_from("gaps.csv", text.as_bytes(), &ChannelMap::default()).unwrap();
    for name in ["gaps.mat", "gaps.parquet"] {
        let path = folder.path().join(name);
        recording.write(&path, &[], &[]).unwrap();
        let again = recording::read(&path, &ChannelMap::default()).unwrap();
        assert_eq!(again.signal(Signal::Position), recording.signal(Signal::Position), "{name}");
        let told: Vec<String> = again.notes().iter().map(ToString::to_string).collect();
        assert_eq!(told[0], "1 row repeats the time before it and is left out, in row 4", "{name}");
        assert_eq!(told[1], "1 row has an empty cell and is left out, in row 2", "{name}");
        let back = folder.path().join("back.csv");
        again.write(&back, &[], &[]).unwrap();
        assert_eq!(fs::read_to_string(back).unwrap(), text, "{name}");
    }
}

#[test]
pub(crate) fn a_file_that_cannot_be_written_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let recording = read("run.csv");
    let path = folder.path().join("out.parquet");
    fs::write(&path, "old").unwrap();
    let short = recording.write(&path, &[(Signal::Position, &[0.0])], &[]).unwrap_err();
    assert!(matches!(short, RecordingError::LengthMismatch { .. }), "{short}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    let nowhere = recording.write(&folder.path().join("no/out.mat"), &[], &[]).unwrap_err();
    assert!(matches!(nowhere, RecordingError::Write { .. }), "{nowhere}");
    let mdf = recording.write(&folder.path().join("out.mf4"), &[], &[]).unwrap_err();
    assert!(mdf.to_string().contains("expected a name that ends with .csv, .mat or .parquet"), "{mdf}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(fixture("run.csv").exists());
}
