//! What `inspect` says about recordings.

use std::fmt::Write as _;
use std::io::Write as _;

use recording::Signal;

use super::{MACHINE, done, example, folder_with, refused, root, run, text};

#[test]
fn the_shipped_recording_is_described_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let found = done(folder.path(), &["inspect", &example("train-1.csv"), "--machine", &example("machine.toml")]);
    let path = root().join("host-sim/tests/cli/inspect.txt");
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(&path, &found).unwrap();
    }
    assert_eq!(found, std::fs::read_to_string(path).unwrap());
}

#[test]
fn what_is_missing_to_test_a_link_is_named() {
    let recording = "time [s],command [V],Kolbenweg [mm]\n0,0,0\n0.1,1,1\n0.2,2,3\n0.3,0,3\n";
    let folder = folder_with(MACHINE, recording);
    let printed = done(folder.path(), &["inspect", "run.csv"]);
    assert!(printed.contains("valve     not: add spool"), "{printed}");
    assert!(
        printed.contains("ignored    Kolbenweg [mm]: no known signal; --map names them (`host-sim inspect --help`)"),
        "{printed}"
    );
    let mapped = done(folder.path(), &["inspect", "run.csv", "--map", "position=Kolbenweg [mm]"]);
    let expected = "judged by position; add spool, pressure_a, pressure_b to test it alone";
    assert!(mapped.contains(expected), "{mapped}");
}

#[test]
fn a_command_has_its_own_unit_until_a_machine_file_says_where_it_puts_the_spool() {
    let recording = "time [s],command [mA],position [mm]\n0,4,0\n0.1,-8,1\n0.2,2,3\n0.3,0,3\n";
    let folder = folder_with(MACHINE, recording);
    let printed = done(folder.path(), &["inspect", "run.csv"]);
    assert!(printed.contains("excited    command -8.00 … 4.00 mA;"), "{printed}");
    let row = printed.lines().find(|line| line.contains("command [mA]")).unwrap();
    assert!(row.contains(" mA "), "{row}");
    let folder = folder_with(MACHINE, &recording.replace("mA", "V"));
    let printed = done(folder.path(), &["inspect", "run.csv", "--machine", "machine.toml"]);
    assert!(printed.contains("command puts the spool at -44.7 … 22.4 %"), "{printed}");
}

#[test]
fn the_help_lists_every_name_that_a_column_can_be_mapped_to() {
    let folder = tempfile::tempdir().unwrap();
    let help = done(folder.path(), &["inspect", "--help"]);
    for signal in Signal::ALL {
        assert!(help.split_whitespace().any(|word| word == signal.name()), "{signal}: {help}");
    }
    let cells = "Zeit [ms];Kolbenweg [mm]\n0;1\n1;2\n";
    std::fs::write(folder.path().join("run.csv"), cells).unwrap();
    let message = refused(folder.path(), &["inspect", "run.csv"]);
    assert!(message.contains("--map \"time=Zeit [ms]\"; other columns as well"), "{message}");
}

#[test]
fn where_no_header_is_known_a_block_of_channels_is_guessed_that_can_be_pasted() {
    let rows = "0;10,5;0;50,5\n10;10,6;1;51\n20;10,7;2;51,5\n";
    let folder = folder_with(MACHINE, &format!("Zeit [ms];Kolbenweg [mm];U [V];Druck A [bar]\n{rows}"));
    let told = refused(folder.path(), &["inspect", "run.csv"]);
    let block = told.split_once("For the machine file, once checked:\n\n").unwrap().1;
    assert!(block.starts_with("[channels] # guessed from names, units and shapes: check every line\n"), "{block}");
    std::fs::write(folder.path().join("pasted.toml"), format!("{MACHINE}\n{block}")).unwrap();
    let printed = done(folder.path(), &["inspect", "run.csv", "--machine", "pasted.toml"]);
    for signal in ["command    U [V]", "position   Kolbenweg [mm]", "pressure_a   Druck A [bar]"] {
        let found = printed.lines().any(|line| {
            line.split_whitespace()
                .collect::<Vec<_>>()
                .join(" ")
                .starts_with(&signal.split_whitespace().collect::<Vec<_>>().join(" "))
        });
        assert!(found, "{signal}: {printed}");
    }
    // With a known time and nothing else, too.
    std::fs::write(folder.path().join("run.csv"), format!("time [ms];Kolbenweg [mm];U [V];p [bar]\n{rows}")).unwrap();
    let printed = done(folder.path(), &["inspect", "run.csv"]);
    assert!(printed.contains("position = \"Kolbenweg [mm]\""), "{printed}");
    // A block that was made for one logger does not break another.
    std::fs::write(folder.path().join("run.csv"), "time [s],position [mm],Kolbenweg\n0,1,9\n1,2,9\n2,3,9\n").unwrap();
    let printed = done(folder.path(), &["inspect", "run.csv", "--machine", "pasted.toml"]);
    assert!(printed.contains("position [mm]"), "{printed}");
}

