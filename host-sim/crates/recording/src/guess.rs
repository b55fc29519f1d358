//! A guess at which column holds which signal, for a file whose headers are not known: by names, units and shapes.
//!
//! It is something to be checked and pasted into a machine file, never something to compute with: a wrong mapping makes a wrong diagnosis.

use std::fmt::Write as _;

use crate::formats::surveyed::Surveyed;
use crate::signal::Signal;
use crate::unit::Dimension;

/// Words in the names of columns, in small letters, and what they mean in English and German.
const WORDS: [(Signal, &[&str]); 12] = [
    (Signal::Reference, &["soll", "ref", "setpoint", "set_", "target"]),
    (Signal::TankPressure, &["tank", "return", "rueckl", "rückl", "ruckl"]),
    (Signal::SupplyPressure, &["supply", "versorg", "pump", "system", "ps", "p_s", "p0", "pp"]),
    (
        Signal::PressureA,
        &["pa", "p_a", "druck a", "druck_a", "pressure a", "pressure_a", "p1", "bottom", "boden", "cap"],
    ),
    (
        Signal::PressureB,
        &["pb", "p_b", "druck b", "druck_b", "pressure b", "pressure_b", "p2", "rod", "stange", "ring"],
    ),
    (Signal::LoadForce, &["load", "last", "extern"]),
    (Signal::Force, &["force", "kraft"]),
    (Signal::Spool, &["spool", "schieber", "slider", "ventilhub"]),
    (Signal::Command, &["command", "cmd", "stell", "ventil", "valve", "ctrl", "u"]),
    (Signal::Velocity, &["vel", "geschw", "speed"]),
    (Signal::OilTemperature, &["oil", "öl", "oel", "temp"]),
    (Signal::Position, &["pos", "weg", "kolben", "hub", "stroke", "x"]),
];

/// What is guessed of one signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// The signal.
    pub signal: Signal,
    /// The header of the column with its unit, as a map has it.
    pub header: String,
    /// Why.
    pub why: &'static str,
}

/// The signals that the columns of a file may hold, time first.
#[must_use]
pub fn channels(columns: &[Surveyed]) -> Vec<Guess> {
    let mut guesses: Vec<Guess> = Vec::new();
    let mut free: Vec<&Surveyed> = columns.iter().filter(|column| !column.name.trim().is_empty()).collect();
    let is_clock =
        |column: &&Surveyed| column.rises() && (column.is_stamped || column.dimension() == Some(Dimension::Time));
    if let Some(at) = free.iter().position(is_clock) {
        let clock = free.remove(at);
        guesses.push(Guess { signal: Signal::Time, header: clock.header(), why: "a time that rises from row to row" });
    }
    // By name first, so that what is left goes by its unit alone.
    for (signal, words) in WORDS {
        let named = |column: &&&Surveyed| column.suits(signal) && words.iter().any(|word| column.is_called(word));
        let found: Vec<&Surveyed> = free.iter().filter(named).copied().collect();
        if let [one] = found.as_slice() {
            guesses.push(Guess { signal, header: one.header(), why: "its name and unit" });
            free.retain(|column| !std::ptr::eq(*column, *one));
        }
    }
    let pressures: Vec<&Surveyed> = free.iter().filter(|column| column.suits(Signal::PressureA)).copied().collect();
    let has_either = guesses.iter().any(|guess| matches!(guess.signal, Signal::PressureA | Signal::PressureB));
    if !has_either && pressures.len() >= 2 {
        let mut chambers = pressures.clone();
        if pressures.len() == 3 && guesses.iter().all(|guess| guess.signal != Signal::SupplyPressure) {
            let steady = (0..3).min_by(|a, b| pressures[*a].spread().total_cmp(&pressures[*b].spread())).unwrap_or(0);
            let supply = chambers.remove(steady);
            let why = "the steadiest of three pressures";
            guesses.push(Guess { signal: Signal::SupplyPressure, header: supply.header(), why });
        }
        if let [a, b] = chambers.as_slice() {
            let why = "one of two pressures, in the order of the file: it may be the other one";
            guesses.push(Guess { signal: Signal::PressureA, header: a.header(), why });
            guesses.push(Guess { signal: Signal::PressureB, header: b.header(), why });
            free.retain(|column| !column.suits(Signal::PressureA));
        }
    }
    for &signal in Signal::ALL {
        let is_other = matches!(signal, Signal::Time | Signal::Reference | Signal::LoadForce | Signal::ValveDirection)
            || signal.is_pressure();
        if is_other || guesses.iter().any(|guess| guess.signal == signal) {
            continue;
        }
        let fitting: Vec<&Surveyed> = free.iter().filter(|column| column.suits(signal)).copied().collect();
        if let [one] = fitting.as_slice() {
            guesses.push(Guess { signal, header: one.header(), why: "the only one left with a unit of it" });
            free.retain(|column| !std::ptr::eq(*column, *one));
        }
    }
    let order = |guess: &Guess| Signal::ALL.iter().position(|signal| *signal == guess.signal);
    guesses.sort_by_key(order);
    guesses
}

