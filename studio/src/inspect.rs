//! The command `inspect`.

use experiment::inspect::Inspection;
use recording::display_unit::unit_for_people;
use recording::{Recording, Signal};
use report::plot::{Panel, Style, Trace, svg};

use crate::commands::Results;
use crate::desk::{Desk, Request};
use crate::refused::Refused;

pub(crate) fn inspect(desk: &Desk, request: &Request) -> Result<Results, Refused> {
    let drive = request.machine()?;
    let channels = request.channels(drive.as_ref())?;
    let names = [request.train.as_slice(), &request.holdout].concat();
    let recordings = desk.recordings(&names, &channels)?;
    let file = drive.as_ref().map(|drive| &drive.file);
    let found: Vec<Inspection> = recordings.iter().map(|recording| Inspection::of(recording, file)).collect();
    let texts: Vec<String> = found.iter().map(|found| report::inspect::text(found, None)).collect();
    Ok(Results {
        text: texts.join("\n"),
        json: format!("{:#}\n", report::inspect::document(&found)),
        drawings: recordings.iter().map(drawn).collect(),
        ..Results::default()
    })
}

/// Every channel over time.
fn drawn(recording: &Recording) -> String {
    let panel = |column: &recording::Column| {
        let (signal, unit) = (column.signal, unit_for_people(column.signal));
        let values = recording.signal(signal).unwrap_or_default().iter().map(|value| unit.from_si(*value)).collect();
        let panel = Panel::new(signal.name(), unit.symbol(), recording.time_s().to_vec());
        panel.trace(Trace::new("recorded", values, Style::Simulated))
    };
    let channels = recording.columns().iter().filter(|column| column.signal != Signal::Time);
    svg(recording.name(), "as it was recorded", &channels.map(panel).collect::<Vec<_>>())
}
