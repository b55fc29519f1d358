//! Input that cannot be used: one clear message, exit status 2, no file.

use super::{MACHINE, at_hand, done, example, folder_with, refused};

const SIMULATE: [&str; 7] = ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "out.csv"];
const COMPARE: [&str; 7] = ["compare", "--machine", "machine.toml", "--recording", "run.csv", "--plot", "out.svg"];

/// The message on a recording; simulating and comparing must give the same.
fn on_recording(recording: &str) -> String {
    let folder = folder_with(MACHINE, recording);
    let message = refused(folder.path(), &SIMULATE);
    assert_eq!(message, refused(folder.path(), &COMPARE));
    message
}

#[test]
fn numbers_that_are_none_are_shown_with_their_line() {
    for bad in ["inf", "-Infinity", "1e999"] {
        let message = on_recording(&format!("time [s],command [V],position [m]\n0,0,0\n0.1,{bad},0\n0.2,0,1\n"));
        assert!(
            message.contains("run.csv:3:5") && message.contains(bad) && message.contains("finite number"),
            "{message}"
        );
    }
    let message = on_recording("time [s],command [V],position [m]\n0,0,0\n0.1,abc,0\n0.2,0,0\n");
    assert!(message.contains("`abc`") && message.contains("expected: a decimal number"), "{message}");
}

#[test]
fn a_recording_needs_two_rows() {
    assert!(on_recording("").contains("there is nothing in the file"));
    assert!(on_recording("time [s],command [V],position [m]\n").contains("a header and no rows"));
    assert!(on_recording("time [s],command [V],position [m]\n0,0,0\n").contains("1 row"));
}

#[test]
fn time_must_not_go_backwards() {
    let message = on_recording("time [s],command [V],position [m]\n0,0,0\n0.2,0,0\n0.1,0,1\n");
    assert!(message.contains("run.csv:4:1") && message.contains("time 0.1 s after 0.2 s"), "{message}");
}

#[test]
fn a_recording_that_is_too_long_is_named_with_its_duration_in_few_digits() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n0.001,0,0\n1.23e300,0,0.1\n");
    let diagnose = ["diagnose", "--machine", "machine.toml", "--train", "run.csv"];
    let fit = ["fit", "--machine", "machine.toml", "--train", "run.csv", "--save-machine", "f.toml"];
    for command in [&SIMULATE[..], &COMPARE, &diagnose, &fit] {
        let message = refused(folder.path(), command);
        let expected =
            "error: run.csv: 1.23e300 s, more than the simulation takes at a tick of 2 ms; expected at most 100000 s";
        assert!(message.contains(expected) && message.len() < 400, "{message}");
    }
}

#[test]
fn an_unknown_unit_names_the_known_ones() {
    let message = on_recording("time [s],command [V],position [furlong]\n0,0,0\n1,0,1\n");
    assert!(message.contains("`furlong`") && message.contains("m mm"), "{message}");
}

#[test]
fn a_constant_signal_is_simulated_but_not_judged() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0.1\n0.1,0,0.1\n0.2,1,0.1\n");
    done(folder.path(), &SIMULATE);
    let message = refused(folder.path(), &COMPARE);
    assert!(message.contains("position is 0.1 m in every row") && message.contains("expected"), "{message}");
}

#[test]
fn what_is_missing_is_named() {
    let folder = folder_with(MACHINE, "time [s],position [m]\n0,0.1\n0.1,0.2\n");
    let message = refused(folder.path(), &SIMULATE);
    assert!(
        message.contains("nothing drives the model")
            && message.contains("command, spool, flow, force or both chamber pressures"),
        "{message}"
    );
    let folder = folder_with(MACHINE, "time [s],command [V]\n0,1\n0.1,2\n");
    assert!(refused(folder.path(), &COMPARE).contains("nothing to compare"));
}

#[test]
fn errors_of_the_machine_file_show_their_line() {
    let recording = "time [s],command [V],position [m]\n0,0,0\n1,0,0.1\n";
    for (machine, expected) in [
        (MACHINE.replace("area_b_m2 = 1.861e-3\n", ""), "`cylinder.area_b_m2` is missing"),
        (MACHINE.replace("gain_per_v", "gain"), "unknown key `gain` in [valve]"),
        (MACHINE.replace("0.1049", "nan"), "`valve.dead_zone` is NaN\n"),
        (MACHINE.replace("= 7.0e6", "= \"70 bar\""), "`supply.pressure_pa` is of type string"),
        (MACHINE.replace("[supply]", "[supply"), "not TOML"),
    ] {
        let folder = folder_with(&machine, recording);
        let message = refused(folder.path(), &SIMULATE);
        assert!(message.contains(expected) && message.contains("machine.toml:"), "{message}");
        assert_eq!(message, refused(folder.path(), &COMPARE));
    }
    let recording = "time [s],command [V],position [m]\n0,0,0\n0.001,0,0.1\n";
    let folder = folder_with(&MACHINE.replace("gain_per_v = 0.0559", "transport_delay_s = 0.9"), recording);
    let message = refused(folder.path(), &SIMULATE);
    assert!(message.contains("machine.toml: valve.transport_delay_s = 0.9 s"), "{message}");
}

