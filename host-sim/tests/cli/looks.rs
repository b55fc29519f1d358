//! What is looked at before anything is searched: recordings as arguments, pages of `inspect`, `compare` and `fit`, machine files beside each other.

use std::fs;
use std::path::Path;

use super::{done, example, refused, run, text};

#[test]
fn recordings_as_arguments_are_those_of_the_options() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (machine, one, two) = (example("machine.toml"), example("train-1.csv"), example("train-2.csv"));
    let drive = ["--machine", machine.as_str()];
    let told = |arguments: &[&str]| done(here, &[arguments, &drive].concat());
    assert_eq!(told(&["compare", &one, &two]), told(&["compare", "--recording", &one, &two]));
    assert_eq!(told(&["compare", &one, "--recording", &two]), told(&["compare", "--recording", &one, &two]));
    let fit = |given: &[&str]| told(&[&["fit", "--json", "-"], given].concat());
    assert_eq!(fit(&[&one]), fit(&["--train", &one]));
    let plan = |given: &[&str]| told(&[&["plan", "--seconds", "5", "--json", "-"], given].concat());
    assert_eq!(plan(&[&one]), plan(&["--recording", &one]));
    let both = refused(here, &[&["plan", &one, "--recording", &two][..], &drive].concat());
    assert!(both.contains("cannot be used with"), "{both}");
    let none = refused(here, &[&["compare"][..], &drive].concat());
    assert!(none.contains("<R.csv>"), "{none}");
}

#[test]
fn machine_files_are_compared_beside_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (machine, run_1) = (example("machine.toml"), example("holdout-1.csv"));
    let soft = fs::read_to_string(&machine).unwrap().replace("bulk_modulus_pa = 1.2e9", "bulk_modulus_pa = 0.8e9");
    fs::write(here.join("soft.toml"), soft).unwrap();
    let compare = ["compare", &run_1, "--machine", &machine, "--machine", "soft.toml"];
    let told = done(here, &[&compare[..], &["--json", "c.json", "--plot", "p.svg"]].concat());
    let alone = done(here, &["compare", &run_1, "--machine", &machine]);
    assert!(told.contains(&alone), "each is told as by itself: {told}");
    // One name in both files: they are called by their files.
    let (_, beside) = told.split_once("side by side, end to end, mean NRMSE fit %").unwrap();
    let words: Vec<&str> = beside.split_whitespace().filter(|word| !word.starts_with('─')).collect();
    assert_eq!(words[..3], ["signal", "machine", "soft"]);
    let fit = |signal: &str| -> [f64; 2] {
        let at = words.iter().position(|word| *word == signal).unwrap();
        [words[at + 1].parse().unwrap(), words[at + 2].parse().unwrap()]
    };
    assert!(fit("pressure_a")[0] > fit("pressure_a")[1] + 5.0, "{beside}");
    let drawn = fs::read_to_string(here.join("p.svg")).unwrap();
    assert!(drawn.contains("machine") && drawn.contains("soft"));
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(here.join("c.json")).unwrap()).unwrap();
    assert_eq!(json["machines"][1]["file"], "soft.toml");
    // Any of them out of tolerance is told with its name.
    let output = run(here, &[&compare[..], &["--exit-code", "--tolerance", "90"]].concat());
    assert_eq!(output.status.code(), Some(1));
    let verdict = text(&output.stdout);
    assert!(verdict.contains("soft, holdout-1.csv pressure_a (") && !verdict.contains("machine, holdout"), "{verdict}");
}

#[test]
fn a_fit_is_judged_by_what_was_held_out_and_not_by_what_it_was_fitted_to() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (machine, train, holdout) = (example("machine.toml"), example("train-1.csv"), example("holdout-1.csv"));
    let fit = ["fit", &train, "--machine", &machine];
    let alone = done(here, &[&fit[..], &["--save-machine", "a.toml"]].concat());
    let judged = done(here, &[&fit[..], &["--save-machine", "b.toml", "--holdout", &holdout]].concat());
    assert!(judged.contains("held out, NRMSE fit %") && !alone.contains("held out"), "{judged}");
    let read = |name: &str| fs::read_to_string(here.join(name)).unwrap();
    assert_eq!(read("a.toml"), read("b.toml"), "what is held out takes no part");
    let same = refused(here, &[&fit[..], &["--json", "-", "--holdout", &train]].concat());
    assert!(same.contains("held-out recordings that are not trained on"), "{same}");
    // Nothing needs to be saved.
    let told = done(here, &fit);
    assert!(told.contains("refitted parameter") && told.contains("valve.gain_per_v"), "{told}");
}

