//! The shipped example, as the README's first command diagnoses it: 2·10⁻¹² m³/s/Pa of internal leakage.

use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::sync::OnceLock;

use serde_json::Value;

use identification::experiment::Prepared;
use recording::{ChannelMap, Signal};
use system_tests::page::without_its_making;

use super::{done, root, text};

/// The effect that was put in, according to its README.
const EFFECT: &str = "internal-leakage";
const CONDUCTANCE: f64 = 2.0e-12;

/// The files that one diagnosis wrote.
pub(super) struct Written {
    pub(super) json: String,
    pub(super) machine: String,
    pub(super) page: String,
    /// The files' names in it are without the output folder.
    pub(super) printed: String,
}

fn folder() -> PathBuf {
    root().join("examples/press-63-40")
}

/// Diagnoses the example in a pool of this number of threads.
fn diagnosed(threads: usize) -> Written {
    let out = tempfile::tempdir().unwrap();
    let [json, machine, page] = ["d.json", "after.toml", "d.html"].map(|name| out.path().join(name));
    let run = || {
        let example = folder();
        let arguments = ["diagnose", text(&example), "--json", text(&json), "--save-machine", text(&machine)];
        done(&[&arguments[..], &["--report", text(&page)]].concat())
    };
    let printed = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
    let printed = printed.replace(&format!("{}{MAIN_SEPARATOR}", text(out.path())), "");
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    Written { json: read(&json), machine: read(&machine), page: read(&page), printed }
}

pub(super) fn by_two_threads() -> &'static Written {
    static WRITTEN: OnceLock<Written> = OnceLock::new();
    WRITTEN.get_or_init(|| diagnosed(2))
}

fn document() -> Value {
    serde_json::from_str(&by_two_threads().json).unwrap()
}

#[test]
fn the_examples_effect_is_named_with_its_effect_parameter_and_its_place() {
    let document = document();
    assert_eq!(document["verdict"], "missing-physics");
    assert_eq!(document["findings"].as_array().unwrap().len(), 1, "{document:#}");
    let finding = &document["findings"][0];
    assert_eq!(finding["effect"], EFFECT);
    assert_eq!(finding["subsystem"], "chambers");
    assert_eq!(document["located"]["subsystem"], "chambers");
    let found = finding["parameters"][0]["value"].as_f64().unwrap();
    assert!((found / CONDUCTANCE - 1.0).abs() < 0.15, "{found:e} where {CONDUCTANCE:e} was put in");
    assert!(finding["confidence"].as_f64().unwrap() > 0.5);
    assert!(by_two_threads().printed.contains(EFFECT));
}

#[test]
fn what_was_held_out_is_followed_better_with_the_effect() {
    let document = document();
    let fit = &document["fit"]["holdout"];
    for (signal, before) in fit["before"].as_object().unwrap() {
        let number = |value: &Value| value.as_f64().unwrap();
        let (before, after, floor) =
            (number(before), number(&fit["after"][signal]), number(&fit["noise_floor"][signal]));
        println!("held out, {signal}: {before} % before, {after} % after, {floor} % at the noise");
        // The spool does not depend on leakage.
        if signal != "spool" {
            assert!(after > before, "{signal}: {before} {after}");
            assert!(floor - after < 0.5 * (floor - before), "{signal}: {before} {after} {floor}");
        }
    }
}

