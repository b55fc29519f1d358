//! What a user sees around the result: colours, notes, completions, suggestions.

use std::path::Path;
use std::process::Command;

use super::{MACHINE, at_hand, done, example, folder_with, refused, run, text};

/// What a command prints on a terminal of its own, without its standard error; `None` where no terminal is available.
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

/// A table is as wide as the terminal, so that the terminal does not break its lines.
#[test]
fn tables_fit_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, recording) = (example("machine.toml"), example("train-1.csv"));
    for arguments in [
        format!("compare --machine {machine} --recording {recording}"),
        format!("inspect {recording} --machine {machine}"),
    ] {
        let Some(shown) = on_a_terminal(folder.path(), "stty cols 80 rows 24;", &arguments) else { return };
        // The width is the same for users who want no colours.
        let colourless = on_a_terminal(folder.path(), "stty cols 80 rows 24; NO_COLOR=1", &arguments).unwrap();
        assert_eq!(colourless, shown.replace("\u{1b}[1m", "").replace("\u{1b}[0m", ""));
        let plain = |line: &str| line.replace("\u{1b}[1m", "").replace("\u{1b}[0m", "").trim_end().chars().count();
        let rows = shown.lines().skip_while(|line| !line.contains('─')).take_while(|line| !line.contains(": weakest"));
        let table: Vec<usize> = rows.take_while(|line| !line.starts_with("tests")).map(plain).collect();
        assert!(table.len() > 6 && table.iter().all(|width| *width <= 80), "{shown}");
    }
}

/// The row that `compare` shows in bold contains the terminal's control sequence; a control sequence in a name is printed as text.
#[test]
fn the_weakest_row_is_bold_on_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(example("train-1.csv"), folder.path().join("r\u{1b}[2Jun.csv")).unwrap();
    let compare = format!("compare --machine {} --recording r*un.csv", example("machine.toml"));
    let Some(shown) = on_a_terminal(folder.path(), "", &compare) else { return };
    let bold = shown.lines().find(|line| line.contains("\u{1b}[1m")).unwrap_or_else(|| panic!("{shown:?}"));
    let weakest = shown.lines().find_map(|line| line.split_once("weakest is ")?.1.split_once(',')).unwrap();
    let signal = weakest.1.split(" at ").next().unwrap().trim();
    assert!(bold.contains(signal), "{bold:?}: {weakest:?}");
    assert!(shown.contains(r"r\u{1b}[2Jun.csv") && !shown.contains(r"\u{1b}[1m"), "{shown:?}");
    assert!(!shown.contains("\u{1b}[2J"), "{shown:?}");
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
    // In a real shell: the completions that it would offer for a line that ends here.
    let line = "source <(\"$0\" completions bash) && COMP_WORDS=(host-sim diagnose --sa) COMP_CWORD=2 && \
        _host__sim host-sim --sa diagnose && echo \"${COMPREPLY[@]}\"";
    match Command::new("bash").args(["-c", line, env!("CARGO_BIN_EXE_host-sim")]).output() {
        Ok(offered) => assert_eq!(text(&offered.stdout), "--save-machine\n", "{}", text(&offered.stderr)),
        Err(_) => at_hand::skipped("there is no bash to complete in"),
    }
    let unknown = run(folder.path(), &["completions", "tcsh"]);
    assert!(unknown.status.code() == Some(2) && text(&unknown.stderr).contains("bash"));
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let printed = done(folder.path(), &["man"]);
    assert!(printed.contains(".TH host-sim 1") && printed.contains("diagnose"), "{printed}");
    let written = done(folder.path(), &["man", "--out", "man1"]);
    let help = done(folder.path(), &["--help"]);
    let commands = help.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with([' ', '-']));
    let commands: Vec<&str> =
        commands.filter_map(|line| line.split(' ').next()).filter(|name| *name != "help").collect();
    assert!(commands.contains(&"diagnose") && commands.contains(&"man"), "{commands:?}");
    for command in commands {
        let page = std::fs::read_to_string(folder.path().join(format!("man1/host-sim-{command}.1"))).unwrap();
        assert!(page.contains(".SH OPTIONS") && page.contains("Example"), "{command}: {page}");
        assert!(written.contains(&format!("host-sim-{command}.1")), "{written}");
    }
}

#[test]
fn what_is_mistyped_is_met_with_the_nearest() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, nearest) in [
        (&["diagnos"][..], "'diagnose'"),
        (&["compare", "--machin", "M.toml"], "'--machine'"),
        (&["fit", "--save-machne", "F.toml"], "'--save-machine'"),
        (&["completions", "bsh"], "`bash`"),
    ] {
        let output = run(folder.path(), arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("similar") && message.contains(nearest), "{message}");
    }
}

/// The message shows the command line as a compiler shows a line of source.
#[test]
fn a_value_that_is_wrong_is_marked_on_the_command_line() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n1,0,1\n");
    let message = refused(folder.path(), &["testbed", "--machine", "machine.toml", "--tick", "0", "--out", "case"]);
    let expected = "\
error: `0` is not a value of --tick
 --> command line:1:48
  |
1 | host-sim testbed --machine machine.toml --tick 0 --out case
  |                                                ^
  |
  = expected: one of 0.5, 1, 2; a similar one is `0.5`
";
    assert_eq!(message, expected);
}

