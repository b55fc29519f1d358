//! `host-sim plan`: before recording, which effects could be seen and told apart, and how to excite the drive.

use std::path::PathBuf;

use diagnosis::base_parameters;
use experiment::at_hand::AtHand;
use experiment::plan::{Planned, plan, steps};
use experiment::sensor::Sensor;
use experiment::standard_tests::StandardTest;
use machine_file::MachineFile;
use recording::excitation::signals::Excitation;
use recording::{ChannelMap, Recording};
use report::plot;

use super::console::Console;
use super::ending::{DOCUMENT, DRAWING, SOURCE, TEXT};
use super::error::CliError;
use super::target::{check_targets, write, write_document};
use super::{Outcome, input};
use crate::played::Played;

/// Arguments of `plan`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim plan --machine M.toml --sensors position:0.05mm,pressure_a:0.2bar,pressure_b:0.2bar
  host-sim plan --machine M.toml --sensors position --input \"random:10V\" --plot matrix.svg
  host-sim plan first.csv --machine M.toml
  host-sim plan --machine M.toml --sensors spool,position --largest 4 --seconds 6 --firmware plan.rs

Every effect is switched on in the model, as it usually is; what a refit would imitate is taken out; \
what is left decides whether it would be accepted, and which effects would pass for each other, by the \
rules of `diagnose`. Sensors are position, velocity, spool, flow, force, pressure_a, pressure_b, \
supply_pressure, each with the standard deviation of its noise (usual noise without). With a recording \
its sensors and their noise are those at hand. The excitation that separates most is the best choice of \
the standard tests within --seconds. The rod starts at mid-stroke.")]
pub struct Arguments {
    /// Recording whose excitation is judged, too
    #[arg(value_name = "R.csv", conflicts_with_all = ["recording", "input"])]
    file: Option<PathBuf>,
    /// Machine file of the drive (TOML, SI units)
    #[arg(long, value_name = "M.toml")]
    machine: PathBuf,
    /// Sensors at hand, each with its noise: `position:0.05mm,spool`
    #[arg(long, value_name = "sensor,…", value_delimiter = ',', required_unless_present_any = ["recording", "file"])]
    sensors: Vec<String>,
    /// Excitation that is judged, too, such as "steps:4V"
    #[arg(long, value_name = "signal", conflicts_with = "recording")]
    input: Option<String>,
    /// The recording, as an option
    #[arg(long, value_name = "R.csv")]
    recording: Option<PathBuf>,
    /// Column of a signal, where its header does not say; may be repeated
    #[arg(long = "map", value_name = "name=header")]
    maps: Vec<String>,
    /// Largest command, V
    ///
    /// Without it that of the excitation at hand, or 10
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    largest: Option<f64>,
    /// Longest excitation, s
    #[arg(long, value_name = "s", default_value_t = 20.0, allow_negative_numbers = true)]
    seconds: f64,
    /// The rig can load the rod from outside: tests under load count
    #[arg(long)]
    with_load: bool,
    /// Write the excitation that separates most (CSV)
    #[arg(long, value_name = "E.csv")]
    out: Option<PathBuf>,
    /// Write it for the firmware, which plays it: build with `FIRMWARE_PLAN=E.rs`
    ///
    /// The plan drives the firmware's reference model while the loops make the drive follow
    #[arg(long, value_name = "E.rs", conflicts_with = "with_load")]
    firmware: Option<PathBuf>,
    /// Write the plan for programs; `-` prints it in place of the text
    #[arg(long, value_name = "P.json")]
    json: Option<PathBuf>,
    /// Draw the isolability matrix of the excitation that separates most
    #[arg(long, value_name = "P.svg")]
    plot: Option<PathBuf>,
}

