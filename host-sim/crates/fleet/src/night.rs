//! One night of one drive, judged.

use std::time::Instant;

use diagnosis::localisation::Miss;
use diagnosis::{Diagnosis, Options, Refit, Refitting, Verdict, diagnose_with};
use identification::fit::Estimate;
use machine_file::MachineFile;
use recording::Recording;
use recording::files::source_error::Explained;
use report::{terminal, wording};
use simulation::figures_of_merit::SignalFit;
use watch::{WatchError, Watched};

use crate::dataset::Night;
use crate::row::{Judgement, MISFITS, Row, Strength};

/// How far a night is looked into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Upto {
    /// Only whether the drive is in its band: one simulation a recording.
    Watch,
    /// And how much there is of every effect: a refit.
    Refit,
    /// And of a drive that left its band what has changed: a diagnosis, where a refit does not explain it.
    #[default]
    Diagnose,
}

/// How nights are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct How {
    /// How far.
    pub upto: Upto,
    /// Share of a healthy drive's recordings that may leave the band by chance.
    pub false_alarms: f64,
    /// What the search of a diagnosis may take, s on two usual cores.
    pub limit_s: f64,
}

impl Upto {
    /// All of them.
    pub const ALL: [(&'static str, Self); 3] =
        [("watch", Self::Watch), ("refit", Self::Refit), ("diagnose", Self::Diagnose)];
}

impl Default for How {
    fn default() -> Self {
        Self { upto: Upto::default(), false_alarms: watch::FALSE_ALARMS, limit_s: Options::USUAL_LIMIT_S }
    }
}

/// The rows of a night: first that of the drive, then one for each recording that cannot be used. Whatever is wrong is a row with the reason.
#[must_use]
pub fn judge(night: &Night, how: &How) -> Vec<Row> {
    let began = Instant::now();
    let mut recordings = Vec::new();
    let mut row = match judged(night, how, &mut recordings) {
        Ok(row) => row,
        Err(reason) => unusable(night, reason),
    };
    row.seconds = began.elapsed().as_secs_f64();
    let of_recording =
        |(recording, reason)| Row { recording: Some(recording), words: reason, ..empty(night, Judgement::Unusable) };
    std::iter::once(row).chain(recordings.into_iter().map(of_recording)).collect()
}

/// The row of a night that could not be judged at all.
#[must_use]
pub fn unusable(night: &Night, reason: String) -> Row {
    Row { words: reason, ..empty(night, Judgement::Unusable) }
}

/// A row in which nothing is known yet.
fn empty(night: &Night, judgement: Judgement) -> Row {
    Row {
        drive: night.drive.clone(),
        night: night.name.clone(),
        recording: None,
        judgement,
        link: None,
        words: String::new(),
        recordings: 0,
        of_limit: None,
        misfits: [None; 4],
        strengths: Vec::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seconds: 0.0,
    }
}

/// A recording's name with the reason why it cannot be used.
type Unusable = (String, String);

fn judged(night: &Night, how: &How, unusable: &mut Vec<Unusable>) -> Result<Row, String> {
    if let Some(twin) = &night.twin {
        return Err(format!("two folders have this name: {} is the other; expected one", twin.display()));
    }
    let file = machine_file::read(&night.machine).map_err(|error| error.to_string())?;
    if file.band.is_none() {
        let path = night.machine.display();
        return Err(format!("{path}: {}; expected one, which `host-sim watch --healthy` writes", WatchError::NoBand));
    }
    let (recordings, watched) = watched(night, &file, how, unusable);
    if recordings.is_empty() {
        let none = if night.recordings.is_empty() { "no recording" } else { "no recording that can be used" };
        return Err(format!("{none}: nothing is known of this night"));
    }
    let left = watched.iter().find_map(|one| one.left);
    let nearest = watched.iter().flat_map(|one| &one.signals).map(wording::share).fold(0.0, f64::max);
    let row = Row {
        link: left.map(|left| left.link),
        words: wording::watched(&watched),
        recordings: recordings.len(),
        of_limit: Some(nearest),
        ..empty(night, if left.is_some() { Judgement::Left } else { Judgement::InBand })
    };
    if how.upto == Upto::Watch {
        return Ok(row);
    }
    // What could not be refitted or diagnosed was watched all the same.
    let refit = match refit(&file, &recordings) {
        Ok(refit) => refit,
        Err(reason) => return Ok(Row { words: format!("{}; not refitted: {reason}", row.words), ..row }),
    };
    if how.upto == Upto::Refit || left.is_none() {
        return Ok(refitted(row, &refit));
    }
    if refit.is_of_the_day() {
        let words = format!("unchanged: refitted to the oil and the day, it follows; {}", row.words);
        return Ok(refitted(Row { judgement: Judgement::Unchanged, words, ..row }, &refit));
    }
    Ok(diagnosed(&row, &file, &recordings, how).unwrap_or_else(|reason| Row {
        judgement: Judgement::Unexplained,
        words: format!("{}; not diagnosed: {reason}", row.words),
        ..row
    }))
}

/// The recordings that can be used, each with what the monitor says of it.
fn watched(
    night: &Night,
    file: &MachineFile,
    how: &How,
    unusable: &mut Vec<Unusable>,
) -> (Vec<Recording>, Vec<Watched>) {
    let (mut recordings, mut all) = (Vec::new(), Vec::new());
    for path in &night.recordings {
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let read = recording::read(path, &file.channels).map_err(|error| {
            // The place without its folder: rows are the same wherever the data set lies.
            format!("{}; expected {}", error.found(), error.expected())
        });
        let found = read.and_then(|recording| {
            let seen = watch::watch(file, &recording, None, how.false_alarms).map_err(|error| error.to_string())?;
            Ok((recording, seen))
        });
        match found {
            Ok((recording, seen)) => {
                recordings.push(recording);
                all.push(seen);
            }
            Err(reason) => unusable.push((name, reason)),
        }
    }
    (recordings, all)
}

/// The drive, refitted: what is of the oil and of the day may move, the rest as far as it is known since then.
fn refit(file: &MachineFile, recordings: &[Recording]) -> Result<Refit, String> {
    let refit = Refitting::since(file, recordings, None).and_then(|refitting| refitting.search(&|_| ()));
    refit.map_err(|error| error.to_string())
}

/// How much there is of every effect.
fn refitted(row: Row, refit: &Refit) -> Row {
    let of = |estimate: &Estimate| Strength { parameter: estimate.parameter, value: estimate.value, std: estimate.std };
    let strengths = if refit.converged { refit.strengths.iter().map(of).collect() } else { Vec::new() };
    Row { misfits: misfits(&refit.left), strengths, ..row }
}

/// What has changed since.
fn diagnosed(row: &Row, file: &MachineFile, recordings: &[Recording], how: &How) -> Result<Row, String> {
    // One recording is held out where there is one to spare.
    let trained = if recordings.len() > 1 { recordings.len() - 1 } else { 1 };
    let (training, held_out) = recordings.split_at(trained);
    let options = Options { tick: None, asks_since: true, limit_s: Some(how.limit_s) };
    let found = diagnose_with(file, (training, held_out), options, &|_| ()).map_err(|error| error.to_string())?;
    let judgement = match found.verdict {
        Verdict::MissingPhysics => Judgement::Changed,
        Verdict::NothingMissing if found.is_unchanged() => Judgement::Unchanged,
        Verdict::NothingMissing | Verdict::Unexplained => Judgement::Unexplained,
    };
    Ok(Row {
        judgement,
        words: format!("{}; {}", terminal::sentence(&found), row.words),
        misfits: misfits_after(&found),
        // A model that does not follow the recordings does not tell what is in it.
        strengths: if judgement == Judgement::Unexplained { Vec::new() } else { strengths(&found) },
        ..row.clone()
    })
}

/// The amounts of what a diagnosis found, and of the effects that the file holds, as far as the recordings tell them: by a third of themselves.
fn strengths(found: &Diagnosis) -> Vec<Strength> {
    let of_findings = found.findings.iter().flat_map(|finding| &finding.parameters);
    let held = found.refitted.iter().filter(|estimate| {
        let is_found = of_findings.clone().any(|own| own.parameter == estimate.parameter);
        estimate.parameter.effect().is_some() && !is_found
    });
    let is_told = |estimate: &&Estimate| 3.0 * estimate.std < estimate.value.abs();
    let all = of_findings.clone().chain(held).filter(is_told);
    all.map(|estimate| Strength { parameter: estimate.parameter, value: estimate.value, std: estimate.std }).collect()
}

fn misfits(left: &[Miss]) -> [Option<f64>; 4] {
    MISFITS.map(|signal| left.iter().find(|miss| miss.signal == signal).map(|miss| miss.over_noise))
}

/// What the model after a diagnosis misses of the recordings that it was fitted to.
fn misfits_after(found: &Diagnosis) -> [Option<f64>; 4] {
    let fits: Vec<SignalFit> =
        found.shown.iter().filter(|shown| !shown.held_out).flat_map(|shown| shown.fits(true)).collect();
    MISFITS.map(|signal| {
        let squares = fits.iter().filter(|fit| fit.signal == signal).map(|fit| fit.over_noise.powi(2));
        let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
        (count > 0.0).then(|| f64::sqrt(sum / count))
    })
}
