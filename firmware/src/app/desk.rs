//! A station with an operator: keys come in, periods run, and a recording goes out. A board adds the line and the clock.
//!
//! ```text
//! key ─► Operator ─► request ─► Station ─► Report           recorder ─► Outbox ─► byte
//! ```

use thiserror::Error;

use super::operator::{Errand, Operator, OperatorError, OperatorState};
use super::press::{TICK_NS, values};
use super::station::Station;
use crate::io::{AnalogIn, AnalogOut, PositionIn};
use crate::period::{Report, Timing};
use crate::recorder::Outbox;
use crate::set_point::Bounds;
use crate::supervision::Log;

/// Why a key had no effect.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DeskError {
    /// It is not a command, or not permitted at this time.
    #[error(transparent)]
    Operator(#[from] OperatorError),
    /// The rod's position is accepted only while the valve is neutral.
    #[error("the rod can be homed only while the valve is neutral")]
    NotNeutral,
}

/// A station, its operator, and the outgoing data.
#[derive(Debug)]
pub struct Desk<'a, A, P, O> {
    station: Station<'a, A, P, O>,
    operator: Operator,
    state: OperatorState,
    outbox: Outbox,
}

impl<'a, A: AnalogIn, P: PositionIn, O: AnalogOut> Desk<'a, A, P, O> {
    /// A desk at this station; the operator may send the rod anywhere within the bounds.
    #[must_use]
    pub fn new(station: Station<'a, A, P, O>, bounds: Bounds) -> Self {
        let operator = Operator::new(bounds, *station.bases());
        Self { station, operator, state: operator.at_rest(), outbox: Outbox::default() }
    }

    /// Takes a key, between two periods.
    ///
    /// # Errors
    /// The key has no effect; the error says why.
    pub fn key(&mut self, key: u8) -> Result<(), DeskError> {
        match self.operator.typed(&mut self.state, key)? {
            None => {}
            Some(Errand::Home { position }) => {
                return self.station.home(position).then_some(()).ok_or(DeskError::NotNeutral);
            }
            Some(Errand::Trigger) => self.station.trigger(),
            Some(Errand::Send) => self.outbox.send(),
            Some(Errand::Arm) => self.station.arm(),
            Some(Errand::IgnoreAlarms) => self.station.answer_alarms(None),
        }
        Ok(())
    }

    /// Stops in the next period.
    pub fn stop(&mut self) {
        self.operator.stop(&mut self.state);
    }

    /// One period, called once a tick.
    pub fn step(&mut self, timing: Timing, log: &mut impl Log) -> Report {
        let report = self.station.step(&self.operator.request(&mut self.state, timing), log);
        self.operator.seen(&mut self.state, &report);
        report
    }

    /// The next byte to be sent, if there is one; to be fetched between two periods.
    pub fn byte(&mut self) -> Option<u8> {
        self.outbox.next(self.station.recorder(), values::NAME, TICK_NS)
    }
}
