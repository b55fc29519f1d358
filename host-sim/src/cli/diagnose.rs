//! `host-sim diagnose`: find the misfit, name the missing physics, show how the fit improves.

use std::path::{Path, PathBuf};
use std::slice;

use diagnosis::agreement::follower;
use diagnosis::{Diagnosis, Options, Verdict, base_parameters, diagnose_with, read_absolute, steps};
use identification::compare::judged;
use machine_file::MachineFile;
use model_core::machine::Tick;
use recording::files::folder;
use recording::{ChannelMap, PressureZero, Recording, Signal};
use report::evidence::Exhibits;
use report::{html, json, terminal, wording};
use simulation::is_driven_by_pressures;

use super::about::about;
use super::console::{Console, Progress, Tone};
use super::ending::{DOCUMENT, DRAWING, MACHINE, PAGE};
use super::error::CliError;
use super::target::{check_apart, check_targets, save_fitted, write, write_document};
use super::{Outcome, input};

/// Arguments of `diagnose`.
#[derive(Clone, Debug, clap::Args)]
#[command(override_usage = "\
host-sim diagnose [OPTIONS] <FOLDER>
       host-sim diagnose [OPTIONS] --machine <M.toml> --train <R.csv>... [--holdout <R.csv>...]
       host-sim diagnose [OPTIONS] --since <THEN.toml> --train <R.csv>... [--holdout <R.csv>...]
       host-sim diagnose [OPTIONS] --since <THEN>... <FOLDER>")]
#[command(after_help = "Examples:
  host-sim diagnose examples/press-63-40
  host-sim diagnose --machine M.toml --train a.csv b.csv c.csv --holdout d.csv \\
      --json D.json --save-machine F.toml --report D.html
  host-sim diagnose --since F.toml --train a-year-later.csv another.csv --holdout third.csv

Training recordings make the choice, each left out in turn; the held-out ones are opened once, after \
it, to confirm or veto. The report of a FOLDER goes to diagnosis-<name>.html in the working folder \
unless --report says otherwise.
Recordings: CSV, TwinCAT Scope text, .xlsx, .mat, .mf4, .parquet, each also .gz.")]
pub struct Arguments {
    /// Folder with machine.toml, train-* and holdout-*
    #[arg(value_name = "FOLDER", required_unless_present_any = ["machine", "since"], conflicts_with_all = ["machine", "train", "holdout"])]
    folder: Option<PathBuf>,
    /// Machine file of the drive (TOML, SI units)
    #[arg(long, value_name = "M.toml", requires = "train")]
    machine: Option<PathBuf>,
    /// What has changed since this machine file was written, or since these recordings were made
    ///
    /// The file stands in the place of --machine or of the folder's own, and the effects that it holds may have become more or less. Recordings of then
    /// are diagnosed first. A folder at their end is FOLDER
    #[arg(long, value_name = "THEN", num_args = 1..)]
    since: Vec<PathBuf>,
    /// Recordings to train on
    #[arg(long, value_name = "R.csv", num_args = 1..)]
    train: Vec<PathBuf>,
    /// Recordings to confirm on, never used to choose
    #[arg(long, value_name = "R.csv", num_args = 1..)]
    holdout: Vec<PathBuf>,
    /// Column of a signal, where its header does not say; may be repeated
    #[arg(long = "map", value_name = "name=header")]
    maps: Vec<String>,
    /// Judge by these signals only: `spool,pressure_a`
    ///
    /// As though the model's others had not been measured
    #[arg(long, value_name = "signal,…", value_delimiter = ',', value_parser = judged::named)]
    judge: Vec<Signal>,
    /// Step of the model in ms
    ///
    /// Without it 1, or 0.5 for recordings faster than that, or 2 below 50 Hz
    #[arg(long, value_enum, value_name = "ms")]
    tick: Option<input::TickArgument>,
    /// What the search may take, in s on two usual cores; it then ends and claims nothing
    ///
    /// It is counted in simulated ticks at a fixed price and not by a clock, so that the same input gives the same answer on every machine: a slow or busy
    /// machine takes longer. A search that reaches the limit ends with the step that it is in, and says what it did not try and what was slow
    #[arg(long, value_name = "s", default_value_t = Options::USUAL_LIMIT_S, value_parser = seconds, allow_negative_numbers = true)]
    time_limit: f64,
    /// Write the diagnosis for programs; `-` prints it in place of the text
    #[arg(long, value_name = "D.json")]
    json: Option<PathBuf>,
    /// Write the machine file with refitted parameters and the effects found
    #[arg(long, value_name = "F.toml")]
    save_machine: Option<PathBuf>,
    /// Write a page for people
    #[arg(long, value_name = "D.html")]
    report: Option<PathBuf>,
    /// Draw the first held-out recording: recorded, before and after
    #[arg(long, value_name = "P.svg")]
    plot: Option<PathBuf>,
    /// Take the recordings as they are
    ///
    /// Even where a channel is certainly reversed, exchanged or in another unit
    #[arg(long)]
    as_recorded: bool,
    /// Answer 1 when something is missing or unexplained
    #[arg(long)]
    exit_code: bool,
}

