//! Which crate may depend on which: the edges of ARCHITECTURE.md, compared with the manifests.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::root;

/// The libraries, lowest first, with the workspace crates that each may depend on. A library must not use a crate that is not listed for it.
const ALLOWED: [(&str, &[&str]); 24] = [
    ("model-core", &[]),
    ("firmware", &["model-core"]),
    ("drive-c", &["model-core"]),
    ("cortex-m-stack", &[]),
    ("mps2-device", &[]),
    ("simulated-press", &["model-core", "firmware"]),
    ("mps2", &["model-core", "firmware", "cortex-m-stack", "simulated-press"]),
    ("recording", &[]),
    ("machine-file", &["model-core", "recording"]),
    ("virtual-plant", &["model-core", "recording", "machine-file"]),
    ("simulation", &["model-core", "recording", "machine-file"]),
    ("test-press", &["model-core", "recording", "machine-file", "simulation"]),
    ("model-export", &["model-core", "recording", "machine-file", "simulation"]),
    ("drive-fmu", &["model-core", "recording", "machine-file", "simulation", "model-export"]),
    ("identification", &["model-core", "recording", "machine-file", "simulation"]),
    ("watch", &["model-core", "firmware", "recording", "machine-file", "simulation", "identification"]),
    ("diagnosis", &["model-core", "recording", "machine-file", "simulation", "identification"]),
    ("experiment", &["model-core", "recording", "machine-file", "simulation", "identification", "diagnosis"]),
    (
        "report",
        &[
            "model-core",
            "recording",
            "machine-file",
            "simulation",
            "identification",
            "watch",
            "diagnosis",
            "experiment",
        ],
    ),
    (
        "fleet",
        &["model-core", "recording", "machine-file", "simulation", "identification", "watch", "diagnosis", "report"],
    ),
    ("trend", &["model-core", "recording", "machine-file", "diagnosis", "report", "fleet"]),
    (
        "host-sim-python",
        &[
            "model-core",
            "recording",
            "machine-file",
            "simulation",
            "identification",
            "watch",
            "diagnosis",
            "experiment",
            "report",
            "fleet",
        ],
    ),
    (
        "host-sim-studio",
        &[
            "model-core",
            "recording",
            "machine-file",
            "simulation",
            "identification",
            "diagnosis",
            "experiment",
            "report",
        ],
    ),
    ("studio-page", &[]),
];

/// Dependencies that only the program may have: its command line.
const OF_THE_PROGRAM: [&str; 2] = ["clap", "clap_complete"];

/// Dependencies that an FMU's library must not have, in itself and in every crate that it links.
const NOT_IN_AN_FMU: [&str; 4] = ["clap", "clap_complete", "plotters", "parquet"];

/// Beginnings of names of crates that the firmware's library must not have, in itself and in every crate that it links: a processor, a board, a debugger, an
/// end for panics, and the critical section, since only a board knows what may interrupt it.
const NOT_IN_THE_FIRMWARE: [&str; 10] = [
    "cortex",
    "riscv",
    "stm32",
    "critical-section",
    "semihosting",
    "defmt-semihosting",
    "defmt-rtt",
    "panic-",
    "volatile-register",
    "mps2",
];

/// A dependency as the manifest states it.
struct Dependency {
    name: String,
    is_for_tests: bool,
}

/// What cargo says of the workspace, from what is there already.
fn cargo(arguments: &str) -> String {
    let asked = Command::new(env!("CARGO"))
        .args(arguments.split(' '))
        .args(["--offline", "--manifest-path"])
        .arg(root().join("Cargo.toml"))
        .output()
        .unwrap();
    assert!(asked.status.success(), "{}", String::from_utf8_lossy(&asked.stderr));
    String::from_utf8(asked.stdout).unwrap()
}

/// The crates of the workspace, by the names that code calls them (some have another on crates.io), with their dependencies.
fn packages() -> BTreeMap<String, Vec<Dependency>> {
    let said = cargo("metadata --no-deps --format-version 1");
    let metadata: Value = serde_json::from_str(&said).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let dependency = |value: &Value| {
        let name = text(if value["rename"].is_null() { &value["name"] } else { &value["rename"] });
        Dependency { name, is_for_tests: value["kind"].as_str() == Some("dev") }
    };
    let package = |value: &Value| {
        let is_library = |target: &&Value| target["kind"].as_array().unwrap().iter().any(|kind| kind == "lib");
        let library = value["targets"].as_array().unwrap().iter().find(is_library);
        let name = library.map_or_else(|| text(&value["name"]), |library| text(&library["name"]).replace('_', "-"));
        let dependencies = value["dependencies"].as_array().unwrap().iter().map(dependency).collect();
        (name, dependencies)
    };
    metadata["packages"].as_array().unwrap().iter().map(package).collect()
}

