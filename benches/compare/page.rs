//! `BENCHMARKS.md`: the results as text.

use std::fmt::Write;
use std::path::Path;

use crate::machine;

/// The results of a part of the comparison.
#[derive(Debug, Default)]
pub(crate) struct Part {
    /// Its tables and the remarks on them.
    pub(crate) text: String,
    /// Its figures for the requirements.
    pub(crate) wanted: Vec<Wanted>,
}

/// A required figure.
#[derive(Debug)]
pub(crate) struct Wanted {
    pub(crate) what: String,
    pub(crate) aim: String,
    pub(crate) found: String,
    pub(crate) is_met: bool,
}

/// The page, as far as it has been measured.
#[derive(Debug)]
pub(crate) struct Page {
    machine: String,
    parts: Vec<Part>,
}

const HEAD: &str = "# What it costs\n\n\
    Written by `benches/run`, which measures all of it anew and installs the opponents; `benches/run fit` prints a part (desktop, target, fit,\n\
    diagnose, names, fleet) and writes nothing. The opponents are not in this repository (`peers/speed` in `$HOST_SIM_SHARED`, PySINDy from PyPI);\n\
    without them our side alone is printed. Times are the shortest of rounds in which all take turns, where nothing else is said, and only ratios\n\
    within a run say something. Other programs that compute take cores away: beside a load of 1 or more, two threads on two cores show little.\n\
    Growth of instructions is what `benches/instructions.txt` and its test are for.\n";

/// What is not measured here.
const NOT_DONE: &str = "## Not done\n\n\
    - Instructions are not cycles: on a Cortex-M4F a square root or a division of floats counts as one and takes 14, which flatters the opponents there.\n";

impl Page {
    pub(crate) fn of_this_machine() -> std::io::Result<Self> {
        Ok(Self { machine: machine::described()?, parts: Vec::new() })
    }

    pub(crate) fn add(&mut self, part: Part) {
        self.parts.push(part);
    }

    pub(crate) fn text(&self) -> String {
        let row = |wanted: &Wanted| {
            let met = if wanted.is_met { "met" } else { "**not met**" };
            [wanted.what.clone(), wanted.aim.clone(), wanted.found.clone(), met.to_owned()].to_vec()
        };
        let wanted: Vec<Vec<String>> = self.parts.iter().flat_map(|part| &part.wanted).map(row).collect();
        let mut text = format!("{HEAD}\n{}", self.machine);
        if !wanted.is_empty() {
            let _ = write!(text, "\n## What was wanted\n\n{}", table(&["what", "wanted", "found", ""], &wanted));
        }
        for part in &self.parts {
            let _ = write!(text, "\n{}", part.text);
        }
        format!("{text}\n{NOT_DONE}")
    }

    pub(crate) fn write(&self) -> std::io::Result<()> {
        std::fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join("../BENCHMARKS.md"), self.text())
    }
}

/// A table in Markdown.
pub(crate) fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut text = format!("| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
    for row in rows {
        let _ = writeln!(text, "| {} |", row.join(" | "));
    }
    text
}
