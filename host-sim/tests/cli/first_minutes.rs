//! The tutorial: every command of `docs/first-minutes.md` runs and prints what the document shows.

use std::path::Path;
use std::process::Command;

use super::{root, text};

/// What a shell prints for a command line of the document.
fn printed(folder: &Path, command: &str) -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_host-sim")).parent().unwrap();
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::env::join_paths([program.to_owned()].into_iter().chain(std::env::split_paths(&paths))).unwrap();
    let output = Command::new("sh").args(["-c", command]).current_dir(folder).env("PATH", paths).output().unwrap();
    assert!(output.status.success(), "{command}: {}", text(&output.stderr));
    let lines = text(&output.stdout);
    lines.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

/// Set `RENEW` to write the document anew.
#[test]
fn the_tutorial_shows_what_the_tool_prints() {
    const COMMAND: &str = "```sh\n";
    let path = root().join("docs/first-minutes.md");
    let document = std::fs::read_to_string(&path).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("presets")).unwrap();
    let preset = "presets/press-63-40-installed.toml";
    std::fs::copy(root().join(preset), folder.path().join(preset)).unwrap();

    let mut parts = document.split(COMMAND);
    let mut renewed = parts.next().unwrap_or_default().to_owned();
    let mut commands = 0;
    for part in parts {
        let (command, after) = part.split_once("\n```\n").unwrap();
        let found = printed(folder.path(), command);
        commands += 1;
        renewed += COMMAND;
        renewed += command;
        renewed += "\n```\n";
        let (shown, rest) = match after.strip_prefix("\n```text\n").and_then(|after| after.split_once("\n```\n")) {
            Some((_, rest)) => (format!("\n```text\n{}\n```\n", found.trim_end()), rest),
            None => (String::new(), after),
        };
        renewed += &shown;
        renewed += &with_file(folder.path(), rest);
    }
    assert!(commands >= 7, "{commands}");
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(&path, &renewed).unwrap();
    }
    for (stands, prints) in document.lines().zip(renewed.lines()) {
        assert_eq!(stands, prints);
    }
    assert_eq!(document.lines().count(), renewed.lines().count());
}

/// The machine file that `init` wrote, where the document shows it.
fn with_file(folder: &Path, rest: &str) -> String {
    const FILE: &str = "```toml\n";
    let Some((before, after)) = rest.split_once(FILE) else { return rest.to_owned() };
    let (_, after) = after.split_once("\n```\n").unwrap();
    let written = std::fs::read_to_string(folder.join("press.toml")).unwrap();
    format!("{before}{FILE}{}\n```\n{after}", written.trim_end())
}
