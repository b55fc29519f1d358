//! `host-sim simulate`: the signals of the model for a recording or for an input signal.

use std::cell::OnceCell;
use std::fs::File;
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use experiment::standard_tests::StandardTest;
use identification::along;
use identification::compare::judged;
use machine_file::LoadSource;
use model_core::machine::{Machine, Source, Tick};
use recording::excitation::signals::Excitation;
use recording::files::atomic::Begun;
use recording::{Format, Linkage, Recording, Series, Signal};
use report::plot;
use report::wording::{linkage_ends, sensor_ends, starts_anywhere, starts_in_play};
use simulation::{
    Arithmetic, InChunks, InputPoint, SimulateError, StartOffset, Stimulus, Trajectory, first_input_point, tick_for,
};

use super::Outcome;
use super::console::{Console, Progress};
use super::ending::{DOCUMENT, DRAWING, RECORDING, is_standard_output};
use super::error::CliError;
use super::input::{self, MachineArguments};
use super::simulated::{Made, document_of};
use super::target::{check_one_output, check_targets, tell, unwritten, write};

/// Arguments of `simulate`.
#[derive(Clone, Debug, clap::Args)]
#[command(override_usage = "\
host-sim simulate [OPTIONS] --machine <M.toml> --out <S.csv> --recording <R.csv>
       host-sim simulate [OPTIONS] --machine <M.toml> --out <S.csv> --input <signal>")]
#[command(after_help = "Examples:
  host-sim simulate --machine M.toml --recording run.csv --out simulated.csv
  host-sim simulate --machine M.toml --input \"step:4V\" --out step.csv

With --recording the file holds one row per recorded row in the recording's own columns and units; the \
signals that the model computes are replaced, or added in SI units where the recording has none. With a \
linkage in the machine file the joint's angle, too. Where its sensor reached an end of its range, a \
signal ends there. A row with a repeated time or an empty cell keeps what it holds and gets the signals \
at its time. With --input the drive starts at mid-stroke, at rest, and every signal is written in SI \
units: spool, position, velocity, both pressures, flow into A, force of the oil.
Inputs: zero:2s  step:4V,0.5s  steps:4V  sweep:6.5V,0.4Hz,5Hz,4s  triangle:2V,0.5Hz,4s
        random:10V,0.08s,0.5s,4s,seed=1")]
#[command(group(clap::ArgGroup::new("stimulus").required(true).args(["recording", "input"])))]
pub struct Arguments {
    #[command(flatten)]
    pub(super) machine: MachineArguments,
    /// Recording to simulate
    #[arg(long, value_name = "R.csv")]
    pub(super) recording: Option<PathBuf>,
    /// Signal at the command in its unit, V or mA, such as "step:4V"
    #[arg(long, value_name = "signal")]
    pub(super) input: Option<String>,
    /// Where to write the signals: .csv, .txt, .mat or .parquet; - is standard output
    ///
    /// No ending is CSV, as is standard output. A file is there whole or not at all; standard output and a pipe have what came before an error
    #[arg(long, value_name = "S.csv")]
    pub(super) out: PathBuf,
    /// Also draw recorded against simulated
    #[arg(long, value_name = "P.svg", requires = "recording")]
    plot: Option<PathBuf>,
    /// Write what was simulated, and between which values, for programs; `-` prints it
    #[arg(long, value_name = "S.json")]
    json: Option<PathBuf>,
}

/// What is simulated, checked.
struct Job {
    name: String,
    machine: Machine<f64>,
    load: LoadSource,
    /// Between joint and rod.
    linkage: Option<Arc<Linkage>>,
    /// The recording, or the input signal alone.
    recording: Recording,
    input_point: InputPoint,
    tick: Tick,
    arithmetic: Arithmetic,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let read: Vec<PathBuf> = arguments.recording.iter().chain([&arguments.machine.machine]).cloned().collect();
    let out = Some(arguments.out.as_path()).filter(|out| !is_standard_output(out));
    check_one_output(&arguments.out, arguments.json.as_deref())?;
    let document = ("--json", arguments.json.as_deref(), DOCUMENT);
    check_targets(&[("--out", out, RECORDING), ("--plot", arguments.plot.as_deref(), DRAWING), document], &read)?;
    let is_text = matches!(Format::of_extension(&arguments.out), Some(Format::Text) | None);
    let made = match &arguments.recording {
        Some(path) if is_text && arguments.plot.is_none() => in_parts(arguments, path, console)?,
        _ => at_once(arguments, console)?,
    };
    tell(arguments.json.as_deref(), || document_of(arguments, &made), console)?;
    Ok(Outcome::Done)
}

