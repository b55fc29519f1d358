//! `host-sim simulate`: the signals of the model for a recording or for an input signal.

use std::cell::OnceCell;
use std::fs::File;
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use experiment::standard_tests::StandardTest;
use identification::compare::judged;
use identification::experiment::Prepared;
use identification::fit::settle;
use machine_file::LoadSource;
use model_core::machine::{Machine, Parameter, Source, Tick};
use recording::display_unit::{significant, unit_for_people};
use recording::excitation::signals::Excitation;
use recording::files::atomic::Begun;
use recording::{Column, Format, Linkage, Recording, Series, Signal};
use report::plot;
use simulation::sensor_fault::sensor_range;
use simulation::{
    Arithmetic, InChunks, InputPoint, SimulateError, StartOffset, Stimulus, Trajectory, first_input_point, tick_for,
};

use super::Outcome;
use super::console::{Console, Progress};
use super::ending::{DRAWING, RECORDING, is_standard_output};
use super::error::CliError;
use super::input::{self, MachineArguments};
use super::target::{check_targets, unwritten, write};

/// Arguments of `simulate`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim simulate --machine M.toml --recording run.csv --out simulated.csv
  host-sim simulate --machine M.toml --input \"step:4V\" --out step.csv

With --recording the file holds one row per recorded row in the recording's own columns and units; the signals that the model
computes are replaced, with a linkage in the machine file also the joint's angle, which is added where it was not recorded; where its sensor reached an end of its range, a signal ends there. Where the recording has none of these, they are added in SI units. A row with a repeated time or an empty
cell keeps what it holds and gets the signals at its time. With --input the drive starts at mid-stroke, at rest, and every signal is
written in SI units: spool, position, velocity, both pressures, flow into A, force of the oil.
Inputs: zero:2s  step:4V,0.5s  steps:4V  sweep:6.5V,0.4Hz,5Hz,4s  random:10V,0.08s,0.5s,4s,seed=1  triangle:2V,0.5Hz,4s")]
#[command(group(clap::ArgGroup::new("stimulus").required(true).args(["recording", "input"])))]
pub struct Arguments {
    #[command(flatten)]
    machine: MachineArguments,
    /// Recording to simulate (CSV, TwinCAT Scope text, .xlsx, .mat, .mf4, .parquet, each also .gz)
    #[arg(long, value_name = "R.csv")]
    recording: Option<PathBuf>,
    /// Signal at the command, such as "step:4V"
    #[arg(long, value_name = "signal")]
    input: Option<String>,
    /// Where to write the simulated signals: .csv or .txt, .mat, .parquet; no ending is CSV, and - is CSV to standard output.
    /// A file is there whole or not at all; standard output and a pipe have what came before an error
    #[arg(long, value_name = "S.csv")]
    out: PathBuf,
    /// Also draw recorded against simulated
    #[arg(long, value_name = "P.svg", requires = "recording")]
    plot: Option<PathBuf>,
}

/// Every signal that the model computes, in the order in which it is written.
const SIGNALS: [Signal; 8] = [
    Signal::Spool,
    Signal::Position,
    Signal::Velocity,
    Signal::PressureA,
    Signal::PressureB,
    Signal::Flow,
    Signal::Force,
    Signal::Angle,
];

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
    check_targets(&[("--out", out, RECORDING), ("--plot", arguments.plot.as_deref(), DRAWING)], &read)?;
    let is_text = matches!(Format::of_extension(&arguments.out), Some(Format::Text) | None);
    match &arguments.recording {
        Some(path) if is_text && arguments.plot.is_none() => in_parts(arguments, path, console)?,
        _ => at_once(arguments, console)?,
    }
    Ok(Outcome::Done)
}

/// Simulates a recording part by part and writes each part before the next is read: the memory does not grow with its length.
fn in_parts(arguments: &Arguments, path: &Path, console: &mut Console<'_>) -> Result<(), CliError> {
    let bar = input::bar(&[path.to_owned()], console, "simulating");
    let done = each_part(arguments, path, console, &bar);
    bar.finish_and_clear();
    done
}

