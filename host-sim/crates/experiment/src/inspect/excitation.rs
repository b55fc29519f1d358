//! What moved, how far, and whether it also rested: a link that was not excited cannot be judged.

use model_core::machine::{Machine, Parameter, Source};
use recording::display_unit::{unit_for_people, unit_of};
use recording::{Recording, Signal, Unit};
use simulation::is_sparse;
use simulation::sensor_fault::{Failures, bridged};
use simulation::signal::noise::{extent, noise, resolution};
use simulation::signal::slope::slopes;
use simulation::signal::window::rows_in;

use super::advice::Advice;
use super::channels::InspectedColumn;

/// Velocity is the slope over this time, s.
const OVER_S: f64 = 0.1;
/// The rod moves where it travels more than this many times its sensor's noise in that time.
const MOVES: f64 = 6.0;
/// A rod that is held for this long shows leakage and drift, s.
const HOLD_S: f64 = 0.3;
/// A smaller share of the stroke shows little of what depends on the position.
const LITTLE_TRAVEL: f64 = 0.2;

/// How the valve was opened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opened {
    /// The measured spool, or the command where no spool is recorded.
    pub by: Signal,
    /// The unit in which people read `low` and `high`: that of a spool position, or the command's own where no machine file
    /// gives the spool position for a command.
    pub unit: Unit,
    /// Lowest spool position, 1; for a command without machine file, V or mA.
    pub low: f64,
    /// Highest, in the same unit.
    pub high: f64,
    /// Share of the rows beyond the dead zone on the retracting and on the extending side, where a machine file gives its width.
    pub beyond: Option<(f64, f64)>,
}

/// How the rod moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travelled {
    /// Lowest position, m.
    pub low_m: f64,
    /// Highest position, m.
    pub high_m: f64,
    /// Covered share of the machine file's stroke.
    pub of_stroke: Option<f64>,
    /// Largest velocity retracting, m/s, not positive.
    pub retracting_m_per_s: f64,
    /// Largest velocity extending, m/s, not negative.
    pub extending_m_per_s: f64,
    /// Share of the rows in which it moves.
    pub moving: f64,
    /// The longest time without motion, s.
    pub held_s: f64,
}

/// What was excited.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excited {
    /// The valve, where spool or command is recorded.
    pub opened: Option<Opened>,
    /// The rod, where its position is recorded.
    pub travelled: Option<Travelled>,
}

impl Excited {
    pub(crate) fn of(recording: &Recording, machine: Option<&Machine<f64>>) -> Self {
        Self { opened: opened(recording, machine), travelled: travelled(recording, machine) }
    }

    pub(crate) fn advice(&self, source: Source) -> Vec<Advice> {
        let mut advice = Vec::new();
        if let Some(Opened { beyond: Some(beyond), by, .. }) = self.opened {
            match beyond {
                (0.0, 0.0) => advice.push(Advice::NeverOpens { by }),
                (0.0, _) => advice.push(Advice::OpensOneWay { by, extending: true }),
                (_, 0.0) => advice.push(Advice::OpensOneWay { by, extending: false }),
                _ => {}
            }
        }
        let Some(travelled) = self.travelled else { return advice };
        if travelled.moving == 0.0 {
            advice.push(Advice::DoesNotMove);
            return advice;
        }
        if travelled.extending_m_per_s == 0.0 || travelled.retracting_m_per_s == 0.0 {
            advice.push(Advice::MovesOneWay);
        }
        if travelled.of_stroke.is_some_and(|share| share < LITTLE_TRAVEL) {
            advice.push(Advice::LittleTravel);
        }
        if travelled.held_s < HOLD_S {
            advice.push(Advice::NeverHolds { source, least_s: HOLD_S });
        }
        advice
    }
}

fn opened(recording: &Recording, machine: Option<&Machine<f64>>) -> Option<Opened> {
    let machine = machine.filter(|machine| machine.source == Source::Valve);
    let get = |parameter| machine.map(|machine| machine.get(parameter));
    let position = unit_for_people(Signal::Spool);
    let (by, unit, values) = if let Some(spool) = recording.signal(Signal::Spool) {
        (Signal::Spool, position, spool.to_vec())
    } else {
        let command = recording.column(Signal::Command)?;
        match (get(Parameter::ValveGain), get(Parameter::ValveOffset)) {
            (Some(gain), Some(offset)) => {
                (Signal::Command, position, command.values.iter().map(|value| gain * value + offset).collect())
            }
            _ => (Signal::Command, unit_of(command), command.values.clone()),
        }
    };
    let (low, high) = extent(&values);
    let share = |beyond: &dyn Fn(f64) -> bool| {
        values.iter().filter(|value| beyond(**value)).count() as f64 / values.len() as f64
    };
    let beyond = get(Parameter::DeadZone).map(|zone| (share(&|value| value < -zone), share(&|value| value > zone)));
    Some(Opened { by, unit, low, high, beyond })
}

