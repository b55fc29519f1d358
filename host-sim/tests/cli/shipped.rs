//! The shipped example, and what its documents print.

use super::{done, example, root, run, text};

/// The command in the example's README, as words.
fn documented_command() -> Vec<String> {
    let readme = std::fs::read_to_string(example("README.md")).unwrap();
    let (_, rest) = readme.split_once("```sh\n").unwrap();
    let command = rest.split_once("```").unwrap().0.replace("\\\n", " ");
    let mut words = Vec::new();
    for (index, part) in command.split('"').enumerate() {
        if index % 2 == 1 {
            words.push(part.to_owned());
        } else {
            words.extend(part.split_whitespace().map(str::to_owned));
        }
    }
    words
}

#[test]
fn a_fit_says_what_it_could_not_mend() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, train) = (example("machine.toml"), example("train-1.csv"));
    let fit = ["fit", "--machine", &machine, "--train", &train, "--save-machine", "fitted.toml"];
    let printed = done(folder.path(), &fit);
    assert!(printed.contains("What is left: ") && printed.contains("`host-sim diagnose` looks for"), "{printed}");
}

/// What a command wrote for programs.
fn written(path: &std::path::Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn a_fit_tells_programs_what_it_saves() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, train) = (example("machine.toml"), example("train-1.csv"));
    let fit = ["fit", "--machine", &machine, "--train", &train, "--save-machine", "fitted.toml", "--json", "f.json"];
    let printed = done(folder.path(), &fit);
    let told = written(&folder.path().join("f.json"));
    assert_eq!((&told["schema"], &told["converged"]), (&"host-sim/fit/1".into(), &true.into()));
    assert_eq!(told["left"]["is_above_noise"], true);
    assert!(printed.contains(told["left"]["sentence"].as_str().unwrap()), "{printed}");
    let saved: toml_edit::DocumentMut =
        std::fs::read_to_string(folder.path().join("fitted.toml")).unwrap().parse().unwrap();
    let mut found = 0;
    for parameter in told["parameters"].as_array().unwrap() {
        let Some((table, key)) = parameter["name"].as_str().unwrap().split_once('.') else { continue };
        let Some(value) = saved.get(table).and_then(|table| table.get(key)?.as_float()) else { continue };
        let told = parameter["value"].as_f64().unwrap();
        assert!((told - value).abs() <= 1e-5 * value.abs(), "{table}.{key}: {told} {value}");
        found += 1;
    }
    assert!(found >= 5, "{told}");
}

#[test]
fn a_comparison_tells_programs_the_fits_of_its_table() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, train) = (example("machine.toml"), example("train-1.csv"));
    let compare = ["compare", "--machine", &machine, "--recording", &train, "--json", "c.json"];
    let printed = done(folder.path(), &compare);
    let told = written(&folder.path().join("c.json"));
    assert_eq!(told["schema"], "host-sim/comparison/1");
    let sections = told["recordings"][0]["sections"].as_array().unwrap();
    assert!(sections.len() > 2 && sections[0]["section"] == "end to end", "{told}");
    for signal in sections.iter().flat_map(|section| section["signals"].as_array().unwrap()) {
        let r_squared = signal["r_squared"].as_f64().unwrap();
        assert!(printed.contains(&format!("{r_squared:.6}")), "{signal}\n{printed}");
    }
    let weakest = &told["weakest"];
    let named = format!("weakest is {}, {}", weakest["section"].as_str().unwrap(), weakest["signal"].as_str().unwrap());
    assert!(printed.contains(&named), "{named}\n{printed}");
}

#[test]
fn the_documented_command_makes_the_example_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut words = documented_command();
    assert_eq!(words.remove(0), "host-sim");
    let out = words.iter().position(|word| word == "--out").unwrap() + 1;
    words[out] = folder.path().display().to_string();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    assert_eq!(done(&root(), &words).lines().count(), 6);
    let mut bytes = 0;
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let (made, shipped) = (folder.path().join(&name), example(&name));
        let (made, shipped) = (std::fs::read_to_string(made).unwrap(), std::fs::read_to_string(shipped).unwrap());
        bytes += shipped.len();
        if made != shipped {
            // Another platform may round the last bit differently, which moves a sensor by one of its steps.
            agree(&name, &made, &shipped);
        }
    }
    assert!(bytes < 500_000, "{bytes}");
}

fn agree(name: &str, made: &str, shipped: &str) {
    let steps = [1e-9, 1e-4, 3.2e-5, 2.6e-5, 770.0, 770.0];
    assert_eq!(made.lines().next(), shipped.lines().next(), "{name}");
    assert_eq!(made.lines().count(), shipped.lines().count(), "{name}");
    for (line, (made, shipped)) in made.lines().zip(shipped.lines()).enumerate().skip(1) {
        for ((made, shipped), step) in made.split(',').zip(shipped.split(',')).zip(steps) {
            let number = |cell: &str| cell.parse::<f64>().unwrap();
            assert!((number(made) - number(shipped)).abs() <= step, "{name}:{}: {made} {shipped}", line + 1);
        }
    }
}

