//! Each file compared with the CSV of the same rows.

use recording::{Note, Recording, RecordingError, Signal, Unsupported};

use crate::{read, read_mapped};

/// The values of two recordings are the same to the bit: the fixtures hold numbers that every format holds exactly.
#[track_caller]
fn assert_same(name: &str, found: &Recording, expected: &Recording) {
    for column in expected.columns() {
        let values = found.signal(column.signal);
        assert_eq!(values, Some(column.values.as_slice()), "{name}: {}", column.signal);
        let header = &found.column(column.signal).unwrap().header;
        assert!(header.starts_with(column.signal.name()), "{name}: {header}");
    }
    assert_eq!(found.columns().len(), expected.columns().len(), "{name}");
}

#[test]
pub(crate) fn every_format_gives_the_recording_of_the_csv() {
    let expected = read("run.csv");
    assert_eq!((expected.rows(), expected.columns().len()), (200, 6));
    for name in [
        "vectors.mat",
        "vectors_packed.mat",
        "structure.mat",
        "timed.mat",
        "simulink.mat",
        "packed_0.mf4",
        "packed_1.mf4",
        "packed_2.mf4",
        "pyarrow.parquet",
        "plain.parquet",
        "mixed.parquet",
        "pandas.parquet",
        "scope.txt",
        "version4.mat",
        "controldesk.mat",
        "run.xlsx",
        "run.csv.gz",
    ] {
        let found = read(name);
        assert_same(name, &found, &expected);
        assert!(found.notes().is_empty(), "{name}: {:?}", found.notes());
    }
}

#[test]
pub(crate) fn what_is_no_signal_is_ignored_by_its_name() {
    assert_eq!(read("vectors.mat").ignored(), ["calibration", "steps"]);
    assert_eq!(read("packed_2.mf4").ignored(), ["state"]);
    assert_eq!(read("pyarrow.parquet").ignored(), ["state"]);
}

#[test]
pub(crate) fn units_are_those_of_the_file() {
    for name in ["vectors.mat", "packed_0.mf4", "pandas.parquet"] {
        let header = |signal| read(name).column(signal).unwrap().header.clone();
        assert_eq!(header(Signal::Time), "time [s]", "{name}");
        assert_eq!(header(Signal::Position), "position [mm]", "{name}");
        assert_eq!(header(Signal::PressureA), "pressure_a [bar]", "{name}");
        assert_eq!(header(Signal::OilTemperature), "oil_temperature [°C]", "{name}");
    }
}

#[test]
pub(crate) fn channels_of_another_group_are_interpolated() {
    let (found, expected) = (read("two_groups.mf4"), read("run.csv"));
    assert_eq!(found.notes(), [Note::Resampled { signals: vec![Signal::OilTemperature], rows_left_out: 0 }]);
    assert_eq!(found.signal(Signal::Position), expected.signal(Signal::Position));
    let oil = |recording: &Recording, row: usize| recording.signal(Signal::OilTemperature).unwrap()[row];
    assert_eq!(oil(&found, 40).to_bits(), oil(&expected, 40).to_bits());
    // Halfway between two samples, where the staircase of the CSV still has the first value.
    assert!((oil(&found, 30) - oil(&expected, 30) - 0.0625).abs() < 1e-12);
}

