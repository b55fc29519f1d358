//! A diagnosis by recorded length, number of recordings and threads, each in a process of its own.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use diagnosis::selection::excerpt::AFFORDABLE_TICKS;

use crate::child::{self, Took, text};
use crate::growth::exponent;
use crate::machine;
use crate::page::{Part, table};

/// The effect in the cases, m³/s/Pa.
const EFFECT: (&str, &str) = ("internal-leakage", "2e-12");
/// Lengths of the one training recording, s.
const LENGTHS_S: [u32; 5] = [10, 30, 120, 600, 3600];
/// Numbers of training recordings, each of this many seconds.
const COUNTS: [u32; 6] = [1, 2, 4, 8, 30, 100];
const COUNTED_S: u32 = 10;
/// The fit alone is timed on the shipped case.
const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/press-63-40");

/// A press with leakage that a controller moves back and forth, on the virtual test bed: this number of recordings of a length, and one of 10 s
/// held out.
fn case(folder: &Path, count: u32, length_s: u32) -> Result<(), Box<dyn Error>> {
    let preset = concat!(env!("CARGO_MANIFEST_DIR"), "/../presets/press-63-40.toml");
    let effect = format!("{}={}", EFFECT.0, EFFECT.1);
    let signals: Vec<String> = (1..=count).map(|seed| format!("random:4V,0.3s,2s,{length_s}s,seed={seed}")).collect();
    let mut arguments = vec!["testbed", "--machine", preset, "--effect", &effect, "--closed-loop", "80", "--seed", "7"];
    arguments.extend(signals.iter().flat_map(|signal| ["--train", signal.as_str()]));
    arguments.extend(["--holdout", "random:4V,0.3s,2s,10s,seed=99", "--out", text(folder)?]);
    child::host_sim(2, &arguments)?;
    Ok(())
}

/// Diagnoses a folder.
fn diagnosed(folder: &Path, scratch: &Path, threads: usize) -> Result<Took, Box<dyn Error>> {
    let report = scratch.join("report.html");
    child::host_sim(threads, &["diagnose", text(folder)?, "--report", text(&report)?])
}

fn line(what: String, took: &Took) -> Vec<String> {
    let named = if took.printed.contains(EFFECT.0) { "named" } else { "**not named**" };
    vec![
        what,
        format!("{:.1}", took.wall_s),
        format!("{:.1}", took.computed_s),
        format!("{:.0}", took.peak_mb),
        named.to_owned(),
    ]
}

/// The exponent over the sizes that are searched completely, and over all sizes; a size is this number of seconds at 1 kHz.
fn exponents(points: &[(f64, f64)], seconds: u32) -> (f64, f64) {
    let is_whole = |(size, _): &(f64, f64)| 1e3 * size * f64::from(seconds) <= AFFORDABLE_TICKS as f64;
    let whole: Vec<(f64, f64)> = points.iter().copied().filter(is_whole).collect();
    (exponent(&whole), exponent(points))
}

/// This part of the comparison.
pub(crate) fn part() -> Result<Part, Box<dyn Error>> {
    let load = machine::load()?;
    let scratch = tempfile::tempdir()?;
    let scratch = scratch.path();
    let mut lines = Vec::new();
    let mut by_length = Vec::new();
    for length_s in LENGTHS_S {
        let folder = scratch.join(format!("length-{length_s}"));
        case(&folder, 1, length_s)?;
        let took = diagnosed(&folder, scratch, 1)?;
        by_length.push((f64::from(length_s), took.computed_s));
        lines.push(line(format!("1 recording of {length_s} s, one thread"), &took));
    }
    let (mut by_count, mut faster) = (Vec::new(), Vec::new());
    for count in COUNTS {
        let folder = scratch.join(format!("count-{count}"));
        case(&folder, count, COUNTED_S)?;
        let [one, two] = [1, 2].map(|threads| diagnosed(&folder, scratch, threads));
        let (one, two) = (one?, two?);
        by_count.push((f64::from(count), one.computed_s));
        faster.push(format!("{:.2} ({count})", one.wall_s / two.wall_s));
        lines.push(line(format!("{count} of {COUNTED_S} s, one thread"), &one));
        lines.push(line(format!("{count} of {COUNTED_S} s, two threads"), &two));
    }
    lines.push(line("the shipped case, two threads".to_owned(), &diagnosed(Path::new(SHIPPED), scratch, 2)?));
    let recordings: Vec<String> = (1..=4).map(|index| format!("{SHIPPED}/train-{index}.csv")).collect();
    let saved = scratch.join("fitted.toml");
    let machine = format!("{SHIPPED}/machine.toml");
    let mut arguments = vec!["fit", "--machine", &machine, "--train"];
    arguments.extend(recordings.iter().map(String::as_str));
    arguments.extend(["--save-machine", text(&saved)?]);
    let mut fitted =
        line("`host-sim fit` of the shipped case, two threads".to_owned(), &child::host_sim(2, &arguments)?);
    "–".clone_into(&mut fitted[4]);
    lines.push(fitted);

    let mut part = Part { text: "## A diagnosis\n\n".to_owned(), wanted: Vec::new() };
    writeln!(
        part.text,
        "`host-sim diagnose` from its start to the written report, once each: a press with `{}` on the virtual test bed, driven by a controller (`--closed-loop`),\n\
         one held-out recording of 10 s. Recordings of more than four minutes together are searched on their first parts and judged whole, so that long ones do not\n\
         take longer in proportion.\n",
        EFFECT.0
    )?;
    let head = ["what", "s", "s, of all threads", "most memory, MB", "the effect"];
    writeln!(part.text, "{}", table(&head, &lines))?;
    let ((length, length_all), (count, count_all)) = (exponents(&by_length, 1), exponents(&by_count, COUNTED_S));
    writeln!(
        part.text,
        "Computing time grows with recorded length to the power {length:.2} as far as it is searched whole ({length_all:.2} up to an hour), with the number of\n\
         recordings to the power {count:.2} ({count_all:.2} up to {}). Two threads are faster than one by (recordings): {}; the load before was {load}.",
        COUNTS[COUNTS.len() - 1],
        faster.join(", "),
    )?;
    Ok(part)
}
