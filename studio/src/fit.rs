//! The command `fit`.

use diagnosis::{Refitting, settle_pressure_zero};
use recording::Recording;
use report::refused::{Refused, check_held_out};
use report::{html, json, terminal, wording};

use crate::commands::Results;
use crate::desk::{Desk, Request, checked_doubts, notes};
use crate::progress::Progress;

pub(crate) fn fit(desk: &Desk, request: &Request, progress: &Progress<'_>) -> Result<Results, Refused> {
    let mut drive = request.drive()?;
    let channels = request.channels(Some(&drive))?;
    let mut training = desk.recordings(&request.train, &channels)?;
    let mut held_out = desk.any_recordings(&request.holdout, &channels)?;
    check_held_out(&training, &held_out)?;
    let name = drive.name.clone();
    let failed = |cause| Refused::diagnose(&name, cause);
    settle_pressure_zero(&mut drive.file, &mut training, &mut held_out, None).map_err(failed)?;
    let all: Vec<&Recording> = training.iter().chain(&held_out).collect();
    let mut notes = notes(&all, &drive.file.machine);
    let doubts = checked_doubts(&drive, &all, request.as_recorded)?;
    notes.extend(doubts.iter().map(wording::doubt));
    let refitting = Refitting::of(&drive.file, &training, None).map_err(failed)?;
    let refitting = refitting.with_held_out(&held_out, None).map_err(failed)?;
    let of = refitting.most_rows() as u64;
    let refit = refitting.search(&|rows| progress.add(rows as u64, of)).map_err(failed)?;
    if !refit.converged {
        notes.push("the search did not converge; these are the best values found".to_owned());
    }
    let left = terminal::missed(&refit.left);
    let worse = wording::fit_is_worse(&refit).map_or_else(String::new, |worse| format!("{worse}\n"));
    Ok(Results {
        text: format!("{worse}{}\nWhat is left: {left}.", terminal::parameters(&refit.estimates)),
        notes,
        json: format!("{:#}\n", json::refit(&refit)),
        machine: Some(refit.file.to_text(&drive.name)?),
        page: Some(html::fit(&refit, &all, &doubts, &request.about())),
    })
}
