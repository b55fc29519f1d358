//! What a recording contains and what it can show, before any model is fitted: its channels, which links of a drive it
//! can test, and how well the drive was excited.

mod advice;
mod channels;
mod command;
mod excitation;
mod marks;
mod testable;
mod units;
mod unseen;

use diagnosis::agreement::{Suspicion, first_look};
use identification::clock::Stamps;
use machine_file::MachineFile;
use model_core::machine::Source;
use recording::{Recording, Signal};

pub use advice::{Advice, Bound, CommandRange, UnitDoubt};
pub use channels::InspectedColumn;
pub use excitation::{Excited, Opened, Travelled};
pub use marks::{Mark, MarkKind};
pub use testable::{LinkTest, Reach};
pub use units::{load_doubt, unit_doubts};
pub use unseen::Unseen;

/// Everything that is found in one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// The recording's name.
    pub recording: String,
    /// Rows.
    pub rows: usize,
    /// From the first row to the last, s.
    pub duration_s: f64,
    /// What its time stamps show.
    pub stamps: Stamps,
    /// Stretches without rows, (from, to) in s.
    pub gaps: Vec<(f64, f64)>,
    /// The known columns but time, in the order of the file.
    pub channels: Vec<InspectedColumn>,
    /// Headers of columns that hold no known signal.
    pub ignored: Vec<String>,
    /// What had to be corrected when reading: duplicates, gaps, empty cells.
    pub notes: Vec<String>,
    /// Whether a valve or a pump feeds the cylinder: from the machine file, or else from the columns.
    pub source: Source,
    /// The links in the model's order.
    pub links: Vec<LinkTest>,
    /// What moved, and how far.
    pub excited: Excited,
    /// What its rows are too far apart to show.
    pub unseen: Option<Unseen>,
    /// What is worth a second look, or another recording.
    pub advice: Vec<Advice>,
}

impl Inspection {
    /// Inspects a recording; with a machine file it is also compared with its dead zone, stroke and supply pressure.
    #[must_use]
    pub fn of(recording: &Recording, file: Option<&MachineFile>) -> Self {
        let time_s = recording.time_s();
        let source = file.map_or_else(|| suggested(recording), |file| file.machine.source);
        let channels: Vec<InspectedColumn> = recording
            .columns()
            .iter()
            .filter(|column| column.signal != Signal::Time)
            .map(|column| InspectedColumn::of(time_s, column))
            .collect();
        let excited = Excited::of(recording, file.map(|file| &file.machine));
        let mut advice: Vec<Advice> = excitation::constant(&channels).collect();
        advice.extend(channels.iter().flat_map(|channel| {
            let signal = channel.signal;
            channel.ends.iter().map(move |&(reading, share)| Advice::RangeEnd { signal, reading, share })
        }));
        let doubts = file.map(|file| unit_doubts(recording, &file.machine)).unwrap_or_default();
        // A doubtful unit says already why a signal moves otherwise than the model's.
        let is_explained = |suspicion: &Suspicion| {
            matches!(suspicion, Suspicion::MovesOtherwise(..) | Suspicion::PressuresCrossed)
                && doubts.iter().any(|doubt| !matches!(doubt, UnitDoubt::Load { .. }))
        };
        let suspicions = file.map(|file| first_look(file, recording)).unwrap_or_default();
        advice.extend(suspicions.into_iter().filter(|suspicion| !is_explained(suspicion)).map(Advice::Agreement));
        advice.extend(doubts.into_iter().map(Advice::Unit));
        advice.extend(excited.advice(source));
        let stamps = Stamps::of(time_s);
        Self {
            recording: recording.name().to_owned(),
            rows: recording.rows(),
            duration_s: time_s.last().zip(time_s.first()).map_or(0.0, |(last, first)| last - first),
            gaps: marks::gaps(time_s, stamps.interval_s),
            stamps,
            channels,
            ignored: recording.ignored().to_vec(),
            notes: recording.notes().iter().map(ToString::to_string).collect(),
            source,
            links: testable::links(source, |signal| recording.has(signal)),
            excited,
            unseen: Unseen::of(recording, file.map(|file| &file.machine)),
            advice,
        }
    }
}

/// A recording with a pump's speed and no valve belongs to a pump-controlled drive; one with a force and no sign of oil to a mass that the force moves.
fn suggested(recording: &Recording) -> Source {
    use Signal::{Command, Flow, Force, PressureA, PressureB, PumpSpeed, Spool, SupplyPressure};
    let has = |signals: &[Signal]| signals.iter().any(|signal| recording.has(*signal));
    if has(&[Command, Spool]) {
        Source::Valve
    } else if has(&[PumpSpeed]) {
        Source::Pump
    } else if has(&[Force]) && !has(&[Flow, PressureA, PressureB, SupplyPressure]) {
        Source::Force
    } else {
        Source::Valve
    }
}
