//! `host-sim statics`: the static characteristic of a valve from a sweep, a table or runs, without a clock.

use std::path::PathBuf;

use identification::static_curve::{Columns, StaticsError, analyse, means};
use recording::StaticTable;

use super::Outcome;
use super::console::Console;
use super::ending::{DOCUMENT, DRAWING};
use super::error::CliError;
use super::target::{check_targets, write};

/// Arguments of `statics`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim statics --recording sweep.csv --input current_mA --output flow_lpm --json S.json --plot S.svg
  host-sim statics --recording means.csv --input u_percent --output speed --slider spool_V --supply ps_bar --return pb_bar
  host-sim statics --runs run-30.csv run-50.csv run-70.csv run-90.csv run-100.csv --input command --output velocity

Columns are named by their headers, with or without the unit, and stay in the file's units; no column need be time. With --runs
each file is one row: the mean of its columns, and `velocity` from the slope of `position` over its clock. Only what does not
depend on the rate is read: hysteresis, null, dead zone, gain and saturation, droop and return pressure over flow.")]
pub struct Arguments {
    /// Sweep in the order of its samples, or table of means (CSV)
    #[arg(long, value_name = "R.csv", required_unless_present = "runs", conflicts_with = "runs")]
    recording: Option<PathBuf>,
    /// Runs at constant command, one a file (CSV)
    #[arg(long, value_name = "R.csv", num_args = 1..)]
    runs: Vec<PathBuf>,
    /// Header of what was set
    #[arg(long, value_name = "header")]
    input: String,
    /// Header of what came of it
    #[arg(long, value_name = "header")]
    output: String,
    /// Header of the measured spool: tells whether spool or orifice stops following
    #[arg(long = "slider", value_name = "header")]
    spool: Option<String>,
    /// Header of the supply pressure: its droop over the output
    #[arg(long, value_name = "header")]
    supply: Option<String>,
    /// Header of a pressure on the way to the tank: its rise over the output
    #[arg(long = "return", value_name = "header")]
    returning: Option<String>,
    /// Write the figures for programs
    #[arg(long, value_name = "S.json")]
    json: Option<PathBuf>,
    /// Draw output over input
    #[arg(long, value_name = "S.svg")]
    plot: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let read: Vec<PathBuf> = arguments.recording.iter().chain(&arguments.runs).cloned().collect();
    let targets = [("--json", arguments.json.as_deref(), DOCUMENT), ("--plot", arguments.plot.as_deref(), DRAWING)];
    check_targets(&targets, &read)?;
    let columns = Columns {
        input: arguments.input.clone(),
        output: arguments.output.clone(),
        spool: arguments.spool.clone(),
        supply: arguments.supply.clone(),
        returning: arguments.returning.clone(),
    };
    let table = table(arguments)?;
    let statics = analyse(&table, &columns)?;
    if let Some(path) = &arguments.json {
        write(path, format!("{:#}\n", report::statics::document(&statics)))?;
    }
    if let Some(path) = &arguments.plot {
        let values = |header: &str| table.column(header).map(|(_, values)| values);
        let (input, output) = (values(&columns.input), values(&columns.output));
        let (input, output) = (input.map_err(StaticsError::from)?, output.map_err(StaticsError::from)?);
        write(path, report::statics::drawing(&statics, input, output))?;
    }
    for note in &table.notes {
        console.note(format_args!("{}: {note}", table.name()));
    }
    if table.incomplete > 0 {
        console.note(format_args!("{}: {} rows have an empty cell and are left out", table.name(), table.incomplete));
    }
    console.print(report::statics::text(&statics))?;
    Ok(Outcome::Done)
}

fn table(arguments: &Arguments) -> Result<StaticTable, CliError> {
    if let Some(path) = &arguments.recording {
        return Ok(StaticTable::read(path)?);
    }
    let runs = arguments.runs.iter().map(|path| StaticTable::read(path)).collect::<Result<Vec<_>, _>>()?;
    Ok(means(&runs, &arguments.input)?)
}
