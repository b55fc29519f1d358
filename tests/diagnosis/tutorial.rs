//! The tutorial's commands are run: the tutorial must show what they print and write. `RENEW=1` writes the printed blocks anew.
//!
//! In `docs/tutorial.md` a block ```` ```console ```` holds one command after `$` and all that it prints; a block
//! ```` ```toml after.toml ```` an excerpt of a file that a command has written or that is in the example's folder.

use std::fmt::Write;
use std::path::{MAIN_SEPARATOR, Path};

use super::shipped::by_two_threads;
use super::{done, root, text};

/// The only diagnosis, which the tests of the shipped case have already made.
const DIAGNOSIS: &str = "diagnose examples/press-63-40 --json d.json --save-machine after.toml --report d.html";

/// Runs a command of the tutorial; returns what it prints. Files that are not part of the repository lie in the scratch folder.
fn printed_by(command: &str, scratch: &Path) -> String {
    let arguments = command.strip_prefix("$ host-sim ").unwrap_or_else(|| panic!("`{command}` is no `$ host-sim …`"));
    if arguments == DIAGNOSIS {
        let written = by_two_threads();
        let files = [("d.json", &written.json), ("after.toml", &written.machine), ("d.html", &written.page)];
        for (name, content) in files {
            std::fs::write(scratch.join(name), content).unwrap();
        }
        return written.printed.clone();
    }
    let placed = |argument: &str| {
        if argument.starts_with("examples/") {
            text(&root().join(argument)).to_owned()
        } else if argument.contains('.') {
            text(&scratch.join(argument)).to_owned()
        } else {
            argument.to_owned()
        }
    };
    let placed: Vec<String> = arguments.split_whitespace().map(placed).collect();
    let printed = done(&placed.iter().map(String::as_str).collect::<Vec<_>>());
    printed.replace(&format!("{}{MAIN_SEPARATOR}", text(scratch)), "")
}

/// The text with every console block as it is printed now; panics where an excerpt is not in its file.
fn renewed(tutorial: &str, scratch: &Path) -> String {
    let mut renewed = String::new();
    let mut lines = tutorial.lines();
    while let Some(line) = lines.next() {
        writeln!(renewed, "{line}").unwrap();
        let Some(info) = line.strip_prefix("```") else { continue };
        let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        if info == "console" {
            writeln!(renewed, "{}", block[0]).unwrap();
            for printed in printed_by(block[0], scratch).trim_end().lines() {
                writeln!(renewed, "{}", printed.trim_end()).unwrap();
            }
        } else {
            if let Some((_, file)) = info.split_once(' ') {
                let written = scratch.join(file);
                let path = if written.exists() { written } else { root().join("examples/press-63-40").join(file) };
                let content = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
                assert!(content.contains(&block.join("\n")), "no such text in {file}:\n{}", block.join("\n"));
            }
            for shown in block {
                writeln!(renewed, "{shown}").unwrap();
            }
        }
        renewed.push_str("```\n");
    }
    renewed
}

#[test]
fn the_tutorial_shows_what_its_commands_print() {
    let path = root().join("docs/tutorial.md");
    let tutorial = std::fs::read_to_string(&path).unwrap();
    let scratch = tempfile::tempdir().unwrap();
    let renewed = renewed(&tutorial, scratch.path());
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(path, renewed).unwrap();
        return;
    }
    for (found, kept) in renewed.lines().zip(tutorial.lines()) {
        assert_eq!(found, kept, "RENEW=1 writes docs/tutorial.md anew");
    }
    assert_eq!(renewed, tutorial, "RENEW=1 writes docs/tutorial.md anew");
}
