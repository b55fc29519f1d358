//! `host-sim fit`: refit the base parameters of a drive to recordings.

use std::path::PathBuf;
use std::slice;

use diagnosis::localisation::Miss;
use diagnosis::{DiagnoseError, Refit, Refitting, settle_pressure_zero};
use identification::compare::judged;
use recording::{ChannelMap, Recording, Signal};
use report::{html, json, terminal, wording};

use super::about::about;
use super::console::{Console, Tone};
use super::ending::{DOCUMENT, MACHINE, PAGE};
use super::error::CliError;
use super::target::{check_apart, check_targets, save_fitted, write, write_document};
use super::{Outcome, input};

/// Arguments of `fit`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim fit train-1.csv train-2.csv --machine M.toml
  host-sim fit train-1.csv train-2.csv --machine M.toml --save-machine F.toml
  host-sim fit train-1.csv train-2.csv --machine M.toml --holdout holdout.csv \\
      --report F.html --save-machine F.toml

The parameters of [fit.sigma] move, each around its nominal value by its standard deviation; without \
that table the usually uncertain ones that the file gives, by a tenth. Held-out recordings take no \
part in the fit: they show what it is worth.
Recordings: CSV, TwinCAT Scope text, .xlsx, .mat, .mf4, .parquet, each also .gz.")]
pub struct Arguments {
    /// Recordings to fit to
    #[arg(value_name = "R.csv", required_unless_present = "train")]
    files: Vec<PathBuf>,
    /// Machine file of the drive (TOML, SI units)
    #[arg(long, value_name = "M.toml")]
    machine: PathBuf,
    /// Recordings to fit to, too
    #[arg(long, value_name = "R.csv", num_args = 1..)]
    train: Vec<PathBuf>,
    /// Recordings that take no part in the fit, to judge it by
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
    /// Take the recordings as they are
    ///
    /// Even where a channel is certainly reversed, exchanged or in another unit
    #[arg(long)]
    as_recorded: bool,
    /// Where to write the machine file with fitted values
    #[arg(long, value_name = "F.toml")]
    save_machine: Option<PathBuf>,
    /// Write the fitted values and what is left for programs; `-` prints it in place of the text
    #[arg(long, value_name = "F.json")]
    json: Option<PathBuf>,
    /// Write a page for people: values before and after, signals, residuals
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let train = [arguments.files.as_slice(), &arguments.train].concat();
    check(arguments, &train)?;
    let maps = ChannelMap::from_arguments(arguments.maps.iter().map(String::as_str))?;
    let mut file = machine_file::read(&arguments.machine)?;
    let channels = file.channels.clone().overlaid_with(&maps);
    let failed =
        |cause: DiagnoseError| CliError::Diagnose { machine: arguments.machine.clone(), cause: Box::new(cause) };
    let read = input::recordings(&[train.as_slice(), &arguments.holdout].concat(), &channels, console)?.into_iter();
    let mut recordings: Vec<Recording> =
        read.map(|recording| input::judged(recording, &file, &arguments.judge)).collect::<Result<_, _>>()?;
    let tick = arguments.tick.map(Into::into);
    let trained = train.len();
    check_held_out(&recordings[..trained], &recordings[trained..])?;
    let (training, held_out) = recordings.split_at_mut(trained);
    settle_pressure_zero(&mut file, training, held_out, tick).map_err(failed)?;
    for note in recordings.iter().flat_map(|recording| input::notes(recording, &file.machine)) {
        console.note(note);
    }
    let doubts = input::doubts(&arguments.machine, &file, &recordings, arguments.as_recorded)?;
    for doubt in &doubts {
        console.note(wording::doubt(doubt));
    }
    let (training, held_out) = recordings.split_at(trained);
    let refitting = Refitting::of(&file, training, tick).map_err(failed)?;
    let refitting = refitting.with_held_out(held_out, tick).map_err(failed)?;
    console.detail(format_args!(
        "read: {} recordings, {} rows; {} parameters may move",
        training.len(),
        refitting.rows(),
        refitting.parameters()
    ));
    // The number of steps of the search is unknown, but its maximum is known.
    let bar = console.at_most(refitting.most_rows() as u64, "fitting");
    let refit = refitting.search(&|rows| bar.inc(rows as u64));
    bar.finish_and_clear();
    let refit = refit.map_err(failed)?;
    if let Some(path) = &arguments.json {
        write_document(path, &format!("{:#}\n", json::refit(&refit)), console)?;
    }
    if let Some(path) = &arguments.report {
        let about = about(slice::from_ref(&arguments.machine));
        write(path, html::fit(&refit, &recordings.iter().collect::<Vec<_>>(), &doubts, &about))?;
    }
    tell(&refit, console)?;
    // The last: whatever is not saved has been told.
    if let Some(path) = &arguments.save_machine {
        save_fitted(path, &refit.file, tick, console)?;
    }
    Ok(Outcome::Done)
}

/// Checks that no recording that was held out is one of those that are fitted to. One that is fitted to may be given twice, to count twice.
fn check_held_out(training: &[Recording], held_out: &[Recording]) -> Result<(), CliError> {
    let Some((first, second)) = Recording::trained_on(training, held_out) else { return Ok(()) };
    let (first, second) = (first.path().to_owned(), second.path().to_owned());
    Err(CliError::SameRecording { first, second, expected: "held-out recordings that are not trained on" })
}

/// Checks the files to write: a fitted machine file may replace the one that it was made from; no other result may replace an input.
fn check(arguments: &Arguments, train: &[PathBuf]) -> Result<(), CliError> {
    let saved = ("--save-machine", arguments.save_machine.as_deref(), MACHINE);
    let others = [("--json", arguments.json.as_deref(), DOCUMENT), ("--report", arguments.report.as_deref(), PAGE)];
    let recordings = [train, &arguments.holdout].concat();
    check_targets(&[saved], &recordings)?;
    check_targets(&others, &[recordings.as_slice(), std::slice::from_ref(&arguments.machine)].concat())?;
    check_apart(&[others.as_slice(), &[saved]].concat())
}

fn tell(refit: &Refit, console: &mut Console<'_>) -> Result<(), CliError> {
    let machine = &refit.file.machine;
    if let Some(worse) = wording::fit_is_worse(refit) {
        console.verdict(worse, Tone::Bad)?;
    }
    console.print(terminal::parameters(&refit.estimates))?;
    if let Some(table) = terminal::tolerances(machine, &refit.tolerated) {
        console.print(table)?;
    }
    for far in wording::far_values(&refit.far_values) {
        console.print(format_args!("far value: {far}"))?;
    }
    for used in wording::used_up(machine, &refit.tolerated) {
        console.print(format_args!("tolerance: {used}"))?;
    }
    if let Some(pairs) = terminal::correlated(&refit.correlations) {
        console.print(pairs)?;
    }
    if let Some(table) = terminal::held_out_fits(&refit.shown) {
        console.print(table)?;
    }
    console.print(format_args!("What is left: {}.", terminal::missed(&refit.left)))?;
    if refit.left.iter().any(Miss::is_above_noise) {
        console.print(
            "This is more than noise, and no parameter that may move can remove it: \
             `host-sim diagnose` looks for what is missing.",
        )?;
    }
    if !refit.converged {
        let moving =
            refit.unsettled.as_ref().map_or_else(String::new, |moving| format!(": {}", wording::still_moving(moving)));
        console.note(format!("the search did not converge; these are the best values found{moving}"));
    }
    Ok(())
}
