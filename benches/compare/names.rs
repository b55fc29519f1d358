//! Names of missing physics, against `PySINDy` on the residuals of the same cases: the shared concealed cases, judged by their own scorer.

use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use system_tests::at_hand::shared;

use crate::page::{Part, table};
use crate::peers::{self, Peers, number, text};
use crate::{child, machine};

/// The sets of cases, of `$HOST_SIM_SHARED`, and what judges them.
const SETS: [&str; 2] = ["concealed", "concealed-hard"];
const SCORER: &str = "score.py";
/// What the scorer's last line says about one tool, and its name here.
const SCORES: [(&str, &str); 4] = [
    ("single effects named ", "singles exact"),
    ("pairs ", "pairs exact"),
    ("decoys left alone ", "nothing missing, no finding"),
    ("outside the catalogue owned up to ", "out of the catalogue, no finding"),
];
/// Threads of the tool; the opponent has one.
const THREADS: usize = 2;

/// A tool that diagnoses.
struct Tool {
    name: String,
    results: PathBuf,
    wall_s: f64,
    computed_s: f64,
    peak_mb: f64,
}

impl Tool {
    fn new(name: String, results: PathBuf) -> Result<Self, Box<dyn Error>> {
        std::fs::create_dir_all(&results)?;
        Ok(Self { name, results, wall_s: 0.0, computed_s: 0.0, peak_mb: 0.0 })
    }

    /// Where the diagnosis of a case is written.
    fn result(&self, case: &Path) -> Result<String, Box<dyn Error>> {
        let name = case.file_name().ok_or("a case has a name")?;
        text_of(&self.results.join(name).with_extension("json"))
    }

    fn took(&mut self, wall_s: f64, computed_s: f64, peak_mb: f64) {
        self.peak_mb = self.peak_mb.max(peak_mb);
        self.wall_s += wall_s;
        self.computed_s += computed_s;
    }

    /// A row of the table.
    fn line(&self, scorer: &Path, set: &str, folder: &Path, count: usize) -> Result<Vec<String>, Box<dyn Error>> {
        let printed = scored(scorer, folder, &self.results)?;
        let last = printed.lines().last().ok_or("the scorer says nothing")?;
        let mut line = vec![format!("`{set}`"), self.name.clone()];
        for (said, _) in SCORES {
            let found = last.split(", ").find_map(|part| part.strip_prefix(said));
            let found = found.ok_or_else(|| format!("the scorer does not say `{said}`: {last}"))?;
            line.push(found.split(' ').next().unwrap_or(found).to_owned());
        }
        line.push(format!("{:.1}", self.wall_s / count as f64));
        line.push(format!("{:.1}", self.computed_s / count as f64));
        line.push(format!("{:.0}", self.peak_mb));
        let missed = printed.lines().filter_map(|row| row.strip_prefix("NO ")?.split_whitespace().next());
        line.push(missed.collect::<Vec<_>>().join(" "));
        Ok(line)
    }
}

fn text_of(path: &Path) -> Result<String, Box<dyn Error>> {
    Ok(path.to_str().ok_or("a folder whose name is not text")?.to_owned())
}

