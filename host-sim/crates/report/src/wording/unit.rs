//! Notes of a recording, and units that can hardly be right for a drive.

use experiment::inspect::{Bound, CommandRange, UnitDoubt, unit_doubts};
use model_core::machine::Machine;
use recording::display_unit::significant;
use recording::{Recording, Unit};

/// The notes of a recording, and doubts about its units for this drive, each with the recording's name.
#[must_use]
pub fn notes(recording: &Recording, machine: &Machine<f64>) -> Vec<String> {
    [own_notes(recording), unit_notes(recording, machine)].concat()
}

/// The notes made when a recording was read, with its name.
#[must_use]
pub fn own_notes(recording: &Recording) -> Vec<String> {
    recording.notes().iter().map(|note| format!("{}: {note}", recording.name())).collect()
}

/// Doubts about the units of a recording for this drive, with its name.
#[must_use]
pub fn unit_notes(recording: &Recording, machine: &Machine<f64>) -> Vec<String> {
    let doubts = unit_doubts(recording, machine);
    doubts.iter().map(|doubt| format!("{}: {}", recording.name(), unit_doubt(doubt))).collect()
}

/// Why a unit can hardly be right for this drive, and what would do.
#[must_use]
pub fn unit_doubt(doubt: &UnitDoubt) -> String {
    match doubt {
        UnitDoubt::Current { command, closed_at_ma } => {
            let CommandRange { header, unit, low, high, opening } = command;
            let (unit, opening) = (unit.symbol(), significant(100.0 * opening, 3));
            let range =
                format!("command goes from {} {unit} to {} {unit}", significant(*low, 3), significant(*high, 3));
            let by_file = format!("by the machine file's gain_per_v it opens the valve to {opening} %");
            let in_channels = |zero: f64, full: f64| {
                format!(
                    "if the file counts in volts, its [channels] can say `command = {{ column = \"{header}\", zero = {zero}, full = {full} }}`"
                )
            };
            match closed_at_ma {
                Some(middle) => format!(
                    "{range}, as a current of 4 to 20 mA that closes the valve at {middle} mA does, but {by_file} and never closes it: {}",
                    in_channels(*middle, 0.8)
                ),
                None => format!("{range}, and {by_file}: {}", in_channels(0.0, 2.0)),
            }
        }
        UnitDoubt::Load { load_n, full_n } => format!(
            "load.force_n of the machine file is {} N, beyond the full force of the cylinder, {} N (supply pressure times area): is its unit right?",
            significant(*load_n, 3),
            significant(*full_n, 3)
        ),
        UnitDoubt::SpoolTravel { unit, share } => format!(
            "the measured spool goes {} as far as gain_per_v says of a held command: does the machine file count in {}, as the recording does?",
            times_as(*share),
            unit.symbol()
        ),
        UnitDoubt::Beyond { signal, unit, high, bound, fitting } => {
            let shown = |unit: Unit| format!("{} {unit}", significant(*high, 3));
            let passed = match bound {
                Bound::Stroke => "beyond the stroke of the machine file",
                Bound::FarAboveSupply => "1.5 times the supply pressure or more of the machine file",
                Bound::FarBelowSupply => "less than a hundredth of the supply pressure of the machine file",
            };
            let instead = fitting.map_or_else(String::new, |unit| format!(" {} would be possible", shown(unit)));
            let asked = if *bound == Bound::Stroke { "are its unit and its zero" } else { "is its unit" };
            format!("{signal} reaches {}, {passed}: {asked} right?{instead}", shown(*unit))
        }
        UnitDoubt::Speed { share, fitting } => {
            let instead = fitting.map_or_else(String::new, |(unit, share)| {
                format!(" With times in {unit}, it would be {}", significant(share, 2))
            });
            format!(
                "the rod goes {} as fast as the valve, opened as it was, lets it without load: are the units of time and position right?{instead}",
                times_as(*share)
            )
        }
    }
}

/// `10 times`, before `as far`; a small fraction as `1/1000`.
pub(super) fn times_as(factor: f64) -> String {
    if (1e-9..0.01).contains(&factor) {
        format!("1/{}", significant(1.0 / factor, 2))
    } else {
        format!("{} times", significant(factor, 2))
    }
}

#[cfg(test)]
mod tests {
    use recording::Signal;

    use super::*;

    #[test]
    fn a_doubt_about_a_unit_says_what_would_do() {
        let unit = |symbol| Unit::parse(symbol).unwrap();
        let current = |low, high, closed_at_ma| {
            let header = "command [mA]".to_owned();
            let command = CommandRange { header, unit: unit("mA"), low, high, opening: 2.0 };
            unit_doubt(&UnitDoubt::Current { command, closed_at_ma })
        };
        let live = current(4.0, 20.0, Some(12.0));
        for part in
            ["from 4.00 mA to 20.0 mA", "to 200 %", "command = { column = \"command [mA]\", zero = 12, full = 0.8 }"]
        {
            assert!(live.contains(part), "{part}: {live}");
        }
        assert!(current(-20.0, 20.0, None).contains("zero = 0, full = 2 }"));
        let travel = unit_doubt(&UnitDoubt::SpoolTravel { unit: unit("mA"), share: 0.5 });
        assert!(travel.contains("0.50 times as far") && travel.contains("count in mA"), "{travel}");
        let beyond = |signal, now, high, bound, fitting| {
            unit_doubt(&UnitDoubt::Beyond { signal, unit: unit(now), high, bound, fitting: Some(unit(fitting)) })
        };
        let position = beyond(Signal::Position, "m", 200.0, Bound::Stroke, "mm");
        assert!(position.contains("beyond the stroke of the machine file"), "{position}");
        assert!(position.ends_with(" 200 mm would be possible"), "{position}");
        let low = beyond(Signal::PressureA, "Pa", 36.0, Bound::FarBelowSupply, "bar");
        assert!(low.contains("less than a hundredth of the supply pressure") && low.contains(" bar would be possible"));
        let high = beyond(Signal::PressureA, "bar", 5e2, Bound::FarAboveSupply, "psi");
        assert!(high.contains("1.5 times the supply pressure or more") && high.contains(" psi would be possible"));
        let speed = unit_doubt(&UnitDoubt::Speed { share: 1e-3, fitting: Some((unit("ms"), 1.0)) });
        assert!(speed.starts_with("the rod goes 1/1000 as fast as the valve, opened as it was, lets it"), "{speed}");
        assert!(speed.ends_with(" With times in ms, it would be 1.0"), "{speed}");
    }
}
