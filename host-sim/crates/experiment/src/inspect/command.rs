//! Whether a command is in the unit that the machine file expects: `valve.gain_per_v` is travel per unit of the
//! recording's command, volts or milliamperes, and neither file states which of the two the other means.

use model_core::machine::{Machine, Parameter, Source};
use recording::display_unit::significant;
use recording::{Dimension, Recording, Signal};
use simulation::signal::noise::extent;

/// Range of currents with a live zero, mA, including the tolerance of a current loop.
const LIVE_ZERO_MA: std::ops::RangeInclusive<f64> = 3.5..=21.0;
/// The current at which the valve is closed, mA.
const MIDDLE_MA: f64 = 12.0;
/// If the file means volts, a current opens the valve by more than this.
const WIDE_OPEN: f64 = 1.1;
/// The measured spool travels by less than this share of what the file says, or by more than its inverse: the usual
/// mistakes are a factor of two.
const SHARE: f64 = 0.65;
/// A command is held while it stays within this share of its range.
const HELD: f64 = 5e-3;
/// Fewest rows for a comparison of the spool with the command.
const LEAST_ROWS: usize = 20;

/// What is doubtful about the command's unit; a sentence without full stop.
#[must_use]
pub(crate) fn command_doubt(recording: &Recording, machine: &Machine<f64>) -> Option<String> {
    let column = recording.column(Signal::Command).filter(|_| machine.source == Source::Valve)?;
    let get = |parameter| machine.get(parameter);
    let opened = |command: f64| get(Parameter::ValveGain) * command + get(Parameter::ValveOffset);
    let (low, high) = extent(&column.values);
    let unit = column.unit.symbol();
    let is_current = column.unit.dimension() == Dimension::Current;
    let shown = |command: f64| format!("{} {unit}", significant(command, 3));
    let percent = |opening: f64| format!("{} %", significant(100.0 * opening, 3));
    let by_file = format!("by the machine file's gain_per_v it opens the valve to {}", percent(opened(high)));
    let in_channels = |zero: f64, full: f64| {
        format!(
            "if the file counts in volts, its [channels] can say command = {{ column = \"{}\", zero = {zero}, full = {full} }}",
            column.header
        )
    };
    if is_current && low < high && [low, high].iter().all(|end| LIVE_ZERO_MA.contains(end)) {
        let closed = opened(MIDDLE_MA).abs() < get(Parameter::DeadZone) + 0.1;
        return (!closed).then(|| {
            format!(
                "command goes from {} to {}, as a current of 4 to 20 mA that closes the valve at {MIDDLE_MA} mA does, but {by_file} \
                 and never closes it: {}",
                shown(low),
                shown(high),
                in_channels(MIDDLE_MA, 0.8)
            )
        });
    }
    if is_current && opened(low).abs().max(opened(high).abs()) > WIDE_OPEN {
        return Some(format!(
            "command goes from {} to {}, and {by_file}: {}",
            shown(low),
            shown(high),
            in_channels(0.0, 2.0)
        ));
    }
    let share = followed(recording, machine)?;
    (!(SHARE..=1.0 / SHARE).contains(&share)).then(|| {
        format!(
            "the measured spool goes {} times as far as gain_per_v says of a held command: does the machine file count in {unit}, as the \
             recording does?",
            significant(share, 2)
        )
    })
}

/// Travel of the measured spool over that from the machine file, where the command was held until the spool arrived.
fn followed(recording: &Recording, machine: &Machine<f64>) -> Option<f64> {
    let (time_s, command) = (recording.time_s(), recording.signal(Signal::Command)?);
    let spool = recording.signal(Signal::Spool)?;
    let get = |parameter| machine.get(parameter);
    let (low, high) = extent(command);
    let lags = get(Parameter::TimeConstant1) + get(Parameter::TimeConstant2);
    let settled_s = get(Parameter::TransportDelay) + 4.0 * lags + 2.0 / get(Parameter::RateLimit);
    let (mut since, mut rows, mut across, mut square) = (0, 0, 0.0, 0.0);
    for row in 0..command.len() {
        if (command[row] - command[since]).abs() > HELD * (high - low) {
            since = row;
        }
        let opened = get(Parameter::ValveGain) * command[row];
        if time_s[row] - time_s[since] > settled_s && opened.abs() > 0.05 {
            rows += 1;
            across += (spool[row] - get(Parameter::ValveOffset)) * opened;
            square += opened * opened;
        }
    }
    (rows >= LEAST_ROWS).then(|| across / square)
}

#[cfg(test)]
mod tests {
    use recording::{ChannelMap, read_from};
    use test_press::press;

    use super::*;

    /// Steps of half a second between two commands, and a spool that goes 50 % to each side.
    fn recording(unit: &str, (low, high): (f64, f64)) -> Recording {
        let rows = (0..400).map(|row| {
            let extends = row / 50 % 2 == 0;
            let (command, spool) = if extends { (high, 0.5) } else { (low, -0.5) };
            format!("{},{command},{spool}\n", f64::from(row) * 0.01)
        });
        let text = format!("time [s],command [{unit}],spool [1]\n{}", rows.collect::<String>());
        read_from("r.csv", text.as_bytes(), &ChannelMap::default()).unwrap()
    }

    fn doubt(unit: &str, ends: (f64, f64), gain: f64, offset: f64) -> Option<String> {
        let machine = press(&[(Parameter::ValveGain, gain), (Parameter::ValveOffset, offset)]);
        command_doubt(&recording(unit, ends), &machine)
    }

    #[test]
    fn a_command_that_the_machine_file_means_is_not_doubted() {
        assert_eq!(doubt("V", (-5.0, 5.0), 0.1, 0.0), None);
        assert_eq!(doubt("mV", (-5000.0, 5000.0), 0.1, 0.0), None);
        assert_eq!(doubt("mA", (-10.0, 10.0), 0.05, 0.0), None);
        assert_eq!(doubt("mA", (8.0, 16.0), 0.125, -1.5), None);
    }

    #[test]
    fn milliamperes_on_a_file_in_volts_are_doubted_with_what_to_do() {
        let live = doubt("mA", (4.0, 20.0), 0.1, 0.0).unwrap();
        for part in
            ["from 4.00 mA to 20.0 mA", "to 200 %", "command = { column = \"command [mA]\", zero = 12, full = 0.8 }"]
        {
            assert!(live.contains(part), "{part}: {live}");
        }
        assert!(doubt("mA", (-20.0, 20.0), 0.1, 0.0).unwrap().contains("zero = 0, full = 2 }"));
        // Half open only, but the spool is measured.
        let spool = doubt("mA", (-10.0, 10.0), 0.1, 0.0).unwrap();
        assert!(spool.contains("0.50 times as far") && spool.contains("count in mA"), "{spool}");
        assert!(doubt("V", (-5.0, 5.0), 0.05, 0.0).unwrap().contains("2.0 times as far"));
    }
}
