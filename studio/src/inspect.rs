//! The command `inspect`.

use experiment::inspect::Inspection;
use recording::{Recording, UnknownColumn, survey_from, unknown_among};
use report::html::{self, Inspected};
use report::refused::Refused;

use crate::commands::Results;
use crate::desk::{Desk, Request};

pub(crate) fn inspect(desk: &Desk, request: &Request) -> Result<Results, Refused> {
    let drive = request.machine()?;
    let channels = request.channels(drive.as_ref())?;
    let names = [request.train.as_slice(), &request.holdout].concat();
    let recordings = desk.recordings(&names, &channels)?;
    let file = drive.as_ref().map(|drive| &drive.file);
    let found: Vec<Inspection> = recordings.iter().map(|recording| Inspection::of(recording, file)).collect();
    let texts: Vec<String> = found.iter().map(|found| report::inspect::text(found, None)).collect();
    // A file whose columns cannot be surveyed shows its known channels alone.
    let surveyed = |(name, recording): (&String, &Recording)| {
        let columns = desk.bytes(name).ok().and_then(|bytes| survey_from(name, bytes).ok())?;
        Some(unknown_among(&columns, recording))
    };
    let unknown: Vec<Vec<UnknownColumn>> =
        names.iter().zip(&recordings).map(|of| surveyed(of).unwrap_or_default()).collect();
    let inspected = Inspected::each(&found, &recordings, &unknown);
    Ok(Results {
        text: texts.join("\n"),
        json: format!("{:#}\n", report::inspect::document(&found)),
        page: Some(html::inspect(file.map(|file| file.name.as_str()), &inspected, &request.about())),
        ..Results::default()
    })
}
