//! `host-sim testbed hall`: a hall of drives, night by night, to try `fleet` on.

use std::fs;
use std::path::{Path, PathBuf};

use jiff::ToSpan;
use jiff::civil::{Date, date};
use rayon::prelude::*;
use serde_json::{Value, json};

use virtual_plant::SyntheticRecording;
use virtual_plant::hall::{OfHall, OneNight, Shop, of_hall};

use super::Outcome;
use super::console::Console;
use super::ending::DOCUMENT;
use super::error::CliError;
use super::target::{check_folder, check_targets, make_folder, tell, write_together};

/// Arguments of `testbed hall`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  host-sim testbed hall --drives 20 --nights 30 --seed 1 --out hall

Every drive is a folder drive=NAME with machine.toml (its data sheet), _healthy (four motions on three days of \
its commissioning) and date=NIGHT with up to two recordings; truth.json says in which drives what wears from \
which night on, which were off, and whose logger changed. The same arguments make the same files, and a \
drive is the same whatever the count.")]
pub struct Arguments {
    /// Seed of everything
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// How many drives
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    drives: u64,
    /// How many nights
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u16).range(1..=1000))]
    nights: u16,
    /// Folder to write to; made where it is not there
    #[arg(long, value_name = "folder")]
    out: PathBuf,
    /// Write what was made for programs; `-` prints it in place of the text
    #[arg(long, value_name = "H.json")]
    json: Option<PathBuf>,
}

/// The name of the truth's file.
const TRUTH: &str = "truth.json";
/// The first night.
const FIRST: Date = date(2026, 1, 1);

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    check_folder(&arguments.out)?;
    check_targets(&[("--json", arguments.json.as_deref(), DOCUMENT)], &[])?;
    let shop = Shop { seed: arguments.seed, nights: arguments.nights.into() };
    // Nights of another hall would be taken for some of this one.
    if let Some(entry) = fs::read_dir(&arguments.out).ok().and_then(|mut all| all.next()).and_then(Result::ok) {
        return Err(CliError::NotEmpty { folder: arguments.out.clone(), found: entry.file_name() });
    }
    make_folder(&arguments.out)?;
    let bar = console.progress(usize::try_from(arguments.drives).unwrap_or(usize::MAX), "drawing drives");
    let drives = (0..arguments.drives).into_par_iter().map(|number| {
        let drawn = of_hall(&shop, number);
        let truth = drawn.map(|drive| written(&drive, &arguments.out)).transpose()?;
        bar.inc(1);
        Ok(truth)
    });
    let truths: Vec<Value> = drives.collect::<Result<Vec<_>, CliError>>()?.into_iter().flatten().collect();
    bar.finish_and_clear();
    let count = truths.len();
    // The last: with it the hall is whole.
    let document = json!({
        "schema": "host-sim/hall/1",
        "seed": arguments.seed,
        "folder": arguments.out.display().to_string(),
        "drives": truths,
    });
    write_together(&[(arguments.out.join(TRUTH), format!("{document:#}\n"))])?;
    tell(arguments.json.as_deref(), || document, console)?;
    console.print(format_args!("{} drives, {} nights: {}", count, shop.nights, arguments.out.display()))?;
    Ok(Outcome::Done)
}

/// Writes a drive's folder; gives the truth about it.
fn written(drive: &OfHall, hall: &Path) -> Result<Value, CliError> {
    let name = &drive.hall.file.name;
    let folder = hall.join(format!("drive={name}"));
    let mut files = vec![(folder.join("machine.toml"), drive.hall.toml.clone())];
    let mut folders = Vec::new();
    let mut put = |folder: PathBuf, recordings: &[SyntheticRecording], text: &dyn Fn(&SyntheticRecording) -> String| {
        files.extend(recordings.iter().zip(1..).map(|(made, k)| (folder.join(format!("{k}.csv")), text(made))));
        folders.push(folder);
    };
    put(folder.join("_healthy"), &drive.healthy, &SyntheticRecording::to_csv);
    for (night, one) in drive.nights.iter().enumerate() {
        let changed = drive.logger_changes.is_some_and(|from| night >= from);
        let text = |made: &SyntheticRecording| if changed { decimal_commas(&made.to_csv()) } else { made.to_csv() };
        put(folder.join(format!("date={}", date_of(night))), &one.recordings, &text);
    }
    folders.iter().try_for_each(|folder| make_folder(folder))?;
    write_together(&files)?;
    Ok(truth(drive))
}

fn date_of(night: usize) -> Date {
    FIRST.saturating_add(i64::try_from(night).unwrap_or(i64::MAX).days())
}

/// As a logger with German settings writes it.
fn decimal_commas(text: &str) -> String {
    text.replace(',', ";").replace('.', ",")
}

fn truth(drive: &OfHall) -> Value {
    let night = |(number, one): (usize, &OneNight)| {
        json!({
            "night": date_of(number).to_string(),
            "is_off": one.is_off,
            "recordings": one.recordings.len(),
            "worn_share": one.worn,
            "amount": one.amount,
            "oil_c": one.oil_c,
        })
    };
    let wear = drive.wear.as_ref().map(|wear| {
        json!({
            "effect": wear.worn.name(),
            "also_right": wear.worn.right(),
            "from": date_of(wear.from).to_string(),
            "before": wear.before,
            "amounts": wear.amounts.iter().map(|amount| amount.description().key).collect::<Vec<_>>(),
        })
    });
    json!({
        "drive": drive.hall.file.name,
        "wear": wear,
        "logger_changes": drive.logger_changes.map(|night| date_of(night).to_string()),
        "signals": drive.hall.signals.iter().map(|signal| signal.name()).collect::<Vec<_>>(),
        "nights": drive.nights.iter().enumerate().map(night).collect::<Vec<_>>(),
    })
}