fn travelled(recording: &Recording, machine: Option<&Machine<f64>>) -> Option<Travelled> {
    let (time_s, read) = (recording.time_s(), recording.signal(Signal::Position)?);
    let position = bridged(read, &Failures::of(Signal::Position, time_s, read).rows());
    let (low_m, high_m) = extent(&position);
    let noise = noise(&position, resolution(&position));
    let reach = (rows_in(time_s, OVER_S) / 2).max(1);
    let velocity = slopes(time_s, &position, reach);
    // Where rows are further apart than that, the slope is over the rows on either side.
    let row_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1).max(1) as f64;
    let slow = MOVES * noise / if is_sparse(time_s) { OVER_S.max(2.0 * reach as f64 * row_s) } else { OVER_S };
    let moves: Vec<bool> = velocity.iter().map(|speed| speed.abs() > slow && high_m > low_m).collect();
    let moving = moves.iter().filter(|moves| **moves).count() as f64 / moves.len() as f64;
    let fastest = velocity.iter().zip(&moves).filter(|(_, moves)| **moves).map(|(speed, _)| *speed);
    let (slowest, fastest) = fastest.fold((0.0_f64, 0.0_f64), |(low, high), speed| (low.min(speed), high.max(speed)));
    Some(Travelled {
        low_m,
        high_m,
        of_stroke: machine.map(|machine| (high_m - low_m) / machine.get(Parameter::Stroke)),
        retracting_m_per_s: slowest,
        extending_m_per_s: fastest,
        moving,
        held_s: held(time_s, &moves),
    })
}

/// The longest time without motion, s.
fn held(time_s: &[f64], moves: &[bool]) -> f64 {
    let (mut longest, mut since) = (0.0_f64, None);
    for (time, moves) in time_s.iter().zip(moves) {
        match (moves, since) {
            (true, _) => since = None,
            (false, None) => since = Some(*time),
            (false, Some(began)) => longest = longest.max(time - began),
        }
    }
    longest
}

/// Channels that show nothing.
pub(crate) fn constant(channels: &[InspectedColumn]) -> impl Iterator<Item = Advice> + '_ {
    let constant = |channel: &&InspectedColumn| {
        channel.is_constant() && channel.noise.is_none() && channel.signal != Signal::ValveDirection
    };
    channels.iter().filter(constant).map(|channel| Advice::Constant {
        signal: channel.signal,
        unit: channel.unit,
        value: channel.low,
    })
}

#[cfg(test)]
mod tests {
    use recording::Column;

    use super::*;

    fn recording(command: impl Fn(f64) -> f64, position: impl Fn(f64) -> f64) -> Recording {
        let time_s: Vec<f64> = (0..3000).map(|row| f64::from(row) * 1e-3).collect();
        let of = |value: &dyn Fn(f64) -> f64| time_s.iter().map(|time| value(*time)).collect::<Vec<f64>>();
        // Written with a step of a hundredth of a millimetre.
        let stepped = |time: f64| (position(time) / 1e-5).round() * 1e-5;
        let columns = vec![Column::si(Signal::Command, of(&command)), Column::si(Signal::Position, of(&stepped))];
        let time = Column::si(Signal::Time, time_s.clone());
        Recording::new("made", [vec![time], columns].concat()).unwrap()
    }

    fn advice(recording: &Recording) -> Vec<Advice> {
        let machine = test_press::press(&[(Parameter::DeadZone, 0.1), (Parameter::ValveOffset, 0.0)]);
        Excited::of(recording, Some(&machine)).advice(machine.source)
    }

    #[test]
    fn a_drive_that_moves_both_ways_and_holds_needs_no_advice() {
        let there_and_back = |time: f64| match time {
            time if time < 1.0 => 0.1 + 0.1 * time,
            time if time < 2.0 => 0.2,
            time => 0.2 - 0.1 * (time - 2.0),
        };
        let made = recording(|time| if time < 1.0 { 5.0 } else { -5.0 }, there_and_back);
        assert_eq!(advice(&made), []);
        let travelled = Excited::of(&made, None).travelled.unwrap();
        assert!((travelled.extending_m_per_s - 0.1).abs() < 2e-3 && (travelled.retracting_m_per_s + 0.1).abs() < 2e-3);
        assert!((travelled.held_s - 1.0).abs() < 0.12, "{travelled:?}");
    }

    #[test]
    fn a_level_that_moves_slowly_between_rows_of_seconds_moves() {
        let time_s: Vec<f64> = (0..60).map(|row| 4.0 * f64::from(row)).collect();
        let position = |time: f64| 0.07 + 0.03 * (time / 40.0).sin();
        let position: Vec<f64> = time_s.iter().map(|time| (position(*time) / 1e-4).round() * 1e-4).collect();
        let columns = vec![Column::si(Signal::Time, time_s), Column::si(Signal::Position, position)];
        let travelled = Excited::of(&Recording::new("made", columns).unwrap(), None).travelled.unwrap();
        assert!(travelled.moving > 0.5, "{travelled:?}");
        assert!((travelled.extending_m_per_s - 0.75e-3).abs() < 0.1e-3, "{travelled:?}");
    }

    #[test]
    fn a_command_within_the_dead_zone_is_found() {
        let found = advice(&recording(|time| (9.0 * time).sin(), |_| 0.15));
        assert_eq!(found, [Advice::NeverOpens { by: Signal::Command }, Advice::DoesNotMove]);
    }

    #[test]
    fn one_way_without_a_pause_is_found() {
        let found = advice(&recording(|_| 5.0, |time| 0.1 + 0.01 * time));
        let opens = Advice::OpensOneWay { by: Signal::Command, extending: true };
        assert_eq!(
            found,
            [
                opens,
                Advice::MovesOneWay,
                Advice::LittleTravel,
                Advice::NeverHolds { source: Source::Valve, least_s: 0.3 }
            ]
        );
    }
}