/// Every Rust source below a folder, with its text.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            found.push((path, text));
        }
    }
    found
}

#[test]
fn every_crate_depends_only_on_those_that_it_may_see() {
    let packages = packages();
    for (name, allowed) in ALLOWED {
        for dependency in packages[name].iter().filter(|dependency| packages.contains_key(&dependency.name)) {
            let is_test_drive = dependency.is_for_tests && dependency.name == "test-press";
            assert!(
                is_test_drive || allowed.contains(&dependency.name.as_str()),
                "{name} depends on {}; expected of this workspace at most {allowed:?}",
                dependency.name
            );
        }
    }
}

#[test]
fn every_crate_of_host_sim_has_its_place() {
    for entry in std::fs::read_dir(root().join("host-sim/crates")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(ALLOWED.iter().any(|(known, _)| *known == name), "{name} is not in the list of what it may see");
    }
}

#[test]
fn what_is_published_says_what_crates_io_and_docs_rs_ask_for() {
    let said = cargo("metadata --no-deps --format-version 1");
    let metadata: Value = serde_json::from_str(&said).unwrap();
    let toolchain = std::fs::read_to_string(root().join("rust-toolchain.toml")).unwrap();
    let run = std::fs::read_to_string(root().join("tests/run")).unwrap();
    let (_, published) = run.split_once("published=(").unwrap();
    let published: BTreeSet<&str> = published.split(')').next().unwrap().split(' ').collect();
    let mut met = BTreeSet::new();
    for package in metadata["packages"].as_array().unwrap() {
        let name = package["name"].as_str().unwrap();
        // An empty list of registries: it goes to none.
        if package["publish"].is_array() {
            continue;
        }
        met.insert(name);
        let said = |key: &str| package[key].as_str().is_some_and(|text| !text.is_empty());
        for key in ["description", "license", "readme", "documentation", "rust_version"] {
            assert!(said(key), "{name} has no {key}");
        }
        for key in ["keywords", "categories"] {
            let count = package[key].as_array().unwrap().len();
            assert!((1..=5).contains(&count), "{name} has {count} {key}; crates.io takes 1 to 5");
        }
        assert!(package["metadata"]["docs"]["rs"].is_object(), "{name} does not say what docs.rs builds");
        // The checks are run by the oldest compiler that is promised.
        let oldest = package["rust_version"].as_str().unwrap();
        assert!(toolchain.contains(&format!("channel = \"{oldest}.")), "{name} promises Rust {oldest}: {toolchain}");
    }
    assert_eq!(met, published, "tests/run packs what is to be published");
}

#[test]
fn only_the_program_has_a_command_line() {
    let packages = packages();
    for (name, _) in ALLOWED {
        let has = |forbidden: &&str| packages[name].iter().any(|dependency| dependency.name == **forbidden);
        assert_eq!(OF_THE_PROGRAM.iter().find(|forbidden| has(forbidden)), None, "a dependency of {name}");
    }
}

#[test]
fn the_library_of_an_fmu_links_no_command_line_no_plots_and_no_parquet() {
    let tree = cargo("tree --locked --package drive-fmu --edges normal --prefix none --format {p}");
    let linked: Vec<&str> = tree.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(linked.contains(&"drive-simulation"), "{linked:?}");
    for forbidden in NOT_IN_AN_FMU {
        assert!(!linked.contains(&forbidden), "drive-fmu links {forbidden}");
    }
}

fn is_of_a_board(name: &str) -> bool {
    NOT_IN_THE_FIRMWARE.iter().any(|start| name.starts_with(start))
}

