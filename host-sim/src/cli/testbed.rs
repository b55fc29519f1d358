//! `host-sim testbed`: synthetic recordings of a drive that has more than its machine file says.

use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter, Source};
use recording::Format;
use recording::excitation::signals::{Dither, Excitation};
use serde_json::{Value, json};
use simulation::signal::noise::extent;
use virtual_plant::sensor::sensors::PositionSensor;
use virtual_plant::{Bench, Drive, InitialState, Plant, PlantEffect, Sensors, SyntheticRecording, truth_near};

use super::console::Console;
use super::ending::DOCUMENT;
use super::error::CliError;
use super::input::TickArgument;
use super::target::{check_folder, check_targets, make_folder, tell, write_together};
use super::{Outcome, draw, hall};

/// Arguments of `testbed`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(after_help = "Example:
  host-sim testbed --machine M.toml --effect coulomb-friction=800 --train \"random:8V,seed=1\" \\
      --train \"steps:6V\" --holdout \"sweep:5V\" --seed 7 --out case

The machine file holds the nominal values. The drive on the test bed is drawn about them by [fit.sigma] \
and the seed (--spread 0 leaves it exact), starts at mid-stroke, at rest, and has the effects given. \
The folder gets the machine file as it is, train-1.csv …, holdout-1.csv …: command, spool, position and \
both pressures as the sensors show them. The same arguments make the same files.")]
pub struct Arguments {
    /// What else it can do
    #[command(subcommand)]
    other: Option<Other>,
    /// Machine file of the drive's nominal values (TOML, SI units)
    #[arg(long, value_name = "M.toml", required = true)]
    machine: Option<PathBuf>,
    /// Command to train on, such as "steps:6V"; may be repeated
    #[arg(long, value_name = "signal", required = true)]
    train: Vec<Excitation>,
    /// Command to hold out; may be repeated
    #[arg(long, value_name = "signal")]
    holdout: Vec<Excitation>,
    /// Effect that the file does not know, with its strength in SI; may be repeated
    #[arg(long, value_name = "name=strength")]
    effect: Vec<String>,
    /// How far the drive is from the file, in standard deviations of [fit.sigma]
    #[arg(long, value_name = "factor", default_value_t = 1.0)]
    spread: f64,
    /// Noise of spool and pressures, in parts of the usual: 5e-4 of travel, 0.3 bar
    #[arg(long, value_name = "factor", default_value_t = 1.0)]
    noise: f64,
    /// Step of a linear scale on the rod, mm; without it the encoder on the joint measures the position
    #[arg(long, value_name = "mm")]
    position_step: Option<f64>,
    /// Dither on the command: amplitude in V, frequency in Hz
    #[arg(long, value_names = ["V", "Hz"], num_args = 2)]
    dither: Vec<f64>,
    /// Proportional control of the position with this gain, V/m; the signals are then deviations of the set value, times the gain
    #[arg(long, value_name = "V/m")]
    closed_loop: Option<f64>,
    /// Interval of control and recording, ms
    #[arg(long, value_enum, value_name = "ms", default_value = "1")]
    tick: TickArgument,
    /// Seed of the drive's deviations and of the sensors' noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder to write to; made where it is not there
    #[arg(long, value_name = "folder", required = true)]
    out: Option<PathBuf>,
    /// Write what was made for programs; `-` prints it in place of the text
    #[arg(long, value_name = "T.json")]
    json: Option<PathBuf>,
}

/// What the test bed can do beside one case as asked for.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum Other {
    /// Draw concealed cases at random, with the truth beside them.
    Draw(draw::Arguments),
    /// Draw a hall of drives, night by night, with what wears, to try `fleet` on.
    Hall(hall::Arguments),
}

/// What is made, checked.
struct Job {
    file: MachineFile,
    bench: Bench,
    initial: InitialState,
    closed_loop: Option<f64>,
    /// File name and excitation of each recording.
    recordings: Vec<(String, Excitation)>,
}

