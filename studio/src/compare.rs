//! The command `compare`.

use diagnosis::base_parameters;
use identification::compare::open_loop::put_sways;
use identification::compare::{Comparison, compare_with_progress, rows_simulated};
use identification::parallel;
use recording::Recording;
use report::html::{self, Compared};
use report::{json, wording};
use simulation::Arithmetic;

use crate::commands::Results;
use crate::desk::{Desk, Drive, Request, checked_doubts, notes};
use crate::progress::Progress;
use crate::refused::Refused;

pub(crate) fn compare(desk: &Desk, request: &Request, progress: &Progress<'_>) -> Result<Results, Refused> {
    let drive = request.drive()?;
    let names = [request.train.as_slice(), &request.holdout].concat();
    let recordings = desk.recordings(&names, &request.channels(Some(&drive))?)?;
    let found = compared(&drive, &recordings, progress)?;
    let all: Vec<&Recording> = recordings.iter().collect();
    let mut notes = notes(&all, &drive.file.machine);
    // They are compared as they are all the same.
    let doubts = checked_doubts(&drive, &all, true)?;
    let certain = doubts.iter().filter(|doubt| doubt.is_certain).map(wording::doubt);
    notes.extend(
        certain.map(|doubt| format!("{doubt}; mend this first: what follows is of the recordings as they are")),
    );
    let compared =
        Compared { label: &drive.file.name, file: &drive.file, recordings: &recordings, comparisons: &found };
    Ok(Results {
        notes,
        json: format!("{:#}\n", json::comparison(&drive.file, &found)),
        page: Some(html::compare(&[compared], &request.about())),
        ..Results::default()
    })
}

fn compared(drive: &Drive, recordings: &[Recording], progress: &Progress<'_>) -> Result<Vec<Comparison>, Refused> {
    let (values, load) = (&drive.file.machine, drive.file.load_source);
    let of = recordings.iter().map(|one| rows_simulated(values.source, load, one) as u64).sum();
    let free = base_parameters(&drive.file);
    let found = parallel::try_each(recordings, |recording| {
        let told = |rows| progress.add(rows as u64, of);
        let mut found = compare_with_progress(values, load, recording, Arithmetic::default(), None, &told)?;
        put_sways(&mut found, values, load, recording, None, &free)?;
        Ok(found)
    });
    found.map_err(|cause| Refused::compare(&drive.name, cause))
}
