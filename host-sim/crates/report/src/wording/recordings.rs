//! What is worth a look in a recording.

use diagnosis::agreement::Suspicion;
use experiment::inspect::{Advice, Mark, MarkKind, UnitDoubt, Unseen};
use model_core::machine::Source;
use recording::display_unit::{significant, unit_for_people};
use recording::{Note, Signal};

use super::unit::times_as;
use super::unit_doubt;

/// What the rows of a recording are too far apart to show.
#[must_use]
pub fn unseen(unseen: &Unseen) -> String {
    let (rate, fastest) = (significant(1.0 / unseen.row_s, 3), significant(unseen.fastest_hz, 3));
    let row = significant(1e3 * unseen.row_s, 3);
    let by_file = [
        unseen.valve_s.map(|lag_s| format!("the valve's delay and lags, {} ms together", significant(1e3 * lag_s, 2))),
        unseen.oil_column_hz.map(|hz| format!("the oil column's {} Hz", significant(hz, 2))),
    ];
    let by_file: Vec<String> = by_file.into_iter().flatten().collect();
    let by_file = if by_file.is_empty() {
        String::new()
    } else {
        format!("; these rows cannot show {}, as the machine file has it", by_file.join(" nor "))
    };
    format!(
        "at {rate} Hz nothing faster than {fastest} Hz shows: no lag below {row} ms, no jump of the spool, no stick-slip or ringing faster than that{by_file}"
    )
}

/// What is worth a second look in a recording, or another recording.
#[must_use]
pub fn recording_advice(advice: &Advice) -> String {
    match advice {
        Advice::Constant { signal, unit, value } => {
            format!("{signal} is {} {unit} in every row and cannot be judged", significant(unit.from_si(*value), 3))
        }
        Advice::Unit(doubt) => unit_doubt(doubt),
        Advice::Agreement(suspicion) => format!(
            "{}; `host-sim fit` and `diagnose` try what would explain it",
            match suspicion {
                Suspicion::RunsAgainst(signal) =>
                    format!("{signal} runs against what the machine file's model does with this input"),
                Suspicion::PressuresCrossed =>
                    "each pressure is nearer to what the machine file's model gives for the other chamber".to_owned(),
                Suspicion::MovesOtherwise(signal, ratio) if ratio.is_finite() => format!(
                    "{signal} moves {} as far as the machine file's model does with this input",
                    times_as(*ratio)
                ),
                Suspicion::MovesOtherwise(signal, _) =>
                    format!("{signal} moves, but the machine file's model hardly does with this input"),
            }
        ),
        Advice::RangeEnd { signal, reading, share } => {
            format!(
                "{}: what is beyond it is not recorded, and these rows are not judged",
                range_end(*signal, *reading, *share)
            )
        }
        Advice::NeverOpens { by } => {
            format!(
                "with this {by} the valve never leaves the dead zone, so nothing below it moves: use larger commands"
            )
        }
        Advice::OpensOneWay { by, extending } => {
            let way = if *extending { "extend" } else { "retract" };
            format!("by its {by} the valve opens to {way} only; commands both ways show both sides")
        }
        Advice::DoesNotMove => {
            "the rod does not move by more than its sensor's noise: friction and flow do not show".to_owned()
        }
        Advice::MovesOneWay => "the rod moves one way only; move both ways to tell friction from load".to_owned(),
        Advice::LittleTravel => {
            "the rod covers little of its stroke: what depends on the position does not show".to_owned()
        }
        Advice::NeverHolds { source: Source::Force, least_s } => {
            format!("it never holds for {least_s} s; a pause shows friction at rest")
        }
        Advice::NeverHolds { least_s, .. } => format!(
            "the rod never holds for {least_s} s; a pause with the valve closed shows leakage, drift and friction at rest"
        ),
    }
}

/// What is taken of pressures that fit the drive only without the pressure of the air in them.
#[must_use]
pub fn taken_as_absolute() -> String {
    format!(
        "pressures  {}; if they are, say so in the machine file: [channels] pressure = \"absolute\"",
        Note::TakenAsAbsolute
    )
}

/// A sensor at an end of its range, without how these rows are treated.
#[must_use]
pub fn range_end(signal: Signal, reading: f64, share: f64) -> String {
    let unit = unit_for_people(signal);
    let (reading, percent) = (significant(unit.from_si(reading), 4), significant(100.0 * share, 2));
    format!("{signal} reads {reading} {unit}, the end of its sensor's range, in {percent} % of the rows")
}