/// What is diagnosed, read and checked.
struct Job {
    machine: PathBuf,
    file: MachineFile,
    /// Recordings of then.
    then: Vec<Recording>,
    training: Vec<Recording>,
    held_out: Vec<Recording>,
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let mut job = job(arguments, console)?;
    let failed = |machine: &Path, cause| CliError::Diagnose { machine: machine.to_owned(), cause: Box::new(cause) };
    let tick = arguments.tick.map(Into::into);
    let absolute = is_absolute(&job.machine, &job.file, &job.training, tick, console)?;
    if absolute {
        job.training.iter_mut().chain(&mut job.held_out).for_each(Recording::take_as_absolute);
    }
    let read: Vec<&Recording> = job.training.iter().chain(&job.held_out).collect();
    note_recordings(&job, &read, console)?;
    console.detail(format_args!(
        "read: {} training and {} held-out recordings, {} rows",
        job.training.len(),
        job.held_out.len(),
        job.training.iter().chain(&job.held_out).map(Recording::rows).sum::<usize>()
    ));
    let bar = console.working("comparing recordings and machine file");
    let doubts =
        input::doubts(&job.machine, &job.file, job.training.iter().chain(&job.held_out), arguments.as_recorded);
    bar.finish_and_clear();
    let doubts = doubts?;
    let options = Options { tick, asks_since: false, limit_s: Some(arguments.time_limit) };
    let then = diagnose_then(&mut job, options, arguments, console)?;
    let options = Options { asks_since: !arguments.since.is_empty(), ..options };
    let bar = progress(&job.file, "diagnosing", console);
    let diagnosis = diagnose_with(&job.file, (&job.training, &job.held_out), options, &|_| bar.inc(1));
    bar.finish_and_clear();
    let diagnosis = Diagnosis { doubts, then, ..diagnosis.map_err(|cause| failed(&job.machine, cause))? };
    console.detail(terminal::sentence(&diagnosis));
    console.detail(format_args!("search: {}", wording::slow(&diagnosis.selection.searched)));
    let bar = console.working("drawing up the evidence");
    let exhibits = Exhibits::of(&job.file, &job.training, &job.held_out, &diagnosis, job.report.is_some());
    bar.finish_and_clear();
    let exhibits = exhibits.map_err(|cause| failed(&job.machine, cause.into()))?;

    if let Some(path) = &arguments.json {
        write_document(path, &format!("{:#}\n", json::document(&diagnosis, &exhibits)), console)?;
    }
    if let Some(path) = &job.report {
        write(path, html::page(&diagnosis, &exhibits, &about(slice::from_ref(&job.machine))))?;
    }
    if let (Some(path), Some(shown)) = (&arguments.plot, diagnosis.example()) {
        write(path, html::overlay(&diagnosis, shown))?;
    }
    let text = terminal::text(&diagnosis, &exhibits);
    let (verdict, rest) = text.split_once('\n').unwrap_or((text.as_str(), ""));
    console.verdict(verdict, tone(diagnosis.verdict))?;
    console.print(rest)?;
    if let Some(path) = &job.report {
        console.print(format_args!("report: {}", path.display()))?;
    }
    // The last: whatever is not saved has been told.
    if let Some(path) = &arguments.save_machine {
        let mut after = diagnosis.machine_file(&job.file);
        if absolute {
            after.channels.pressure = PressureZero::Absolute;
        }
        save_fitted(path, &after, tick, console)?;
    }
    let missing = diagnosis.verdict != Verdict::NothingMissing;
    Ok(if arguments.exit_code && missing { Outcome::OutOfTolerance } else { Outcome::Done })
}

/// Whether the pressures of these recordings count from a vacuum.
fn is_absolute(
    machine: &Path,
    file: &MachineFile,
    recordings: &[Recording],
    tick: Option<Tick>,
    console: &Console<'_>,
) -> Result<bool, CliError> {
    let bar = console.working("looking at the pressures' zero");
    let absolute = read_absolute(file, recordings, tick);
    bar.finish_and_clear();
    absolute.map_err(|cause| CliError::Diagnose { machine: machine.to_owned(), cause: Box::new(cause) })
}