/// Usual noise of the spool's sensor, in parts of its travel.
const SPOOL_NOISE: f64 = 5e-4;

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    match &arguments.other {
        Some(Other::Draw(arguments)) => return draw::run(arguments, console),
        Some(Other::Hall(arguments)) => return hall::run(arguments, console),
        None => {}
    }
    let (Some(machine), Some(out)) = (&arguments.machine, &arguments.out) else {
        unreachable!("without a subcommand both are required")
    };
    let job = job(arguments, machine)?;
    check_folder(out)?;
    check_targets(&[("--json", arguments.json.as_deref(), DOCUMENT)], std::slice::from_ref(machine))?;
    refuse_others(out, |name| job.recordings.iter().any(|(own, _)| own == name))?;
    let bar = console.progress(job.recordings.len(), "running the test bed");
    let mut files = job
        .recordings
        .par_iter()
        .enumerate()
        .map(|(index, (name, excitation))| {
            let text = record(&job, index, excitation)?.to_csv();
            bar.inc(1);
            Ok((out.join(name), text))
        })
        .collect::<Result<Vec<_>, CliError>>()?;
    bar.finish_and_clear();

    // Everything is made before the first file is written.
    let machine = out.join("machine.toml");
    let toml = job.file.to_text(&machine.display().to_string())?;
    make_folder(out)?;
    let recordings = files.len();
    files.push((machine, toml));
    write_together(&files)?;
    tell(arguments.json.as_deref(), || document_of(arguments, &job, out), console)?;
    for (path, _) in files.iter().take(recordings) {
        console.print(path.display())?;
    }
    Ok(Outcome::Done)
}

/// What was made, for programs.
fn document_of(arguments: &Arguments, job: &Job, folder: &Path) -> Value {
    let recording = |(name, _): &(String, Excitation)| json!({ "file": folder.join(name).display().to_string(), "held_out": name.starts_with("holdout-") });
    json!({
        "schema": "host-sim/testbed/1",
        "machine": job.file.name,
        "machine_file": folder.join("machine.toml").display().to_string(),
        "seed": arguments.seed,
        "recordings": job.recordings.iter().map(recording).collect::<Vec<_>>(),
    })
}

fn job(arguments: &Arguments, machine: &Path) -> Result<Job, CliError> {
    let not_negative = "a finite number that is not negative";
    number("--spread", arguments.spread, 0.0..=100.0, "0 to 100")?;
    number("--noise", arguments.noise, 0.0..=f64::MAX, not_negative)?;
    number("--position-step", arguments.position_step.unwrap_or(0.0), 0.0..=f64::MAX, not_negative)?;
    number("--closed-loop", arguments.closed_loop.unwrap_or(1.0), 1e-3..=1e6, "0.001 to 1000000 V/m")?;
    let file = machine_file::read(machine)?;
    if file.machine.source != Source::Valve {
        let (machine, source_of_drive) = (machine.to_owned(), file.machine.source);
        return Err(CliError::NeedsValve { machine, source_of_drive, what: "the test bed" });
    }
    let truth = truth_near(&file.machine, &file.sigma, arguments.spread, arguments.seed);
    let effects = arguments.effect.iter().map(|text| effect(text)).collect::<Result<Vec<_>, _>>()?;
    let plant = Plant::new(&truth, 1e-7)
        .map_err(|cause| CliError::Plant { excitation: machine.display().to_string(), cause })?
        .with_effects(&effects);
    let mut bench = Bench::new(plant, sensors(arguments, machine, &truth)?);
    bench.tick_s = model_core::machine::Tick::from(arguments.tick).seconds();
    bench.seed = arguments.seed;
    if let [amplitude_v, frequency_hz] = arguments.dither[..] {
        number("--dither", amplitude_v, 0.0..=10.0, "an amplitude of 0 to 10 V")?;
        number("--dither", frequency_hz, 0.0..=0.5 / bench.tick_s, "a frequency up to half of the control rate, Hz")?;
        bench.dither = Some(Dither { amplitude_v, frequency_hz });
    }
    let initial = InitialState::at_rest(&truth, 0.5 * truth.get(Parameter::Stroke));
    let named = |kind: &'static str, excitations: &[Excitation]| {
        let numbered = |(index, excitation): (usize, &Excitation)| (format!("{kind}-{}.csv", index + 1), *excitation);
        excitations.iter().enumerate().map(numbered).collect::<Vec<_>>()
    };
    let recordings = [named("train", &arguments.train), named("holdout", &arguments.holdout)].concat();
    Ok(Job { file, bench, initial, closed_loop: arguments.closed_loop, recordings })
}