/// Where a channel is suspicious, a sentence for each kind of mark.
#[must_use]
pub fn marks(signal: Signal, marks: &[Mark]) -> Vec<String> {
    /// So many are told by their times.
    const TOLD: usize = 3;
    let unit = unit_for_people(signal);
    let read = |si: f64| format!("{} {unit}", significant(unit.from_si(si), 4));
    let time = |seconds: f64| significant(seconds, 3);
    let said = |kind: MarkKind, here: &[&Mark]| {
        let first = here.first()?;
        let stretch = |mark: &&&Mark| {
            if mark.from_s < mark.to_s {
                format!("{} to {} s", time(mark.from_s), time(mark.to_s))
            } else {
                format!("at {} s", time(mark.from_s))
            }
        };
        let stretches: Vec<String> = here.iter().take(TOLD).map(|mark| stretch(&mark)).collect();
        let more = if here.len() > TOLD { format!(" and {} more", here.len() - TOLD) } else { String::new() };
        Some(match kind {
            MarkKind::Spike if here.len() == 1 => {
                format!("a spike at {} s, to {}", time(first.from_s), read(first.reading))
            }
            MarkKind::Spike => {
                let times: Vec<String> = here.iter().take(TOLD).map(|mark| time(mark.from_s)).collect();
                format!(
                    "{} spikes, at {} s{}",
                    here.len(),
                    times.join(", "),
                    if more.is_empty() { "" } else { " and on" }
                )
            }
            MarkKind::Dropout => {
                format!("the sensor drops out, to {}: {}{more}", read(first.reading), stretches.join(", "))
            }
            MarkKind::Stuck => {
                format!("the sensor is stuck at {}: {}{more}", read(first.reading), stretches.join(", "))
            }
            MarkKind::RangeEnd => format!(
                "clipped at {}, the end of the sensor's range: {}{more}",
                read(first.reading),
                stretches.join(", ")
            ),
        })
    };
    let mut all = Vec::new();
    for kind in MarkKind::ALL {
        // Each reading by itself: a channel may be clipped at both ends. Spikes have as many readings as there are.
        let mut groups: Vec<(String, Vec<&Mark>)> = Vec::new();
        for mark in marks.iter().filter(|mark| mark.kind == kind) {
            let reading = if kind == MarkKind::Spike { String::new() } else { read(mark.reading) };
            match groups.iter_mut().find(|(known, _)| *known == reading) {
                Some((_, group)) => group.push(mark),
                None => groups.push((reading, vec![mark])),
            }
        }
        all.extend(groups.iter().filter_map(|(_, group)| said(kind, group)));
    }
    all
}

/// The signal that a piece of advice is about, where it is one.
#[must_use]
pub(crate) fn about(advice: &Advice) -> Option<Signal> {
    match advice {
        Advice::Constant { signal, .. }
        | Advice::RangeEnd { signal, .. }
        | Advice::Unit(UnitDoubt::Beyond { signal, .. })
        | Advice::Agreement(Suspicion::RunsAgainst(signal) | Suspicion::MovesOtherwise(signal, _)) => Some(*signal),
        Advice::Unit(UnitDoubt::Current { .. }) => Some(Signal::Command),
        Advice::Unit(UnitDoubt::SpoolTravel { .. }) => Some(Signal::Spool),
        Advice::NeverOpens { by } | Advice::OpensOneWay { by, .. } => Some(*by),
        Advice::Unit(UnitDoubt::Speed { .. } | UnitDoubt::Load { .. })
        | Advice::Agreement(Suspicion::PressuresCrossed)
        | Advice::DoesNotMove
        | Advice::MovesOneWay
        | Advice::LittleTravel
        | Advice::NeverHolds { .. } => None,
    }
}

/// What follows from a recording that does not begin at rest, where a part of its state is not measured.
#[must_use]
pub fn unsettled(for_s: f64) -> String {
    format!(
        "does not begin at rest, and what moved the drive before is not recorded: the first {} s are not judged",
        significant(for_s, 2)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_on_a_recording_says_what_to_do() {
        for (advice, part) in [
            (Advice::NeverOpens { by: Signal::Command }, "with this command the valve never leaves the dead zone"),
            (Advice::DoesNotMove, "does not move"),
            (Advice::OpensOneWay { by: Signal::Command, extending: true }, "opens to extend only"),
            (Advice::MovesOneWay, "one way only"),
            (Advice::LittleTravel, "little of its stroke"),
            (
                Advice::NeverHolds { source: Source::Valve, least_s: 0.3 },
                "never holds for 0.3 s; a pause with the valve closed",
            ),
            (
                Advice::NeverHolds { source: Source::Force, least_s: 0.3 },
                "never holds for 0.3 s; a pause shows friction",
            ),
        ] {
            let said = recording_advice(&advice);
            assert!(said.contains(part), "{part}: {said}");
        }
    }
}
