//! What a step measured, what it expected, and why it refuses: numbers in the units of the hall, words at the edge.

use core::fmt::{self, Display, Formatter};

use crate::measured::AnalogSignal;
use crate::period::Answer;

/// The way that a command moves the rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Way {
    /// Out.
    Extends,
    /// In.
    Retracts,
}

impl Way {
    /// 1 out, -1 in.
    pub(super) const fn sign(self) -> i32 {
        match self {
            Way::Extends => 1,
            Way::Retracts => -1,
        }
    }

    pub(super) const fn other(self) -> Self {
        match self {
            Way::Extends => Way::Retracts,
            Way::Retracts => Way::Extends,
        }
    }
}

impl Display for Way {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Way::Extends => "extends",
            Way::Retracts => "retracts",
        })
    }
}

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum What {
    /// Largest pressure in A, kPa.
    PressureA,
    /// Largest pressure in B, kPa.
    PressureB,
    /// An analogue input, mV.
    Input(AnalogSignal),
    /// The command as the valve's terminal has it, mV.
    ReadBack,
    /// Where the rod is, µm.
    Position,
    /// How far the rod moved while nobody commanded it, µm.
    Creep,
    /// How far the spool went along a command of this way, thousandths of its travel.
    Spool(Way),
    /// How far the rod went by its encoder along a command of this way, µm.
    Rod(Way),
    /// Pressure in A less that in B while the rod extends, less the same while it retracts, kPa.
    PressureSigns,
    /// Largest following error of a small step, µm.
    FollowingError,
}

impl What {
    const fn unit(self) -> &'static str {
        match self {
            What::PressureA | What::PressureB | What::PressureSigns => "kPa",
            What::Input(_) | What::ReadBack => "mV",
            What::Position | What::Creep | What::Rod(_) | What::FollowingError => "µm",
            What::Spool(_) => "thousandths of its travel",
        }
    }

    /// What the usual cause is of a value that is not as expected.
    const fn cause(self) -> &'static str {
        match self {
            What::PressureA | What::PressureB => "the oil is on, or its pressure is not low",
            What::Input(_) => "a wire or a sensor",
            What::ReadBack => "the output does not follow",
            What::Position => "the rod is not where it may be sent",
            What::Creep => "the rod does not rest",
            What::Spool(_) => {
                "the command's wires are exchanged, the spool's sensor is turned, or the spool does not follow"
            }
            What::Rod(_) => "the encoder is turned, hoses are exchanged, or there is no oil",
            What::PressureSigns => "the pressure sensors are exchanged",
            What::FollowingError => "the tuning, or the values of the machine",
        }
    }
}

impl Display for What {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            What::PressureA => f.write_str("pressure in A"),
            What::PressureB => f.write_str("pressure in B"),
            What::Input(signal) => write!(f, "input of {signal:?}"),
            What::ReadBack => f.write_str("voltage read back at the valve"),
            What::Position => f.write_str("position"),
            What::Creep => f.write_str("way of the rod at rest"),
            What::Spool(way) => write!(f, "way of the spool along a command that {way}"),
            What::Rod(way) => write!(f, "way of the rod along a command that {way}"),
            What::PressureSigns => f.write_str("pressure in A less B, extending less retracting"),
            What::FollowingError => f.write_str("largest following error"),
        }
    }
}

/// What is expected of a value, in its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Expected {
    /// This or less.
    AtMost(i32),
    /// This or more.
    AtLeast(i32),
    /// From the first to the second.
    Between(i32, i32),
}

impl Display for Expected {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Expected::AtMost(most) => write!(f, "at most {most}"),
            Expected::AtLeast(least) => write!(f, "at least {least}"),
            Expected::Between(from, to) => write!(f, "{from} to {to}"),
        }
    }
}

/// A measured value beside what is expected of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("{what}: found {found}, expected {expected} {}", what.unit())]
pub struct Reading {
    /// What.
    pub what: What,
    /// The value, in its unit.
    pub found: i32,
    /// What it must be.
    pub expected: Expected,
}

impl Reading {
    /// Whether the value is as expected.
    #[must_use]
    pub const fn holds(&self) -> bool {
        match self.expected {
            Expected::AtMost(most) => self.found <= most,
            Expected::AtLeast(least) => self.found >= least,
            Expected::Between(from, to) => from <= self.found && self.found <= to,
        }
    }
}

/// Why a step is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// A value is not as expected.
    #[error("{0}: {cause}", cause = .0.what.cause())]
    Value(Reading),
    /// A fault; the log has said which.
    #[error("a fault was found, or is not acknowledged yet")]
    Fault,
    /// The operator stopped.
    #[error("stopped")]
    Stopped,
    /// Following was refused.
    #[error("the rod does not follow: {0:?}")]
    NotFollowing(Answer),
    /// Nothing reads the command back.
    #[error("the command is not read back: wire it to an input")]
    NotReadBack,
    /// An input does not answer.
    #[error("the inputs do not answer")]
    Silent,
    /// Nobody has said where the rod is.
    #[error("the rod has not been homed")]
    Lost,
    /// The deviation of the machine is not limited.
    #[error("a limit of deviation is missing")]
    Unwatched,
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn a_refusal_says_what_was_found_what_was_expected_and_the_usual_cause() {
        let reading = Reading { what: What::Rod(Way::Extends), found: -300, expected: Expected::AtLeast(1000) };
        assert!(!reading.holds());
        let said = "way of the rod along a command that extends: found -300, expected at least 1000 µm: \
                    the encoder is turned, hoses are exchanged, or there is no oil";
        assert_eq!(Refusal::Value(reading).to_string(), said);
        let within = Reading {
            what: What::Input(AnalogSignal::Spool),
            found: -10_051,
            expected: Expected::Between(-10_050, 10_050),
        };
        assert!(!within.holds() && Reading { found: 10_050, ..within }.holds());
        assert_eq!(within.to_string(), "input of Spool: found -10051, expected -10050 to 10050 mV");
    }
}
