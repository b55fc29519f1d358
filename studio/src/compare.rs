//! The command `compare`.

use diagnosis::base_parameters;
use identification::compare::open_loop::compare_each;
use identification::compare::{Comparison, rows_simulated};
use recording::Recording;
use report::html::{self, Compared};
use report::refused::Refused;
use report::{json, wording};
use simulation::Arithmetic;

use crate::commands::Results;
use crate::desk::{Desk, Drive, Request, checked_doubts, notes};
use crate::progress::Progress;

pub(crate) fn compare(desk: &Desk, request: &Request, progress: &Progress<'_>) -> Result<Results, Refused> {
    let drive = request.drive()?;
    let names = [request.train.as_slice(), &request.holdout].concat();
    let recordings = desk.recordings(&names, &request.channels(Some(&drive))?)?;
    let found = compared(&drive, &recordings, progress)?;
    let all: Vec<&Recording> = recordings.iter().collect();
    let mut notes = notes(&all, &drive.file.machine);
    // They are compared as they are all the same.
    let doubts = checked_doubts(&drive, &all, true)?;
    notes.extend(doubts.iter().filter(|doubt| doubt.is_certain).map(wording::mend_first));
    let (file, label) = (&drive.file, drive.file.name.as_str());
    let compared = Compared { label, file, recordings: &recordings, comparisons: &found, doubts: &doubts };
    Ok(Results {
        notes,
        json: format!("{:#}\n", json::comparison(&drive.file, &found)),
        page: Some(html::compare(&[compared], &request.about())),
        ..Results::default()
    })
}

fn compared(drive: &Drive, recordings: &[Recording], progress: &Progress<'_>) -> Result<Vec<Comparison>, Refused> {
    let Drive { name, file } = drive;
    let rows = |one| rows_simulated(file.machine.source, file.load_source, one) as u64;
    let of = recordings.iter().map(rows).sum();
    let told = |rows| progress.add(rows as u64, of);
    let found = compare_each(file, &base_parameters(file), recordings, (Arithmetic::default(), None), &told);
    found.map_err(|cause| Refused::compare(name, cause))
}