/// Keys and types of the contract, each as a JSON pointer into the document.
#[test]
fn the_json_has_the_contracts_keys_and_types() {
    let document = document();
    let at = |pointer: &str| document.pointer(pointer).unwrap_or_else(|| panic!("no {pointer}"));
    assert_eq!(at("/schema"), "host-sim/diagnosis/1");
    let strings = [
        "/verdict",
        "/located/subsystem",
        "/located/signal",
        "/located/region",
        "/located/intervals/0/recording",
        "/findings/0/effect",
        "/findings/0/subsystem",
        "/findings/0/separated_by",
        "/findings/0/parameters/0/name",
        "/findings/0/parameters/0/unit",
    ];
    for pointer in strings {
        assert!(!at(pointer).as_str().unwrap().is_empty(), "{pointer}");
    }
    let numbers = [
        "/located/intervals/0/from_s",
        "/located/intervals/0/to_s",
        "/findings/0/parameters/0/value",
        "/findings/0/parameters/0/std",
    ];
    for pointer in numbers {
        assert!(at(pointer).is_number(), "{pointer}");
    }
    for pointer in ["/located/share", "/located/share_of_time", "/located/intervals/0/share", "/findings/0/confidence"]
    {
        assert!((0.0..=1.0).contains(&at(pointer).as_f64().unwrap()), "{pointer}");
    }
    let fits = [
        "/findings/0/evidence/holdout_fit_before",
        "/findings/0/evidence/holdout_fit_after",
        "/fit/train/before",
        "/fit/train/after",
        "/fit/holdout/before",
        "/fit/holdout/after",
        "/fit/holdout/noise_floor",
    ];
    for pointer in fits {
        let fits = at(pointer).as_object().unwrap();
        assert!(fits.contains_key("position") && fits.values().all(|fit| fit.as_f64().unwrap() <= 100.0), "{pointer}");
    }
    let subsystems = ["valve", "flow", "chambers", "mechanics", "sensing"];
    assert!(subsystems.contains(&at("/located/subsystem").as_str().unwrap()));
    for alternative in at("/findings/0/alternatives").as_array().unwrap() {
        assert!(alternative["effect"].is_string() && alternative["confidence"].is_number());
    }
    for interval in at("/located/intervals").as_array().unwrap() {
        assert!(interval["from_s"].as_f64().unwrap() < interval["to_s"].as_f64().unwrap(), "{interval}");
        assert!(folder().join(interval["recording"].as_str().unwrap()).is_file(), "{interval}");
    }
}

#[test]
fn every_step_of_the_waterfall_leaves_less_and_a_test_is_named_that_makes_sure() {
    let document = document();
    let stages = document["waterfall"]["stages"].as_array().unwrap();
    let left: Vec<f64> = stages.iter().map(|stage| stage["square_over_noise"]["position"].as_f64().unwrap()).collect();
    assert_eq!(stages.len(), 4, "{stages:#?}");
    assert!(left[0] > left[1] && left[1] > 10.0 * left[2] && left[2] < 3.0, "{left:?}");
    assert_eq!(stages[2]["effect"], EFFECT);
    let outside = document["residuals"]["position"]["outside_band"].as_f64().unwrap();
    assert!((0.0..=1.0).contains(&outside));
    let rivals = document["findings"][0]["separation"]["rivals"].as_array().unwrap();
    assert!(rivals.iter().all(|rival| rival["tests"][0]["over_noise"].is_number()), "{rivals:#?}");
    assert!(!rivals.is_empty() && document["findings"][0]["separated_by"] == rivals[0]["advice"], "{rivals:#?}");
}

#[test]
fn the_shares_of_the_waterfall_add_up_and_stand_in_the_printed_table() {
    let document = document();
    let stages = document["waterfall"]["stages"].as_array().unwrap();
    let shares: Vec<f64> = stages.iter().map(|stage| stage["share_taken"].as_f64().unwrap()).collect();
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 2e-3, "{shares:?}");
    let printed = &by_two_threads().printed;
    for (stage, share) in stages.iter().zip(&shares).skip(1) {
        let (label, cell) = (stage["stage"].as_str().unwrap(), format!("{:.1} %", 100.0 * share.abs()));
        let row =
            printed.lines().find(|line| line.trim_start().starts_with(label)).unwrap_or_else(|| panic!("{label}"));
        assert!(row.contains(&cell), "{row} has no {cell}");
    }
}

/// Of the valve's two lags only the sum is determined.
#[test]
fn correlated_parameters_are_told_alike_in_all_that_is_written() {
    let document = document();
    let pairs = document["correlations"].as_array().unwrap();
    let lags = ["valve.time_constants_s[0]", "valve.time_constants_s[1]"];
    let of_lags = pairs.iter().find(|pair| pair["parameters"] == serde_json::json!(lags)).unwrap();
    assert!((-1.0..-0.9).contains(&of_lags["coefficient"].as_f64().unwrap()), "{of_lags}");
    for pair in pairs {
        let coefficient = pair["coefficient"].as_f64().unwrap();
        assert!(coefficient.abs() > 0.9, "{pair}");
        let of = |index: usize| pair["parameters"][index].as_str().unwrap();
        let sign = if coefficient < 0.0 { "−" } else { "" };
        let told = format!("{} and {}: {sign}0.9", of(0), of(1));
        let written = by_two_threads();
        assert!(written.printed.contains(&told) && written.page.contains(&told), "{told}");
    }
}

