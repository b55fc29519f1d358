//! A drawn hall, night by night, from its commissioning to the trend: what wears has to be named before it has doubled, healthy drives have to stay quiet, and
//! rates have to be right.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use rayon::prelude::*;
use serde_json::Value;

use fleet::{Judgement, Row, column_of, rows};
use host_sim::cli::{self, Cli, Console};
use model_core::machine::Parameter;

/// Deviations beyond which wear shows, and beyond which it has doubled since.
const SHOWS: f64 = 3.0;
const DOUBLED: f64 = 2.0 * SHOWS;

/// What is printed by a command of the program.
fn done(arguments: &[&str]) -> String {
    let line = ["host-sim", "--quiet"].iter().chain(arguments);
    let cli = Cli::try_parse_from(line).unwrap_or_else(|error| panic!("{arguments:?}: {error}"));
    let mut out = Vec::new();
    let done = cli::run(&cli.command, &mut Console::into_buffer(&mut out));
    done.unwrap_or_else(|error| panic!("{arguments:?}: {}", error.render()));
    String::from_utf8(out).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Fits a drive to the first day of its commissioning, and finds its band in the others; where that has not been done.
fn commissioned(drive: &Path) {
    let machine = drive.join("machine.toml");
    if fs::read_to_string(&machine).unwrap().contains("[watch]") {
        return;
    }
    let healthy: Vec<PathBuf> = (1..=12).map(|number| drive.join(format!("_healthy/{number}.csv"))).collect();
    let healthy: Vec<&str> = healthy.iter().map(|path| text(path)).collect();
    let saved = ["--machine", text(&machine), "--save-machine", text(&machine)];
    done(&[&["fit"][..], &healthy[..4], &saved].concat());
    done(&[&["watch"][..], &saved, &["--healthy"], &healthy[4..]].concat());
}

/// What became of a hall.
#[derive(Debug, Default)]
pub(super) struct Nights {
    lines: Vec<String>,
    /// Nights of drives in which nothing wears, or not yet, that were recorded; and those that were put before somebody.
    healthy: usize,
    alarms: usize,
    /// Drives whose wear showed; that were named in time; of those with a rate, whose rate is within a quarter.
    showed: usize,
    pub(super) named: usize,
    rated: usize,
    near: usize,
}

impl Nights {
    /// At most one healthy night in a hundred raises an alarm, everything that showed was named in time, and rates are within a quarter.
    pub(super) fn is_reached(&self) -> bool {
        100 * self.alarms <= self.healthy && self.named == self.showed && self.near == self.rated
    }

    pub(super) fn table(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "healthy nights {}, alarms in {}", self.healthy, self.alarms);
        let _ = writeln!(text, "wear that showed {}, named before it had doubled {}", self.showed, self.named);
        let _ = writeln!(text, "rates {}, within 25 % {}", self.rated, self.near);
        self.lines.iter().fold(text, |text, line| text + line + "\n")
    }

    /// Draws a hall into a folder, commissions its drives, judges its nights and scores them; what is there already is not done again.
    pub(super) fn of(folder: &Path, (drives, nights, seed): (&str, &str, &str)) -> Self {
        let (hall, table) = (folder.join("hall"), folder.join("table"));
        if !hall.join("truth.json").exists() {
            done(&["testbed", "hall", "--drives", drives, "--nights", nights, "--seed", seed, "--out", text(&hall)]);
        }
        let truth: Value = serde_json::from_str(&fs::read_to_string(hall.join("truth.json")).unwrap()).unwrap();
        let drives = truth["drives"].as_array().unwrap();
        let name = |drive: &Value| drive["drive"].as_str().unwrap().to_owned();
        drives.par_iter().for_each(|drive| commissioned(&hall.join(format!("drive={}", name(drive)))));
        done(&["fleet", text(&hall), "--out", text(&table)]);
        let trend: Value = serde_json::from_str(&done(&["trend", text(&table), "--json", "-"])).unwrap();
        let mut of_drive: BTreeMap<String, Vec<Row>> = BTreeMap::new();
        for row in rows(&table).unwrap().into_iter().filter(|row| row.recording.is_none()) {
            of_drive.entry(row.drive.clone()).or_default().push(row);
        }
        let mut all = Self::default();
        for drive in drives {
            all.add(drive, of_drive.get(&name(drive)).map_or(&[], Vec::as_slice), &trend);
        }
        all
    }

    fn add(&mut self, drive: &Value, rows: &[Row], trend: &Value) {
        let nights = drive["nights"].as_array().unwrap();
        let is_alarm = |row: &&Row| !matches!(row.judgement, Judgement::InBand | Judgement::Unchanged);
        let name = drive["drive"].as_str().unwrap();
        assert_eq!(nights.len(), rows.len(), "{name}: a row for every night");
        for (night, row) in nights.iter().zip(rows) {
            assert_eq!(night["night"], *row.night, "{name}");
            if night["worn_share"] == 0.0 && night["recordings"] != 0 {
                self.healthy += 1;
                if is_alarm(&row) {
                    self.alarms += 1;
                    self.lines.push(format!("{name} {}: alarm, {}", row.night, row.words));
                }
            }
        }
        if drive["wear"].is_object() {
            self.add_wear(drive, rows, trend);
        }
    }

    /// A drive of which a part wears.
    fn add_wear(&mut self, drive: &Value, rows: &[Row], trend: &Value) {
        let (wear, nights) = (&drive["wear"], drive["nights"].as_array().unwrap());
        let names: Vec<&str> = wear["also_right"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        let keys: Vec<&str> = wear["amounts"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        let amounts: Vec<Parameter> =
            Parameter::ALL.iter().copied().filter(|one| keys.contains(&one.description().key)).collect();
        let tells = |row: &Row| row.strengths.iter().find(|one| amounts.contains(&one.parameter)).map(|one| one.std);
        let names_it =
            |row: &Row| row.judgement == Judgement::Changed && names.iter().any(|name| row.words.contains(name));
        let first = rows.iter().zip(nights).position(|(row, night)| night["worn_share"] != 0.0 && names_it(row));
        // By how much there is more than is installed.
        let before = wear["before"].as_f64().unwrap();
        let more = |night: &Value| night["amount"].as_f64().map(|amount| (amount - before).abs());
        let last = nights.iter().rposition(|night| night["recordings"] != 0).unwrap_or(0);
        // What a night tells it with; of one that was never told, that it showed at all is why it was drawn.
        let std = rows.iter().filter_map(tells).fold(f64::INFINITY, f64::min);
        let doubled = nights
            .iter()
            .position(|night| more(night).is_some_and(|more| more > DOUBLED * std) && night["recordings"] != 0);
        let shows = more(&nights[last]).is_none_or(|more| more > SHOWS * std || std.is_infinite());
        let in_time = first.is_some_and(|first| doubled.is_none_or(|doubled| first <= doubled));
        self.showed += usize::from(shows);
        self.named += usize::from(shows && in_time);
        let effect = wear["effect"].as_str().unwrap();
        let night = |index: Option<usize>| index.map_or("never".to_owned(), |index| index.to_string());
        let rate = rate(drive, &amounts, trend);
        // Of what showed a rate has to be there.
        let has_rate = shows && !amounts.is_empty();
        self.rated += usize::from(has_rate);
        self.near += usize::from(has_rate && rate.is_some_and(|rate| (rate - 1.0).abs() <= 0.25));
        self.lines.push(format!(
            "{} {effect} from {}: named in night {}, doubled in {}, rate over true rate {}",
            drive["drive"].as_str().unwrap(),
            wear["from"].as_str().unwrap(),
            night(first),
            night(doubled),
            rate.map_or("–".to_owned(), |rate| format!("{rate:.2}")),
        ));
    }
}

/// The trend's rate over the true one, where both are there; of several amounts that may hold the wear the nearest.
fn rate(drive: &Value, amounts: &[Parameter], trend: &Value) -> Option<f64> {
    let columns: Vec<String> = amounts.iter().filter_map(|one| column_of(*one)).collect();
    let is_own =
        |one: &&Value| one["drive"] == drive["drive"] && columns.iter().any(|column| one["column"] == **column);
    let told: Vec<f64> = drive["nights"].as_array()?.iter().filter_map(|night| night["amount"].as_f64()).collect();
    #[expect(clippy::cast_precision_loss, reason = "a number of nights")]
    let true_rate = (told.last()? - told.first()?) / (told.len().checked_sub(1).filter(|more| *more > 0)? as f64);
    let of = |one: &Value| Some(one["pieces"].as_array()?.last()?["per_month"].as_f64()? / 30.4375 / true_rate);
    let all = trend["amounts"].as_array()?.iter().filter(is_own).filter_map(of);
    all.min_by(|one, other| (one - 1.0).abs().total_cmp(&(other - 1.0).abs()))
}