fn number(
    argument: &'static str,
    found: f64,
    range: std::ops::RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), CliError> {
    if range.contains(&found) { Ok(()) } else { Err(CliError::Number { argument, found, expected }) }
}

fn effect(argument: &str) -> Result<PlantEffect, CliError> {
    let parsed = argument.split_once('=').and_then(|(name, strength)| {
        let strength: f64 = strength.trim().parse().ok()?;
        if strength.is_finite() && strength >= 0.0 { PlantEffect::named(name.trim(), strength) } else { None }
    });
    parsed.ok_or_else(|| {
        let known: Vec<String> = PlantEffect::known().map(|(name, unit)| format!("{name} [{unit}]")).collect();
        CliError::Effect { argument: argument.to_owned(), known: known.join(", ") }
    })
}

fn sensors(arguments: &Arguments, machine: &Path, truth: &Machine<f64>) -> Result<Sensors, CliError> {
    let linkage_error = |cause| CliError::Linkage { machine: machine.to_owned(), cause };
    let mut sensors = match arguments.position_step {
        Some(step_mm) => Sensors::with_position(truth, PositionSensor::Linear { resolution_m: 1e-3 * step_mm }),
        None => Sensors::of(truth).map_err(linkage_error)?,
    };
    sensors.spool.noise_std = SPOOL_NOISE * arguments.noise;
    sensors.pressure.noise_std_pa *= arguments.noise;
    Ok(sensors)
}

fn record(job: &Job, index: usize, excitation: &Excitation) -> Result<SyntheticRecording, CliError> {
    let mut bench = job.bench.clone();
    bench.seed = bench.seed.wrapping_mul(1000).wrapping_add(index as u64);
    let drive = match job.closed_loop {
        None => Drive::Open(*excitation),
        Some(gain_v_per_m) => {
            let about = job.initial.position_m;
            let reference_m =
                excitation.sample(bench.tick_s).iter().map(|volts| about + volts / gain_v_per_m).collect();
            Drive::Closed { reference_m, gain_v_per_m }
        }
    };
    let described = || format!("{excitation:?}");
    let recording =
        bench.record(&drive, &job.initial).map_err(|cause| CliError::Plant { excitation: described(), cause })?;
    let positions = recording.truth.iter().map(|state| state.position_m);
    let (low, high) = extent(positions);
    let stroke = bench.plant.machine().get(Parameter::Stroke);
    if low < 0.0 || high > stroke {
        let (low_mm, high_mm, stroke_mm) = (1e3 * low, 1e3 * high, 1e3 * stroke);
        return Err(CliError::LeavesStroke { excitation: described(), low_mm, high_mm, stroke_mm });
    }
    Ok(recording.rounded())
}

/// Refuses a folder with recordings of another run: they would be taken for recordings of this one.
pub(crate) fn refuse_others(folder: &Path, is_own: impl Fn(&str) -> bool) -> Result<(), CliError> {
    // A folder that does not exist yet holds nothing.
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    for entry in entries.flatten() {
        let (name, path) = (entry.file_name().to_string_lossy().into_owned(), entry.path());
        let kind = name.starts_with("train-") || name.starts_with("holdout-");
        if kind && Format::of_extension(&path).is_some() && !is_own(&name) {
            return Err(CliError::OtherRecording { path });
        }
    }
    Ok(())
}