#[test]
fn the_saved_machine_is_read_again_and_follows_the_held_out_recordings_at_their_noise() {
    let out = tempfile::tempdir().unwrap();
    let saved = out.path().join("after.toml");
    std::fs::write(&saved, &by_two_threads().machine).unwrap();
    let file = machine_file::read(&saved).unwrap();
    assert!(file.effects.contains(EFFECT));
    for name in ["holdout-1.csv", "holdout-2.csv"] {
        let (recorded, simulated) = (folder().join(name), out.path().join(name));
        let arguments = ["simulate", "--machine", text(&saved), "--recording", text(&recorded)];
        done(&[&arguments[..], &["--out", text(&simulated)]].concat());
        let read = |path: &Path| recording::read(path, &ChannelMap::default()).unwrap();
        let (recorded, simulated) = (read(&recorded), read(&simulated));
        let prepared = Prepared::new(&recorded, &file.machine, file.load_source, None).unwrap();
        for channel in &prepared.channels {
            let simulated = simulated.signal(channel.signal).unwrap();
            let square: f64 = channel.recorded.iter().zip(simulated).map(|(a, b)| (a - b).powi(2)).sum();
            let over_noise = (square / simulated.len() as f64).sqrt() / channel.noise;
            println!("{name}, {}: {over_noise:.3} of the noise", channel.signal);
            // A position accumulates every small error of the flow: some steps of its scale after 3 s.
            let most = if channel.signal == Signal::Position { 10.0 } else { 1.1 };
            assert!(over_noise < most, "{name}, {}: {over_noise}", channel.signal);
        }
    }
}

#[test]
fn the_readme_shows_what_is_printed_and_how_much_better_the_held_out_recordings_are_followed() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let printed = &by_two_threads().printed;
    let shown = readme.split("```text\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    for line in shown.lines() {
        assert!(printed.contains(line), "README has `{line}`");
    }
    let document = document();
    let fit = |model: &str, signal: &str| document["fit"]["holdout"][model][signal].as_f64().unwrap();
    let [position, pressure] = ["position", "pressure_a"]
        .map(|signal| ["before", "after", "noise_floor"].map(|model| format!("{:.2}", fit(model, signal))));
    let [before, after, floor] = position;
    let told = format!("from {before} to {after} % (noise floor {floor} %)");
    // A line may end between any two words.
    let words = readme.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains(&told), "README has not `{told}`");
    assert!(words.contains(&format!("{before} → {after} %")), "README's table has not `{before} → {after} %`");
    let [before, after, floor] = pressure;
    let told = format!("pressure A from {before} to {after} % ({floor} %)");
    assert!(words.contains(&told), "README has not `{told}`");
}

#[test]
fn one_thread_and_two_write_the_same_bytes() {
    let (one, two) = (diagnosed(1), by_two_threads());
    assert_eq!(one.json, two.json);
    assert_eq!(one.machine, two.machine);
    assert_eq!(without_its_making(&one.page), without_its_making(&two.page));
}

#[test]
fn the_page_needs_nothing_from_elsewhere_and_is_small() {
    let page = &by_two_threads().page;
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    assert!(page.contains("<svg") && page.contains(EFFECT));
    for part in [
        ">Where</h2>",
        ">What: internal-leakage</h2>",
        ">How sure</h2>",
        "<h3>When</h3>",
        "<h3>Operating regions</h3>",
        "<th>moved</th>",
        "[effects.internal-leakage]",
        "Flow missing from A",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // The address of the SVG namespace and the chart library's address are never opened.
    let page = page.replace("http://www.w3.org/2000/svg", "").replace("https://github.com/leeoniya/uPlot", "");
    assert!(page.contains("default-src 'none'"), "the page forbids itself to load anything");
    for foreign in ["http:", "https:", "src=", "<link", "<img", "<iframe", "@import", "url("] {
        assert!(!page.contains(foreign), "{foreign}");
    }
}