fn each_part(arguments: &Arguments, path: &Path, console: &mut Console<'_>, bar: &Progress) -> Result<(), CliError> {
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
        for note in input::notes(&part.recording, &file.machine).chain(starts_anywhere(&part.recording)) {
            console.note(note);
        }
        console.detail(format_args!("read: the first {} rows", part.recording.rows()));
    });
    let failed = |cause| CliError::Simulate { machine: arguments.machine.machine.clone(), cause };
    let input_point = first_input_point(file.machine.source, &part.recording).map_err(failed)?;
    let tick = arguments.machine.tick().unwrap_or_else(|| tick_for(&part.recording, &file.machine));
    let start = start_in_play(&file.machine, &part.recording, file.load_source, tick, |note| {
        bar.aside(|| console.note(note));
    });
    let mut in_chunks =
        InChunks::new(&file.machine, input_point, file.load_source, tick, arguments.machine.arithmetic.into())
            .starting(start);
    let mut out = Target::new(&arguments.out)?;
    let mut ended: Vec<Signal> = Vec::new();
    loop {
        let mut advance = in_chunks.part(&part).map_err(failed)?;
        let mut notes = within_range(&part.recording, &mut advance.trajectory);
        notes.extend(add_angle(channels.linkage.as_deref(), part.recording.name(), &mut advance.trajectory));
        for (signal, note) in notes {
            if !ended.contains(&signal) {
                bar.aside(|| console.note(note));
                ended.push(signal);
            }
        }
        let (replaced, added) = columns(&part.recording, &advance.trajectory);
        let text = part.recording.csv_rows(&arguments.out, advance.rows, &replaced, &added)?;
        bar.aside(|| out.write(&text, console))?;
        if let Some(bytes) = read.get().and_then(|mut file: &File| file.stream_position().ok()) {
            bar.reach(bytes);
        }
        parts.forget_before(advance.next_from);
        let Some(next) = parts.read_next()? else { break };
        bar.aside(|| input::own_notes(&next.recording).for_each(|note| console.note(note)));
        part = next;
    }
    out.finish()
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
fn at_once(arguments: &Arguments, console: &mut Console<'_>) -> Result<(), CliError> {
    let job = job(arguments, console)?;
    for note in input::notes(&job.recording, &job.machine).chain(starts_anywhere(&job.recording)) {
        console.note(note);
    }
    let start = start_in_play(&job.machine, &job.recording, job.load, job.tick, |note| console.note(note));
    let bar = console.share(job.recording.rows() as u64, "simulating");
    let simulated = simulate(&job, start, &|rows| bar.inc(rows as u64));
    bar.finish_and_clear();
    let mut simulated =
        simulated.map_err(|cause| CliError::Simulate { machine: arguments.machine.machine.clone(), cause })?;
    let mut notes = within_range(&job.recording, &mut simulated);
    notes.extend(add_angle(job.linkage.as_deref(), job.recording.name(), &mut simulated));
    for (_, note) in notes {
        console.note(note);
    }
    let drawing = arguments.plot.as_ref().map(|path| {
        let signals = judged(&job.recording, job.input_point, job.load);
        let panels = plot::panels(&job.recording, job.input_point, &simulated, &signals);
        (path, plot::svg(job.recording.name(), &job.name, &panels))
    });
    if arguments.recording.is_some() {
        let (replaced, added) = columns(&job.recording, &simulated);
        written(&job.recording, &arguments.out, &replaced, &added, console)?;
    } else {
        written(&response(&job.recording, &simulated)?, &arguments.out, &[], &[], console)?;
    }
    if let Some((path, svg)) = drawing {
        write(path, svg)?;
    }
    Ok(())
}

/// Where in the play of its sensor the rod starts, told by a note: no sensor shows it, and what was recorded tells it as soon as the rod has moved
/// through the play. In the middle without a play, or where nothing is recorded that tells it.
fn start_in_play(
    machine: &Machine<f64>,
    recording: &Recording,
    load: LoadSource,
    tick: Tick,
    note: impl FnOnce(String),
) -> StartOffset {
    let half_m = 0.5 * machine.get(Parameter::BacklashPlay);
    let found = || -> Option<f64> {
        if half_m <= 0.0 || !recording.has(Signal::Position) {
            return None;
        }
        // A recording that cannot be judged is simulated all the same.
        let case = Prepared::new(recording, machine, load, Some(tick)).ok()?;
        let shift_m = settle(machine, &case).ok()?.offset(machine, &case).shift_m.clamp(-half_m, half_m);
        (shift_m.abs() > case.start_sigma_m).then_some(shift_m)
    };
    let Some(shift_m) = found() else { return StartOffset::none() };
    let (name, size) = (recording.name(), significant(1e3 * shift_m.abs(), 2));
    let side = if shift_m < 0.0 { "retracted" } else { "extended" };
    note(format!(
        "{name}: the rod starts {size} mm on the {side} side of the middle of its play, as the recording tells"
    ));
    StartOffset { shift_m, ..StartOffset::none() }
}