#[test]
fn duplicates_gaps_and_wrong_units_are_told() {
    let mut recording = String::from("time [s],command [V],spool [1],position [mm],pressure_a [MPa]\n");
    for row in (0..400).filter(|row| !(200..250).contains(row)) {
        let time = f64::from(row) * 1e-3;
        writeln!(recording, "{time},2,0.05,{},{}", 100.0 + time, 35.0 + 0.1 * (time * 40.0).sin()).unwrap();
        if row == 100 {
            writeln!(recording, "{time},2,0.05,100.1,35").unwrap();
        }
    }
    let folder = folder_with(MACHINE, &recording);
    let printed = done(folder.path(), &["inspect", "run.csv", "--machine", "machine.toml"]);
    for part in [
        "1 row repeats the time before it",
        "1 gap in time, of 0.051 s",
        "50 rows missing",
        "spool is 5.00 % in every row",
        "pressure_a reaches 35.1 MPa, 1.5 times the supply pressure or more of the machine file: is its unit right?",
        "the valve never leaves the dead zone",
    ] {
        assert!(printed.contains(part), "{part}: {printed}");
    }
}

#[test]
fn a_recording_of_a_german_spreadsheet_is_read_and_what_was_guessed_is_said() {
    let folder = folder_with(MACHINE, "");
    let mut recording = b"time [\xb5s];command [V];Druck A \xfc [bar];position [mm]\r\n".to_vec();
    for row in 0..100_u32 {
        write!(recording, "{};1,5;{},5;{}\r\n", 1000 * row, 20 + row % 3, 100 + row).unwrap();
    }
    std::fs::write(folder.path().join("excel.csv"), recording).unwrap();
    let map = ["--map", "pressure_a=Druck A ü [bar]"];
    let printed = done(folder.path(), &[&["inspect", "excel.csv"][..], &map].concat());
    assert!(printed.contains("note: not UTF-8 from line 1 on: read as Windows-1252, as Excel writes it"), "{printed}");
    assert!(printed.contains("at 1000 Hz (1.00 ms)") && printed.contains("Druck A ü [bar]"), "{printed}");
}

#[test]
fn every_column_without_a_unit_is_named_at_once() {
    let folder = folder_with(MACHINE, "time [s],command,spool,position,pressure_a [bar]\n0,0,0,0,0\n1,1,1,1,1\n");
    let message = refused(folder.path(), &["inspect", "run.csv"]);
    assert!(message.contains("columns `command`, `position` have no unit"), "{message}");
    assert!(message.contains("`command` one of: V mV mA; `position` one of: m mm"), "{message}");
}

#[test]
fn headers_as_they_are_can_be_mapped_with_their_units() {
    let folder = folder_with(MACHINE, "Zeit (s),Weg (mm)\n0,1\n0.001,2\n");
    let message = refused(folder.path(), &["inspect", "run.csv"]);
    assert!(message.contains("--map \"time=Zeit (s)\"") && message.contains("begin with `#`"), "{message}");
    for [time, position] in [["Zeit (s) [s]", "Weg (mm) [mm]"], ["Zeit (s)", "Weg (mm)"], ["Zeit", "Weg [mm]"]] {
        let maps = ["--map", &format!("time={time}"), "--map", &format!("position={position}")];
        let printed = done(folder.path(), &[&["inspect", "run.csv"][..], &maps].concat());
        assert!(printed.contains(" position   Weg (mm)   1.000   2.000   mm "), "{printed}");
    }
}