/// Simulates a recording part by part and writes each part before the next is read: the memory does not grow with its length.
fn in_parts(arguments: &Arguments, path: &Path, console: &mut Console<'_>) -> Result<Made, CliError> {
    let bar = input::bar(&[path.to_owned()], console, "simulating");
    let done = each_part(arguments, path, console, &bar);
    bar.finish_and_clear();
    done
}

fn each_part(arguments: &Arguments, path: &Path, console: &mut Console<'_>, bar: &Progress) -> Result<Made, CliError> {
    let (file, channels) = arguments.machine.read()?;
    // A second handle on the same file shows how far it has been read; a pipe has no position.
    let read = OnceCell::new();
    let mut parts = recording::in_parts(path, &channels, |file| {
        if let Ok(same) = file.try_clone() {
            let _ = read.set(same);
        }
        file
    })?;
    let mut part = parts.read_next()?.expect("a text without rows is an error");
    bar.aside(|| {
        for note in input::notes(&part.recording, &file.machine).into_iter().chain(starts_anywhere(&part.recording)) {
            console.note(note);
        }
        console.detail(format_args!("read: the first {} rows", part.recording.rows()));
    });
    let failed = |cause| CliError::Simulate { machine: arguments.machine.machine.clone(), cause };
    let input_point = first_input_point(file.machine.source, &part.recording).map_err(failed)?;
    let tick = arguments.machine.model.tick().unwrap_or_else(|| tick_for(&part.recording, &file.machine));
    let start = start_in_play(&file.machine, &part.recording, file.load_source, tick, |note| {
        bar.aside(|| console.note(note));
    });
    let mut in_chunks =
        InChunks::new(&file.machine, input_point, file.load_source, tick, arguments.machine.model.arithmetic.into())
            .starting(start);
    let mut out = Target::new(&arguments.out)?;
    let mut ended: Vec<Signal> = Vec::new();
    let mut made = Made::of(&file.name, input_point, tick);
    loop {
        let mut advance = in_chunks.part(&part).map_err(failed)?;
        for (signal, note) in as_sensed(&part.recording, channels.linkage.as_deref(), &mut advance.trajectory) {
            if !ended.contains(&signal) {
                bar.aside(|| console.note(note));
                ended.push(signal);
            }
        }
        made.add(&part.recording.time_s()[advance.rows.clone()], &advance.trajectory, &advance.rows);
        let (replaced, added) = along::columns(&part.recording, &advance.trajectory);
        let text = part.recording.csv_rows(&arguments.out, advance.rows, &replaced, &added)?;
        bar.aside(|| out.write(&text, console))?;
        if let Some(bytes) = read.get().and_then(|mut file: &File| file.stream_position().ok()) {
            bar.reach(bytes);
        }
        parts.forget_before(advance.next_from);
        let Some(next) = parts.read_next()? else { break };
        bar.aside(|| input::own_notes(&next.recording).into_iter().for_each(|note| console.note(note)));
        part = next;
    }
    out.finish()?;
    Ok(made)
}

/// Where the rows of a text are written.
enum Target {
    File(Begun, PathBuf),
    Standard,
}

impl Target {
    fn new(path: &Path) -> Result<Self, CliError> {
        if is_standard_output(path) {
            return Ok(Target::Standard);
        }
        let begun = Begun::new(path).map_err(unwritten(path))?;
        Ok(Target::File(begun, path.to_owned()))
    }

    fn write(&mut self, text: &[u8], console: &mut Console<'_>) -> Result<(), CliError> {
        match self {
            Target::File(begun, path) => begun.write_all(text).map_err(unwritten(path)),
            Target::Standard if text.is_empty() => Ok(()),
            Target::Standard => console.stream(String::from_utf8_lossy(text).trim_end()),
        }
    }

    fn finish(self) -> Result<(), CliError> {
        match self {
            Target::File(begun, path) => begun.finish().map_err(unwritten(&path)),
            Target::Standard => Ok(()),
        }
    }
}

