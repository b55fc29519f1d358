//! `trend`: what wears, from a table of nights.
#![cfg(feature = "fleet")]

use std::fs;
use std::path::Path;

use fleet::{Judgement, Row, Strength, to_parquet};
use model_core::machine::Parameter;
use recording::seeded_noise::Noise;
use serde_json::Value;

use super::{done, refused, root, run};

/// Nights of a table that [`worn`] writes.
const NIGHTS: u32 = 60;

/// A table of fifty drives: of most the leak is as it was; `press-07` leaks more every night from the twentieth on, `press-12` had its seal exchanged,
/// `press-20` has another friction every night and no trend; nights are missing.
pub(super) fn worn(folder: &Path) {
    let mut dice = Noise::new(4, 0);
    let mut rows = Vec::new();
    for drive in 0..50 {
        let usual = 1e-12 * dice.uniform(0.5, 2.0);
        for night in 0..NIGHTS {
            let day = f64::from(night);
            let grown = if drive == 7 { 4e-14 * (day - 20.0).max(0.0) } else { 0.0 };
            let leak = if drive == 12 && night >= 30 { 0.2 * usual } else { usual } + grown;
            let noisy =
                Strength { parameter: Parameter::InternalLeakage, value: leak + dice.gaussian(2e-14), std: 2e-14 };
            let friction =
                Strength { parameter: Parameter::CoulombFriction, value: 300.0 + dice.gaussian(20.0), std: 4.0 };
            let is_off = dice.happens(0.1);
            rows.push(Row {
                drive: format!("press-{drive:02}"),
                night: format!("2026-{:02}-{:02}", 9 + night / 30, 1 + night % 30),
                recording: None,
                judgement: if drive == 7 && night > 25 { Judgement::Changed } else { Judgement::InBand },
                link: None,
                words: String::new(),
                recordings: if is_off { 0 } else { 3 },
                of_limit: None,
                misfits: [None; 4],
                strengths: if is_off {
                    vec![]
                } else if drive == 20 {
                    vec![noisy, friction]
                } else {
                    vec![noisy]
                },
                version: "0.1.0".into(),
                seconds: 0.1,
            });
        }
    }
    // Not by the library that keeps files whole: in this process another test interrupts it.
    fs::create_dir_all(folder).unwrap();
    fs::write(folder.join("part-000000.parquet"), to_parquet(&rows).unwrap()).unwrap();
}

#[test]
fn what_wears_is_told_with_its_rate_and_when_it_reaches_its_limit() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    worn(&here.join("table"));
    let limit = "internal_leakage_conductance_m3_per_s_pa=6e-12";
    let said = done(here, &["trend", "table", "--limit", limit, "--report", "wear.html"]);
    let book = fs::read_to_string(root().join("docs/fleet.md")).unwrap();
    assert!(said.starts_with("2 of 50 drives") && book.contains(said.lines().next().unwrap()), "{said}");
    assert!(said.contains("press-07") && said.contains("press-12") && !said.contains("press-20"), "{said}");
    let page = fs::read_to_string(here.join("wear.html")).unwrap();
    assert_eq!(page.matches("<figure").count(), 51, "a chart of every amount");
    assert!(page.contains("optimal partitioning") && page.contains("grows by"));

    let document = done(here, &["trend", "table", "--limit", limit, "--json", "-"]);
    let document: Value = serde_json::from_str(&document).unwrap();
    let [first, second] = [&document["amounts"][0], &document["amounts"][1]];
    assert_eq!((&first["drive"], &first["state"]), (&"press-07".into(), &"reaches-limit".into()));
    let last = first["pieces"].as_array().unwrap().last().unwrap();
    let rate = last["per_month"].as_f64().unwrap() / 30.4375;
    assert!((rate / 4e-14 - 1.0).abs() < 0.1, "{last}");
    let reach = ["earliest", "expected", "latest"].map(|day| first["reaches_limit"][day].as_str().unwrap());
    assert!(reach.is_sorted(), "{reach:?}");
    assert_eq!((&second["drive"], &second["state"]), (&"press-12".into(), &"changed".into()));
    assert_eq!(second["pieces"][1]["from"], "2026-10-01", "{second}");
    assert!(document["amounts"].as_array().unwrap()[2..].iter().all(|amount| amount["state"] == "steady"));
    assert_eq!(run(here, &["trend", "table", "--exit-code"]).status.code(), Some(1));
}

#[test]
fn the_limit_of_a_leak_is_where_sources_call_a_cylinder_worn() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    worn(&here.join("table"));
    fs::create_dir_all(here.join("hall/press-07/2026-09-01")).unwrap();
    fs::copy(root().join("presets/press-63-40-installed.toml"), here.join("hall/press-07/machine.toml")).unwrap();
    fs::create_dir_all(here.join("hall/press-08/2026-09-01")).unwrap();
    let told = run(here, &["trend", "table", "--drives", "hall"]);
    let said = String::from_utf8_lossy(&told.stdout);
    assert!(said.contains("l/min") && said.contains("worn according to sources"), "{said}");
    assert!(String::from_utf8_lossy(&told.stderr).contains("no sizes of press-08"), "{told:?}");
}

#[test]
fn a_table_that_is_none_and_a_limit_of_nothing_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    assert!(refused(here, &["trend", "nowhere"]).contains("nowhere"));
    fs::create_dir(here.join("empty")).unwrap();
    assert!(refused(here, &["trend", "empty"]).contains("no row"));
    worn(&here.join("table"));
    let said = refused(here, &["trend", "table", "--limit", "internal-leakage=1"]);
    assert!(said.contains("internal_leakage_conductance_m3_per_s_pa"), "{said}");
    let said = refused(here, &["trend", "table", "--report", "wear.pdf"]);
    assert!(said.contains("wear.pdf"), "{said}");
    assert!(!here.join("wear.pdf").exists());
}
