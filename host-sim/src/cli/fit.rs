//! `host-sim fit`: refit the base parameters of a drive to recordings.

use std::path::PathBuf;

use diagnosis::agreement::{far_values, has_sensor, not_tolerated, tolerated};
use diagnosis::localisation::{Miss, misses};
use diagnosis::{DiagnoseError, base_parameters, read_absolute};
use identification::compare::judged;
use identification::experiment::{Prepared, share_range_ends};
use identification::fit::residuals::counts_from;
use identification::fit::{
    Counts, Fit, FitError, Free, From, effective_samples, first_search, fit_with_progress, inflation, level_at_rest,
    most_evaluations, softened_all, staged, with_channel_tolerances,
};
use model_core::machine::Machine;
use recording::{ChannelMap, PressureZero, Recording, Signal};
use report::{terminal, wording};

use super::console::Console;
use super::ending::MACHINE;
use super::error::CliError;
use super::target::check_targets;
use super::{Outcome, input};

/// Arguments of `fit`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  host-sim fit --machine M.toml --train train-1.csv train-2.csv --save-machine F.toml

The parameters of [fit.sigma] move, each around its nominal value by its standard deviation; without that table the usually
uncertain ones that the file gives, by a tenth.")]
pub struct Arguments {
    /// Machine file of the drive (TOML, SI units)
    #[arg(long, value_name = "M.toml")]
    machine: PathBuf,
    /// Recordings to fit to (CSV, TwinCAT Scope text, .xlsx, .mat, .mf4, .parquet, each also .gz)
    #[arg(long, value_name = "R.csv", required = true, num_args = 1..)]
    train: Vec<PathBuf>,
    /// Which column holds a signal, where its header does not say; may be repeated
    #[arg(long = "map", value_name = "name=header")]
    maps: Vec<String>,
    /// Judge by these signals only, as though the model's others had not been measured: `spool,pressure_a`
    #[arg(long, value_name = "signal,…", value_delimiter = ',', value_parser = judged::named)]
    judge: Vec<Signal>,
    /// Step of the model in ms; without it 1, or 0.5 for recordings faster than that, or 2 below 50 Hz
    #[arg(long, value_enum, value_name = "ms")]
    tick: Option<input::TickArgument>,
    /// Take the recordings as they are, even where a channel is certainly reversed, exchanged or in another unit
    #[arg(long)]
    as_recorded: bool,
    /// Where to write the machine file with fitted values
    #[arg(long, value_name = "F.toml")]
    save_machine: PathBuf,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    check_targets(&[("--save-machine", Some(&arguments.save_machine), MACHINE)], &arguments.train)?;
    let maps = ChannelMap::from_arguments(arguments.maps.iter().map(String::as_str))?;
    let mut file = machine_file::read(&arguments.machine)?;
    let channels = file.channels.clone().overlaid_with(&maps);
    let failed =
        |cause: DiagnoseError| CliError::Diagnose { machine: arguments.machine.clone(), cause: Box::new(cause) };
    let read = input::recordings(&arguments.train, &channels, console)?.into_iter();
    let mut recordings: Vec<Recording> =
        read.map(|recording| input::judged(recording, &file, &arguments.judge)).collect::<Result<_, _>>()?;
    let tick = arguments.tick.map(Into::into);
    if read_absolute(&file, &recordings, tick).map_err(failed)? {
        recordings.iter_mut().for_each(Recording::take_as_absolute);
        file.channels.pressure = PressureZero::Absolute;
    }
    for note in recordings.iter().flat_map(|recording| input::notes(recording, &file.machine)) {
        console.note(note);
    }
    for doubt in input::doubts(&arguments.machine, &file, &recordings, arguments.as_recorded)? {
        console.note(wording::doubt(&doubt));
    }
    let mut prepared: Vec<Prepared> = Vec::new();
    for recording in &recordings {
        let case = Prepared::new(recording, &file.machine, file.load_source, tick);
        prepared.push(case.map_err(|cause| failed(cause.into()))?);
    }
    share_range_ends(&mut prepared.iter_mut().collect::<Vec<_>>());
    let free = base_parameters(&file);
    let near = near(&file.machine, &free, &mut prepared).map_err(|cause| failed(cause.into()))?;
    let cases: Vec<&Prepared> = prepared.iter().collect();
    console.detail(format_args!(
        "read: {} recordings, {} rows; {} parameters may move",
        cases.len(),
        cases.iter().map(|case| case.rows()).sum::<usize>(),
        free.len()
    ));
    // The number of steps of the search is unknown, but its maximum is known.
    let rows = |case: &Prepared| case.rows() as u64;
    let once: u64 = cases.iter().map(|case| rows(case)).sum();
    let bar = console.at_most(once * most_evaluations(free.len(), cases.len()) as u64, "fitting");
    let from = From { solution: Some(&near), ..From::default() };
    let fitted = fit_with_progress(&file.machine, &free, &cases, &from, 1e-8, &|case| bar.inc(rows(case)));
    bar.finish_and_clear();
    let fitted = fitted.map_err(|cause| failed(cause.into()))?;
    file.machine = fitted.machine;
    file.start_at(level_at_rest(&fitted.machine, &cases, &fitted.starts));
    file.given.extend(fitted.free.iter().map(|free| free.parameter));
    file.save(&arguments.save_machine)?;
    let with_starts = || cases.iter().copied().zip(fitted.starts.iter().copied());
    let residuals = softened_all(&fitted.machine, with_starts()).map_err(|cause| failed(cause.into()))?;
    let counts = cases.first().map_or(effective_samples as Counts, |case| counts_from(case.stimulus.input_point));
    let inflation = inflation(&residuals, counts);
    let estimates = fitted.estimates(inflation);
    console.print(terminal::parameters(&not_tolerated(&free, &estimates)))?;
    let mut within = tolerated(&free, &estimates);
    within.retain(|one| has_sensor(cases.iter().copied(), one.parameter));
    if let Some(table) = terminal::tolerances(&file.machine, &within) {
        console.print(table)?;
    }
    for far in wording::far_values(&far_values(&file.machine, &free, &estimates)) {
        console.print(format_args!("far value: {far}"))?;
    }
    for used in wording::used_up(&file.machine, &within) {
        console.print(format_args!("tolerance: {used}"))?;
    }
    if let Some(pairs) = terminal::correlated(&fitted.correlations(inflation)) {
        console.print(pairs)?;
    }
    let left = misses(&fitted.machine, with_starts()).map_err(|cause| failed(cause.into()))?;
    console.print(format_args!("What is left: {}.", terminal::missed(&left)))?;
    if left.iter().any(Miss::is_above_noise) {
        console.print(
            "This is more than noise, and no parameter that may move can remove it: \
             `host-sim diagnose` looks for what is missing.",
        )?;
    }
    if !fitted.converged {
        let moving = fitted
            .unsettled(inflation)
            .map_or_else(String::new, |moving| format!(": {}", wording::still_moving(&moving)));
        console.note(format!("the search did not converge; these are the best values found{moving}"));
    }
    Ok(Outcome::Done)
}

/// A first solution, with the tolerance of every channel at its misfit: residuals far beyond it count linearly in all later fits.
fn near(machine: &Machine<f64>, free: &[Free], prepared: &mut [Prepared]) -> Result<Fit, FitError> {
    /// The first search ends when the loss falls by less than this share in a step.
    const SETTLED: f64 = 1e-3;
    with_channel_tolerances(machine, prepared, |cases| {
        let is_sparse = cases.iter().any(|case| case.is_sparse());
        if is_sparse { staged(machine, free, cases, SETTLED) } else { first_search(machine, free, cases, SETTLED) }
    })
}
