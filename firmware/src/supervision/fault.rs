//! Faults: what can go wrong with devices and signals, and which state each leads to.
//!
//! The table is in `docs/firmware.md`; [`Fault::response`] is what happens.
//!
//! The response begins in the period that finds the fault. A fault in something that the position loop needs leads to neutral at once; a
//! fault that only blinds the monitor leaves time for a ramp.

use model_core::number::PerUnit;

use crate::io::Cause;
use crate::measured::AnalogSignal;
use crate::monitor::MonitoredSignal;

/// A device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Device {
    /// Analogue inputs.
    Inputs,
    /// Counter of the position's encoder.
    Position,
    /// Analogue output.
    Output,
}

/// What went wrong, with its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// A sensor gives a count that no working sensor gives.
    OutOfRange {
        /// Which.
        signal: AnalogSignal,
        /// What it gives.
        count: i32,
    },
    /// A sensor's wire is open.
    OpenWire {
        /// Which.
        signal: AnalogSignal,
        /// What is read.
        count: i32,
    },
    /// A sensor has not moved by one count while the model moved.
    Stuck {
        /// Which.
        signal: AnalogSignal,
        /// Its count.
        count: i32,
    },
    /// The encoder has not moved by one count while the model moved.
    PositionStuck {
        /// Its position, as a share of the stroke.
        position: PerUnit,
    },
    /// The encoder moved by more than the rod can.
    EncoderJump {
        /// By this many counts.
        counts: i32,
    },
    /// A device did not answer correctly in any attempt.
    Silent {
        /// Which.
        device: Device,
        /// Why, at the last attempt.
        cause: Cause,
    },
    /// The last period took longer than permitted.
    Overrun,
    /// The set point's position or velocity is outside the permitted range.
    SetPointOutside {
        /// Wanted position, as a share of the stroke.
        position: PerUnit,
        /// Wanted velocity, relative to its base.
        velocity: PerUnit,
    },
    /// The set point jumps by more than is permitted in a period.
    SetPointJump {
        /// From here, as a share of the stroke.
        from: PerUnit,
        /// To here.
        to: PerUnit,
    },
    /// The set point accelerates more than is permitted.
    SetPointSteep {
        /// Its position, as a share of the stroke.
        position: PerUnit,
        /// Its velocity, relative to its base.
        velocity: PerUnit,
    },
    /// The rod is farther from its set point than is permitted, for longer than is permitted.
    FollowingError {
        /// Measured less wanted position, as a share of the stroke.
        off: PerUnit,
    },
    /// The rod moves faster or slower than its set point by more than is permitted, for longer than is permitted.
    VelocityError {
        /// Measured less wanted velocity, in strokes per period.
        off: PerUnit,
    },
    /// The spool is not where the valve's model has it under the same command, for longer than is permitted: it is jammed, its amplifier or
    /// its sensor fails, or the command's wires are exchanged.
    SpoolDeviates {
        /// Measured less the model's spool, as a share of full travel.
        off: PerUnit,
    },
    /// The rod left the range that it may be in.
    PositionOutside {
        /// Its position, as a share of the stroke.
        position: PerUnit,
    },
    /// The rod moves although the valve has been neutral for long enough to close.
    MovesAtNeutral {
        /// From here, as a share of the stroke.
        from: PerUnit,
        /// To here.
        to: PerUnit,
    },
    /// The model no longer predicts what the sensors show: the monitor's alarm, where it is not ignored.
    Alarm {
        /// The signal that it is for.
        signal: MonitoredSignal,
        /// What it is to lead to.
        response: Response,
    },
    /// The valve does not get the voltage that is put out.
    OutputAway {
        /// Put out, in units of 10 V.
        command: PerUnit,
        /// Read back, in units of 10 V.
        found: PerUnit,
    },
}