/// Renew with `RENEW=1`.
#[test]
fn the_table_of_a_comparison_is_as_it_was() {
    let (machine, first, second) = (example("machine.toml"), example("train-1.csv"), example("holdout-1.csv"));
    let found = done(&root(), &["compare", "--machine", &machine, "--recording", &first, &second]);
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/compare.txt");
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(&path, &found).unwrap();
    }
    assert_eq!(found, std::fs::read_to_string(path).unwrap());
}

#[test]
fn the_exit_code_tells_whether_every_signal_is_in_tolerance() {
    let (machine, recording) = (example("machine.toml"), example("train-1.csv"));
    let arguments = ["compare", "--machine", &machine, "--recording", &recording, "--exit-code", "--tolerance"];
    let answer = |tolerance: &str| {
        let output = run(&root(), &[&arguments[..], &[tolerance]].concat());
        (output.status.code(), text(&output.stdout).lines().last().unwrap().to_owned())
    };
    let (code, line) = answer("50");
    assert_eq!((code, line.starts_with("in tolerance")), (Some(0), true));
    let (code, line) = answer("95");
    assert_eq!((code, line.starts_with("out of tolerance: below 95 %")), (Some(1), true));
    assert!(line.contains("train-1.csv pressure_a (") && !line.contains("spool"), "{line}");
    assert_eq!(answer("90").0, Some(1));
    let output = run(&root(), &[&arguments[..], &["101"]].concat());
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_comparison_says_what_it_cannot_tell() {
    let folder = tempfile::tempdir().unwrap();
    let full = std::fs::read_to_string(example("train-1.csv")).unwrap();
    let keep = |columns: &[usize]| -> String {
        let line = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            columns.iter().map(|column| cells[*column]).collect::<Vec<_>>().join(",") + "\n"
        };
        full.lines().map(line).collect()
    };
    let answer = |columns: &[usize]| {
        std::fs::write(folder.path().join("run.csv"), keep(columns)).unwrap();
        done(folder.path(), &["compare", "--machine", &example("machine.toml"), "--recording", "run.csv"])
    };
    let all = answer(&[0, 1, 2, 3, 4, 5]);
    assert!(all.contains("mechanics") && !all.contains("record `"), "{all}");
    let without_pressures = answer(&[0, 1, 2, 3]);
    assert!(without_pressures.contains("(`pressure_a`, `pressure_b`)"), "{without_pressures}");
    let position_only = answer(&[0, 1, 3]);
    assert!(
        position_only.contains("the whole chain") && position_only.contains("record `spool` for this"),
        "{position_only}"
    );
}

#[test]
fn several_recordings_give_a_plot_each() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, first, second) = (example("machine.toml"), example("train-3.csv"), example("train-4.csv"));
    let compare = |recordings: &[&str]| {
        let arguments = [&["compare", "--machine", &machine, "--plot", "p.svg", "--recording"], recordings].concat();
        done(folder.path(), &arguments);
    };
    compare(&[&first]);
    compare(&[&first, &second]);
    compare(&[&first, &first]);
    let mut names: Vec<String> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["p-1-train-3.svg", "p-2-train-3.svg", "p-train-3.svg", "p-train-4.svg", "p.svg"]);
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("p.svg"), read("p-train-3.svg"), "the same every time");
}

#[test]
fn the_papers_tables_stand_beside_the_papers_figures() {
    let printed = done(&root(), &["paper"]);
    for expected in
        ["synthetic", "Table 1", "Table 2", "94.20", "99.42", "0.0559 U + 0.0345", "NRMSE fit", "does not have"]
    {
        assert!(printed.contains(expected), "{expected} in {printed}");
    }
}

#[test]
fn a_search_that_its_limit_has_ended_is_done_and_says_what_it_did_not_try() {
    let folder = tempfile::tempdir().unwrap();
    let [machine, one, two] = ["machine.toml", "train-1.csv", "train-2.csv"].map(example);
    let diagnose = ["diagnose", "--machine", &machine, "--train", &one, &two, "--time-limit", "0.01"];
    let output = run(folder.path(), &diagnose);
    assert_eq!(output.status.code(), Some(0));
    let printed = text(&output.stdout);
    let first = printed.lines().next().unwrap();
    assert!(first.contains("unexplained so far") && first.contains("reached its limit of 0.0100 s"), "{first}");
    assert!(printed.contains("\nnot tried  ") && printed.contains("single effects"), "{printed}");
    let with_code = run(folder.path(), &[diagnose.as_slice(), &["--exit-code"]].concat());
    assert_eq!(with_code.status.code(), Some(1));
    let help = text(&run(folder.path(), &["diagnose", "--help"]).stdout);
    assert!(help.contains("--time-limit <s>") && help.contains("[default: 300]"), "{help}");
}