#[test]
fn a_fit_that_is_worse_on_what_was_held_out_says_so_first() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // Recordings of two drives: the machine file's is held out.
    let text = fs::read_to_string(example("machine.toml")).unwrap();
    fs::write(here.join("own.toml"), &text).unwrap();
    fs::write(here.join("other.toml"), text.replace("dead_zone = 0.", "dead_zone = 0.0")).unwrap();
    for (machine, recording) in [("own.toml", "own.csv"), ("other.toml", "other.csv")] {
        done(here, &["simulate", "--machine", machine, "--input", "steps:6V", "--out", recording]);
    }
    let fit = ["fit", "other.csv", "--machine", "own.toml", "--as-recorded", "--holdout", "own.csv"];
    let told = done(here, &[&fit[..], &["--json", "f.json", "--report", "f.html"]].concat());
    let worse = "The fit is worse than the machine file on recordings it has not seen: ";
    assert!(told.starts_with(worse) && told.contains("Do not use it"), "{told}");
    let document: serde_json::Value = serde_json::from_str(&fs::read_to_string(here.join("f.json")).unwrap()).unwrap();
    assert_eq!(document["held_out"]["is_worse"], true);
    assert!(document["held_out"]["sentence"].as_str().unwrap().starts_with(worse), "{document}");
    assert!(fs::read_to_string(here.join("f.html")).unwrap().contains(&format!("<h1 class=\"missing\">{worse}")));
}

/// A page holds no tag that a name brought, and nothing that is fetched.
fn check_page(path: &Path, machine: &str) {
    let page = fs::read_to_string(path).unwrap();
    assert!(page.contains("&lt;b&gt;&amp;") && !page.contains("<b>"), "{}: a name became markup", path.display());
    assert!(page.contains(machine), "{}", path.display());
    let page = page.replace("https://github.com/leeoniya/uPlot", "").replace("http://www.w3.org/2000/svg", "");
    assert!(
        page.contains("default-src 'none'") && !page.contains("http://") && !page.contains("https://"),
        "{}",
        path.display()
    );
    assert!(!page.contains("<link") && !page.contains("<img"), "{}", path.display());
}

#[test]
fn the_pages_escape_every_name_and_fetch_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let named = |name: &str| {
        let lines = fs::read_to_string(example("machine.toml")).unwrap();
        let lines = lines
            .lines()
            .map(|line| if line.starts_with("name") { format!("name = \"{name}\"") } else { line.to_owned() });
        lines.collect::<Vec<_>>().join("\n")
    };
    fs::write(here.join("m.toml"), named("<b>&m")).unwrap();
    fs::write(here.join("n.toml"), named("<b>&n")).unwrap();
    let recorded = fs::read_to_string(example("train-1.csv")).unwrap();
    let (header, rows) = recorded.split_once('\n').unwrap();
    let rows: String = rows.lines().flat_map(|row| [row, ",1\n"]).collect();
    fs::write(here.join("<b>&.csv"), format!("{header},<b>&odd [A]\n{rows}")).unwrap();
    let machines = ["--machine", "m.toml"];
    let with = |arguments: &[&str], page: &str| {
        done(here, &[arguments, &machines, &["--report", page]].concat());
    };
    with(&["inspect", "<b>&.csv"], "i.html");
    with(&["compare", "<b>&.csv", "--machine", "n.toml"], "c.html");
    with(&["fit", "<b>&.csv", "--holdout", &example("holdout-1.csv")], "f.html");
    for page in ["i.html", "c.html", "f.html"] {
        check_page(&here.join(page), "&lt;b&gt;&amp;m");
    }
    let inspected = fs::read_to_string(here.join("i.html")).unwrap();
    assert!(inspected.contains("\\u003cb\\u003e\\u0026odd"), "the channel that no signal is known for is drawn");
    let message = refused(here, &["inspect", "<b>&.csv", "--report", "i.csv"]);
    assert!(message.contains("--report") && message.contains(".html"), "{message}");
}