/// What a fault leads to. A greater value is more severe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Response {
    /// The rod is held at the last set point within the limits.
    Hold,
    /// The command moves to neutral at a stated slope.
    RampDown,
    /// The command is neutral at once.
    Neutral,
}

impl Fault {
    /// What it leads to.
    #[must_use]
    pub const fn response(&self) -> Response {
        match self {
            Fault::SetPointOutside { .. } | Fault::SetPointJump { .. } | Fault::SetPointSteep { .. } => Response::Hold,
            Fault::Alarm { response, .. } => *response,
            Fault::OutOfRange { .. }
            | Fault::OpenWire { .. }
            | Fault::Stuck { .. }
            | Fault::Silent { device: Device::Inputs, .. }
            | Fault::Overrun => Response::RampDown,
            Fault::PositionStuck { .. }
            | Fault::EncoderJump { .. }
            | Fault::Silent { device: Device::Position | Device::Output, .. }
            | Fault::FollowingError { .. }
            | Fault::VelocityError { .. }
            | Fault::SpoolDeviates { .. }
            | Fault::PositionOutside { .. }
            | Fault::MovesAtNeutral { .. }
            | Fault::OutputAway { .. } => Response::Neutral,
        }
    }

    /// Whether a restart of the controller may cure it: then the watchdog is not fed.
    #[must_use]
    pub const fn is_own(&self) -> bool {
        match self {
            Fault::Silent { .. } | Fault::Overrun => true,
            Fault::OutOfRange { .. }
            | Fault::OpenWire { .. }
            | Fault::Stuck { .. }
            | Fault::PositionStuck { .. }
            | Fault::EncoderJump { .. }
            | Fault::SetPointOutside { .. }
            | Fault::SetPointJump { .. }
            | Fault::SetPointSteep { .. }
            | Fault::FollowingError { .. }
            | Fault::VelocityError { .. }
            | Fault::SpoolDeviates { .. }
            | Fault::PositionOutside { .. }
            | Fault::MovesAtNeutral { .. }
            | Fault::Alarm { .. }
            | Fault::OutputAway { .. } => false,
        }
    }

    /// Whether the rod may move although the valve is commanded to neutral: then an independent valve must cut off the oil.
    ///
    /// The firmware cannot close a jammed spool, and cannot know whether one that deviates will close. It switches off the valve's
    /// current and asks.
    #[must_use]
    pub const fn needs_shut_off(&self) -> bool {
        matches!(
            self,
            Fault::FollowingError { .. }
                | Fault::VelocityError { .. }
                | Fault::SpoolDeviates { .. }
                | Fault::PositionOutside { .. }
                | Fault::PositionStuck { .. }
                | Fault::MovesAtNeutral { .. }
                | Fault::OutputAway { .. }
                | Fault::Silent { device: Device::Output, .. }
        )
    }

    /// Whether the encoder's count is no longer known to be the rod's position.
    #[must_use]
    pub const fn loses_place(&self) -> bool {
        matches!(
            self,
            Fault::EncoderJump { .. }
                | Fault::PositionStuck { .. }
                | Fault::Silent { device: Device::Position, cause: Cause::PowerLost | Cause::WrongAnswer { .. } }
        )
    }

    /// Number of its kind, 0 to 31, for a receiver that has no room for its values. Each sensor is a kind of its own.
    #[must_use]
    pub const fn kind(&self) -> u8 {
        const SIGNALS: u8 = 5;
        match *self {
            Fault::OutOfRange { signal, .. } => signal as u8,
            Fault::OpenWire { signal, .. } => SIGNALS + signal as u8,
            Fault::Stuck { signal, .. } => 2 * SIGNALS + signal as u8,
            Fault::PositionStuck { .. } => 15,
            Fault::EncoderJump { .. } => 16,
            Fault::Silent { device, .. } => 17 + device as u8,
            Fault::Overrun => 20,
            Fault::SetPointOutside { .. } => 21,
            Fault::SetPointJump { .. } => 22,
            Fault::OutputAway { .. } => 23,
            Fault::SetPointSteep { .. } => 24,
            Fault::FollowingError { .. } => 25,
            Fault::VelocityError { .. } => 26,
            Fault::SpoolDeviates { .. } => 27,
            Fault::PositionOutside { .. } => 28,
            Fault::MovesAtNeutral { .. } => 29,
            Fault::Alarm { .. } => 30,
        }
    }
}

