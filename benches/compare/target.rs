//! A step on the target: instructions under QEMU, of our step by the firmware's `budget`, of the peers' by their `bench_target.py`.

use std::error::Error;
use std::fmt::Write;
use std::path::PathBuf;

use serde_json::Value;
use tempfile::TempDir;

use model_core::number::PerUnit;
use system_tests::emulator::Processor;
use system_tests::simulate::DELAY;

use crate::accurate::{self, Signals};
use crate::page::{Part, Wanted, table};
use crate::peers::{self, list, number, text};

/// The drive that is counted, and the one of its signals whose mean is compared.
const DRIVE: &str = "press";
const COMPARED: &str = "random";
/// Rows of `budget` under its own signals.
const OWN: [&str; 2] = ["paper's model, random", "paper's model, random under load"];

/// A row of the peers: flags, substeps, figures.
type Opponent<'a> = (String, u64, &'a Value);

/// The peers' name of a processor.
fn of_peers(processor: Processor) -> &'static str {
    match processor {
        Processor::M4F => "M4F",
        Processor::M3 => "M3",
    }
}

/// Required ratio of the opponent's instructions to ours: at least this.
fn wanted(processor: Processor) -> f64 {
    match processor {
        Processor::M4F => 1.0,
        Processor::M3 => 30.0,
    }
}

/// Mean and worst instructions of a row that `budget` printed.
fn row(printed: &str, name: &str) -> Option<(f64, f64)> {
    printed.lines().find_map(|line| {
        let (mean, rest) = line.strip_prefix("instructions ")?.trim_start().split_once(' ')?;
        let (worst, rest) = rest.trim_start().split_once(' ')?;
        (rest == name).then_some(())?;
        Some((mean.parse().ok()?, worst.parse().ok()?))
    })
}

/// This part of the comparison.
pub(crate) fn part() -> Result<Part, Box<dyn Error>> {
    let mut part = Part { text: "## A step on the target\n\n".to_owned(), wanted: Vec::new() };
    let theirs = peers::on_target()?;
    let given = Signals::start()?.map(|signals| Given::of(&signals)).transpose()?;
    let mut lines = Vec::new();
    for processor in Processor::ALL {
        if !processor.can_be_emulated() {
            writeln!(part.text, "{} is left out: no QEMU, or no such target of Rust.\n", processor.name())?;
            continue;
        }
        let printed = match &given {
            Some(given) => processor.run_with(&[("FIRMWARE_COMMANDS", &given.file)], "budget"),
            None => processor.run("budget"),
        };
        let said = |name: &str| row(&printed, name).ok_or_else(|| format!("budget says nothing of {name}"));
        let image = memory(&printed, processor)?;
        for name in OWN {
            let (mean, worst) = said(name)?;
            lines.push(line(processor, &format!("**core, fixed point**: {name}"), [mean, worst], "–", &image));
        }
        let (Some(given), Some(theirs)) = (&given, &theirs) else { continue };
        let (ours, _) = said(COMPARED)?;
        let rows: Vec<(f64, f64)> = given.names.iter().map(|name| said(name)).collect::<Result<_, _>>()?;
        let worst = rows.iter().fold(0.0_f64, |worst, row| worst.max(row.1));
        lines.push(line(processor, "**core, fixed point**", [ours, worst], &given.off, &image));
        for (label, substeps, found) in opponents(theirs, processor)? {
            let off = format!("{:.0e} / {:.0e}", number(&found["err_y"])?, number(&found["err_p"])?);
            let numbers = [number(&found["random"])?, number(&found["worst"])?];
            let bytes = ["flash", "ram", "stack"].map(|of| text(&found[of]));
            lines.push(line(processor, &format!("RK4 C {label}, S={substeps}"), numbers, &off, &bytes));
        }
        let means: Vec<f64> = opponents(theirs, processor)?
            .into_iter()
            .filter(|(_, substeps, _)| *substeps == 2)
            .map(|(_, _, found)| number(&found["random"]))
            .collect::<Result<_, _>>()?;
        let first = means.first().copied().ok_or("the first row of a processor is -O2 with S=2")?;
        let best = means.into_iter().fold(f64::INFINITY, f64::min);
        let factor = wanted(processor);
        let fewer = if factor > 1.0 { format!("{factor:.0} times fewer") } else { "fewer".to_owned() };
        part.wanted.push(Wanted {
            what: format!("instructions of a step on the {}", processor.name()),
            aim: format!("{fewer} than RK4 in C float"),
            found: format!(
                "{ours:.0}; C takes {first:.0} with -O2 ({:.2} times ours) and {best:.0} at best ({:.2} times)",
                first / ours,
                best / ours
            ),
            is_met: factor * ours < best,
        });
    }
    writeln!(
        part.text,
        "Instructions under QEMU with `-icount shift=0`, the worst tick to 40. Ours is the step of `PaperDrive` for the drive `{DRIVE}`, with parameters of the run\n\
         time; what it misses the references by is computed on this computer, bit for bit what the target computes (`tests/on_target/parity.rs`), the sweep by the project's\n\
         oracle, see above. All rows but those with signals of our own are under the peers' signals: mean of the random steps, worst of all of them. The peers' have\n\
         parameters that are constants of the compiler. Flash is the step's: ours with the processor's start-up, some 200 bytes, and without what computes its coefficients\n\
         (which a host may do, `host-sim export`). RAM is state, delay lines ({DELAY} ticks each, which ours may use) and coefficients; those of the peers' are constants in flash.\n"
    )?;
    if theirs.is_none() {
        writeln!(part.text, "The peers' figures are not at hand: no opponents.\n")?;
    }
    let head = [
        "processor",
        "what",
        "instructions a tick, mean",
        "worst",
        "off, position % / pressure %",
        "flash, bytes",
        "RAM, bytes",
        "stack, bytes",
    ];
    write!(part.text, "{}", table(&head, &lines))?;
    Ok(part)
}

