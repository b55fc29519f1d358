//! A step on the target: instructions under QEMU, ours by the firmware's `budget`, the peers' by their `bench_target.py`.

use std::error::Error;
use std::fmt::Write;

use serde_json::Value;
use system_tests::emulator::Processor;

use crate::page::{Part, Wanted, table};
use crate::peers::{self, list, number, text};

/// Rows of `budget` that stand beside the peers'.
const OURS: [&str; 3] = ["paper's model, steps", "paper's model, random", "paper's model, random under load"];
/// The row that is compared, of the drive `press`.
const COMPARED: &str = OURS[1];

/// A row of the peers: flags, substeps, figures.
type Opponent<'a> = (String, u64, &'a Value);

/// What the peers call a processor.
fn of_peers(processor: Processor) -> &'static str {
    match processor {
        Processor::M4F => "M4F",
        Processor::M3 => "M3",
    }
}

/// How many instructions of the opponent's one of ours may at most take the place of: wanted.
fn wanted(processor: Processor) -> f64 {
    match processor {
        Processor::M4F => 1.0,
        Processor::M3 => 30.0,
    }
}

/// Mean and worst instructions of a row that `budget` printed.
fn row(printed: &str, name: &str) -> Option<(f64, f64)> {
    let line = printed.lines().find(|line| line.starts_with("instructions") && line.ends_with(&format!(" {name}")))?;
    let mut numbers = line.split_whitespace().skip(1).map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

/// The part.
pub(crate) fn part() -> Result<Part, Box<dyn Error>> {
    let mut part = Part { text: "## A step on the target\n\n".to_owned(), wanted: Vec::new() };
    let theirs = peers::on_target()?;
    let mut lines = Vec::new();
    for processor in Processor::ALL {
        if !processor.can_be_emulated() {
            writeln!(part.text, "{} is left out: no QEMU, or no such target of Rust.\n", processor.name())?;
            continue;
        }
        let printed = processor.run("budget");
        for name in OURS {
            let (mean, worst) = row(&printed, name).ok_or_else(|| format!("budget says nothing of {name}"))?;
            lines.push(line(
                processor,
                &format!("**core, fixed point**: {name}"),
                [mean, worst],
                "accurate, see above",
            ));
        }
        let (ours, _) = row(&printed, COMPARED).ok_or("it was there a moment ago")?;
        let Some(theirs) = &theirs else { continue };
        for (label, substeps, found) in opponents(theirs, processor)? {
            let off = format!("{:.0e} / {:.0e}", number(&found["err_y"])?, number(&found["err_p"])?);
            let numbers = [number(&found["random"])?, number(&found["worst"])?];
            lines.push(line(processor, &format!("RK4 C {label}, S={substeps}"), numbers, &off));
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
        "Instructions under QEMU with `-icount shift=0`, the worst tick to 40. Ours is the step of `PaperDrive` for the drive `press` under signals of its own\n\
         (a row each), with parameters of the run time; fixed point is on the desktop bit for bit what it is here. The peers' rows are for\n\
         `press` under their random steps, with parameters that are constants of the compiler.\n"
    )?;
    if theirs.is_none() {
        writeln!(part.text, "The peers' figures are not at hand: no opponents.\n")?;
    }
    let head = ["processor", "what", "instructions a tick, mean", "worst", "off, position % / pressure %"];
    write!(part.text, "{}", table(&head, &lines))?;
    Ok(part)
}

fn line(processor: Processor, what: &str, [mean, worst]: [f64; 2], off: &str) -> Vec<String> {
    vec![processor.name().to_owned(), what.to_owned(), format!("{mean:.0}"), format!("{worst:.0}"), off.to_owned()]
}

/// The peers' accurate rows for `press` in float with few substeps.
fn opponents(theirs: &Value, processor: Processor) -> Result<Vec<Opponent<'_>>, Box<dyn Error>> {
    let rows = list(&theirs["target"])?.iter().filter_map(|found| {
        let substeps = found["S"].as_u64()?;
        let is_one = found["cpu"] == of_peers(processor) && found["drive"] == "press" && found["real"] == "float";
        let label = Some(text(&found["label"])).filter(|label| !label.is_empty()).unwrap_or("-O2".to_owned());
        (is_one && substeps <= 4 && found["ok"] == true).then_some((label, substeps, found))
    });
    Ok(rows.collect())
}
