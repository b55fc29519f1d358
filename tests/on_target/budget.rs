//! What the model and the whole firmware cost on the target, against their budgets.
//!
//! The whole firmware is compared with a controller on which it could run: 100 MHz, 256 KiB of flash, 128 KiB of RAM (an `STM32F411xC`; no
//! smaller one with an FPU has room for six seconds of recorder). An instruction counts as two cycles (loads, branches, waits for the flash), and
//! half of a period of 1 ms is left to the buses: 25 000 instructions, and 6250 at 25 MHz, which must be enough for the paper's model.

use std::fmt::Write;

use firmware::app::RING_BYTES;
use model_core::number::{PerUnit, Single};
use model_export::rust::BakedNumber;
use mps2::trial::Traced;
use system_tests::emulator::{self, Processor};
use system_tests::snapshot;

use crate::baked::{self, Exports};
use crate::whole;

/// The limit of a figure.
struct Budget {
    /// The figure's row in the table.
    row: &'static str,
    limit: u64,
    /// Whether the limit is met on both processors, and so must stay met.
    met: bool,
}

const BUDGETS: [Budget; 20] = [
    Budget { row: "instructions a step, mean: paper's model, random", limit: 500, met: false },
    Budget { row: "instructions a step, mean: every effect, random under load", limit: 1500, met: false },
    Budget { row: "flash of the step, bytes: paper's model", limit: 8 * 1024, met: true },
    Budget { row: "flash of the step, bytes: every effect", limit: 8 * 1024, met: false },
    // Coefficients are configuration: as constants in flash they would take no RAM, but they are computed at the start.
    Budget { row: "RAM beside the delay lines, bytes: paper's model", limit: 512, met: true },
    Budget { row: "RAM beside the delay lines, bytes: every effect", limit: 512, met: false },
    Budget { row: "RAM, bytes: state beside its delay lines", limit: 512, met: true },
    Budget { row: "instructions a step, mean: baked, paper's model, random", limit: 740, met: false },
    Budget { row: "instructions a step, mean: baked, three effects, random", limit: 1500, met: true },
    Budget { row: "instructions a step, mean: baked, five effects, random", limit: 1500, met: true },
    Budget { row: "instructions a step, mean: baked, five effects with edges, random", limit: 1500, met: false },
    Budget { row: "flash of a whole image, bytes: baked, paper's model", limit: 8 * 1024, met: true },
    Budget { row: "RAM, bytes: baked, paper's model: state and stack", limit: 512, met: true },
    Budget { row: "instructions a period, worst: following", limit: 6250, met: true },
    Budget { row: "instructions a period, worst: begins to follow", limit: 6250, met: true },
    Budget { row: "instructions a period, worst: faults and the way back", limit: 6250, met: true },
    Budget { row: "instructions a period, worst: following, every effect", limit: 25_000, met: false },
    // Half of the controller's flash: the other half is for the other parts of a board's firmware.
    Budget { row: "flash of the control period, every effect included, bytes", limit: 128 * 1024, met: true },
    Budget { row: "flash of the whole firmware, bytes", limit: 256 * 1024, met: true },
    Budget { row: "RAM of the whole firmware and its stack, bytes", limit: 128 * 1024, met: true },
];

/// Limits of single precision, on a processor with an FPU.
const SINGLE_BUDGETS: [Budget; 7] = [
    Budget { row: "instructions a step, mean: f32, paper's model, random", limit: 400, met: false },
    // Of a step that takes any drive; one that is compiled for a drive's own effects is what the limit is meant for.
    Budget { row: "instructions a step, mean: f32, five effects", limit: 900, met: false },
    Budget { row: "instructions a step, mean: f32, every effect, random under load", limit: 3000, met: false },
    Budget { row: "instructions a step, mean: baked, f32, paper's model, random", limit: 400, met: true },
    Budget { row: "instructions a step, mean: baked, f32, three effects, random", limit: 900, met: true },
    Budget { row: "instructions a step, mean: baked, f32, five effects, random", limit: 900, met: true },
    Budget { row: "instructions a step, mean: baked, f32, every effect, random", limit: 3000, met: false },
];

/// Limits on this processor.
fn budgets(processor: Processor) -> impl Iterator<Item = &'static Budget> {
    let single = processor == Processor::M4F;
    BUDGETS.iter().chain(SINGLE_BUDGETS.iter().filter(move |_| single))
}

/// Largest change of a figure against the snapshot: for a worst case, two of the counter's steps; for a mean over periods, which lie on few of
/// the counter's steps, one step (where the image's code lies moves periods from one step to the next); for any other figure, a share and two more.
const WORST: f64 = 80.0;
const PERIOD: f64 = 40.0;
const RELATIVE: f64 = 0.005;
const ABSOLUTE: f64 = 2.0;
/// Where the figures begin in a row.
const COLUMN: usize = 78;

