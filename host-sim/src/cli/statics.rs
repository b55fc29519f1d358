//! `host-sim statics`: the static characteristic of a valve from a sweep, several sweeps, a table or runs, without a clock.

use std::path::PathBuf;

use identification::static_curve::{Columns, RateFrom, Statics, StaticsError, analyse, compare, means};
use recording::StaticTable;
use report::statics::{document, document_of_sweeps, drawing, drawing_of_sweeps, text, text_of_sweeps};

use super::Outcome;
use super::console::Console;
use super::ending::{DOCUMENT, DRAWING};
use super::error::CliError;
use super::target::{check_targets, write, write_document};

/// Arguments of `statics`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim statics --recording sweep.csv --input current_mA --output flow_lpm --plot S.svg
  host-sim statics --recording means.csv --input u_percent --output speed --supply ps_bar
  host-sim statics --recording fast.csv slow.csv --period 20 200 --input u_mA --output q_lpm
  host-sim statics --runs run-30.csv run-50.csv run-70.csv --input command --output velocity

Columns are named by their headers, with or without the unit, and stay in the file's units; no column \
need be time. With --runs each file is one row: the mean of its columns, and `velocity` from the slope \
of `position` over its clock. Null, dead zone, gain and saturation are read of a curve that rises or \
falls throughout; of one with a peak or a valley its place, height and width; of others nothing.
A loop between the ways up and down is hysteresis or a lag: one sweep cannot tell. Several recordings \
are sweeps of the same thing at other rates: a loop that shrinks with the rate is a lag, one that stays \
is hysteresis. The rates come from --period, without it from clocks, which all recordings need, and \
without these from the number of rows, which names no effect.")]
pub struct Arguments {
    /// Sweep in the order of its samples, or table of means (CSV); several: sweeps at different rates
    #[arg(long, value_name = "R.csv", num_args = 1.., required_unless_present = "runs", conflicts_with = "runs")]
    recording: Vec<PathBuf>,
    /// Time of each sweep's way up and down, s, in the order of the recordings
    #[arg(long, value_name = "seconds", num_args = 1.., conflicts_with = "runs")]
    period: Vec<f64>,
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
    /// Write the figures for programs; `-` prints it in place of the text
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
    check_periods(arguments)?;
    let tables = tables(arguments)?;
    let periods = arguments.period.iter().map(|period| Some(*period)).chain(std::iter::repeat(None));
    let sweeps = tables.iter().zip(periods).map(|(table, period)| {
        let found = analyse(table, &columns)?;
        Ok(if let Some(period_s) = period { found.with_period(period_s) } else { found })
    });
    let sweeps: Vec<Statics> = sweeps.collect::<Result<_, StaticsError>>()?;
    let values = tables.iter().map(|table| Ok((table.column(&columns.input)?.1, table.column(&columns.output)?.1)));
    let values: Vec<(&[f64], &[f64])> = values.collect::<Result<_, StaticsError>>()?;
    let (text, document, drawing) = views(&sweeps, &values, arguments);
    if let Some(path) = &arguments.json {
        write_document(path, &document, console)?;
    }
    if let Some(path) = &arguments.plot {
        write(path, drawing)?;
    }
    for table in &tables {
        for note in &table.notes {
            console.note(format_args!("{}: {note}", table.name()));
        }
        if table.incomplete > 0 {
            console.note(format_args!(
                "{}: {} rows have an empty cell and are left out",
                table.name(),
                table.incomplete
            ));
        }
        if !arguments.period.is_empty() && table.clock_s().is_some() {
            console.note(format_args!("{}: has a clock; --period is used in its place", table.name()));
        }
    }
    console.print(text)?;
    Ok(Outcome::Done)
}

/// Text, JSON and drawing of one sweep, or of several compared.
fn views(sweeps: &[Statics], values: &[(&[f64], &[f64])], arguments: &Arguments) -> (String, String, String) {
    if let [statics] = sweeps {
        let (input, output) = values[0];
        return (text(statics), format!("{:#}\n", document(statics)), drawing(statics, input, output));
    }
    let clocks = sweeps.iter().all(|statics| statics.rate_per_s.is_some());
    let rate_from = match (arguments.period.is_empty(), clocks) {
        (false, _) => RateFrom::Period,
        (true, true) => RateFrom::Clock,
        (true, false) => RateFrom::Rows,
    };
    let timed = |statics: &Statics| match statics.rate_per_s {
        Some(rate) if rate_from != RateFrom::Rows => 2.0 * (statics.input.high - statics.input.low) / rate,
        _ => 2.0 * statics.rows as f64 / statics.branches.len().max(1) as f64,
    };
    let timed: Vec<(&Statics, f64)> = sweeps.iter().map(|statics| (statics, timed(statics))).collect();
    let compared = compare(&timed, rate_from);
    let drawing = drawing_of_sweeps(sweeps, values, &compared);
    let document = format!("{:#}\n", document_of_sweeps(sweeps, &compared));
    (text_of_sweeps(sweeps, &compared), document, drawing)
}

fn check_periods(arguments: &Arguments) -> Result<(), CliError> {
    let (periods, sweeps) = (arguments.period.len(), arguments.recording.len());
    let odd = arguments.period.iter().find(|period| !(period.is_finite() && **period > 0.0));
    if let Some(&found) = odd {
        return Err(CliError::Number { argument: "--period", found, expected: "a time above zero, s" });
    }
    if periods != 0 && periods != sweeps {
        return Err(StaticsError::PeriodsOfOthers { periods, sweeps }.into());
    }
    Ok(())
}

fn tables(arguments: &Arguments) -> Result<Vec<StaticTable>, CliError> {
    let read = |paths: &[PathBuf]| paths.iter().map(|path| StaticTable::read(path)).collect::<Result<Vec<_>, _>>();
    if arguments.runs.is_empty() {
        return Ok(read(&arguments.recording)?);
    }
    Ok(vec![means(&read(&arguments.runs)?, &arguments.input)?])
}
