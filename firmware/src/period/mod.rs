//! One control period: inputs → measured → faults → reference model and control → output.
//!
//! The order within a period: the counter and every voltage are read and checked; faults and commands change the mode
//! ([`Mode::next`]); the mode determines where the command comes from; the command is limited in size and slope and put out. So a fault
//! takes effect in the period that finds it, and the valve is neutral after at most [`Limits::periods_to_neutral`] periods of a ramp.
//!
//! | mode | command |
//! |---|---|
//! | starting, neutral | neutral at once |
//! | following | control along the set point, or along a model that is driven ([`Period::play`]), within slew and size |
//! | holding | control at the set point, which comes to rest at the permitted acceleration; within slew and size |
//! | ramping down | towards neutral by the ramp; the model runs along |
//!
//! **Deviation.** While the valve is commanded, the rod is compared with its set point, the spool with its model, and all sensors with the reference
//! model (`supervision/deviation.rs`, [`Monitor`]). A spool that jams open cannot be closed by any command: the valve loses its command and its
//! current, and [`Report::shut_off`] asks an independent valve to cut off the oil.
//!
//! **Watchdog.** It must be fed after a healthy period: the period before ended in time, every device answered and the output took
//! the command. In any other period the valve loses its current as well ([`Report::energised`]), because the ramp may not arrive. A
//! restart may cure the cause of such a period. It cannot cure a broken sensor, and would lose the recorder's contents: such faults lead
//! to their own modes, and the watchdog is still fed.

#[cfg(feature = "async")]
mod awaited;
mod compare;
mod decide;
mod report;

use model_core::number::{Number, PerUnit};

use self::blocking::devices::{convert, count, put_out, sample, write};
use crate::control::Control;
use crate::io::{AnalogIn, AnalogOut, PositionIn};
use crate::measured::AnalogSignal;
use crate::monitor::{Monitor, MonitorState};
use crate::scaling::{Calibration, Travel};
use crate::set_point::Followed;
use crate::supervision::deviating::Deviating;
use crate::supervision::sense::Senses;
use crate::supervision::{ActiveFaults, Limits, LimitsError, Log, Mode, Response};

/// What is asked of devices that block.
#[path = "."]
mod blocking {
    use maybe_async::must_be_sync as twice;

    use crate::io::{AnalogIn, AnalogOut, PositionIn};
    #[cfg(test)]
    use crate::mock::done as block_on;

    pub(super) mod devices;
}

/// What is asked of devices that are awaited.
#[cfg(feature = "async")]
#[path = "."]
#[expect(clippy::duplicate_mod, reason = "one source for both kinds of devices")]
mod asynchronous {
    use maybe_async::must_be_async as twice;
    #[cfg(test)]
    use pollster::block_on;

    use crate::io::asynchronous::{AnalogIn, AnalogOut, PositionIn};

    pub(super) mod devices;
}

pub use report::{Answer, InputVoltage, Place, Report, Request, Timing, Watchdog};

/// The devices of a rig.
#[derive(Debug)]
pub struct Devices<A, P, O> {
    /// Analogue inputs.
    pub inputs: A,
    /// Counter of the position's encoder.
    pub position: P,
    /// Output to the valve.
    pub output: O,
}

/// Configuration of a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rig {
    /// From counts to values and back.
    pub calibration: Calibration,
    /// From the encoder's count to the position.
    pub travel: Travel,
    /// What is too far, too fast or too long.
    pub limits: Limits,
    /// Whether the model still predicts what the sensors show; `None` is not monitored.
    pub monitor: Option<Monitor>,
}

/// State of a period: everything that it remembers, except the control's own state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeriodState {
    mode: Mode,
    active_faults: ActiveFaults,
    senses: Senses,
    place: Place,
    /// Whether somebody has homed, acknowledged or followed since the controller started: before that, nobody knows why it started.
    released: bool,
    energised: bool,
    /// Periods without a fault since the last fault, or since the valve was last sent to neutral.
    healthy: u16,
    /// Successive periods in which the voltage at the valve differed from the output.
    away: u16,
    /// Last set point within the limits; comes to rest while the rod is held.
    followed: Followed,
    deviating: Deviating,
    watched: MonitorState,
    /// Last command, from which the next one slews.
    command: PerUnit,
    /// Command that the output holds, where that is certain.
    put_out: Option<PerUnit>,
    /// Command of the next period from elsewhere.
    given: Option<Given>,
}

/// A command in place of a loop's, in units of 10 V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Given {
    /// For the output, in place of both loops'.
    Output(PerUnit),
    /// For the model, in place of the model loop's.
    Model(PerUnit),
}

/// Why a rig does not begin.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BeginError<P, O> {
    /// Its limits are not valid.
    #[error(transparent)]
    Limits(#[from] LimitsError),
    /// The counter does not answer.
    #[error("counter: {0:?}")]
    Position(P),
    /// The output does not answer.
    #[error("output: {0:?}")]
    Output(O),
}

impl Rig {
    /// The output's count at which the valve is neutral, if the limits are valid.
    fn neutral(&self) -> Result<i32, LimitsError> {
        self.limits.check()?;
        Ok(self.calibration.output.count(self.limits.neutral))
    }
}

/// The control period of a rig.
#[derive(Debug)]
pub struct Period<A, P, O, C> {
    devices: Devices<A, P, O>,
    rig: Rig,
    control: C,
    state: PeriodState,
}