/// The guesses as a block of a machine file, with what was not guessed as comments.
#[must_use]
pub fn block(columns: &[Surveyed]) -> String {
    let guesses = channels(columns);
    let mut text = String::from("[channels] # guessed from names, units and shapes: check every line\n");
    for Guess { signal, header, why } in &guesses {
        // A basic string of TOML.
        let plain: String = header.chars().filter(|character| !character.is_control()).collect();
        let quoted = plain.replace('\\', "\\\\").replace('"', "\\\"");
        let _ = writeln!(text, "{signal} = \"{quoted}\" # {why}");
    }
    let left = columns.iter().filter(|column| guesses.iter().all(|guess| guess.header != column.header()));
    for column in left.filter(|column| !column.name.trim().is_empty()) {
        let header = column.header().replace(char::is_control, " ");
        let unit = if column.unit.is_some() { "" } else { ", which has no known unit: add it in brackets" };
        let _ = writeln!(text, "# not guessed: {header}{unit}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::survey::survey_from;
    use crate::{ChannelMap, read_from};

    fn guessed(text: &str) -> Vec<(Signal, String)> {
        let columns = survey_from("run.csv", text.as_bytes()).unwrap();
        channels(&columns).into_iter().map(|guess| (guess.signal, guess.header)).collect()
    }

    #[test]
    fn units_and_shapes_tell_the_signals() {
        let text = "Nr;Zeit [ms];Kolbenweg [mm];U_Ventil [V];Druck 1 [bar];Druck 2 [bar];Druck 3 [bar];Kraft/kN;Text\n\
            1;0;10,5;0;70,1;20;30;1,5;a\n2;10;10,6;1;70,0;25;35;1,5;b\n3;20;10,5;2;70,1;30;40;1,5;c\n";
        let found = guessed(text);
        let expected = [
            (Signal::Time, "Zeit [ms]"),
            (Signal::Command, "U_Ventil [V]"),
            (Signal::PressureA, "Druck 2 [bar]"),
            (Signal::PressureB, "Druck 3 [bar]"),
            (Signal::SupplyPressure, "Druck 1 [bar]"),
            (Signal::Force, "Kraft/kN"),
            (Signal::Position, "Kolbenweg [mm]"),
        ];
        let expected: Vec<(Signal, String)> = expected.map(|(signal, header)| (signal, header.to_owned())).into();
        assert_eq!(found, expected);
        // What was guessed can be used as it is.
        let maps: Vec<String> = found.iter().map(|(signal, header)| format!("{signal}={header}")).collect();
        let map = ChannelMap::from_arguments(maps.iter().map(String::as_str)).unwrap();
        assert_eq!(read_from("run.csv", text.as_bytes(), &map).unwrap().columns().len(), 7);
    }

    #[test]
    fn an_index_is_no_time_and_what_is_not_known_is_left_to_the_user() {
        let text = ",t,Weg soll [mm],Weg ist [mm],x\n0,0.5,1,1,7\n1,0.6,2,2,7\n2,0.7,3,3,7\n";
        let columns = survey_from("run.csv", text.as_bytes()).unwrap();
        assert_eq!(
            block(&columns),
            "[channels] # guessed from names, units and shapes: check every line\n\
             position = \"Weg ist [mm]\" # its name and unit\n\
             reference = \"Weg soll [mm]\" # its name and unit\n\
             # not guessed: t, which has no known unit: add it in brackets\n\
             # not guessed: x, which has no known unit: add it in brackets\n"
        );
        assert_eq!(
            guessed("Datum,p\n2024-05-06 07:08:09,1\n2024-05-06 07:08:10,2\n"),
            [(Signal::Time, "Datum".to_owned())]
        );
        assert_eq!(guessed("Zeit [s],p\n3,1\n2,2\n"), [], "it falls");
    }
}