/// Simulates at once what needs the whole recording, or an input signal.
fn at_once(arguments: &Arguments, console: &mut Console<'_>) -> Result<Made, CliError> {
    let job = job(arguments, console)?;
    for note in input::notes(&job.recording, &job.machine).into_iter().chain(starts_anywhere(&job.recording)) {
        console.note(note);
    }
    let start = start_in_play(&job.machine, &job.recording, job.load, job.tick, |note| console.note(note));
    let bar = console.share(job.recording.rows() as u64, "simulating");
    let simulated = simulate(&job, start, &|rows| bar.inc(rows as u64));
    bar.finish_and_clear();
    let mut simulated =
        simulated.map_err(|cause| CliError::Simulate { machine: arguments.machine.machine.clone(), cause })?;
    for (_, note) in as_sensed(&job.recording, job.linkage.as_deref(), &mut simulated) {
        console.note(note);
    }
    let drawing = arguments.plot.as_ref().map(|path| {
        let signals = judged(&job.recording, job.input_point, job.load);
        let panels = plot::panels(&job.recording, job.input_point, &simulated, &signals);
        (path, plot::svg(job.recording.name(), &job.name, &panels))
    });
    if arguments.recording.is_some() {
        let (replaced, added) = along::columns(&job.recording, &simulated);
        written(&job.recording, &arguments.out, &replaced, &added, console)?;
    } else {
        written(&along::response(&job.recording, &simulated)?, &arguments.out, &[], &[], console)?;
    }
    if let Some((path, svg)) = drawing {
        write(path, svg)?;
    }
    let mut made = Made::of(&job.name, job.input_point, job.tick);
    made.add(job.recording.time_s(), &simulated, &(0..job.recording.rows()));
    Ok(made)
}

/// Where in the play of its sensor the rod starts, told by a note.
fn start_in_play(
    machine: &Machine<f64>,
    recording: &Recording,
    load: LoadSource,
    tick: Tick,
    note: impl FnOnce(String),
) -> StartOffset {
    let Some(shift_m) = along::start_in_play(machine, recording, load, tick) else { return StartOffset::none() };
    note(starts_in_play(recording, shift_m));
    StartOffset { shift_m, ..StartOffset::none() }
}

/// What is simulated, as the recorded sensors and the joint show it, with a note for each signal that ends somewhere.
fn as_sensed(recording: &Recording, linkage: Option<&Linkage>, simulated: &mut Trajectory) -> Vec<(Signal, String)> {
    let ends = along::end_with_sensors(recording, simulated);
    let mut notes: Vec<(Signal, String)> =
        ends.iter().map(|(signal, ends)| (*signal, sensor_ends(recording, *signal, ends))).collect();
    if let Some(linkage) = linkage
        && along::add_angle(linkage, simulated)
    {
        notes.push((Signal::Angle, linkage_ends(recording, linkage)));
    }
    notes
}

/// Writes the signals: to standard output as CSV, where that is asked for.
fn written(
    recording: &Recording,
    out: &Path,
    replaced: &[Series<'_>],
    added: &[Series<'_>],
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    if is_standard_output(out) {
        let text = recording.csv_rows(out, 0..recording.rows(), replaced, added)?;
        return console.print(String::from_utf8_lossy(&text).trim_end());
    }
    Ok(recording.write(out, replaced, added)?)
}

fn job(arguments: &Arguments, console: &Console<'_>) -> Result<Job, CliError> {
    let (file, channels) = arguments.machine.read()?;
    let (machine, asked) = (file.machine, arguments.machine.model.tick());
    let (recording, load) = if let Some(path) = &arguments.recording {
        (input::recording(path, &channels, console)?, file.load_source)
    } else {
        let input = arguments.input.as_deref().unwrap_or_default();
        let (excitation, unit) = Excitation::read(input, channels.command_unit())?;
        if machine.source != Source::Valve {
            let (machine, source_of_drive) = (arguments.machine.machine.clone(), machine.source);
            return Err(CliError::NeedsValve { machine, source_of_drive, what: "--input" });
        }
        let test = StandardTest::of_input(&excitation, input, asked.unwrap_or(Tick::OneMillisecond));
        (test.recording_in(unit, &machine)?, LoadSource::Constant)
    };
    let input_point = first_input_point(machine.source, &recording)
        .map_err(|cause| CliError::Simulate { machine: arguments.machine.machine.clone(), cause })?;
    let tick = asked.unwrap_or_else(|| tick_for(&recording, &machine));
    Ok(Job {
        name: file.name,
        machine,
        linkage: channels.linkage,
        load,
        recording,
        input_point,
        tick,
        arithmetic: arguments.machine.model.arithmetic.into(),
    })
}

fn simulate(job: &Job, start: StartOffset, told: &dyn Fn(usize)) -> Result<Trajectory, SimulateError> {
    let stimulus = Stimulus::new(&job.recording, &job.machine, job.input_point, job.load, job.tick)?;
    job.arithmetic.simulate_with_progress(&job.machine, &stimulus, start, told)
}