/// What was noted as the recordings were read, and doubts about their units, unless what they show has another reason: it follows what drives it.
fn note_recordings(job: &Job, recordings: &[&Recording], console: &Console<'_>) -> Result<(), CliError> {
    recordings.iter().copied().flat_map(input::own_notes).for_each(|note| console.note(note));
    let by_pressures = |recording: &&&Recording| is_driven_by_pressures(job.file.machine.source, recording);
    if let Some(recording) = recordings.iter().find(by_pressures) {
        console.note(format_args!(
            "{}: neither command, spool, flow nor force is recorded: pa·Aa − pb·Ab drives the model as the force on the rod",
            recording.name()
        ));
    }
    let of_units = |recording: &&Recording| input::unit_notes(recording, &job.file.machine);
    let doubts: Vec<String> = recordings.iter().flat_map(of_units).collect();
    if doubts.is_empty() {
        return Ok(());
    }
    let found = follower(&job.file, &base_parameters(&job.file), recordings);
    let found =
        found.map_err(|cause| CliError::Diagnose { machine: job.machine.clone(), cause: Box::new(cause.into()) })?;
    if found.is_none() {
        for doubt in doubts {
            console.note(doubt);
        }
    }
    Ok(())
}

/// Where there are recordings of then: the machine file with what they tell in the place of the job's, and how that diagnosis ended. What is noted and
/// doubted of them is told as of the others.
fn diagnose_then(
    job: &mut Job,
    options: Options,
    arguments: &Arguments,
    console: &Console<'_>,
) -> Result<Option<Verdict>, CliError> {
    if job.then.is_empty() {
        return Ok(None);
    }
    if is_absolute(&job.machine, &job.file, &job.then, options.tick, console)? {
        job.then.iter_mut().for_each(Recording::take_as_absolute);
    }
    note_recordings(job, &job.then.iter().collect::<Vec<_>>(), console)?;
    for doubt in input::doubts(&job.machine, &job.file, &job.then, arguments.as_recorded)? {
        console.note(format_args!("then: doubt: {}", wording::doubt(&doubt)));
    }
    let bar = progress(&job.file, "diagnosing then", console);
    let then = diagnose_with(&job.file, (&job.then, &[]), options, &|_| bar.inc(1));
    bar.finish_and_clear();
    let then = then.map_err(|cause| CliError::Diagnose { machine: job.machine.clone(), cause: Box::new(cause) })?;
    console.note(format_args!("then: {}", terminal::sentence(&then)));
    if !then.selection.searched.is_finished() {
        return Err(CliError::ThenUnfinished { machine: job.machine.clone() });
    }
    job.file = then.machine_file(&job.file);
    Ok(Some(then.verdict))
}

/// A limit in seconds.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let found = text.parse::<f64>().ok().filter(|seconds| seconds.is_finite() && *seconds > 0.0);
    found.ok_or_else(|| format!("`{text}` is no limit of time; expected seconds above 0, such as 300"))
}

/// A bar over the steps of a diagnosis.
fn progress(file: &MachineFile, doing: &'static str, console: &Console<'_>) -> Progress {
    console.progress(usize::try_from(steps(file)).unwrap_or(usize::MAX), doing)
}

const fn tone(verdict: Verdict) -> Tone {
    match verdict {
        Verdict::NothingMissing => Tone::Good,
        Verdict::MissingPhysics => Tone::Bad,
        Verdict::Unexplained => Tone::Open,
    }
}