#[test]
pub(crate) fn timestamps_count_from_the_first() {
    let (found, expected) = (read("stamped.parquet"), read("run.csv"));
    let worst = found.time_s().iter().zip(expected.time_s()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(found.rows() == 200 && worst <= 1e-6, "{worst}");
    assert_eq!(found.signal(Signal::Position), expected.signal(Signal::Position));
}

#[test]
pub(crate) fn durations_and_old_timestamps_are_in_seconds_whatever_their_names_say() {
    let expected = read("run.csv");
    for name in ["spans.parquet", "polars_spans.parquet", "spark.parquet"] {
        let found = read(name);
        let off = found.time_s().iter().zip(expected.time_s()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(found.rows() == 200 && off < 1e-12, "{name}: {off}");
        // Spark's file has floating numbers of 16 bits and decimal numbers among them.
        for column in &expected.columns()[1..] {
            assert_eq!(found.signal(column.signal), Some(column.values.as_slice()), "{name}: {}", column.signal);
        }
    }
}

#[test]
pub(crate) fn the_members_of_a_structure_and_the_elements_of_an_array_are_channels() {
    let expected = read("run.csv");
    let all = ["Bench", "Bench.position", "Bench.command", "pressures", "pressures[0]", "pressures[1]"];
    assert_eq!(read("composed.mf4").ignored(), all);
    let maps = [
        "position=Bench.position [mm]",
        "command=Bench.command [V]",
        "pressure_a=pressures[0] [bar]",
        "pressure_b=pressures[1] [bar]",
    ];
    let found = read_mapped("composed.mf4", &maps).unwrap();
    for signal in [Signal::Position, Signal::Command, Signal::PressureA, Signal::Spool] {
        assert_eq!(found.signal(signal), expected.signal(signal), "{signal}");
    }
    let above =
        |row: usize| found.signal(Signal::PressureB).unwrap()[row] - found.signal(Signal::PressureA).unwrap()[row];
    assert!((0..200).all(|row| (above(row) - 1e5).abs() < 1e-6));
    for (map, what) in [("position=Bench [mm]", "a structure"), ("position=pressures [mm]", "an array")] {
        let refused = read_mapped("composed.mf4", &[map]).unwrap_err();
        assert!(matches!(&refused, RecordingError::NotNumbers { found, .. } if found.starts_with(what)), "{refused}");
    }
}

#[test]
pub(crate) fn a_text_among_the_numbers_of_a_channel_is_an_empty_cell() {
    let (found, expected) = (read("states.mf4"), read("run.csv"));
    assert_eq!(found.notes()[0].to_string(), "1 row has an empty cell and is left out, in row 8");
    let mut positions = expected.signal(Signal::Position).unwrap().to_vec();
    positions.remove(7);
    assert_eq!(found.signal(Signal::Position).unwrap(), positions);
}

#[test]
pub(crate) fn a_null_is_an_empty_cell() {
    let found = read("holes.parquet");
    assert_eq!(found.rows(), 199);
    assert_eq!(found.notes()[0].to_string(), "1 row has an empty cell and is left out, in row 8");
}

#[test]
pub(crate) fn every_format_is_mapped() {
    for (name, map) in [
        ("run.csv", "force=spool"),
        ("vectors.mat", "position=pressure_a_bar [mm]"),
        ("vectors.mat", "position=pressure_a_bar"),
        ("structure.mat", "position=run.pressure_a_bar"),
        ("structure.mat", "position=run.pressure_a_bar [mm]"),
        ("packed_1.mf4", "position=pressure_a [bar]"),
        ("pyarrow.parquet", "position=pressure_a [bar]"),
    ] {
        // A mapping to an impossible unit: its error proves that the column was found.
        let error = read_mapped(name, &[map]).map(|recording| recording.columns().len());
        match error {
            Err(RecordingError::WrongDimension { .. } | RecordingError::MissingUnit { .. }) => {}
            Ok(5) if name.ends_with("mat") => {}
            other => panic!("{name}: {other:?}"),
        }
        let absent = read_mapped(name, &["force=rod force [kN]"]).unwrap_err();
        assert!(matches!(absent, RecordingError::MappedColumnAbsent { .. }), "{name}: {absent}");
    }
    let mapped = read_mapped("packed_0.mf4", &["reference=position [mm]"]).unwrap();
    assert!(mapped.has(Signal::Reference) && !mapped.has(Signal::Position));
    assert_eq!(mapped.column(Signal::Reference).unwrap().header, "position [mm]");
}

#[test]
pub(crate) fn what_is_not_read_says_what_to_do() {
    let packing = read_mapped("brotli.parquet", &[]).unwrap_err();
    assert!(matches!(packing, RecordingError::Unsupported { what: Unsupported::Packing(_), .. }));
    assert!(
        packing.to_string().contains("brotli.parquet, column `time [s]`: data packed by brotli; expected"),
        "{packing}"
    );
    let text = read_mapped("packed_0.mf4", &["force=state [N]"]).unwrap_err();
    assert!(matches!(text, RecordingError::NotNumbers { .. }), "{text}");
    assert!(text.to_string().contains("packed_0.mf4, channel `state`: `state` holds text"), "{text}");
    let matrix = read_mapped("vectors.mat", &["force=calibration [N]"]).unwrap_err();
    assert!(
        matrix.to_string().contains("vectors.mat, variable `calibration`: `calibration` holds a matrix"),
        "{matrix}"
    );
    let short = read_mapped("vectors.mat", &["force=steps [N]"]).unwrap_err();
    assert!(
        short.to_string().contains("variable `steps`: `steps` has no times; expected `time [s]` (time_s)"),
        "{short}"
    );
}