#[test]
fn the_library_of_the_firmware_links_no_processor_no_board_and_no_critical_section() {
    let linked = |features: &str, target: &str| -> Vec<String> {
        let asked = "tree --locked --package drive-firmware --edges normal --prefix none --format {p}";
        let tree = cargo(&format!("{asked} --features={features} --target {target}"));
        tree.lines().filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
    };
    for features in ["", "async", "defmt"] {
        let on_a_desktop = linked(features, "x86_64-unknown-linux-gnu");
        for target in ["thumbv7em-none-eabihf", "thumbv6m-none-eabi", "riscv32imac-unknown-none-elf"] {
            let linked = linked(features, target);
            assert!(linked.iter().any(|name| name == "model-core"), "{linked:?}");
            assert_eq!(linked.iter().find(|name| is_of_a_board(name)), None, "for {target}, features {features:?}");
            assert_eq!(linked, on_a_desktop, "the same for every target, not for {target}");
        }
    }
}

/// So that the test above can fail.
#[test]
fn an_emulated_board_has_what_the_firmware_must_not_have() {
    let packages = packages();
    let of_a_board: Vec<_> = packages["mps2"].iter().map(|of| &of.name).filter(|name| is_of_a_board(name)).collect();
    assert!(of_a_board.len() >= 4, "{of_a_board:?}");
}

#[test]
fn the_virtual_plant_takes_parameters_of_the_core_and_no_equation() {
    for (path, text) in sources(&root().join("host-sim/crates/virtual-plant/src")) {
        for (number, line) in text.lines().enumerate() {
            let (code, _) = line.split_once("//").unwrap_or((line, ""));
            for rest in code.split("model_core").skip(1) {
                assert!(
                    rest.starts_with("::machine::"),
                    "{}:{}: {}; expected of model-core `machine` alone",
                    path.display(),
                    number + 1,
                    line.trim()
                );
            }
        }
    }
}

/// Below `report` a type prints itself only where it is a name; what was found is put into sentences in `report::wording`.
#[test]
fn only_names_print_themselves_below_the_report() {
    const NAMES: [&str; 2] = ["Section", "Subsystem"];
    for folder in ["simulation", "identification", "diagnosis", "experiment"] {
        for (path, source) in sources(&root().join("host-sim/crates").join(folder).join("src")) {
            for line in source.lines().filter(|line| line.starts_with("impl ") && line.contains("Display for ")) {
                let name = line.rsplit("Display for ").next().unwrap_or_default().trim_end_matches(" {");
                assert!(NAMES.contains(&name), "{}: {line}", path.display());
            }
        }
    }
}

/// A public function that is generic over the number type would be compiled once more in every crate that calls it.
#[test]
fn no_public_function_of_simulation_is_generic_in_its_number() {
    for (path, text) in sources(&root().join("host-sim/crates/simulation/src")) {
        let public = text.lines().map(str::trim_start).filter(|line| line.starts_with("pub fn "));
        for line in public {
            let generic = ["Number", "Scalar", "Real", "Field"].iter().any(|of| line.contains(&format!(": {of}")));
            assert!(!generic, "{}: {line}", path.display());
        }
    }
}

/// From the number types of simulation, other crates use only the number of lanes, the single-precision derivative, and the processor check.
#[test]
fn the_numbers_of_simulation_stay_in_it() {
    let above = ["identification", "diagnosis", "experiment", "model-export", "report"];
    for folder in above.iter().map(|name| root().join("host-sim/crates").join(name).join("src")) {
        for (path, text) in sources(&folder) {
            for rest in text.split("simulation::number::").skip(1) {
                let taken = ["cpu", "simd::LANES", "dual::single"].iter().any(|taken| rest.starts_with(taken));
                assert!(taken, "{}: {}", path.display(), rest.lines().next().unwrap_or_default());
            }
        }
    }
}

/// `tests/run` names the tests that it runs and those that it leaves to `--all`: a new one must be in a list, or it would be left out in silence.
#[test]
fn every_test_is_in_a_list_of_the_test_command() {
    let script = std::fs::read_to_string(root().join("tests/run")).unwrap();
    let listed: Vec<&str> = ["short=(", "long=("]
        .iter()
        .flat_map(|list| script.split_once(list).unwrap().1.split_once(')').unwrap().0.split_whitespace())
        .collect();
    let metadata: Value = serde_json::from_str(&cargo("metadata --no-deps --format-version 1")).unwrap();
    let packages =
        metadata["packages"].as_array().unwrap().iter().filter(|package| package["name"] != "system-benches");
    for target in packages.flat_map(|package| package["targets"].as_array().unwrap()) {
        let name = target["name"].as_str().unwrap();
        if target["kind"][0] == "test" {
            assert!(listed.contains(&name), "{name} is in neither list of tests/run");
        }
    }
}
