//! Neither a step nor a refit may take more instructions than the stored count.
//!
//! Callgrind counts them, less those of a run that does everything except the counted work. The counts are of the test profile (optimised, with a
//! debug build's checks), of the compiler that `rust-toolchain.toml` pins, and of the processor features that valgrind shows to the
//! C library: another compiler needs `RENEW=1`, which writes `instructions.txt` anew. No time is measured.

use std::fmt::Write;
use std::process::{Command, Stdio};

use system_tests::at_hand::skipped;
use system_tests::snapshot;

/// Largest relative difference of a figure from the stored one.
const RELATIVE: f64 = 0.05;
/// Where the figures begin in a row.
const COLUMN: usize = 60;

/// Ticks of the longer and of the shorter run.
const TICKS: [u64; 2] = [12_000, 4_000];

/// In place of a figure.
const NOT_COUNTED: &str = "-";

/// Instructions of the whole program; `None` where the compiler has chosen an instruction that this valgrind does not know, such as
/// `vmovq` between registers in its shorter form, which 3.19 does not accept as an instruction.
fn instructions(arguments: &[&str]) -> Option<u64> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", env!("CARGO_BIN_EXE_counted")])
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .expect("it was there a moment ago");
    let said = String::from_utf8_lossy(&output.stderr);
    if let Some((_, unknown)) = said.split_once("unhandled instruction bytes: ") {
        let bytes = unknown.lines().next().unwrap_or_default();
        skipped(&format!("instructions of {arguments:?} are not counted: valgrind does not know {bytes}"));
        return None;
    }
    assert!(output.status.success(), "{arguments:?}: {}\n{said}", output.status);
    let collected = said.lines().find_map(|line| line.split_once("Collected : "));
    let (_, count) = collected.unwrap_or_else(|| panic!("{arguments:?}: no count in\n{said}"));
    Some(count.trim().parse().unwrap_or_else(|error| panic!("{count}: {error}")))
}

fn of_a_step(which: &str) -> Option<u64> {
    let [more, fewer] = TICKS.map(|ticks| instructions(&[which, &ticks.to_string()]));
    Some((more? - fewer?) / (TICKS[0] - TICKS[1]))
}

fn of_a_refit() -> Option<u64> {
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/press-63-40");
    let [once, none] = ["1", "0"].map(|times| instructions(&["refit", case, times]));
    Some((once? - none?) / 1_000_000)
}

#[test]
fn a_step_and_a_refit_take_no_more_instructions_than_before() {
    let valgrind = Command::new("valgrind").arg("--version").stdout(Stdio::null()).status();
    if !valgrind.is_ok_and(|status| status.success()) {
        skipped("there is no valgrind; Debian: apt-get install valgrind");
        return;
    }
    if !cfg!(all(target_arch = "x86_64", target_feature = "avx2")) {
        skipped("the instructions that were kept are those of x86-64 with AVX2");
        return;
    }
    let figures = [
        ("instructions a step, f64", of_a_step("step-f64")),
        ("instructions a step, fixed point", of_a_step("step-fixed")),
        ("instructions a step of four drives in SIMD lanes, f64", of_a_step("step-lanes")),
        ("millions of instructions a refit, four recordings", of_a_refit()),
    ];
    let renews = std::env::var_os("RENEW").is_some();
    assert!(
        !renews || figures.iter().all(|(_, figure)| figure.is_some()),
        "not every figure was counted, so none is written"
    );
    let mut table = "Under callgrind, x86-64 with AVX2, test profile.\n".to_owned();
    for (row, figure) in figures {
        let figure = figure.map_or(NOT_COUNTED.to_owned(), |figure| figure.to_string());
        writeln!(table, "{row:<COLUMN$} {figure:>8}").unwrap();
    }
    let near = |found: &str, kept: &str| {
        found.ends_with(NOT_COUNTED) || snapshot::numbers_near(found, kept, COLUMN, RELATIVE, 0.0)
    };
    snapshot::compare("../benches/instructions.txt", &table, near);
}
