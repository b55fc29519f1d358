//! Does `docs/target.md` have the timing table that cycles are weighed by, and the cycles that were found?

use std::fs;

use system_tests::cycles::timing::TABLE;

use crate::root;

fn page() -> String {
    fs::read_to_string(root().join("docs/target.md")).unwrap()
}

#[test]
fn the_book_has_every_row_of_the_timing_table() {
    let page = page();
    for row in TABLE {
        let line = row.line();
        assert!(page.contains(&line), "docs/target.md has not:\n{line}");
    }
}

/// Means of a processor in the snapshot: name of the step, its instructions, its cycles.
fn means<'a>(snapshot: &'a str, processor: &str) -> Vec<(&'a str, String)> {
    let (_, figures) = snapshot.split_once(&format!("\n{processor} ")).unwrap();
    let (figures, _) = figures.split_once("\nwanted").unwrap();
    let mean = |line: &'a str| {
        let (name, figures) = line.split_once(", mean ")?;
        let [instructions, nominal, low, high] = figures.split_whitespace().collect::<Vec<&str>>().try_into().unwrap();
        Some((name, format!("{instructions} | {nominal}, {low} to {high}")))
    };
    figures.lines().skip(1).filter_map(mean).collect()
}

#[test]
fn the_cycles_of_the_book_are_those_of_the_snapshot() {
    let (page, snapshot) = (page(), fs::read_to_string(root().join("tests/on_target/cycles.txt")).unwrap());
    let [m4f, m3] = ["Cortex-M4F", "Cortex-M3"].map(|processor| means(&snapshot, processor));
    assert!(m3.len() > 1 && m3.iter().all(|(name, _)| m4f.iter().any(|(same, _)| same == name)), "{m4f:?} {m3:?}");
    for (name, m4f) in &m4f {
        // Single precision is counted where there is an FPU.
        let m3 = m3.iter().find(|(same, _)| same == name).map_or("– | –", |(_, figures)| figures);
        assert_eq!(m3 == "– | –", name.starts_with("f32, "), "{name}");
        let row = format!("| {name} | {m4f} | {m3} |");
        assert!(page.contains(&row), "docs/target.md has not:\n{row}");
    }
}
