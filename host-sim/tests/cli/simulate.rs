//! The output of `simulate`.

use std::path::Path;

use super::{MACHINE, done, example, folder_with, refused, run, text};

/// Header and rows of numbers.
fn table(path: &Path) -> (String, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let numbers = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    (header.to_owned(), rows.lines().map(numbers).collect())
}

#[test]
fn one_row_for_each_recorded_row_in_the_recordings_columns_and_units() {
    // Uneven times, an unknown column, units that people use.
    let recorded = "time [ms];command [mV];spool [%];Kolbenweg [mm];remark;pressure_a [bar];pressure_b [bar]\n\
        0;0;0,5;150;a;20,1;35\n10,5;4000;0,5;150;b;20,1;35\n20;4000;3;150;c;21;35\n300;4000;22;155;d;30;30\n";
    let folder = folder_with(MACHINE, recorded);
    let arguments = ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "out.csv"];
    done(folder.path(), &[&arguments[..], &["--map", "position=Kolbenweg [mm]", "--plot", "out.svg"]].concat());
    let (header, rows) = table(&folder.path().join("out.csv"));
    assert_eq!(header, "time [ms],command [mV],spool [%],Kolbenweg [mm],pressure_a [bar],pressure_b [bar]");
    let inputs: Vec<(f64, f64)> = rows.iter().map(|row| (row[0], row[1])).collect();
    assert_eq!(inputs, [(0.0, 0.0), (10.5, 4000.0), (20.0, 4000.0), (300.0, 4000.0)]);
    assert!((rows[0][3] - 150.0).abs() < 1e-6, "it starts where the recording starts");
    assert!((rows[3][2] - 22.36).abs() < 0.1, "the spool is in %: {}", rows[3][2]);
    assert!(rows[3][3] > 150.5 && rows[3][3] < 170.0, "the position is in mm: {}", rows[3][3]);
    let svg = std::fs::read_to_string(folder.path().join("out.svg")).unwrap();
    assert!(svg.contains("viewBox") && svg.contains("sans-serif") && svg.contains("Position [mm]"));
}

#[test]
fn an_input_signal_gives_every_signal_in_si_units_from_mid_stroke() {
    let folder = folder_with(MACHINE, "");
    let out = |extra: &[&str], name: &str| {
        let arguments = ["simulate", "--machine", "machine.toml", "--input", "step:4V", "--out", name];
        done(folder.path(), &[&arguments[..], extra].concat());
        table(&folder.path().join(name))
    };
    let (header, rows) = out(&[], "a.csv");
    assert_eq!(
        header,
        "time [s],command [V],spool [1],position [m],velocity [m/s],pressure_a [Pa],pressure_b [Pa],flow [m3/s],force [N]"
    );
    assert_eq!(rows.len(), 951);
    assert!((rows[0][3] - 0.15).abs() < 1e-9 && rows[0][4].abs() < 1e-9);
    assert!(rows[950][3] > 0.159, "4 V extends: {}", rows[950][3]);

    let (_, float) = out(&["--arithmetic", "float"], "b.csv");
    let scales = [1.0, 10.0, 1.0, 0.3, 1.0, 7e6, 7e6, 1e-3, 3e4];
    for (fixed, float) in rows.iter().zip(&float) {
        for ((fixed, float), scale) in fixed.iter().zip(float).zip(scales) {
            assert!((fixed - float).abs() < 1e-4 * scale, "{fixed} {float}");
        }
    }
    assert_ne!(rows, float, "two number types");
    assert_eq!(out(&["--tick", "0.5"], "c.csv").1.len(), 1901);
    assert_eq!(out(&["--tick", "2"], "d.csv").1.len(), 476);
}

#[test]
fn fixed_and_float_agree_on_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, recording) = (example("machine.toml"), example("train-1.csv"));
    let out = |arithmetic: &str| {
        let arguments = ["simulate", "--machine", &machine, "--recording", &recording, "--out", arithmetic];
        done(folder.path(), &[&arguments[..], &["--arithmetic", arithmetic]].concat());
        table(&folder.path().join(arithmetic))
    };
    let ((fixed_header, fixed), (float_header, float)) = (out("fixed"), out("float"));
    assert_eq!(fixed_header, float_header);
    assert_eq!(fixed.len(), std::fs::read_to_string(&recording).unwrap().lines().count() - 1);
    let scales = [1.0, 10.0, 1.0, 0.3, 7e6, 7e6];
    for (fixed, float) in fixed.iter().zip(&float) {
        for ((fixed, float), scale) in fixed.iter().zip(float).zip(scales) {
            assert!((fixed - float).abs() < 1e-4 * scale, "{fixed} {float}");
        }
    }
}

