//! The repository's README: it is short, its first command gives the result printed there, and its figure is what the tool draws.

use std::fs;
use std::path::Path;

use super::{done, root};

/// How the README's commands call the tool.
const TOOL: &str = "cargo run --release -- ";

/// The text between the first occurrences of two marks.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("no `{from}`"));
    rest.split_once(to).unwrap_or_else(|| panic!("no `{to}` after `{from}`")).0
}

/// A command's arguments, without its comment.
fn arguments(command: &str) -> Vec<&str> {
    let arguments = command.strip_prefix(TOOL).unwrap_or_else(|| panic!("`{command}` is no `{TOOL}…`"));
    arguments.split_whitespace().take_while(|word| *word != "#").collect()
}

/// The words of a text, each a space from the next, since the columns of a table may shift.
fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A folder with the shipped case at the same path as in the repository, and with a place for figures.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let case = Path::new("examples/press-63-40");
    fs::create_dir_all(folder.path().join(case)).unwrap();
    fs::create_dir_all(folder.path().join("docs/figures")).unwrap();
    for file in fs::read_dir(root().join(case)).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), folder.path().join(case).join(file.file_name())).unwrap();
    }
    folder
}

/// Set `RENEW` to draw the figure anew.
#[test]
fn the_readme_is_short_and_shows_what_its_commands_print_and_draw() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.lines().count() <= 150, "{} lines", readme.lines().count());
    assert_eq!(readme.matches("![").count(), 1, "one figure");
    let figure = between(between(&readme, "![", "\n"), "](", ")");
    let first = arguments(between(&readme, "```sh\n", "\n"));
    let drawing = arguments(between(&readme, "Drawn by `", "`"));
    // This allows one run for both commands.
    assert_eq!(drawing, [&first[..], &["--plot", figure]].concat());

    let folder = folder();
    let printed = words(&done(folder.path(), &drawing));
    for line in between(&readme, "```text\n", "```").lines() {
        assert!(printed.contains(&words(line)), "{line}\nis not in\n{printed}");
    }
    assert!(printed.contains("missing physics: internal-leakage"), "{printed}");
    let report =
        fs::read_to_string(folder.path().join(between(&readme, "It prints the finding and writes `", "`"))).unwrap();
    assert!(report.contains("internal-leakage") && report.trim_end().ends_with("</html>"));
    let drawn = fs::read(folder.path().join(figure)).unwrap();
    let figure = root().join(figure);
    if std::env::var_os("RENEW").is_some() {
        fs::write(&figure, &drawn).unwrap();
    }
    let shown = fs::read(&figure).unwrap();
    assert!(drawn == shown, "{} is not what its command draws; RENEW=1 draws it anew", figure.display());
}
