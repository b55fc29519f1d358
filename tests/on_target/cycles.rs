//! What a step costs in instructions and in cycles by the processors' timing tables, against the snapshot `cycles.txt`.
//!
//! Instructions are counted and compared to the last one; cycles come from Arm's tables (`tests/src/cycles/timing.rs`), not from silicon.

use std::fmt::Write;
use std::path::Path;

use model_core::number::{PerUnit, Single};
use model_export::rust::BakedNumber;
use system_tests::cycles::Costs;
use system_tests::cycles::path::Cost;
use system_tests::cycles::traced::{Counted, trace};
use system_tests::emulator::Processor;
use system_tests::{peers_signal, snapshot};

use crate::baked::{self, Exports};

/// An image, its functions that are counted, and the function that calls them. It prints a line `row TICKS NAME` for each row.
struct Image {
    binary: &'static str,
    functions: &'static [&'static str],
    caller: &'static str,
}

const IMAGES: [Image; 2] = [
    Image {
        binary: "cycles",
        functions: &["cycles::on_target::paper_step", "cycles::on_target::step"],
        caller: "mps2::commanded::run",
    },
    Image { binary: "baked_cycles", functions: &["baked_cycles::on_target::step"], caller: "mps2::commanded::run" },
];

/// The limit of a row's mean: instructions and nominal cycles.
struct Wanted {
    processor: Processor,
    row: &'static str,
    limits: [f64; 2],
    /// Whether each is met, and so must stay met.
    met: [bool; 2],
}

const WANTED: [Wanted; 5] = [
    Wanted { processor: Processor::M4F, row: "paper's model", limits: [740.0, 850.0], met: [true, false] },
    Wanted { processor: Processor::M4F, row: "baked, paper's model", limits: [740.0, 850.0], met: [true, true] },
    Wanted { processor: Processor::M4F, row: "f32, baked, paper's model", limits: [400.0, 700.0], met: [true, true] },
    // Instructions are not limited on the M3.
    Wanted { processor: Processor::M3, row: "paper's model", limits: [f64::INFINITY, 1300.0], met: [true, false] },
    Wanted {
        processor: Processor::M3,
        row: "baked, paper's model",
        limits: [f64::INFINITY, 1300.0],
        met: [true, true],
    },
];

/// Where the figures begin in a row.
const COLUMN: usize = 44;

/// Cost of each row of an image, under the peers' random steps.
fn rows(processor: Processor, image: &Image, commands: &Path, drives: &Path) -> Vec<(String, Costs)> {
    let counted = Counted { functions: image.functions, caller: image.caller, at_most: usize::MAX };
    let taken = [("FIRMWARE_COMMANDS", commands), ("FIRMWARE_BAKED_TRIALS", drives)];
    let file = processor.built_with(&taken, image.binary);
    let traced = trace(processor, &file, counted).unwrap_or_else(|error| panic!("{}: {error}", image.binary));
    let mut ticks = traced.ticks.as_slice();
    let mut rows = Vec::new();
    for line in traced.printed.lines() {
        let row = line.strip_prefix("row ").and_then(|row| row.split_once(' '));
        let (count, name) = row.unwrap_or_else(|| panic!("not a row: {line}"));
        let count = count.parse().unwrap_or_else(|error| panic!("{line}: {error}"));
        let (of_row, rest) =
            ticks.split_at_checked(count).unwrap_or_else(|| panic!("{line}: only {} ticks", ticks.len()));
        rows.push((name.to_owned(), Costs::of(of_row).unwrap_or_else(|| panic!("{line}: no ticks"))));
        ticks = rest;
    }
    assert!(ticks.is_empty() && !rows.is_empty(), "{} ticks are of no row:\n{}", ticks.len(), traced.printed);
    rows
}

fn add_counted<N: BakedNumber>(exports: &mut Exports) {
    for (name, machine) in baked::counted() {
        exports.add::<N>(name, &machine, &[]);
    }
}