/// The peers' signals as `budget` takes them, and the error of our step under them.
struct Given {
    names: Vec<String>,
    file: PathBuf,
    off: String,
    _folder: TempDir,
}

impl Given {
    fn of(signals: &Signals) -> Result<Self, Box<dyn Error>> {
        let names = signals.names()?;
        let given: Vec<(&String, Vec<f32>)> =
            names.iter().map(|name| Ok((name, signals.volts(name)?))).collect::<Result<_, Box<dyn Error>>>()?;
        let list: Vec<String> = given.iter().map(|(name, volts)| format!("({name:?}, &{volts:?})")).collect();
        let folder = tempfile::tempdir()?;
        let file = folder.path().join("commands.rs");
        std::fs::write(&file, format!("[{}]\n", list.join(", ")))?;
        let off = accurate::of_core::<PerUnit>(signals, DRIVE)?;
        Ok(Self { off: off.steps.or(off.sweep).shown(), names, file, _folder: folder })
    }
}

/// Flash, RAM and stack of the paper's model, bytes.
fn memory(printed: &str, processor: Processor) -> Result<[String; 3], Box<dyn Error>> {
    let of = |kind: &str, name: &str| {
        let line = printed.lines().find(|line| line.starts_with(kind) && line.contains(name));
        let bytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<usize>().ok());
        bytes.ok_or_else(|| format!("budget says nothing of {kind}: {name}"))
    };
    let ram = of("ram", "coefficients, paper's")? + of("ram", "state beside")? + of("ram", "delay lines of")?;
    Ok([processor.flash("paper_step"), ram as u64, of("stack", "paper's model")? as u64].map(|bytes| bytes.to_string()))
}

fn line(processor: Processor, what: &str, numbers: [f64; 2], off: &str, bytes: &[String; 3]) -> Vec<String> {
    let numbers = numbers.map(|number| format!("{number:.0}"));
    let mut line = vec![processor.name().to_owned(), what.to_owned()];
    line.extend(numbers);
    line.push(off.to_owned());
    line.extend_from_slice(bytes);
    line
}

/// The peers' accurate rows for `press` in float with few substeps.
fn opponents(theirs: &Value, processor: Processor) -> Result<Vec<Opponent<'_>>, Box<dyn Error>> {
    let rows = list(&theirs["target"])?.iter().filter_map(|found| {
        let substeps = found["S"].as_u64()?;
        let is_one = found["cpu"] == of_peers(processor) && found["drive"] == DRIVE && found["real"] == "float";
        let label = Some(text(&found["label"])).filter(|label| !label.is_empty()).unwrap_or("-O2".to_owned());
        (is_one && substeps <= 4 && found["ok"] == true).then_some((label, substeps, found))
    });
    Ok(rows.collect())
}
