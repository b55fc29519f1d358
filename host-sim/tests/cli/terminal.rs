//! What people see around the result: colours, notes, completions, suggestions.

use std::path::Path;
use std::process::Command;

use super::{MACHINE, at_hand, done, example, folder_with, refused, run, text};

/// What a command prints on a terminal of its own, its standard error set aside; `None` where no terminal can be had.
fn on_a_terminal(folder: &Path, variables: &str, arguments: &str) -> Option<String> {
    let line = format!("{variables} {} {arguments} 2>/dev/null", env!("CARGO_BIN_EXE_host-sim"));
    let clean = |command: &mut Command| {
        command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").env_remove("CI").env("TERM", "xterm").output()
    };
    let output = clean(Command::new("script").current_dir(folder).args(["-qec", &line, "/dev/null"]));
    if output.is_err() {
        at_hand::skipped("there is no `script`, which makes a terminal");
    }
    Some(text(&output.ok()?.stdout))
}

#[test]
fn the_verdict_is_coloured_on_a_terminal_unless_nobody_wants_colours() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, recording) = (example("machine.toml"), example("train-1.csv"));
    let compare = format!("compare --machine {machine} --recording {recording} --exit-code");
    let Some(coloured) = on_a_terminal(folder.path(), "", &compare) else { return };
    assert!(coloured.contains("\u{1b}[1m\u{1b}[31mout of tolerance"), "{coloured:?}");
    let plain = on_a_terminal(folder.path(), "NO_COLOR=1", &compare).unwrap();
    assert!(plain.contains("out of tolerance") && !plain.contains('\u{1b}'), "{plain:?}");
    let piped = run(folder.path(), &compare.split(' ').collect::<Vec<_>>());
    assert!(text(&piped.stdout).contains("out of tolerance") && !text(&piped.stdout).contains('\u{1b}'));
}

#[test]
fn quiet_prints_the_result_alone() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n0.1,4,0\n0.1,4,0\n0.2,4,0.1\n");
    let compare = ["compare", "--machine", "machine.toml", "--recording", "run.csv"];
    let simulate = ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "out.csv"];
    assert!(done(folder.path(), &compare).contains("note: run.csv: 1 row repeats"));
    assert!(text(&run(folder.path(), &simulate).stderr).contains("note: run.csv: 1 row repeats"));
    let quiet = done(folder.path(), &[&compare[..], &["--quiet"]].concat());
    assert!(quiet.contains("end to end") && !quiet.contains("note:"), "{quiet}");
    assert_eq!(text(&run(folder.path(), &[&["-q"][..], &simulate].concat()).stderr), "");
}

#[test]
fn verbose_says_what_was_found_and_where_the_time_went() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n0.1,4,0\n0.2,4,0.1\n");
    let fit = ["fit", "--machine", "machine.toml", "--train", "run.csv", "--save-machine", "f.toml", "--verbose"];
    let output = run(folder.path(), &fit);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("read: 1 recordings, 3 rows; 5 parameters may move") && said.contains("fitting: 0."),
        "{said}"
    );
    assert_eq!(run(folder.path(), &["paper", "--quiet", "--verbose"]).status.code(), Some(2));
}

#[test]
fn every_shell_gets_its_completions() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let script = done(folder.path(), &["completions", shell]);
        assert!(script.contains("diagnose") && script.contains("save-machine"), "{shell}");
    }
    let unknown = run(folder.path(), &["completions", "tcsh"]);
    assert!(unknown.status.code() == Some(2) && text(&unknown.stderr).contains("bash"));
}

#[test]
fn what_is_mistyped_is_met_with_the_nearest() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, nearest) in [
        (&["diagnos"][..], "'diagnose'"),
        (&["compare", "--machin", "M.toml"], "'--machine'"),
        (&["fit", "--save-machne", "F.toml"], "'--save-machine'"),
        (&["completions", "bsh"], "'bash'"),
    ] {
        let output = run(folder.path(), arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("similar") && message.contains(nearest), "{message}");
    }
}

#[test]
fn every_refusal_says_where_and_what_was_expected() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n1,0,1\n");
    for (command, place) in [
        ("init --bore 63bar", "--bore"),
        ("inspect none.csv", "none.csv"),
        ("simulate --machine machine.toml --input jump:4V --out s.csv", "jump"),
        ("simulate --machine machine.toml --input step:4Q --out s.csv", "4Q"),
        ("compare --machine machine.toml --recording none.csv", "none.csv"),
        ("fit --machine none.toml --train run.csv --save-machine f.toml", "none.toml"),
        ("diagnose none", "none"),
        ("statics --recording run.csv --input nothing --output position", "run.csv"),
        ("testbed --machine machine.toml --train step:4V,0.1s --effect rust=1 --out case", "--effect rust=1"),
        ("testbed draw --only rust --out cases", "--only rust"),
        ("export --machine none.toml --out p.rs", "none.toml"),
        ("import --frames none.bin --out r.csv", "none.bin"),
    ] {
        let message = refused(folder.path(), &command.split(' ').collect::<Vec<_>>());
        assert!(message.contains(place) && message.contains("expected"), "{command}: {message}");
    }
}