#[test]
fn a_current_for_a_drive_in_volts_is_doubted_by_inspect_and_diagnose() {
    let mut recording = String::from("time [s],command [mA],position [mm]\n");
    for row in 0..400 {
        let (time, current) = (f64::from(row) * 5e-3, if row / 50 % 2 == 0 { 20 } else { 4 });
        writeln!(recording, "{time},{current},{}", 100.0 + 20.0 * (3.0 * time).sin()).unwrap();
    }
    let folder = folder_with(&MACHINE.replace("0.0559", "0.1"), &recording);
    let doubt = "by the machine file's gain_per_v it opens the valve to 200 % and never closes it";
    let printed = done(folder.path(), &["inspect", "run.csv", "--machine", "machine.toml"]);
    assert!(printed.contains(doubt), "{printed}");
    assert!(printed.contains("command puts the spool at 40.0 … 200 %"), "{printed}");
    for command in [
        "diagnose --machine machine.toml --train run.csv",
        "fit --machine machine.toml --save-machine f.toml --train run.csv",
    ] {
        let output = run(folder.path(), &command.split(' ').collect::<Vec<_>>());
        assert!(text(&output.stderr).contains(doubt), "{}", text(&output.stderr));
    }
    // Its advice helps.
    let channels = "\n[channels]\ncommand = { column = \"command [mA]\", zero = 12, full = 0.8 }\n";
    assert!(printed.contains(channels.lines().last().unwrap()), "{printed}");
    let machine = MACHINE.replace("0.0559", "0.1") + channels;
    std::fs::write(folder.path().join("machine.toml"), machine).unwrap();
    let printed = done(folder.path(), &["inspect", "run.csv", "--machine", "machine.toml"]);
    assert!(!printed.contains("gain_per_v") && printed.contains("-10.00   10.00   V "), "{printed}");
}

#[test]
fn a_page_leaves_the_names_of_the_file_s_columns_as_they_are() {
    // Another column is mapped to the signal, so that its own name is no signal's.
    let recording =
        "time [s],command [V],pressure_a,pressure_b note,pA [bar]\n0,0,1,x,50\n0.1,1,2,y,51\n0.2,2,3,z,52\n";
    let folder = folder_with(MACHINE, recording);
    done(folder.path(), &["inspect", "run.csv", "--map", "pressure_a=pA [bar]", "--report", "i.html"]);
    let page = std::fs::read_to_string(folder.path().join("i.html")).unwrap();
    assert!(page.contains("<bdi>pressure_b note</bdi>"), "{page}");
    let drawn: Vec<&str> =
        page.split("<text").skip(1).filter_map(|text| text.split_once('>')?.1.split('<').next()).collect();
    assert!(drawn.iter().any(|text| text.trim() == "pressure_a [unit unknown]"), "{drawn:?}");
    assert!(drawn.iter().any(|text| text.trim() == "Pressure A (pA) [bar]"), "{drawn:?}");
}

#[test]
fn the_same_is_written_for_programs() {
    let folder = tempfile::tempdir().unwrap();
    let recordings = [example("train-1.csv"), example("train-2.csv")];
    done(folder.path(), &["inspect", &recordings[0], &recordings[1], "--json", "i.json"]);
    let text = std::fs::read_to_string(folder.path().join("i.json")).unwrap();
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(found["schema"], "host-sim/inspection/1");
    let first = &found["recordings"][0];
    assert_eq!((&first["recording"], &first["source"]), (&"train-1.csv".into(), &"valve".into()));
    assert_eq!(first["links"][4]["tested"], "by-itself");
    assert_eq!(first["channels"][2]["signal"], "position");
    assert!(first["channels"][2]["step"].as_f64().unwrap() > 0.0);
    assert_eq!(found["recordings"].as_array().unwrap().len(), 2);
}

#[test]
fn what_cannot_be_read_is_refused_and_nothing_written_over_a_recording() {
    let folder = folder_with(MACHINE, "time [s],command [V]\n0,0\n1,x\n");
    assert!(refused(folder.path(), &["inspect", "run.csv", "--json", "i.json"]).contains("run.csv:3:3"));
    let message = refused(folder.path(), &["inspect", "run.csv", "--json", "run.csv"]);
    assert!(message.contains("would be written over"), "{message}");
}