/// A note where the rod starts if its position was not measured.
fn starts_anywhere(recording: &Recording) -> Option<String> {
    let unmeasured = !recording.has(Signal::Position);
    unmeasured.then(|| format!("{}: no position is recorded: the rod starts at mid-stroke", recording.name()))
}

/// Ends what is simulated where the recorded sensors end, and says so, once for each signal.
fn within_range(recording: &Recording, simulated: &mut Trajectory) -> Vec<(Signal, String)> {
    let mut notes = Vec::new();
    for (signal, values) in &mut simulated.series {
        let (low, high) = sensor_range(recording, *signal);
        for value in values.iter_mut() {
            *value = value.clamp(low, high);
        }
        let ends: Vec<String> =
            [low, high].into_iter().filter(|end| end.is_finite()).map(|end| told(*signal, end)).collect();
        if !ends.is_empty() {
            let (name, ends) = (recording.name(), ends.join(" and "));
            notes.push((
                *signal,
                format!("{name}: the sensor of {signal} ends at {ends}, and so does what is simulated of it"),
            ));
        }
    }
    notes
}

/// Adds the angle of the joint, where the machine file has the linkage; with a note where the rod leaves what that reaches.
fn add_angle(linkage: Option<&Linkage>, name: &str, simulated: &mut Trajectory) -> Option<(Signal, String)> {
    let linkage = linkage?;
    let position_m = simulated.signal(Signal::Position)?;
    let angle_rad: Vec<f64> = position_m.iter().map(|position| linkage.angle_rad(*position)).collect();
    let (low, high) = linkage.reach_rad();
    let is_end = |angle: &f64| *angle <= low || *angle >= high;
    let ends = angle_rad.iter().any(is_end);
    simulated.series.push((Signal::Angle, angle_rad));
    ends.then(|| {
        let (low, high) = (told(Signal::Angle, low), told(Signal::Angle, high));
        (Signal::Angle, format!("{name}: the linkage reaches {low} to {high}, and the simulated rod comes to its end: the angle stays there"))
    })
}

/// A value of a signal in the unit for people.
fn told(signal: Signal, value: f64) -> String {
    let unit = unit_for_people(signal);
    format!("{} {unit}", significant(unit.from_si(value), 4))
}

/// The simulated signals in place of the recorded ones, and the additional ones where none was recorded.
fn columns<'a>(recording: &Recording, simulated: &'a Trajectory) -> (Vec<Series<'a>>, Vec<Series<'a>>) {
    let computed: Vec<Series<'_>> =
        SIGNALS.iter().filter_map(|&signal| Some((signal, simulated.signal(signal)?))).collect();
    let replaces = computed.iter().any(|(signal, _)| *signal != Signal::Angle && recording.has(*signal));
    let is_added = |signal: Signal| !replaces || (signal == Signal::Angle && !recording.has(signal));
    let added = computed.iter().copied().filter(|(signal, _)| is_added(*signal)).collect();
    (computed, added)
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
    let (machine, asked) = (file.machine, arguments.machine.tick());
    let (recording, load) = if let Some(path) = &arguments.recording {
        (input::recording(path, &channels, console)?, file.load_source)
    } else {
        let input = arguments.input.as_deref().unwrap_or_default();
        let excitation: Excitation = input.parse()?;
        if machine.source != Source::Valve {
            let (machine, source_of_drive) = (arguments.machine.machine.clone(), machine.source);
            return Err(CliError::NeedsValve { machine, source_of_drive, what: "--input" });
        }
        let test = StandardTest::of_input(&excitation, input, asked.unwrap_or(Tick::OneMillisecond));
        (test.recording(&machine)?, LoadSource::Constant)
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
        arithmetic: arguments.machine.arithmetic.into(),
    })
}

/// The command and every signal that follows from it, in SI units.
fn response(input: &Recording, simulated: &Trajectory) -> Result<Recording, CliError> {
    let given = input.columns().iter().filter(|column| column.signal != Signal::Position).cloned();
    let computed = SIGNALS.iter().filter_map(|&signal| Some(Column::si(signal, simulated.signal(signal)?.to_vec())));
    Ok(Recording::new("the response", given.chain(computed).collect())?)
}

fn simulate(job: &Job, start: StartOffset, told: &dyn Fn(usize)) -> Result<Trajectory, SimulateError> {
    let stimulus = Stimulus::new(&job.recording, &job.machine, job.input_point, job.load, job.tick)?;
    job.arithmetic.simulate_with_progress(&job.machine, &stimulus, start, told)
}
