//! Whether a command is in the unit that the machine file expects: `valve.gain_per_v` is travel per unit of the
//! recording's command, volts or milliamperes, and neither file states which of the two the other means.

use model_core::machine::{Machine, Parameter, Source};
use recording::{Dimension, Recording, Signal};
use simulation::signal::noise::extent;

use super::advice::{CommandRange, UnitDoubt};

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
/// An opening, or a travel of the spool, that says something about the gain.
const OPENED: f64 = 0.05;
/// The spool goes along with the command if their correlation is above this.
const ALONG: f64 = 0.9;
/// Fewest rows for a comparison of the spool with the command.
const LEAST_ROWS: usize = 20;

/// What is doubtful about the command's unit.
#[must_use]
pub(crate) fn command_doubt(recording: &Recording, machine: &Machine<f64>) -> Option<UnitDoubt> {
    let column = recording.column(Signal::Command).filter(|_| machine.source == Source::Valve)?;
    let get = |parameter| machine.get(parameter);
    let opened = |command: f64| get(Parameter::ValveGain) * command + get(Parameter::ValveOffset);
    let (low, high) = extent(&column.values);
    let is_current = column.unit.dimension() == Dimension::Current;
    let command =
        || CommandRange { header: column.header.clone(), unit: column.unit, low, high, opening: opened(high) };
    if is_current && low < high && [low, high].iter().all(|end| LIVE_ZERO_MA.contains(end)) {
        let closed = opened(MIDDLE_MA).abs() < get(Parameter::DeadZone) + 0.1;
        return (!closed).then(|| UnitDoubt::Current { command: command(), closed_at_ma: Some(MIDDLE_MA) });
    }
    if is_current && opened(low).abs().max(opened(high).abs()) > WIDE_OPEN {
        return Some(UnitDoubt::Current { command: command(), closed_at_ma: None });
    }
    let share = followed(recording, machine)?;
    (!(SHARE..=1.0 / SHARE).contains(&share)).then_some(UnitDoubt::SpoolTravel { unit: column.unit, share })
}

/// Travel of the measured spool over that from the machine file, where the command was held until the spool arrived.
///
/// Where the file's opening is too small to be compared by itself, as with a tenth of the command, the spool still goes far: then the slope over
/// both sides is taken, which an offset of the spool does not change.
fn followed(recording: &Recording, machine: &Machine<f64>) -> Option<f64> {
    let held = held(recording, machine)?;
    let offset = machine.get(Parameter::ValveOffset);
    let opened: Vec<(f64, f64)> = held.iter().copied().filter(|(opened, _)| opened.abs() > OPENED).collect();
    if opened.len() >= LEAST_ROWS {
        let across: f64 = opened.iter().map(|(opened, spool)| (spool - offset) * opened).sum();
        return Some(across / opened.iter().map(|(opened, _)| opened * opened).sum::<f64>());
    }
    let far = held.iter().filter(|(_, spool)| (spool - offset).abs() > OPENED).count();
    let mean = |of: fn(&(f64, f64)) -> f64| held.iter().map(of).sum::<f64>() / held.len() as f64;
    let (mean_opened, mean_spool) = (mean(|row| row.0), mean(|row| row.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        held.iter().map(|(opened, spool)| of(opened - mean_opened, spool - mean_spool)).sum()
    };
    let (across, of_opened, of_spool) =
        (sum(&|opened, spool| opened * spool), sum(&|opened, _| opened * opened), sum(&|_, spool| spool * spool));
    let goes_along = across > ALONG * (of_opened * of_spool).sqrt();
    (far >= LEAST_ROWS && goes_along).then(|| across / of_opened)
}

/// Opening by the machine file without its offset, and measured spool, in every row in which the command was held until the spool arrived.
fn held(recording: &Recording, machine: &Machine<f64>) -> Option<Vec<(f64, f64)>> {
    let (time_s, command) = (recording.time_s(), recording.signal(Signal::Command)?);
    let spool = recording.signal(Signal::Spool)?;
    let get = |parameter| machine.get(parameter);
    let (low, high) = extent(command);
    let lags = machine.spool_lag_s();
    let settled_s = get(Parameter::TransportDelay) + 4.0 * lags + 2.0 / get(Parameter::RateLimit);
    let (mut since, mut held) = (0, Vec::new());
    for row in 0..command.len() {
        if (command[row] - command[since]).abs() > HELD * (high - low) {
            since = row;
        }
        if time_s[row] - time_s[since] > settled_s {
            held.push((get(Parameter::ValveGain) * command[row], spool[row]));
        }
    }
    Some(held)
}

#[cfg(test)]
mod tests {
    use recording::{ChannelMap, Unit, read_from};
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

    fn doubt(unit: &str, ends: (f64, f64), gain: f64, offset: f64) -> Option<UnitDoubt> {
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
    fn milliamperes_on_a_file_in_volts_are_doubted() {
        let range = |low, high, opening| CommandRange {
            header: "command [mA]".to_owned(),
            unit: Unit::parse("mA").unwrap(),
            low,
            high,
            opening,
        };
        assert_eq!(
            doubt("mA", (4.0, 20.0), 0.1, 0.0),
            Some(UnitDoubt::Current { command: range(4.0, 20.0, 2.0), closed_at_ma: Some(12.0) })
        );
        assert_eq!(
            doubt("mA", (-20.0, 20.0), 0.1, 0.0),
            Some(UnitDoubt::Current { command: range(-20.0, 20.0, 2.0), closed_at_ma: None })
        );
        // Half open only, but the spool is measured.
        let travel = |doubt| match doubt {
            Some(UnitDoubt::SpoolTravel { unit, share }) => (unit.symbol(), (100.0 * share).round() / 100.0),
            other => panic!("{other:?}"),
        };
        assert_eq!(travel(doubt("mA", (-10.0, 10.0), 0.1, 0.0)), ("mA", 0.5));
        assert_eq!(travel(doubt("V", (-5.0, 5.0), 0.05, 0.0)), ("V", 2.0));
        // A tenth of the command opens the valve by less than a twentieth, and a hundredth by next to nothing.
        assert_eq!(travel(doubt("V", (-0.5, 0.5), 0.1, 0.03)), ("V", 10.0));
        assert_eq!(travel(doubt("V", (-0.05, 0.05), 0.1, 0.0)), ("V", 100.0));
    }
}