#[test]
fn rows_that_cannot_be_used_are_written_too() {
    let recorded =
        "time [s],command [V],position [m]\n0,0,0.1\n0.1,4,0.1\n0.1,5,0.2\n0.15,,0.3\n0.2,4,0.1\n,,\n0.3,4,\n";
    let folder = folder_with(MACHINE, recorded);
    let arguments = ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "out.csv"];
    done(folder.path(), &arguments);
    let text = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let given: Vec<String> = rows.iter().map(|row| row[..2].join(",")).collect();
    assert_eq!(given, ["0,0", "0.1,4", "0.1,5", "0.15,", "0.2,4", ",", "0.3,4"]);
    let position = |row: usize| rows[row][2].parse::<f64>().unwrap();
    assert_eq!(rows[2][2], rows[1][2], "the same time, the same position");
    assert!((position(3) - f64::midpoint(position(1), position(4))).abs() < 1e-12);
    assert_eq!((rows[5][2], rows[6][2]), ("", ""), "no time, and a time that the simulation does not reach");
}

#[test]
fn a_recording_of_the_command_alone_gets_every_signal() {
    let folder = folder_with(MACHINE, "time [ms],command [V]\n0,0\n10,4\n300,4\n");
    let arguments = ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "out.csv"];
    done(folder.path(), &arguments);
    let (header, rows) = table(&folder.path().join("out.csv"));
    assert_eq!(
        header,
        "time [ms],command [V],spool [1],position [m],velocity [m/s],pressure_a [Pa],pressure_b [Pa],flow [m3/s],force [N]"
    );
    assert!(rows[2][3] > rows[0][3], "4 V extends");
}

/// A recording with more rows than are held in memory at once.
fn more_than_a_part() -> String {
    let volts = |row: usize| if row % 1000 < 500 { 2 } else { -2 };
    let rows: Vec<String> = (0..600_000).map(|row| format!("{row},{}\n", volts(row))).collect();
    format!("time [ms],command [V]\n{}", rows.concat())
}

#[test]
fn standard_output_gets_what_a_file_gets_of_more_rows_than_are_held() {
    let folder = folder_with(MACHINE, &more_than_a_part());
    let simulate = |out| ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", out];
    let printed = done(folder.path(), &simulate("-"));
    done(folder.path(), &simulate("out.csv"));
    assert_eq!(printed.lines().count(), 600_001);
    assert!(printed == std::fs::read_to_string(folder.path().join("out.csv")).unwrap());
}

#[test]
fn an_error_beyond_what_is_held_leaves_the_old_file() {
    let folder = folder_with(MACHINE, &(more_than_a_part() + "600000,far\n"));
    let out = folder.path().join("out.csv");
    std::fs::write(&out, "old").unwrap();
    let arguments = ["--quiet", "simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "out.csv"];
    let message = refused(folder.path(), &arguments);
    assert!(message.contains("run.csv:600002") && message.contains("far"), "{message}");
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "old");
}

#[cfg(unix)]
#[test]
fn the_signals_can_go_down_a_pipe() {
    let folder = folder_with(MACHINE, "");
    let arguments = ["simulate", "--machine", "machine.toml", "--input", "zero:10ms", "--out", "/dev/stdout"];
    assert_eq!(done(folder.path(), &arguments).lines().count(), 12);
}

#[test]
fn a_rod_starts_where_in_its_play_the_recording_tells() {
    let machine = format!("{MACHINE}\n[effects.linkage-backlash]\nplay_m = 0.0012\n");
    let folder = folder_with(&machine, "");
    let made = ["simulate", "--machine", "machine.toml", "--input", "step:4V", "--out", "made.csv"];
    done(folder.path(), &made);
    // The rod stood 0.5 mm nearer to the retracted end than the middle of its play: the sensor shows less as soon as it is pushed.
    let (header, rows) = table(&folder.path().join("made.csv"));
    let moved = |row: &[f64]| if row[3] > 0.1501 { (row[3] - 5e-4).max(0.15) } else { row[3] };
    let noise = |index: usize| 1e-5 * ((index * 7919 % 13) as f64 - 6.0) / 6.0;
    let lines: Vec<String> = rows
        .iter()
        .enumerate()
        .map(|(index, row)| format!("{},{},{:.6}", row[0], row[1], moved(row) + noise(index)))
        .collect();
    assert!(header.starts_with("time [s],command [V],spool [1],position [m],"));
    let recorded = format!("time [s],command [V],position [m]\n{}\n", lines.join("\n"));
    std::fs::write(folder.path().join("run.csv"), recorded).unwrap();
    for out in ["out.csv", "out.parquet"] {
        let simulated = ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", out];
        let told = text(&run(folder.path(), &simulated).stderr);
        assert!(told.contains("the rod starts 0.50 mm on the retracted side of the middle of its play"), "{told}");
    }
    let (_, simulated) = table(&folder.path().join("out.csv"));
    let (last, expected) = (simulated[950][2], moved(&rows[950]));
    assert!((last - expected).abs() < 5e-5, "{last} {expected}");
}
