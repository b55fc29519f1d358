//! The command `fit`.

use diagnosis::{Refitting, read_absolute};
use recording::{PressureZero, Recording};
use report::{html, json, terminal, wording};

use crate::commands::Results;
use crate::desk::{Desk, Request, checked_doubts, notes};
use crate::progress::Progress;
use crate::refused::Refused;

pub(crate) fn fit(desk: &Desk, request: &Request, progress: &Progress<'_>) -> Result<Results, Refused> {
    let mut drive = request.drive()?;
    let channels = request.channels(Some(&drive))?;
    let mut recordings = desk.recordings(&request.train, &channels)?;
    let trained = recordings.len();
    recordings.extend(desk.any_recordings(&request.holdout, &channels)?);
    check_held_out(&recordings[..trained], &recordings[trained..])?;
    let name = drive.name.clone();
    let failed = |cause| Refused::diagnose(&name, cause);
    if read_absolute(&drive.file, &recordings[..trained], None).map_err(failed)? {
        recordings.iter_mut().for_each(Recording::take_as_absolute);
        drive.file.channels.pressure = PressureZero::Absolute;
    }
    let all: Vec<&Recording> = recordings.iter().collect();
    let mut notes = notes(&all, &drive.file.machine);
    notes.extend(checked_doubts(&drive, &all, request.as_recorded)?.iter().map(wording::doubt));
    let (training, held_out) = recordings.split_at(trained);
    let refitting = Refitting::of(&drive.file, training, None).map_err(failed)?;
    let refitting = refitting.with_held_out(held_out, None).map_err(failed)?;
    let of = refitting.most_rows() as u64;
    let refit = refitting.search(&|rows| progress.add(rows as u64, of)).map_err(failed)?;
    if !refit.converged {
        notes.push("the search did not converge; these are the best values found".to_owned());
    }
    let left = terminal::missed(&refit.left);
    Ok(Results {
        text: format!("{}\nWhat is left: {left}.", terminal::parameters(&refit.estimates)),
        notes,
        json: format!("{:#}\n", json::refit(&refit)),
        machine: Some(refit.file.to_text(&drive.name)?),
        page: Some(html::fit(&refit, &all, &request.about())),
    })
}

/// A recording that is fitted to may count twice; one that is held out may not be among them.
fn check_held_out(training: &[Recording], held_out: &[Recording]) -> Result<(), Refused> {
    let Some((first, second)) = Recording::trained_on(training, held_out) else { return Ok(()) };
    let (first, second) = (first.name(), second.name());
    Err(Refused::of(format_args!(
        "{first} and {second} hold the same recording; expected held-out recordings that are not trained on"
    )))
}