impl<A: AnalogIn, P: PositionIn, O: AnalogOut, C: Control> Period<A, P, O, C> {
    /// Puts the valve to neutral. `place` is known where the counter itself gives the rod's position: that of an absolute encoder, or one
    /// that was cleared at the reference.
    ///
    /// # Errors
    /// The limits are not valid, or counter or output do not answer.
    pub fn begin(
        mut devices: Devices<A, P, O>,
        rig: Rig,
        control: C,
        place: Place,
    ) -> Result<Self, BeginError<P::Error, O::Error>> {
        let attempts = rig.limits.attempts;
        write(attempts, &mut devices.output, rig.neutral()?).map_err(BeginError::Output)?;
        let count = count(attempts, &mut devices.position, |_| true).map_err(BeginError::Position)?;
        Ok(Self::at(devices, &rig, control, place, count))
    }

    /// One period, called once a tick.
    pub fn step(&mut self, request: &Request, log: &mut impl Log) -> Report {
        let sample = sample(&mut self.devices, &self.rig, &self.state.senses.travel);
        let decided = self.decide(request, &sample, log);
        let neutral = self.neutral();
        let done = put_out(self.rig.limits.attempts, &mut self.devices.output, decided.count, neutral);
        self.conclude(decided, done)
    }

    /// Reads the voltage of a signal's input, between two periods; `None` where it has no sensor.
    ///
    /// # Errors
    /// The inputs do not answer.
    pub fn voltage(&mut self, signal: AnalogSignal) -> Result<Option<InputVoltage>, A::Error> {
        let Some(row) = self.rig.calibration.row(signal) else { return Ok(None) };
        let count = convert(self.rig.limits.attempts, &mut self.devices.inputs, row.channel())?;
        Ok(Some(InputVoltage::of(signal, row, count, A::SPAN_UV)))
    }
}

impl<A, P, O, C: Control> Period<A, P, O, C> {
    /// At the start, with the counter at this count.
    fn at(devices: Devices<A, P, O>, rig: &Rig, control: C, place: Place, count: i32) -> Self {
        let state = PeriodState {
            mode: Mode::Starting,
            active_faults: ActiveFaults::NONE,
            senses: Senses::new(count),
            place,
            released: false,
            energised: false,
            healthy: 0,
            away: 0,
            followed: Followed::resting(PerUnit::ZERO),
            deviating: Deviating::NEW,
            watched: MonitorState::AT_REST,
            command: rig.limits.neutral,
            put_out: Some(rig.limits.neutral),
            given: None,
        };
        Self { devices, rig: *rig, control, state }
    }

    /// Sets the rod's present position to `position`, as a share of the stroke. Accepted only while the valve is neutral; returns whether it was.
    pub fn home(&mut self, position: PerUnit) -> bool {
        let neutral = matches!(self.state.mode, Mode::Starting | Mode::Neutral);
        if neutral {
            self.rig.travel.home(&mut self.state.senses.travel, position);
            self.state.place = Place::Known;
            self.state.released = true;
            self.state.deviating.displaced();
        }
        neutral
    }

    /// In the next period this command, in units of 10 V, is put out in place of the loops'; within size and slew, and with every check. While the rod
    /// follows, the model goes along. In mode starting the valve has no current meanwhile ([`Report::energised`]). In other modes it does nothing.
    ///
    /// For [commissioning](crate::commissioning). Loops that go on afterwards start from where they stood.
    pub fn put_out_by_hand(&mut self, command: PerUnit) {
        self.state.given = Some(Given::Output(command));
    }

    /// In the next period this command, in units of 10 V, drives the reference model in place of the set point, while the rod follows; the loops make the
    /// machine do the same. What is wanted is then where the model is, with every check: within the bounds, with room to come to rest there at their
    /// acceleration; else it is a fault of the set point, and the rod is held. In other modes it does nothing.
    ///
    /// A set point that goes on afterwards begins at [`Report::followed`], once that rests.
    pub fn play(&mut self, command: PerUnit) {
        self.state.given = Some(Given::Model(command));
    }

    /// Whether the rod's place is known.
    pub fn place(&self) -> Place {
        self.state.place
    }

    /// The output's count at which the valve is neutral.
    fn neutral(&self) -> i32 {
        self.rig.calibration.output.count(self.rig.limits.neutral)
    }

    /// Changes what the monitor's alarm leads to: `None` ignores it, as for recording a drive that is to be diagnosed. An alarm that was ignored is given
    /// again once alarms are heeded.
    pub fn answer_alarms(&mut self, response: Option<Response>) {
        if response.is_some() && self.rig.limits.deviation.alarm.is_none() {
            self.arm_monitor();
        }
        self.rig.limits.deviation.alarm = response;
    }

    /// The monitor forgets what it has seen, and may give an alarm again.
    pub fn arm_monitor(&mut self) {
        self.state.watched = MonitorState::AT_REST;
    }

    /// The mode now.
    pub fn mode(&self) -> Mode {
        self.state.mode
    }

    /// The state without the control's own, to be stored.
    pub fn state(&self) -> &PeriodState {
        &self.state
    }

    /// Goes on from a stored state.
    pub fn restore(&mut self, state: PeriodState) {
        self.state = state;
    }

    /// The reference model with its loops.
    pub fn control(&self) -> &C {
        &self.control
    }

    /// Gives the devices back.
    pub fn release(self) -> Devices<A, P, O> {
        self.devices
    }
}