fn job(arguments: &Arguments, console: &Console<'_>) -> Result<Job, CliError> {
    let maps = ChannelMap::from_arguments(arguments.maps.iter().map(String::as_str))?;
    let (folder, all_of_then) = folder(arguments);
    let (then, recordings_of_then) = then(arguments, all_of_then)?;
    if !all_of_then.is_empty() && folder.is_none() && arguments.train.is_empty() {
        return Err(CliError::Since { found: "no recording of now".to_owned(), is_now: true });
    }
    let (machine, train, holdout, report) = match (folder, then.or(arguments.machine.as_ref())) {
        (Some(folder), machine) => {
            let name =
                folder.file_name().map_or_else(|| "drive".to_owned(), |name| name.to_string_lossy().into_owned());
            let report = arguments.report.clone().unwrap_or_else(|| PathBuf::from(format!("diagnosis-{name}.html")));
            let train = listed(folder, "train-")?;
            if train.is_empty() {
                return Err(CliError::NothingToTrain { folder: folder.clone() });
            }
            let machine = machine.cloned().unwrap_or_else(|| folder.join("machine.toml"));
            (machine, train, listed(folder, "holdout-")?, Some(report))
        }
        (None, Some(machine)) => {
            (machine.clone(), arguments.train.clone(), arguments.holdout.clone(), arguments.report.clone())
        }
        (None, None) if !arguments.since.is_empty() => {
            return Err(CliError::Since { found: "recordings and no machine file".to_owned(), is_now: false });
        }
        (None, None) => return Err(CliError::NothingToTrain { folder: PathBuf::from(".") }),
    };
    // A refined machine file may replace the one that it was made from; no other result may replace an input.
    let recordings = [train.as_slice(), &holdout, recordings_of_then].concat();
    let saved = ("--save-machine", arguments.save_machine.as_deref(), MACHINE);
    check_targets(&[saved], &recordings)?;
    let others = [
        ("--json", arguments.json.as_deref(), DOCUMENT),
        ("--report", report.as_deref(), PAGE),
        ("--plot", arguments.plot.as_deref(), DRAWING),
    ];
    check_targets(&others, &[recordings.as_slice(), std::slice::from_ref(&machine)].concat())?;
    check_apart(&[others.as_slice(), &[saved]].concat())?;
    let file = machine_file::read(&machine)?;
    let channels = file.channels.clone().overlaid_with(&maps);
    let read = input::recordings(&recordings, &channels, console)?;
    let judged = read.into_iter().map(|recording| input::judged(recording, &file, &arguments.judge));
    let mut training = judged.collect::<Result<Vec<_>, _>>()?;
    let mut held_out = training.split_off(train.len());
    let then = held_out.split_off(holdout.len());
    check_distinct(&training, &held_out, &then)?;
    Ok(Job { machine, file, then, training, held_out, report })
}

/// The folder, and what is of then: a folder behind that is none of it.
fn folder(arguments: &Arguments) -> (Option<&PathBuf>, &[PathBuf]) {
    let named = [&arguments.train, &arguments.holdout];
    let stands_alone =
        arguments.folder.is_none() && arguments.machine.is_none() && named.iter().all(|named| named.is_empty());
    match arguments.since.split_last() {
        Some((last, of_then)) if stands_alone && !of_then.is_empty() && last.is_dir() => (Some(last), of_then),
        _ => (arguments.folder.as_ref(), &arguments.since),
    }
}

/// The machine file of then, or the recordings of then.
fn then<'a>(arguments: &Arguments, of_then: &'a [PathBuf]) -> Result<(Option<&'a PathBuf>, &'a [PathBuf]), CliError> {
    let is_file = |path: &PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    let refused = |found: &str| Err(CliError::Since { found: found.to_owned(), is_now: false });
    if let Some(folder) = of_then.iter().find(|path| path.is_dir()) {
        return refused(&format!("the folder {}", folder.display()));
    }
    match of_then {
        [file] if is_file(file) && arguments.machine.is_some() => refused("a machine file beside that of --machine"),
        [file] if is_file(file) => Ok((Some(file), &[])),
        all if all.iter().any(is_file) => refused("a machine file among others"),
        recordings => Ok((None, recordings)),
    }
}

/// A recording cannot confirm effects that it was used to choose, and counts only once, whatever its name, even as a copy.
fn check_distinct(training: &[Recording], held_out: &[Recording], then: &[Recording]) -> Result<(), CliError> {
    let all: Vec<&Recording> = training.iter().chain(held_out).chain(then).collect();
    let Some((first, second)) = Recording::held_twice(&all) else { return Ok(()) };
    let is_held_out = (training.len()..training.len() + held_out.len()).contains(&second);
    let expected = if first < training.len() && is_held_out {
        "held-out recordings that are not trained on"
    } else {
        "each recording once"
    };
    let (first, second) = (all[first].path().to_owned(), all[second].path().to_owned());
    Err(CliError::SameRecording { first, second, expected })
}

/// The recordings of a folder whose names begin with this prefix, each in one format.
fn listed(folder: &Path, prefix: &str) -> Result<Vec<PathBuf>, CliError> {
    let found =
        folder::listed(folder, prefix).map_err(|cause| CliError::Folder { folder: folder.to_owned(), cause })?;
    match folder::in_two_formats(&found) {
        Some((first, second)) => {
            let (first, second) = (first.display().to_string(), second.display().to_string());
            Err(CliError::SameRecording { first, second, expected: "each recording in one format" })
        }
        None => Ok(found),
    }
}
