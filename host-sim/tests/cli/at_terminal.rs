//! Questions and output for a person at a terminal: with a real pseudo-terminal, because none of this appears in a pipe.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use rexpect::process::WaitStatus;
use rexpect::reader::Options;
use rexpect::session::{PtySession, spawn_with_options};

use machine_file::data_sheet::Item;

use super::{MACHINE, PRESS, at_hand, done, example, folder_with, listing, root};

/// The program at a terminal of its own, with the default action of signals (`nohup` and a shell's background ignore some of them); `None`
/// where no terminal is available.
fn at_terminal(folder: &Path, arguments: &[&str]) -> Option<PtySession> {
    const AS_USUAL: &str = "--default-signal=INT,TERM,HUP";
    if !Command::new("env").args([AS_USUAL, "true"]).output().is_ok_and(|output| output.status.success()) {
        at_hand::skipped("this `env` cannot give signals their usual meaning");
        return None;
    }
    let mut command = Command::new("env");
    command.arg(AS_USUAL).arg(env!("CARGO_BIN_EXE_host-sim")).args(arguments).current_dir(folder).env("TERM", "xterm");
    let options = Options::new().timeout_ms(Some(120_000)).strip_ansi_escape_codes(true);
    Some(spawn_with_options(command, options).unwrap())
}

/// Stops it as a person does, and returns its exit status.
fn interrupted(terminal: &mut PtySession) -> i32 {
    terminal.send_control('c').unwrap();
    terminal.exp_eof().unwrap();
    status(terminal)
}

fn status(terminal: &PtySession) -> i32 {
    match terminal.process().wait().unwrap() {
        WaitStatus::Exited(_, status) => status,
        other => panic!("{other:?}"),
    }
}

/// The answer to each question: the value of the flags, and an empty answer to all other questions.
fn answer(item: Item) -> &'static str {
    let flag = item.question().flag;
    let given = PRESS.windows(2).find(|pair| pair[0].strip_prefix("--") == Some(flag)).map(|pair| pair[1]);
    let joined = PRESS.iter().find_map(|word| word.strip_prefix("--")?.strip_prefix(flag)?.strip_prefix('='));
    given.or(joined).unwrap_or("")
}

#[test]
fn questions_that_are_answered_make_the_same_file_as_flags() {
    let (asked, flags) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let Some(mut terminal) = at_terminal(asked.path(), &["init", "--out", "press.toml"]) else { return };
    terminal.exp_string("What feeds the cylinder?").unwrap();
    terminal.send("\r").unwrap();
    terminal.flush().unwrap();
    terminal.exp_string("Diameter of the piston (63mm)").unwrap();
    // After a wrong answer the reason is shown, and the question is repeated.
    terminal.send_line("63bar").unwrap();
    terminal.exp_string("`bar` is not a unit of this quantity; expected one of m, mm").unwrap();
    for item in Item::ALL.iter().filter(|item| item.belongs(false) && **item != Item::HoseDiameter) {
        // Only the beginning, because a long question is broken at the end of the line.
        let question: String = item.question().what.chars().take(40).collect();
        terminal.exp_string(&question).unwrap();
        terminal.send_line(answer(*item)).unwrap();
    }
    terminal.exp_string("next       host-sim inspect run.csv --machine press.toml").unwrap();
    terminal.exp_eof().unwrap();
    assert_eq!(status(&terminal), 0);
    done(flags.path(), &PRESS);
    let text = |folder: &Path| std::fs::read_to_string(folder.join("press.toml")).unwrap();
    assert_eq!(text(asked.path()), text(flags.path()));
}

#[test]
fn a_question_that_is_interrupted_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut terminal) = at_terminal(folder.path(), &["init"]) else { return };
    terminal.exp_string("What feeds the cylinder?").unwrap();
    terminal.send("\r").unwrap();
    terminal.flush().unwrap();
    terminal.exp_string("Diameter of the piston").unwrap();
    assert_eq!(interrupted(&mut terminal), 130);
    assert!(listing(folder.path()).is_empty());
}

#[test]
fn what_takes_long_shows_the_time_left() {
    let folder = folder_with(MACHINE, "");
    let mut recording = String::from("time [s],command [V],position [m]\n");
    for row in 0..1_500_000_u32 {
        writeln!(recording, "{},{},0.{}", f64::from(row) * 1e-3, row % 7, row % 5).unwrap();
    }
    std::fs::write(folder.path().join("long.csv"), recording).unwrap();
    let trains = ["train-1.csv", "train-2.csv", "train-3.csv", "train-4.csv"].map(example);
    let machine = example("machine.toml");
    let fit = ["fit", "--machine", &machine, "--save-machine", "f.toml", "--train"];
    let fit: Vec<&str> = fit.into_iter().chain(trains.iter().map(String::as_str).cycle().take(40)).collect();
    let (shipped, preset) = (example(""), root().join("presets/press-63-40.toml").display().to_string());
    let diagnose = ["diagnose", &shipped, "--report", "d.html"];
    let testbed = ["testbed", "--machine", &preset, "--out", "case"].into_iter();
    let testbed: Vec<&str> = testbed.chain(["--train", "sweep:5V,0.5Hz,3Hz,20s"].repeat(60)).collect();
    for (arguments, shown) in [
        (&["inspect", "long.csv"][..], r"reading .* \d+ %, \d+(s|m|h) left"),
        (
            &["simulate", "--machine", "machine.toml", "--input", "random:10V,0.08s,0.5s,3600s", "--out", "s.csv"],
            r"simulating .* \d+ %, \d+(s|m|h) left",
        ),
        (&["compare", "--machine", "machine.toml", "--recording", "long.csv"], r"comparing .* \d+ %, \d+(s|m|h) left"),
        (&fit, r"fitting .* \d+ %, at most \d+(s|m|h) left"),
        (&diagnose, r"diagnosing .* \d+/\d+, \d+(s|m|h) left"),
        (
            &["plan", "--machine", "machine.toml", "--sensors", "position,pressure_a,pressure_b"],
            r"planning .* \d+/\d+, \d+(s|m|h) left",
        ),
        (&testbed, r"running the test bed .* \d+/\d+, \d+(s|m|h) left"),
        (&["testbed", "draw", "--count", "40", "--out", "cases"], r"drawing cases .* \d+/\d+, \d+(s|m|h) left"),
    ] {
        let Some(mut terminal) = at_terminal(folder.path(), arguments) else { return };
        let found = terminal.exp_regex(shown);
        assert!(found.is_ok(), "{arguments:?}: {found:?}");
        interrupted(&mut terminal);
    }
}
