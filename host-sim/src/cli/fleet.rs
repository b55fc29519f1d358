//! `host-sim fleet`: every night of every drive into a table.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use comfy_table::Table;
use serde_json::{Value, json};

use diagnosis::Options;
use fleet::{How, Judgement, Pending, Row, Tally, Upto};
use recording::display_unit::{TABLE, arrange};
use recording::files::source_error::printable;

use super::Outcome;
use super::console::{Console, Tone};
use super::ending::DOCUMENT;
use super::error::CliError;
use super::input::check_false_alarms;
use super::target::{check_folder, check_targets, tell};

/// Arguments of `fleet`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim fleet hall --out table
  host-sim fleet hall --out table --upto watch --json -

DATASET holds drive=NAME/machine.toml, whose [watch] `host-sim watch --healthy` wrote, and recordings \
in drive=NAME/date=NIGHT/, in any format; NAME and NIGHT alone are as good. Every night becomes a row \
of the Parquet files in TABLE: verdict, link, every effect's amount and its deviation. Of a drive that \
left its band a diagnosis says what has changed. Nights that are there already are left alone, so the \
same command goes on where it was killed. A recording that cannot be used is a row with the reason.")]
pub struct Arguments {
    /// Folder of drives, each with its machine file and a folder for each night
    #[arg(value_name = "DATASET")]
    dataset: PathBuf,
    /// Folder of the rows, Parquet; made where it is not there
    #[arg(long, value_name = "TABLE")]
    out: PathBuf,
    /// How far a night is looked into
    #[arg(long, value_enum, default_value_t)]
    upto: UptoArgument,
    /// Share of a healthy drive's recordings that may leave the band by chance
    #[arg(long, value_name = "share", default_value_t = watch::FALSE_ALARMS, allow_negative_numbers = true)]
    false_alarms: f64,
    /// What the search of one diagnosis may take, in s on two usual cores
    #[arg(long, value_name = "s", default_value_t = Options::USUAL_LIMIT_S, value_parser = super::diagnose::seconds, allow_negative_numbers = true)]
    time_limit: f64,
    /// Threads; without it as many as there are cores
    #[arg(long, value_name = "count", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Write what this run did for programs; `-` prints it in place of the text
    #[arg(long, value_name = "F.json")]
    json: Option<PathBuf>,
    /// Answer 1 when a drive is not in its band
    #[arg(long)]
    exit_code: bool,
}

/// How far a night is looked into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum UptoArgument {
    /// Whether the drive is in its band
    Watch,
    /// And how much there is of every effect
    Refit,
    /// And of a drive that left its band what has changed
    #[default]
    Diagnose,
}

impl From<UptoArgument> for Upto {
    fn from(argument: UptoArgument) -> Self {
        match argument {
            UptoArgument::Watch => Upto::Watch,
            UptoArgument::Refit => Upto::Refit,
            UptoArgument::Diagnose => Upto::Diagnose,
        }
    }
}

/// What a run did.
#[derive(Default)]
struct Done {
    tally: Tally,
    /// The rows that are not in the band.
    shown: Vec<Row>,
}

impl Done {
    /// The rows of a night.
    fn add(&mut self, rows: &[Row]) {
        self.tally.add(rows);
        self.shown.extend(rows.iter().filter(|row| row.judgement != Judgement::InBand).cloned());
    }
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    check_false_alarms(arguments.false_alarms)?;
    check_targets(&[("--json", arguments.json.as_deref(), DOCUMENT)], &[])?;
    check_folder(&arguments.out)?;
    let how = How { upto: arguments.upto.into(), false_alarms: arguments.false_alarms, limit_s: arguments.time_limit };
    let pending = Pending::of(&arguments.dataset, &arguments.out)?;
    let bar = console.progress(pending.nights(), "judging");
    let done = Mutex::new(Done::default());
    let told = |rows: &[Row]| {
        done.lock().unwrap_or_else(PoisonError::into_inner).add(rows);
        bar.inc(1);
    };
    let judged = || pending.run(&how, &told);
    // Without a number the threads that all commands share.
    let pool = arguments.threads.map(|count| rayon::ThreadPoolBuilder::new().num_threads(count.into()).build());
    let ended = match pool {
        Some(Ok(pool)) => pool.install(judged),
        _ => judged(),
    };
    bar.finish_and_clear();
    ended?;
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.shown.sort_by(|one, other| one.order().cmp(&other.order()));
    tell(arguments.json.as_deref(), || document(arguments, &done), console)?;
    let is_out = done.tally.iter().any(|(judgement, _)| judgement != Judgement::InBand);
    console.verdict(headline(&done.tally), if is_out { Tone::Bad } else { Tone::Good })?;
    if !done.shown.is_empty() {
        console.print(table(&done.shown, console.width))?;
    }
    console.print(format_args!("rows: {}", arguments.out.display()))?;
    Ok(if is_out && arguments.exit_code { Outcome::OutOfTolerance } else { Outcome::Done })
}

/// How many nights ended how.
fn headline(tally: &Tally) -> String {
    let all = tally.nights();
    if all == 0 {
        return "every night is in the table already".to_owned();
    }
    let each: Vec<String> = tally.iter().map(|(judgement, count)| format!("{count} {}", judgement.name())).collect();
    format!("{all} {}: {}", if all == 1 { "night" } else { "nights" }, each.join(", "))
}

fn document(arguments: &Arguments, done: &Done) -> Value {
    let path = |path: &Path| path.display().to_string();
    let row = |row: &Row| {
        json!({
            "drive": row.drive,
            "night": row.night,
            "recording": row.recording,
            "verdict": row.judgement.name(),
            "words": row.words,
        })
    };
    let counts: BTreeMap<&str, usize> = Judgement::ALL.iter().map(|one| (one.name(), done.tally.of(*one))).collect();
    json!({
        "schema": "host-sim/fleet/1",
        "dataset": path(&arguments.dataset),
        "table": path(&arguments.out),
        "nights": done.tally.nights(),
        "verdicts": counts,
        "not_in_band": done.shown.iter().map(row).collect::<Vec<_>>(),
    })
}

/// A row for each night that is not in the band, and for each recording that cannot be used.
fn table(rows: &[Row], width: Option<u16>) -> Table {
    let mut table = Table::new();
    table.load_style(TABLE);
    arrange(&mut table, width);
    table.set_header(["drive", "night", "verdict", "what"]);
    for row in rows {
        let of = row.recording.as_ref().map_or_else(String::new, |recording| format!("{}: ", printable(recording)));
        let what = format!("{of}{}", printable(&row.words));
        table.add_row([printable(&row.drive), printable(&row.night), row.judgement.name().to_owned(), what]);
    }
    table
}
