//! What the model costs on the target, against what it may cost.

use std::fmt::Write;

use system_tests::emulator::Processor;
use system_tests::snapshot;

use crate::step;

/// What a figure may be at most.
struct Budget {
    /// Its row.
    row: &'static str,
    limit: u64,
    /// Whether it is met on both processors, and so must stay met.
    met: bool,
}

const BUDGETS: [Budget; 7] = [
    Budget { row: "instructions a step, mean: paper's model, random", limit: 500, met: false },
    Budget { row: "instructions a step, mean: every effect, random under load", limit: 1500, met: false },
    Budget { row: "flash of the step, bytes: paper's model", limit: 8 * 1024, met: true },
    Budget { row: "flash of the step, bytes: every effect", limit: 8 * 1024, met: false },
    // Coefficients are configuration: constants in flash would be none of the RAM, but they are computed at the start.
    Budget { row: "RAM beside the delay lines, bytes: paper's model", limit: 512, met: true },
    Budget { row: "RAM beside the delay lines, bytes: every effect", limit: 512, met: false },
    Budget { row: "RAM, bytes: state beside its delay lines", limit: 512, met: true },
];

/// Largest change of a figure against the snapshot.
const RELATIVE: f64 = 0.01;
/// Where the figures begin in a row.
const COLUMN: usize = 72;

/// A row for each figure.
fn figures(processor: Processor) -> Vec<(String, u64)> {
    let of = |model: &str| format!("flash of the step, bytes: {model}");
    let mut figures = vec![
        (of("paper's model"), step::flash(processor, "paper_step")),
        (of("every effect"), step::flash(processor, "step")),
    ];
    let (mut state, mut coefficients) = (0, Vec::new());
    for line in processor.run("budget").lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |word: &str| word.parse::<u64>().unwrap_or_else(|error| panic!("{line}: {error}"));
        match words.as_slice() {
            ["instructions", mean, worst, name @ ..] => {
                let name = name.join(" ");
                figures.push((format!("instructions a step, mean: {name}"), number(mean)));
                figures.push((format!("instructions a step, worst: {name}"), number(worst)));
            }
            ["stack", bytes, name @ ..] => figures.push((format!("stack, bytes: {}", name.join(" ")), number(bytes))),
            ["ram", bytes, name @ ..] => {
                let name = name.join(" ");
                if let Some(model) = name.strip_prefix("coefficients, ") {
                    coefficients.push((model.to_owned(), number(bytes)));
                } else if name.starts_with("state") {
                    state = number(bytes);
                }
                figures.push((format!("RAM, bytes: {name}"), number(bytes)));
            }
            _ => panic!("not a figure: {line}"),
        }
    }
    assert!(state > 0 && coefficients.len() == 2, "{coefficients:?} beside {state}");
    for (model, bytes) in coefficients {
        figures.push((format!("RAM beside the delay lines, bytes: {model}"), state + bytes));
    }
    figures
}

#[test]
fn the_step_stays_within_its_budgets() {
    let mut table = "Under QEMU with an instruction a nanosecond; the worst step to 40 instructions.\n".to_owned();
    for processor in Processor::ALL {
        if !processor.can_be_emulated() {
            return;
        }
        let figures = figures(processor);
        writeln!(table, "\n{}", processor.name()).unwrap();
        for (row, figure) in &figures {
            writeln!(table, "{row:<COLUMN$} {figure:>8}").unwrap();
        }
        for Budget { row, limit, met } in BUDGETS {
            let (_, figure) = figures.iter().find(|(name, _)| name == row).expect("every budget is of a row");
            assert!(!met || *figure <= limit, "{}: {row} is {figure}, allowed {limit}", processor.name());
            assert!(met || *figure > limit, "{}: {row} is {figure}, {limit} at most: met now", processor.name());
        }
        writeln!(table, "wanted:").unwrap();
        for Budget { row, limit, met } in BUDGETS {
            writeln!(table, "{row:<COLUMN$} {limit:>8}{}", if met { "" } else { "  not met" }).unwrap();
        }
    }
    snapshot::compare("on_target/budget.txt", &table, |found, kept| {
        snapshot::numbers_near(found, kept, COLUMN, RELATIVE, 0.0)
    });
}