/// A row for each figure.
fn figures(processor: Processor) -> Vec<(String, u64)> {
    let of = |model: &str| format!("flash of the step, bytes: {model}");
    let mut figures =
        vec![(of("paper's model"), processor.flash("paper_step")), (of("every effect"), processor.flash("step"))];
    if processor == Processor::M4F {
        figures.push((of("f32, paper's model"), processor.flash("paper_step_single")));
        figures.push((of("f32, every effect"), processor.flash("step_single")));
    }
    let (mut states, mut coefficients) = (Vec::new(), Vec::new());
    let baked = of_baked(processor, &mut figures);
    for line in (processor.run("budget") + &processor.run("budget_whole") + &baked).lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |word: &str| word.parse::<u64>().unwrap_or_else(|error| panic!("{line}: {error}"));
        match words.as_slice() {
            ["instructions", mean, worst, name @ ..] => {
                let name = name.join(" ");
                figures.push((format!("instructions a step, mean: {name}"), number(mean)));
                figures.push((format!("instructions a step, worst: {name}"), number(worst)));
            }
            ["period", mean, worst, name @ ..] => {
                let name = name.join(" ");
                figures.push((format!("instructions a period, mean: {name}"), number(mean)));
                figures.push((format!("instructions a period, worst: {name}"), number(worst)));
            }
            ["stack", bytes, name @ ..] => figures.push((format!("stack, bytes: {}", name.join(" ")), number(bytes))),
            ["ram", bytes, name @ ..] => {
                let name = name.join(" ");
                if let Some(model) = name.strip_prefix("coefficients, ") {
                    coefficients.push((model.to_owned(), number(bytes)));
                } else if let Some(numbers) = name.strip_suffix("state beside its delay lines") {
                    states.push((numbers.to_owned(), number(bytes)));
                }
                figures.push((format!("RAM, bytes: {name}"), number(bytes)));
            }
            _ => panic!("not a figure: {line}"),
        }
    }
    assert_eq!(coefficients.len(), 2 * states.len(), "{coefficients:?} beside {states:?}");
    for (model, bytes) in coefficients {
        // Of the same numbers: fixed point, which comes first, is not named.
        let (_, state) =
            states.iter().rfind(|(numbers, _)| model.starts_with(numbers)).expect("a state for each model");
        figures.push((format!("RAM beside the delay lines, bytes: {model}"), state + bytes));
    }
    figures.push(("flash of the control period, every effect included, bytes".to_owned(), processor.flash("period")));
    figures.push(("flash of the whole firmware, bytes".to_owned(), processor.flash("loop")));
    let (statics, ring, stack) = (processor.statics("loop"), RING_BYTES as u64, whole::stack(processor));
    figures.push(("RAM, bytes: whole firmware beside the recorder's rows".to_owned(), statics - ring));
    figures.push(("RAM, bytes: the recorder's rows".to_owned(), ring));
    figures.push(("stack, bytes: whole firmware, from its start to its end".to_owned(), stack));
    figures.push(("RAM of the whole firmware and its stack, bytes".to_owned(), statics + stack));
    figures
}

/// What steps of baked drives cost; the flash of images that hold one of them and nothing else is added to the figures.
fn of_baked(processor: Processor, figures: &mut Vec<(String, u64)>) -> String {
    let mut exports = Exports::new();
    add_baked::<PerUnit>(processor, &mut exports, figures);
    // Single precision where there is an FPU.
    if processor == Processor::M4F {
        add_baked::<Single>(processor, &mut exports, figures);
    }
    processor.run_with(&[("FIRMWARE_BAKED_TRIALS", &exports.list())], "baked_budget")
}

fn add_baked<N: BakedNumber + Traced>(processor: Processor, exports: &mut Exports, figures: &mut Vec<(String, u64)>) {
    for (name, machine) in baked::counted() {
        let file = exports.add::<N>(name, &machine, &[]);
        let image = processor.image_with(&[("FIRMWARE_BAKED", &file)], "baked_step");
        let flash = emulator::size(&image, &[".vector_table", ".text", ".rodata"]);
        assert_eq!(emulator::size(&image, &[".data", ".bss"]), 0, "all of the state is on the stack");
        figures.push((format!("flash of a whole image, bytes: baked, {}{name}", N::PREFIX), flash));
    }
}

/// Whether a line agrees with the snapshot.
fn near(found: &str, kept: &str) -> bool {
    // Only one period begins to follow.
    let of_one = kept.contains("worst") || kept.contains("begins");
    let (relative, absolute) =
        if of_one { (0.0, WORST) } else { (RELATIVE, if kept.contains("a period, mean") { PERIOD } else { ABSOLUTE }) };
    snapshot::numbers_near(found, kept, COLUMN, relative, absolute)
}

#[test]
fn the_step_stays_within_its_budgets() {
    let mut table =
        "Under QEMU with an instruction a nanosecond; the worst step to 40 instructions, the worst period to 80.\n"
            .to_owned();
    for processor in Processor::ALL {
        if !processor.can_be_emulated() {
            return;
        }
        let figures = figures(processor);
        writeln!(table, "\n{}", processor.name()).unwrap();
        for (row, figure) in &figures {
            writeln!(table, "{row:<COLUMN$} {figure:>8}").unwrap();
        }
        for &Budget { row, limit, met } in budgets(processor) {
            let (_, figure) = figures.iter().find(|(name, _)| name == row).expect("every budget is of a row");
            assert!(!met || *figure <= limit, "{}: {row} is {figure}, allowed {limit}", processor.name());
            assert!(met || *figure > limit, "{}: {row} is {figure}, {limit} at most: met now", processor.name());
        }
        writeln!(table, "wanted:").unwrap();
        for Budget { row, limit, met } in budgets(processor) {
            writeln!(table, "{row:<COLUMN$} {limit:>8}{}", if *met { "" } else { "  not met" }).unwrap();
        }
    }
    snapshot::compare("on_target/budget.txt", &table, near);
}
