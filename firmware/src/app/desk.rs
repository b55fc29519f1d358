//! A station with an operator: keys come in, periods run, and a recording goes out. A board adds the line and the clock.
//!
//! ```text
//! key ─► Operator ─► request ─► Station ─► Report           recorder ─► Outbox ─► byte
//! ```

use thiserror::Error;

use super::operator::{Errand, Operator, OperatorError, OperatorState};
use super::press::{self, TICK_NS, values};
use super::station::Station;
use crate::commissioning::{Commissioning, CommissioningError, CommissioningState, Step};
use crate::excitation::plan::Permitted;
use crate::io::{AnalogIn, AnalogOut, PositionIn};
use crate::period::{Report, Request, Timing};
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
    /// The commissioning does not permit it now, or cannot begin that step.
    #[error(transparent)]
    Commissioning(#[from] CommissioningError),
}

/// A station, its operator, and the outgoing data.
#[derive(Debug)]
pub struct Desk<'a, A, P, O> {
    station: Station<'a, A, P, O>,
    operator: Operator,
    state: OperatorState,
    bounds: Bounds,
    commissioning: Commissioning,
    steps: CommissioningState,
    outbox: Outbox,
}

impl<'a, A: AnalogIn, P: PositionIn, O: AnalogOut> Desk<'a, A, P, O> {
    /// A desk at this station; the operator may send the rod anywhere within the bounds, and play the press's excitations and its plan there.
    #[must_use]
    pub fn new(station: Station<'a, A, P, O>, bounds: Bounds) -> Self {
        let bases = *station.bases();
        let permitted = Permitted { fingerprint: station.fingerprint(), bases, bounds, most_v: press::COMMAND_V };
        let operator = Operator::new(bounds, bases, &press::EXCITATIONS).with_plan(press::PLAN, permitted);
        let (commissioning, steps) = (station.commissioning(), CommissioningState::default());
        let (state, outbox) = (operator.at_rest(), Outbox::default());
        Self { station, operator, state, bounds, commissioning, steps, outbox }
    }

    /// Takes a key, between two periods.
    ///
    /// # Errors
    /// The key has no effect; the error says why.
    pub fn key(&mut self, key: u8) -> Result<(), DeskError> {
        if let Err(refused) = self.commissioning.permits(&self.steps, key) {
            self.operator.forget(&mut self.state);
            return Err(refused.into());
        }
        if key == b's' {
            self.commissioning.stop(&mut self.steps);
        }
        match self.operator.typed(&mut self.state, key)? {
            None => {}
            Some(Errand::Home { position }) => {
                return self.station.home(position).then_some(()).ok_or(DeskError::NotNeutral);
            }
            Some(Errand::Trigger) => self.station.trigger(),
            Some(Errand::Send) => self.outbox.send(),
            Some(Errand::Arm) => self.station.arm(),
            Some(Errand::IgnoreAlarms) => self.station.answer_alarms(None),
            Some(Errand::Commission { step }) => self.commission(step)?,
        }
        Ok(())
    }

    /// Begins a step. The model holds for the working pressure: at a low one, and while the tuning is tried, its alarms are told and stop nothing.
    fn commission(&mut self, step: u32) -> Result<(), CommissioningError> {
        self.commissioning.begin(&mut self.steps, step, &self.bounds)?;
        match self.commissioning.running(&self.steps) {
            Some(Step::Direction | Step::Tuning) => self.station.answer_alarms(None),
            Some(Step::Limits) => {
                self.station.answer_alarms(press::ALARM);
                self.station.arm_monitor();
            }
            Some(Step::NoOil | Step::Voltages | Step::Output | Step::Place) | None => {}
        }
        Ok(())
    }

    /// Stops in the next period.
    pub fn stop(&mut self) {
        self.commissioning.stop(&mut self.steps);
        self.operator.stop(&mut self.state);
    }

    /// One period, called once a tick.
    pub fn step(&mut self, timing: Timing, log: &mut impl Log) -> Report {
        let (Request { set_point, command, timing }, ask) =
            (self.operator.request(&mut self.state, timing), self.commissioning.ask(&mut self.steps));
        if let Some(command) = self.operator.played(&mut self.state) {
            self.station.play(command);
        }
        if let Some(by_hand) = ask.by_hand {
            self.station.put_out_by_hand(by_hand);
        }
        let request =
            Request { set_point: ask.set_point.unwrap_or(set_point), command: command.or(ask.command), timing };
        let report = self.station.step(&request, log);
        self.operator.seen(&mut self.state, &report);
        let input = ask.input.and_then(|signal| self.station.voltage(signal));
        let before = self.commissioning.running(&self.steps);
        self.commissioning.seen(&mut self.steps, &report, input, self.station.place(), log);
        if before.is_some() && self.commissioning.running(&self.steps).is_none() {
            self.station.answer_alarms(press::ALARM);
        }
        report
    }

    /// The commissioning, as far as it has got.
    #[must_use]
    pub fn steps(&self) -> &CommissioningState {
        &self.steps
    }

    /// The next byte to be sent, if there is one; to be fetched between two periods.
    pub fn byte(&mut self) -> Option<u8> {
        self.outbox.next(self.station.recorder(), values::NAME, TICK_NS)
    }
}
