//! What a period is asked for, and what it reports.

use model_core::number::PerUnit;

use crate::control::Predicted;
use crate::measured::{AnalogSignal, Measured};
use crate::monitor::Miss;
use crate::scaling::Row;
use crate::set_point::SetPoint;
use crate::supervision::{ActiveFaults, Command, Mode};

/// Whether the last period ended in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Timing {
    /// The last period ended before this one was due.
    Kept,
    /// It did not end in time.
    Overrun,
}

/// What is wanted in a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Wanted position and velocity of the rod.
    pub set_point: SetPoint,
    /// A command, only in the period in which it is given.
    pub command: Option<Command>,
    /// Whether the last period ended in time.
    pub timing: Timing,
}

/// What became of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Answer {
    /// It was handed to the state machine.
    Taken,
    /// Refused: a fault is present in this period.
    Faulty,
    /// Refused: the sensors, or a valve that went to neutral, have not settled yet.
    Unsettled,
    /// Refused: the encoder lost the rod's position, and nobody has given it since.
    Lost,
}

/// Whether the encoder's count is known to be the rod's position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Place {
    /// It is.
    Known,
    /// Somebody must give the rod's position before it follows: [`Period::home`](super::Period::home).
    Lost,
}

/// What is to be done with the watchdog after a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Watchdog {
    /// Feed it: the period was healthy.
    Feed,
    /// Do not feed it: a restart may cure what is wrong.
    Withhold,
}

/// The voltage of an input, beside what a working sensor gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InputVoltage {
    /// Of this signal.
    pub signal: AnalogSignal,
    /// Found, mV.
    pub found_mv: i32,
    /// The least that a working sensor gives, mV.
    pub from_mv: i32,
    /// The most, mV.
    pub to_mv: i32,
}

impl InputVoltage {
    /// From a count of an input whose 2¹⁶ counts are so many µV.
    pub(super) fn of(signal: AnalogSignal, row: &Row, count: i32, span_uv: u32) -> Self {
        let millivolts = |count: i32| {
            let microvolts = (i64::from(count) * i64::from(span_uv)) >> 16;
            i32::try_from(microvolts / 1000).unwrap_or(i32::MAX)
        };
        let [from, to] = row.working();
        Self { signal, found_mv: millivolts(count), from_mv: millivolts(from), to_mv: millivolts(to) }
    }
}

/// Result of a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// The mode after the period.
    pub mode: Mode,
    /// What the sensors measured.
    pub measured: Measured,
    /// The voltage at the valve's end of its wire, in units of 10 V, where it is read back.
    pub read_back: Option<PerUnit>,
    /// What the model predicted for the same time, before its step; `None` while it does not run.
    pub predicted: Option<Predicted>,
    /// The command that was put out, in units of 10 V.
    pub command: PerUnit,
    /// The set point that is followed; while the rod is held, where it comes to rest. From there it goes on.
    pub followed: SetPoint,
    /// What became of the given command, if one was given.
    pub answer: Option<Answer>,
    /// Faults that have not been acknowledged.
    pub active_faults: ActiveFaults,
    /// What is to be done with the watchdog.
    pub watchdog: Watchdog,
    /// The monitor's alarm, in the period that gives it.
    pub alarm: Option<Miss>,
    /// Whether an independent valve must cut off the oil: the rod may move although the valve is commanded to neutral
    /// ([`Fault::needs_shut_off`](crate::supervision::Fault::needs_shut_off)), until the fault is acknowledged. Also while the rod's place is lost, and
    /// from the controller's start until somebody homes, acknowledges or follows.
    pub shut_off: bool,
    /// Whether the valve may have current: from the command to follow until neutral is reached, or until a period that was not
    /// healthy. Without current the valve's springs close it, whatever the output holds; only a command switches the current on again.
    pub energised: bool,
}