/// Refused commands, each with its message, the marked characters, and what was expected.
const WRONG: &[(&str, &str, &str, &str)] = &[
    (
        "testbed --machine machine.toml --train step:4V,0.1s --effect rust=1 --out case",
        "--effect rust=1: no effect of the test bed",
        "rust=1",
        "one of hose-compliance [m3/Pa]",
    ),
    (
        "testbed --machine machine.toml --train jump:4V --out case",
        "\"jump\" is not known",
        "jump:4V",
        "one of zero, step",
    ),
    (
        "simulate --machine machine.toml --input step:4Q --out s.csv",
        "\"4Q\" is not known",
        "4Q",
        "a number with unit V",
    ),
    (
        "simulate --machine machine.toml --input=step:40V --out s.csv",
        "the amplitude is 40 V",
        "step:40V",
        "-10 to 10 V",
    ),
    (
        "simulate --machine machine.toml --recording run.csv --map positon=x --out s.csv",
        "`positon`",
        "positon",
        "one of time command",
    ),
    (
        "compare --machine machine.toml --recording run.csv --map position=Weg",
        "which is not a column",
        "Weg",
        "one of its headers: time [s]",
    ),
    (
        "compare --machine machine.toml --recording run.csv --judge spol",
        "`spol` is not a known signal",
        "spol",
        "one of time command",
    ),
    (
        "compare --machine machine.toml --recording run.csv --judge spool",
        "spool cannot be judged",
        "spool",
        "some of: position",
    ),
    (
        "compare --machine machine.toml --recording run.csv --exit-code --tolerance 9x",
        "`9x` is not a number",
        "9x",
        "a number",
    ),
    (
        "compare --machine machine.toml --recording run.csv --exit-code --tolerance 900",
        "--tolerance is 900",
        "900",
        "at most 100 %",
    ),
    ("diagnose --time-limit 0 folder", "`0` is no limit of time", "0", "seconds above 0, such as 300"),
    ("diagnose --time-limit -5 folder", "`-5` is no limit of time", "-5", "seconds above 0, such as 300"),
    ("diagnose --time-limit nan folder", "`nan` is no limit of time", "nan", "seconds above 0, such as 300"),
    ("diagnose --time-limit inf folder", "`inf` is no limit of time", "inf", "seconds above 0, such as 300"),
    ("diagnose --time-limit 5min folder", "`5min` is no limit of time", "5min", "seconds above 0, such as 300"),
    (
        "plan --machine machine.toml --sensors position,pressure_a:3mm",
        "noise `3mm` of pressure_a",
        "3mm",
        "a positive number with a unit",
    ),
    (
        "statics --recording run.csv --input nothing --output position",
        "run.csv: `nothing` is not a column",
        "nothing",
        "one of its headers",
    ),
    ("testbed draw --count 0 --out cases", "`0` is out of range", "0", "a whole number in 1..=1000"),
    ("testbed draw --only rust --out cases", "--only rust", "rust", "one of valve-hysteresis"),
    (
        "export --machine machine.toml --out p.c --library l.so",
        "its name does not say what it is",
        "p.c",
        "one that ends in .rs",
    ),
    (
        "export --machine machine.toml --out p.rs --library l.so",
        "--library: only an FMU has it",
        "--library",
        "--out with .fmu",
    ),
    ("init --bore 63mm --rod 40bar", "`bar` is not a unit of this quantity", "40bar", "one of m, mm"),
];

#[test]
fn every_option_that_is_wrong_is_marked_where_it_stands() {
    let folder = folder_with(MACHINE, "time [s],command [V],position [m]\n0,0,0\n1,0,1\n2,1,2\n3,2,3\n4,1,4\n5,0,5\n");
    for &(command, title, carets, expected) in WRONG {
        let message = refused(folder.path(), &command.split(' ').collect::<Vec<_>>());
        let line = message.lines().position(|line| line == format!("1 | host-sim {command}"));
        let line = line.unwrap_or_else(|| panic!("{command}: {message}"));
        let (shown, marks) = (message.lines().nth(line).unwrap(), message.lines().nth(line + 1).unwrap());
        let marked: String =
            shown.chars().zip(marks.chars()).filter(|(_, mark)| *mark == '^').map(|(shown, _)| shown).collect();
        assert_eq!(marked, carets, "{message}");
        assert!(message.contains(title) && message.contains(&format!("= expected: {expected}")), "{message}");
    }
}

#[test]
fn diagnose_without_arguments_shows_both_ways_to_call_it() {
    let folder = tempfile::tempdir().unwrap();
    let message = refused(folder.path(), &["diagnose"]);
    assert!(message.contains("diagnose [OPTIONS] <FOLDER>"), "{message}");
    assert!(message.contains("--machine <M.toml> --train <R.csv>... [--holdout <R.csv>...]"), "{message}");
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

#[test]
fn the_help_of_a_command_fits_a_screen_and_what_is_longer_stands_in_its_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let help = done(folder.path(), &["--help"]);
    let commands = help.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with([' ', '-']));
    for command in commands.filter_map(|line| line.split(' ').next()).filter(|name| *name != "help") {
        let help = done(folder.path(), &[command, "--help"]);
        let widest = help.lines().map(|line| line.chars().count()).max();
        // The data sheet has as many questions as it has.
        let most = if command == "init" { 55 } else { 45 };
        assert!(help.lines().count() <= most && widest <= Some(100), "{command}: {widest:?} columns, {help}");
        let manual = done(folder.path(), &["man", command]);
        assert!(
            manual.contains(&format!("host\\-sim\\-{command}")) || manual.contains(&format!("host-sim-{command}")),
            "{manual}"
        );
    }
}
