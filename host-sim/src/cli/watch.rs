//! `host-sim watch`: does a drive still follow its model as it did while it was healthy?

use std::path::PathBuf;

use comfy_table::{CellAlignment, Table};

use machine_file::MachineFile;
use model_core::machine::Tick;
use recording::display_unit::{TABLE, arrange, difference, percent, significant};
use recording::files::source_error::printable;
use recording::{ChannelMap, Recording, Signal};
use report::json;
use report::wording;
use watch::{FALSE_ALARMS, WatchError, Watched, healthy};

use super::Outcome;
use super::console::{Console, Tone};
use super::ending::{DOCUMENT, MACHINE};
use super::error::CliError;
use super::input;
use super::target::{check_apart, check_targets, tell};

/// Arguments of `watch`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim watch --machine F.toml --healthy train-*.csv holdout-*.csv --save-machine W.toml
  host-sim watch --machine W.toml tonight-1.csv tonight-2.csv --exit-code

Each recording is simulated with the drive's own machine file, as `diagnose --save-machine` wrote it, \
and the difference is monitored as the controller's monitor does it: the mean square of the last \
moments over that of the healthy drive, against a limit. It takes milliseconds. Recordings of the \
healthy drive tell the band once; [watch] of the machine file keeps it. What has changed in a drive \
that left its band, `host-sim diagnose --since W.toml` says.
Recordings: CSV, TwinCAT Scope text, .xlsx, .mat, .mf4, .parquet, each also .gz.")]
pub struct Arguments {
    /// Recordings to judge
    #[arg(value_name = "R.csv", required_unless_present = "healthy")]
    files: Vec<PathBuf>,
    /// Machine file of the drive (TOML, SI units)
    #[arg(long, value_name = "M.toml")]
    machine: PathBuf,
    /// Recordings of the healthy drive, which tell its band; in the place of [watch]
    ///
    /// Several, with the motions and loads that the drive is watched in: what they do not hold counts as a change
    #[arg(long, value_name = "R.csv", num_args = 1..)]
    healthy: Vec<PathBuf>,
    /// Write the machine file with the band in [watch]
    #[arg(long, value_name = "W.toml", requires = "healthy")]
    save_machine: Option<PathBuf>,
    /// Share of a healthy drive's recordings that may be told by chance
    #[arg(long, value_name = "share", default_value_t = FALSE_ALARMS, allow_negative_numbers = true)]
    false_alarms: f64,
    /// Column of a signal, where its header does not say; may be repeated
    #[arg(long = "map", value_name = "name=header")]
    maps: Vec<String>,
    /// Step of the model in ms
    ///
    /// Without it 1, or 0.5 for recordings faster than that, or 2 below 50 Hz
    #[arg(long, value_enum, value_name = "ms")]
    tick: Option<input::TickArgument>,
    /// Write what was seen for programs; `-` prints it in place of the text
    #[arg(long, value_name = "W.json")]
    json: Option<PathBuf>,
    /// Answer 1 when a recording is outside the band
    #[arg(long)]
    exit_code: bool,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    check(arguments)?;
    let maps = ChannelMap::from_arguments(arguments.maps.iter().map(String::as_str))?;
    let mut file = machine_file::read(&arguments.machine)?;
    let channels = file.channels.clone().overlaid_with(&maps);
    let tick = arguments.tick.map(Tick::from);
    let failed = |cause| CliError::Watch { machine: arguments.machine.clone(), cause: Box::new(cause) };
    if !arguments.healthy.is_empty() {
        let recordings = input::recordings(&arguments.healthy, &channels, console)?;
        note(&recordings, &file, console);
        file.band = Some(healthy(&file, &recordings, tick).map_err(failed)?);
    }
    let recordings = input::recordings(&arguments.files, &channels, console)?;
    note(&recordings, &file, console);
    let judged = |recording| watch::watch(&file, recording, tick, arguments.false_alarms);
    let all = recordings.iter().map(judged).collect::<Result<Vec<Watched>, WatchError>>().map_err(failed)?;
    tell(arguments.json.as_deref(), || json::watch(&file, &all), console)?;
    let is_out = all.iter().any(|one| one.left.is_some());
    if !all.is_empty() {
        console.verdict(wording::watched(&all), if is_out { Tone::Bad } else { Tone::Good })?;
        console.print(table(&all, console.width))?;
    }
    if !arguments.healthy.is_empty() {
        console.print(band(&file, console.width))?;
    }
    if is_out {
        console.print("what has changed: host-sim diagnose --since with this machine file, on these recordings")?;
    }
    if let Some(path) = &arguments.save_machine {
        file.save(path)?;
        console.print(format_args!("machine file with its band: {}", path.display()))?;
    }
    Ok(if is_out && arguments.exit_code { Outcome::OutOfTolerance } else { Outcome::Done })
}

/// Checks what needs no file, and the files to write: the machine file may replace the one that it was made from.
fn check(arguments: &Arguments) -> Result<(), CliError> {
    input::check_false_alarms(arguments.false_alarms)?;
    let recordings = [arguments.files.as_slice(), &arguments.healthy].concat();
    let saved = ("--save-machine", arguments.save_machine.as_deref(), MACHINE);
    let document = ("--json", arguments.json.as_deref(), DOCUMENT);
    check_targets(&[saved], &recordings)?;
    check_targets(&[document], &[recordings.as_slice(), std::slice::from_ref(&arguments.machine)].concat())?;
    check_apart(&[saved, document])
}

/// What was noted as the recordings were read, and doubts about their units.
fn note(recordings: &[Recording], file: &MachineFile, console: &Console<'_>) {
    for note in recordings.iter().flat_map(|recording| input::notes(recording, &file.machine)) {
        console.note(note);
    }
}

/// A row for each recording and signal.
fn table(all: &[Watched], width: Option<u16>) -> Table {
    let mut table = new_table(width);
    table.set_header(["recording", "signal", "mean square / healthy", "limit", "% of limit", "at s"]);
    for one in all {
        for (row, seen) in one.signals.iter().enumerate() {
            table.add_row([
                if row == 0 { printable(&one.recording) } else { String::new() },
                seen.signal.to_string(),
                significant(seen.square, 3),
                significant(seen.limit, 3),
                percent(100.0 * wording::share(seen)),
                format!("{:.3}", seen.at_s),
            ]);
        }
    }
    to_the_right(&mut table, 2);
    table
}

/// What the healthy recordings told.
fn band(file: &MachineFile, width: Option<u16>) -> Table {
    let mut table = new_table(width);
    table.set_header(["healthy", "standard deviation", "correlated over s"]);
    let band = file.band.as_ref();
    let spreads = band.map_or([None; 3], |band| [band.spool, band.pressure, band.position]);
    let named = [("spool", Signal::Spool), ("pressures", Signal::PressureA), ("position", Signal::Position)];
    for ((name, signal), spread) in named.into_iter().zip(spreads) {
        if let Some(spread) = spread {
            table.add_row([name.to_owned(), difference(signal, spread.sigma), significant(spread.correlation_s, 2)]);
        }
    }
    to_the_right(&mut table, 1);
    table
}

fn new_table(width: Option<u16>) -> Table {
    let mut table = Table::new();
    table.load_style(TABLE);
    arrange(&mut table, width);
    table
}

fn to_the_right(table: &mut Table, from: usize) {
    for (_, column) in table.column_iter_mut().enumerate().skip(from) {
        column.set_cell_alignment(CellAlignment::Right);
    }
}
