//! `host-sim inspect`: what recordings hold, and which parts of a drive they can test.

use std::path::PathBuf;

use experiment::inspect::Inspection;
use machine_file::MachineFile;
use recording::files::source_error::Explained;
use recording::{ChannelMap, Recording, RecordingError, UnknownColumn, guess, survey, unknown_columns};
use report::html::{self, Inspected};

use super::about::about;
use super::console::Console;
use super::ending::{DOCUMENT, PAGE};
use super::error::CliError;
use super::target::{check_targets, write, write_document};
use super::{Outcome, input};

/// Arguments of `inspect`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim inspect run.csv
  host-sim inspect train-1.csv train-2.csv --machine M.toml --json I.json --report I.html

Says of each recording which signals it holds with their noise and steps, which links of the drive it \
can test and what is missing to test the others, and whether valve and rod were moved. With a machine \
file also against its dead zone, stroke and supply.
Recordings: CSV, TwinCAT Scope text, .xlsx, .mat, .mf4, .parquet, each also .gz.

A column is known by its name with a unit, such as `position [mm]`. One that is called otherwise is \
mapped, here by --map \"position=Kolbenweg [mm]\", for all recordings of a drive in the machine file by \
a line `position = \"Kolbenweg [mm]\"` in [channels]. Where no header is known, a block [channels] is \
guessed, to be checked and pasted. Names: time command spool flow pump_speed valve_direction \
pressure_a pressure_b supply_pressure tank_pressure other_flow other_flow_2 other_flow_3 load_force \
force position velocity angle oil_temperature reference")]
pub struct Arguments {
    /// Recordings
    #[arg(value_name = "R.csv", required = true)]
    recordings: Vec<PathBuf>,
    /// Machine file of the drive (TOML, SI units)
    #[arg(long, value_name = "M.toml")]
    machine: Option<PathBuf>,
    /// Column of a signal, where its header does not say; may be repeated
    #[arg(long = "map", value_name = "name=header")]
    maps: Vec<String>,
    /// Write what was found for programs; `-` prints it in place of the text
    #[arg(long, value_name = "I.json")]
    json: Option<PathBuf>,
    /// Write a page for people: every channel, what is suspicious, which links can be tested
    #[arg(long, value_name = "I.html")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let read = [arguments.recordings.as_slice(), arguments.machine.as_slice()].concat();
    let document = ("--json", arguments.json.as_deref(), DOCUMENT);
    check_targets(&[document, ("--report", arguments.report.as_deref(), PAGE)], &read)?;
    let maps = ChannelMap::from_arguments(arguments.maps.iter().map(String::as_str))?;
    let file = arguments.machine.as_deref().map(machine_file::read).transpose()?;
    let channels = file.as_ref().map(|file| file.channels.clone()).unwrap_or_default().overlaid_with(&maps);
    let recordings = input::recordings(&arguments.recordings, &channels, console);
    let recordings = recordings.map_err(|error| with_guess(error, &arguments.recordings))?;
    let bar = console.progress(recordings.len(), "inspecting");
    let inspected = |recording| {
        let found = Inspection::of(recording, file.as_ref());
        bar.inc(1);
        found
    };
    let found: Vec<Inspection> = recordings.iter().map(inspected).collect();
    bar.finish_and_clear();
    if let Some(path) = &arguments.json {
        write_document(path, &format!("{:#}\n", report::inspect::document(&found)), console)?;
    }
    if let Some(path) = &arguments.report {
        write(path, page(arguments, &recordings, &found, file.as_ref()))?;
    }
    let texts: Vec<String> = found.iter().map(|found| report::inspect::text(found, console.width)).collect();
    console.print(texts.join("\n").trim_end())?;
    let nothing_known = recordings.iter().position(|recording| recording.columns().len() == 1);
    if let Some(columns) = nothing_known.and_then(|index| survey(&arguments.recordings[index]).ok()) {
        console.print(format_args!("\n{}", guess::block(&columns)))?;
    }
    Ok(Outcome::Done)
}

/// The page of recordings that were read from these files.
fn page(arguments: &Arguments, recordings: &[Recording], found: &[Inspection], file: Option<&MachineFile>) -> String {
    // A file that could be read once and no longer, such as a pipe, shows its known channels alone.
    let unknown: Vec<Vec<UnknownColumn>> = arguments
        .recordings
        .iter()
        .zip(recordings)
        .map(|(path, recording)| unknown_columns(path, recording).unwrap_or_default())
        .collect();
    let inspected = Inspected::each(found, recordings, &unknown);
    html::inspect(file.map(|file| file.name.as_str()), &inspected, &about(arguments.machine.as_slice()))
}

/// Where no header is known, the error with what the columns may hold.
fn with_guess(error: CliError, recordings: &[PathBuf]) -> CliError {
    let cause = match error {
        CliError::Recording(
            cause @ (RecordingError::NoTimeColumn { .. }
            | RecordingError::NothingKnown { .. }
            | RecordingError::NoTimes { .. }),
        ) => cause,
        other => return other,
    };
    let named = |path: &&PathBuf| cause.place().file.starts_with(&path.display().to_string());
    let columns = recordings.iter().find(named).and_then(|path| survey(path).ok());
    // A file in which nothing can be guessed has no header at all.
    match columns.filter(|columns| !guess::channels(columns).is_empty()) {
        Some(columns) => CliError::NothingKnown { guess: guess::block(&columns), cause: Box::new(cause) },
        None => cause.into(),
    }
}