/// Kinds of fault that have not been acknowledged: each is logged when it is entered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ActiveFaults {
    /// A bit for each kind.
    kinds: u32,
    /// Whether one of them needs the oil to be cut off.
    shut_off: bool,
}

impl ActiveFaults {
    /// None.
    pub const NONE: Self = Self { kinds: 0, shut_off: false };

    /// Enters a fault, and returns whether it is the first of its kind.
    #[must_use]
    pub const fn enter(&mut self, fault: &Fault) -> bool {
        let bit = 1 << fault.kind();
        let first = self.kinds & bit == 0;
        self.kinds |= bit;
        self.shut_off |= fault.needs_shut_off();
        first
    }

    /// Whether a fault of this kind is active.
    #[must_use]
    pub const fn has(self, fault: &Fault) -> bool {
        self.kinds & 1 << fault.kind() != 0
    }

    /// Whether a kind of fault is active that is not in `others`.
    #[must_use]
    pub const fn has_more_than(self, others: Self) -> bool {
        self.kinds & !others.kinds != 0
    }

    /// Whether no fault is active.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.kinds == 0
    }

    /// Whether the oil must be cut off by an independent valve: [`Fault::needs_shut_off`] of any that is active.
    #[must_use]
    pub const fn need_shut_off(self) -> bool {
        self.shut_off
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::vec::Vec;

    use model_core::number::Number;

    use super::*;

    /// One of each kind.
    fn all() -> Vec<Fault> {
        let zero = PerUnit::ZERO;
        let mut all = Vec::from([
            Fault::PositionStuck { position: zero },
            Fault::EncoderJump { counts: 1 },
            Fault::Overrun,
            Fault::SetPointOutside { position: zero, velocity: zero },
            Fault::SetPointJump { from: zero, to: zero },
            Fault::OutputAway { command: zero, found: zero },
            Fault::SetPointSteep { position: zero, velocity: zero },
            Fault::FollowingError { off: zero },
            Fault::VelocityError { off: zero },
            Fault::SpoolDeviates { off: zero },
            Fault::PositionOutside { position: zero },
            Fault::MovesAtNeutral { from: zero, to: zero },
            Fault::Alarm { signal: MonitoredSignal::Spool, response: Response::RampDown },
        ]);
        for signal in AnalogSignal::ALL {
            all.push(Fault::OutOfRange { signal, count: 1 });
            all.push(Fault::OpenWire { signal, count: 1 });
            all.push(Fault::Stuck { signal, count: 1 });
        }
        for device in [Device::Inputs, Device::Position, Device::Output] {
            all.push(Fault::Silent { device, cause: Cause::Bus });
        }
        all
    }

    #[test]
    fn kinds_do_not_coincide_and_fit_a_word() {
        let kinds: BTreeSet<u8> = all().iter().map(Fault::kind).collect();
        assert_eq!(kinds.len(), all().len());
        assert!(kinds.iter().all(|&kind| u32::from(kind) < u32::BITS));
    }

    #[test]
    fn a_fault_enters_once() {
        for fault in all() {
            let mut active_faults = ActiveFaults::NONE;
            assert!(active_faults.is_empty() && !active_faults.has(&fault));
            assert!(active_faults.enter(&fault));
            assert!(!active_faults.enter(&fault));
            assert!(active_faults.has(&fault) && !active_faults.is_empty());
            assert!(all().iter().filter(|other| active_faults.has(other)).count() == 1);
        }
    }
}