#[test]
fn arguments_that_make_no_sense_are_explained() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n1,0,1\n");
    for (extra, expected) in [
        (["--map", "position"], "has no `=`"),
        (["--map", "positon=x"], "did you mean `position`"),
        (["--map", "position=Weg [mm]"], "which is not a column of this file"),
    ] {
        let message = refused(folder.path(), &[&SIMULATE[..], &extra].concat());
        assert!(message.contains(expected), "{message}");
    }
    let input = ["simulate", "--machine", "machine.toml", "--out", "out.csv", "--input"];
    for (signal, expected) in [("jump:4V", "not known"), ("step:40V", "expected: -10 to 10 V"), ("step", "missing")] {
        let message = refused(folder.path(), &[&input[..], &[signal]].concat());
        assert!(message.contains(expected), "{message}");
    }
    let pump = "[supply]\npressure_pa = 7e6\n[pump]\n[cylinder]\narea_a_m2 = 2e-3\narea_b_m2 = 1e-3\n";
    let folder = folder_with(pump, "");
    assert!(refused(folder.path(), &[&input[..], &["step:4V"]].concat()).contains("expected a [valve]"));
}

#[test]
fn an_output_that_cannot_be_written_is_said() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n1,0,1\n");
    let with_out = |out| [&SIMULATE[..6], &[out]].concat();
    let message = refused(folder.path(), &with_out("no/such/folder/out.csv"));
    assert!(message.contains("no/such/folder/out.csv") && message.contains("expected a folder"), "{message}");
    let plot = [&COMPARE[..6], &["no/such/out.svg"]].concat();
    assert!(refused(folder.path(), &plot).contains("no/such/out.svg: cannot be written"));

    let closed = folder.path().join("closed");
    std::fs::create_dir(&closed).unwrap();
    let mut rights = std::fs::metadata(&closed).unwrap().permissions();
    rights.set_readonly(true);
    std::fs::set_permissions(&closed, rights).unwrap();
    if std::fs::write(closed.join("try"), "").is_ok() {
        at_hand::skipped("the read-only folder: this user may write everywhere");
        std::fs::remove_file(closed.join("try")).unwrap();
    } else {
        refused(folder.path(), &with_out("closed/out.csv"));
    }
    // A file where a folder should be.
    let message = refused(folder.path(), &with_out("run.csv/out.csv"));
    assert!(message.contains("cannot be written"), "{message}");
}

#[test]
fn a_failed_run_leaves_the_old_output_as_it_was() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\nbroken\n");
    std::fs::write(folder.path().join("out.csv"), "old").unwrap();
    refused(folder.path(), &SIMULATE);
    assert_eq!(std::fs::read_to_string(folder.path().join("out.csv")).unwrap(), "old");
}

#[test]
fn one_bad_recording_among_good_ones_leaves_no_plot() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n1,x,1\n");
    let good = example("train-1.csv");
    let arguments = ["compare", "--machine", "machine.toml", "--recording", &good, "run.csv", "--plot", "out.svg"];
    refused(folder.path(), &arguments);
}

/// Endless input through a pipe, with the program's memory limited: it must give up by itself.
#[cfg(unix)]
mod endless {
    use std::fs::OpenOptions;
    use std::io::Write;
    use std::process::Command;

    use super::{MACHINE, folder_with};

    /// The message on a recording that repeats `block` for ever; it is given 1 GB of memory.
    fn message_on(block: Vec<u8>) -> String {
        let folder = folder_with(MACHINE, "");
        let pipe = folder.path().join("garbage");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let mut command = Command::new("sh");
        let script = "ulimit -v 1000000; exec \"$0\" simulate --machine machine.toml --recording garbage --out out.csv";
        command.args(["-c", script, env!("CARGO_BIN_EXE_host-sim")]).current_dir(folder.path());
        let writer = std::thread::spawn(move || {
            let mut pipe = OpenOptions::new().write(true).open(pipe).unwrap();
            // Ends when the program closes the pipe, or at the latest after 10 GB.
            let blocks = 10_000_000_000 / block.len();
            (0..blocks).take_while(|_| pipe.write_all(&block).is_ok()).count() < blocks
        });
        let output = command.output().unwrap();
        let message = super::super::text(&output.stderr);
        assert!(writer.join().unwrap(), "all of it was read");
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(!folder.path().join("out.csv").exists());
        message
    }

    #[test]
    fn noise_is_no_text() {
        let mut state = 1_u64;
        let noise = (0..1 << 16).map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state.to_be_bytes()[0]
        });
        assert!(message_on(noise.collect()).contains("not UTF-8 text"));
    }

    #[test]
    fn a_line_without_end_is_given_up() {
        assert!(message_on(vec![b'x'; 1 << 16]).contains("a line of more than"));
    }

    #[test]
    fn blank_lines_without_end_are_given_up() {
        assert!(message_on(vec![b'\n'; 1 << 16]).contains("blank lines and comments"));
    }

    #[test]
    fn rows_of_nothing_known_are_given_up() {
        let message = message_on(b"1,2,3\n".repeat(1 << 13));
        assert!(message.contains("numbers where the header should be"), "{message}");
    }
}