fn line(name: &str, which: &str, cost: Cost) -> String {
    let Cost { instructions, cycles: [low, nominal, high] } = cost;
    let name = format!("{name}, {which}");
    format!("{name:<COLUMN$} {instructions:>12.0} {nominal:>8.0} {low:>8.0} {high:>8.0}")
}

#[test]
fn the_step_takes_the_instructions_and_cycles_of_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let commands = folder.path().join("commands.rs");
    std::fs::write(&commands, format!("[(\"random\", &{:?})]\n", peers_signal::random())).unwrap();
    let mut table =
        "A tick under the peers' random steps; cycles by Arm's tables, without wait states, not measured on silicon.\n"
            .to_owned();
    for processor in Processor::ALL {
        if !processor.can_be_emulated() {
            return;
        }
        let head = ["instructions", "nominal", "low", "high"];
        writeln!(table, "\n{:<COLUMN$} {:>12} {:>8} {:>8} {:>8}", processor.name(), head[0], head[1], head[2], head[3])
            .unwrap();
        let mut exports = Exports::new();
        add_counted::<PerUnit>(&mut exports);
        // Single precision where there is an FPU.
        if processor == Processor::M4F {
            add_counted::<Single>(&mut exports);
        }
        let drives = exports.list();
        let rows: Vec<(String, Costs)> =
            IMAGES.iter().flat_map(|image| rows(processor, image, &commands, &drives)).collect();
        for (name, costs) in &rows {
            writeln!(table, "{}", line(name, "mean", costs.mean)).unwrap();
            writeln!(table, "{}", line(name, "worst", costs.worst)).unwrap();
        }
        for wanted in WANTED.iter().filter(|wanted| wanted.processor == processor) {
            judge(wanted, &rows, &mut table);
        }
    }
    // QEMU and the compiler give the same instructions in every run; a cycle of rounding is none.
    snapshot::compare("on_target/cycles.txt", &table, |found, kept| found == kept);
}

/// Fails where a limit that was met is met no longer, or one that was not is met now; else says it in the table.
fn judge(wanted: &Wanted, rows: &[(String, Costs)], table: &mut String) {
    let Wanted { row, limits, met, .. } = wanted;
    let (_, costs) = rows.iter().find(|(name, _)| name == row).expect("every limit is of a row");
    let found = [costs.mean.instructions, costs.mean.cycles[1]];
    let mut said = Vec::new();
    for (place, unit) in ["instructions", "cycles"].into_iter().enumerate() {
        let (found, limit, met) = (found[place], limits[place], met[place]);
        assert_eq!(found <= limit, met, "{row}: {found:.1} {unit}, {limit} at most; it was {met} that this is met");
        if limit.is_finite() {
            said.push(format!("{limit} {unit}{}", if met { "" } else { ", not met" }));
        }
    }
    writeln!(table, "wanted of {row}, mean at most: {}", said.join("; ")).unwrap();
}

#[test]
fn the_peers_signal_is_theirs_to_the_bit() {
    let volts = peers_signal::random();
    assert_eq!(volts.len(), 4000);
    assert!(volts[..100].iter().all(|&volts| volts == 0.0));
    // What their `common.py` gives with NumPy 2: the first commands and when they begin, and a checksum of all in single precision, little-endian.
    let mut starts = volts
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| pair[0].to_bits() != pair[1].to_bits())
        .map(|(tick, pair)| (tick + 1, pair[1]));
    let first: [Option<(usize, f32)>; 3] = std::array::from_fn(|_| starts.next());
    assert_eq!(first, [Some((100, 9.009_274)), Some((394, 8.972_989)), Some((534, -1.533_471))]);
    let bytes: Vec<u8> = volts.iter().flat_map(|volts| volts.to_le_bytes()).collect();
    assert_eq!(crc32fast::hash(&bytes), 0x60b9_eb52);
}
