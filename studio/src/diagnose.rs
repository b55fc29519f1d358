//! The command `diagnose`.

use diagnosis::{Diagnosis, Options, diagnose_with, settle_pressure_zero, steps};
use recording::Recording;
use report::evidence::Exhibits;
use report::refused::{Refused, check_distinct};
use report::{html, json, terminal};

use crate::commands::Results;
use crate::desk::{Desk, Request, checked_doubts, notes};
use crate::progress::Progress;

pub(crate) fn diagnose(desk: &Desk, request: &Request, progress: &Progress<'_>) -> Result<Results, Refused> {
    let mut drive = request.drive()?;
    let channels = request.channels(Some(&drive))?;
    let mut training = desk.recordings(&request.train, &channels)?;
    let mut held_out = desk.any_recordings(&request.holdout, &channels)?;
    check_distinct(&training, &held_out)?;
    let name = drive.name.clone();
    let failed = |cause| Refused::diagnose(&name, cause);
    settle_pressure_zero(&mut drive.file, &mut training, &mut held_out, None).map_err(failed)?;
    let all: Vec<&Recording> = training.iter().chain(&held_out).collect();
    let doubts = checked_doubts(&drive, &all, request.as_recorded)?;
    let limit_s = request.limit_s.unwrap_or(Options::USUAL_LIMIT_S);
    if !(limit_s.is_finite() && limit_s > 0.0) {
        return Err(Refused::of(format_args!("a time limit of {limit_s} s; expected more than 0")));
    }
    let options = Options { tick: None, asks_since: false, limit_s: Some(limit_s) };
    let (file, of) = (&drive.file, steps(&drive.file));
    let found = diagnose_with(file, (&training, &held_out), options, &|_| progress.add(1, of)).map_err(failed)?;
    let diagnosis = Diagnosis { doubts, ..found };
    let exhibits = Exhibits::of(file, &training, &held_out, &diagnosis, true);
    let exhibits = exhibits.map_err(|cause| Refused::machine(&drive.name, cause))?;
    Ok(Results {
        text: terminal::text(&diagnosis, &exhibits),
        notes: notes(&all, &file.machine),
        json: format!("{:#}\n", json::document(&diagnosis, &exhibits)),
        machine: Some(diagnosis.machine_file(file).to_text(&drive.name)?),
        page: Some(html::page(&diagnosis, &exhibits, &request.about())),
    })
}