/// What the scorer prints about results.
fn scored(scorer: &Path, folder: &Path, results: &Path) -> Result<String, Box<dyn Error>> {
    let output = Command::new(peers::python()).arg(scorer).args([folder, results]).output()?;
    if !output.status.success() {
        return Err(format!("{SCORER}: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    Ok(String::from_utf8(output.stdout)?)
}

/// The contents of a folder, by name.
fn within(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    entries.sort();
    Ok(entries)
}

/// The cases of a set.
fn cases(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    Ok(within(folder)?.into_iter().filter(|path| path.join("machine.toml").is_file()).collect())
}

/// Recordings of a case whose names begin with this prefix.
fn recordings(case: &Path, prefix: &str) -> Result<Vec<String>, Box<dyn Error>> {
    let begins = |path: &&PathBuf| {
        path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(prefix))
            && path.extension().is_some_and(|ending| ending == "csv")
    };
    within(case)?.iter().filter(begins).map(|path| text_of(path)).collect()
}

/// Both tools on all cases, in turns.
fn diagnosed(
    cases: &[PathBuf],
    ours: &mut Tool,
    theirs: Option<(&mut Tool, &mut Peers)>,
) -> Result<(), Box<dyn Error>> {
    let mut theirs = theirs;
    for case in cases {
        let (machine, result) = (text_of(&case.join("machine.toml"))?, ours.result(case)?);
        let (training, held_out) = (recordings(case, "train-")?, recordings(case, "holdout-")?);
        let mut arguments = vec!["diagnose", "--machine", &machine, "--json", &result, "--train"];
        arguments.extend(training.iter().map(String::as_str));
        arguments.push("--holdout");
        arguments.extend(held_out.iter().map(String::as_str));
        let took = child::host_sim(THREADS, &arguments)?;
        ours.took(took.wall_s, took.computed_s, took.peak_mb);
        if let Some((tool, peers)) = &mut theirs {
            let found = peers.ask(&format!("{}\t{}", text_of(case)?, tool.result(case)?))?;
            let peak_mb = number(&found["peak_kb"])? / 1024.0;
            tool.took(number(&found["seconds"])?, number(&found["computed"])?, peak_mb);
        }
    }
    Ok(())
}

/// This part of the comparison.
pub(crate) fn part() -> Result<Part, Box<dyn Error>> {
    let mut part = Part { text: "## Names, against PySINDy\n\n".to_owned(), wanted: Vec::new() };
    let Some(scorer) = shared(SETS[0]).map(|set| set.join(SCORER)).filter(|scorer| scorer.is_file()) else {
        writeln!(part.text, "Left out: `{}/{SCORER}` is not at hand.\n", SETS[0])?;
        return Ok(part);
    };
    let load = machine::load()?;
    let scratch = tempfile::tempdir()?;
    let (mut versions, mut lines) = (None, Vec::new());
    for set in SETS {
        let Some(folder) = shared(set) else {
            writeln!(part.text, "Left out: `{set}` is not at hand.\n")?;
            continue;
        };
        let cases = cases(&folder)?;
        // One process for each set: the peak memory of a process never falls.
        let mut opponent = if peers::can_import("numba, pysindy") { Peers::start("sindy.py")? } else { None };
        versions = opponent.as_ref().map(|(_, said)| text(&said["versions"]));
        let results = scratch.path().join(set);
        let mut ours = Tool::new("**`host-sim diagnose`**".to_owned(), results.join("ours"))?;
        let mut theirs = Tool::new("PySINDy, weak form".to_owned(), results.join("theirs"))?;
        diagnosed(&cases, &mut ours, opponent.as_mut().map(|(peers, _)| (&mut theirs, peers)))?;
        let tools = if opponent.is_some() { vec![&ours, &theirs] } else { vec![&ours] };
        for tool in tools {
            lines.push(tool.line(&scorer, set, &folder, cases.len())?);
        }
    }
    if lines.is_empty() {
        return Ok(part);
    }
    writeln!(
        part.text,
        "Each case once, in turns, and judged by the scorer of the cases: the set of effects must be the one that is missing, or one that the noise leaves to be found.\n\
         The tool is a process a case with {THREADS} threads, without its page, and also checks its findings on the held-out recordings. The opponent is `benches/peers/sindy.py`, one\n\
         process and one thread, whose start is not counted: `WeakPDELibrary` and `STLSQ` with what an expert adds (noise that the sensors predict, parameters\n\
         refitted and projected out, one shape an effect, signs, the likeliest simulated once more). It refits the base model itself, which is counted, and its memory is that of all cases of a set in one process, imports and compiler\n\
         included; the tool's is that of its largest case. Both were\n\
         developed with these cases at hand: neither score is one on unknown cases. The load before was {load}.\n"
    )?;
    match versions {
        Some(versions) => writeln!(part.text, "Opponent: {versions}.\n")?,
        None => writeln!(part.text, "PySINDy is not at hand: no opponent.\n")?,
    }
    let mut head = vec!["cases", "tool"];
    head.extend(SCORES.map(|(_, called)| called));
    head.extend(["s a case", "s, of all threads", "most memory, MB", "missed"]);
    write!(part.text, "{}", table(&head, &lines))?;
    Ok(part)
}