impl Arguments {
    /// The recording, however it is given.
    fn recording(&self) -> Option<&PathBuf> {
        self.file.as_ref().or(self.recording.as_ref())
    }
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let read: Vec<PathBuf> = arguments.recording().into_iter().chain([&arguments.machine]).cloned().collect();
    let targets = [
        ("--out", arguments.out.as_deref(), TEXT),
        ("--firmware", arguments.firmware.as_deref(), SOURCE),
        ("--json", arguments.json.as_deref(), DOCUMENT),
        ("--plot", arguments.plot.as_deref(), DRAWING),
    ];
    check_targets(&targets, &read)?;
    positive("--seconds", arguments.seconds)?;
    arguments.largest.map_or(Ok(()), |largest| positive("--largest", largest))?;
    let file = machine_file::read(&arguments.machine)?;
    let at_hand = at_hand(arguments, &file, console)?;
    let sensors = match &at_hand {
        Some(at_hand) if arguments.sensors.is_empty() => at_hand.sensors.clone(),
        _ => sensors(&arguments.sensors, &file)?,
    };
    let largest_v = arguments.largest.or(at_hand.as_ref().map(|at_hand| at_hand.largest_v)).unwrap_or(10.0);
    let planned = Planned {
        machine: &file.machine,
        base_parameters: &base_parameters(&file),
        sensors: &sensors,
        largest_v,
        can_load: arguments.with_load,
        longest_s: arguments.seconds,
    };
    let bar = console.progress(steps(&planned), "planning");
    let plan = plan(&planned, at_hand.as_ref().map(|at_hand| &at_hand.stimulus), &|| bar.inc(1));
    bar.finish_and_clear();
    let plan = plan.map_err(|cause| CliError::Plan { machine: arguments.machine.clone(), cause })?;
    if let Some(path) = &arguments.out {
        excitation(&plan.excitation)?.write_csv(path, &[], &[])?;
    }
    if let Some(path) = &arguments.firmware {
        let StandardTest { interval_s, command_v, .. } = &plan.excitation;
        let played = Played::of(&file.name, &file.machine, *interval_s, command_v);
        let played = played.map_err(|cause| CliError::Played { machine: arguments.machine.clone(), cause })?;
        write(path, played.rust())?;
    }
    if let Some(path) = &arguments.json {
        write_document(path, &format!("{:#}\n", report::plan::document(&file.name, &sensors, &plan)), console)?;
    }
    if let Some(path) = &arguments.plot {
        write(path, plot::grid(&report::plan::matrix(&plan.best)))?;
    }
    console.print(report::plan::text(&file.name, &sensors, &plan, console.width).trim_end())?;
    Ok(Outcome::Done)
}

fn positive(argument: &'static str, found: f64) -> Result<(), CliError> {
    if found.is_finite() && found > 0.0 {
        return Ok(());
    }
    Err(CliError::Number { argument, found, expected: "a positive number" })
}

/// The named sensors, each once.
fn sensors(named: &[String], file: &MachineFile) -> Result<Vec<Sensor>, CliError> {
    let mut found: Vec<Sensor> = Vec::new();
    for text in named {
        let sensor = Sensor::parse(text, &file.machine)?;
        // If a sensor is named twice, the last one counts.
        found.retain(|known| known.signal != sensor.signal);
        found.push(sensor);
    }
    Ok(found)
}

fn at_hand(arguments: &Arguments, file: &MachineFile, console: &Console<'_>) -> Result<Option<AtHand>, CliError> {
    let failed = |cause| CliError::Compare { machine: arguments.machine.clone(), cause };
    if let Some(path) = arguments.recording() {
        let maps = ChannelMap::from_arguments(arguments.maps.iter().map(String::as_str))?;
        let recording = input::recording(path, &file.channels.clone().overlaid_with(&maps), console)?;
        for note in input::notes(&recording, &file.machine) {
            console.note(note);
        }
        return AtHand::of_recording(&recording, file).map(Some).map_err(failed);
    }
    let Some(text) = &arguments.input else { return Ok(None) };
    let (signal, _) = Excitation::read(text, file.channels.command_unit())?;
    AtHand::of_input(&signal, text, file).map(Some).map_err(failed)
}

/// Time and command, and the load where there is one, as the controller plays them.
fn excitation(test: &StandardTest) -> Result<Recording, CliError> {
    Ok(Recording::new(test.name, test.columns().collect())?)
}
