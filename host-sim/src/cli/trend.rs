//! `host-sim trend`: what wears in a hall, since when, how fast, and when it reaches its limit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use comfy_table::Table;
use jiff::civil::Date;
use machine_file::MachineFile;
use recording::display_unit::{TABLE, arrange};
use recording::files::source_error::printable;
use serde_json::{Value, json};
use trend::{Limits, Urgency, Wear, Wears, date_of, headline, limit, name, now, page, state, to_limit, wears};

use super::Outcome;
use super::about::about;
use super::console::{Console, Tone};
use super::ending::{DOCUMENT, PAGE};
use super::error::CliError;
use super::target::{check_targets, tell, write};

/// Arguments of `trend`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim trend table --drives hall --report wear.html
  host-sim trend table --limit internal_leakage_conductance_m3_per_s_pa=4e-12 --json -

TABLE is what `host-sim fleet --out TABLE` wrote. Of every drive and every effect: how much there is \
night by night, on which nights it changed, how fast it grows, and when it reaches its limit at that \
rate, with a range that is 95 % sure if it goes on so. A night that does not tell an amount is a gap, not a zero. \
Nights are named by their date. Without --limit the limit of friction and leakages is where sources \
call a cylinder worn, which takes --drives.")]
pub struct Arguments {
    /// Folder of rows that `fleet` wrote
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// Folder of drives that the table was made of: their machine files tell sizes in l/min and N, and limits
    #[arg(long, value_name = "DATASET")]
    drives: Option<PathBuf>,
    /// Limit of an amount, by its column in the table, in the column's unit; may be repeated
    #[arg(long = "limit", value_name = "column=value")]
    limits: Vec<String>,
    /// Write a page with a small chart of every amount
    #[arg(long, value_name = "T.html")]
    report: Option<PathBuf>,
    /// Write what was found for programs; `-` prints it in place of the text
    #[arg(long, value_name = "T.json")]
    json: Option<PathBuf>,
    /// Answer 1 when something has changed
    #[arg(long)]
    exit_code: bool,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let limits = Limits::parse(arguments.limits.iter().map(String::as_str))?;
    let others = [("--json", arguments.json.as_deref(), DOCUMENT), ("--report", arguments.report.as_deref(), PAGE)];
    check_targets(&others, &[])?;
    let rows = fleet::rows(&arguments.table).map_err(fleet::FleetError::from)?;
    let machines = arguments.drives.as_deref().map(|dataset| machines(dataset, console)).transpose()?;
    let failed = |cause| CliError::Trend { table: arguments.table.clone(), cause };
    let found = wears(&rows, &limits, machines.unwrap_or_default()).map_err(failed)?;
    if let Some(first) = found.no_dates.first() {
        console.note(format_args!(
            "nights whose names are no dates are left out: {first}{}",
            if found.no_dates.len() > 1 { " and others" } else { "" }
        ));
    }
    if let Some(path) = &arguments.report {
        write(path, page(&found, &about(&[])))?;
    }
    tell(arguments.json.as_deref(), || document(&found), console)?;
    let has_changed = found.moving().next().is_some();
    console.verdict(headline(&found), if has_changed { Tone::Bad } else { Tone::Good })?;
    if has_changed {
        console.print(table(&found, console.width))?;
    }
    if let Some(path) = &arguments.report {
        console.print(format_args!("page: {}", path.display()))?;
    }
    Ok(if has_changed && arguments.exit_code { Outcome::OutOfTolerance } else { Outcome::Done })
}

/// The machine file of every drive of a data set. One that cannot be read is told, and its drive has no sizes.
fn machines(dataset: &Path, console: &Console<'_>) -> Result<BTreeMap<String, MachineFile>, CliError> {
    let failed = |cause| fleet::FleetError::Dataset { path: dataset.to_owned(), cause };
    let paths: BTreeMap<String, PathBuf> =
        fleet::nights(dataset).map_err(failed)?.into_iter().map(|night| (night.drive, night.machine)).collect();
    let read = |(drive, path): (String, PathBuf)| match machine_file::read(&path) {
        Ok(file) => Some((drive, file)),
        Err(error) => {
            console.note(format_args!("no sizes of {drive}: {error}"));
            None
        }
    };
    Ok(paths.into_iter().filter_map(read).collect())
}

fn document(found: &Wears) -> Value {
    json!({
        "schema": "host-sim/trend/1",
        "from": found.nights.0.to_string(),
        "to": found.nights.1.to_string(),
        "drives": found.drives.len(),
        "not_dates": found.no_dates,
        "amounts": found.all.iter().map(amount).collect::<Vec<_>>(),
    })
}

fn amount(wear: &Wear) -> Value {
    let date = |day: f64| date_of(day).as_ref().map(Date::to_string);
    let trend = &wear.trend;
    let piece = |piece: &trend::Piece| {
        let (from, to) = trend.days(piece);
        let (rate, rate_std) = piece.line.per_month();
        let (value, std) = piece.line.at(to);
        json!({"from": date(from), "to": date(to), "value": value, "std": std, "per_month": rate, "per_month_std": rate_std})
    };
    let reaches = match wear.urgency {
        Urgency::Reaches(reach) => {
            json!({"expected": date(reach.expected), "earliest": date(reach.earliest), "latest": reach.latest.and_then(date)})
        }
        _ => Value::Null,
    };
    json!({
        "drive": wear.drive,
        "column": fleet::column_of(wear.parameter),
        "effect": name(wear.parameter),
        "state": wear.urgency.name(),
        "nights": trend.points.len(),
        "pieces": trend.pieces.iter().map(piece).collect::<Vec<_>>(),
        "limit": wear.limit.map(|limit| limit.value),
        "reaches_limit": reaches,
    })
}

/// A row for each amount that has changed, the most urgent first.
fn table(found: &Wears, width: Option<u16>) -> Table {
    let mut table = Table::new();
    table.load_style(TABLE);
    arrange(&mut table, width);
    table.set_header(["drive", "effect", "now", "trend", "limit", "reached"]);
    for wear in found.moving() {
        let drive = printable(&wear.drive);
        let said = [name(wear.parameter), now(found, wear), state(found, wear), limit(wear), to_limit(found, wear)];
        table.add_row([drive].into_iter().chain(said));
    }
    table
}
