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

mod compare;
mod report;

use model_core::number::{Number, PerUnit};

use crate::control::{Control, Predicted};
use crate::io::{AnalogIn, AnalogOut, IoError, PositionIn};
use crate::measured::{AnalogSignal, Measured};
use crate::monitor::{Monitor, MonitorState};
use crate::scaling::{Calibration, Travel};
use crate::set_point::{Followed, Refusal, SetPoint};
use crate::supervision::deviating::Deviating;
use crate::supervision::sense::{Expected, Senses, apart, ask, sorted};
use crate::supervision::{
    Action, ActiveFaults, Command, Device, Event, Fault, Findings, Limits, LimitsError, Log, Mode, Response,
};

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
        let limits = &rig.limits;
        limits.check()?;
        let neutral = rig.calibration.output.count(limits.neutral);
        ask(limits.attempts, || devices.output.write(neutral)).map_err(BeginError::Output)?;
        let count = ask(limits.attempts, || devices.position.count()).map_err(BeginError::Position)?;
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
            command: limits.neutral,
            put_out: Some(limits.neutral),
            given: None,
        };
        Ok(Self { devices, rig, control, state })
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

    /// Reads the voltage of a signal's input, between two periods; `None` where it has no sensor.
    ///
    /// # Errors
    /// The inputs do not answer.
    pub fn voltage(&mut self, signal: AnalogSignal) -> Result<Option<InputVoltage>, A::Error> {
        let Some(row) = self.rig.calibration.row(signal) else { return Ok(None) };
        let count = ask(self.rig.limits.attempts, || self.devices.inputs.convert(row.channel()))?;
        let millivolts = |count: i32| {
            // 2¹⁶ counts are so many µV.
            let microvolts = (i64::from(count) * i64::from(A::SPAN_UV)) >> 16;
            i32::try_from(microvolts / 1000).unwrap_or(i32::MAX)
        };
        let [from, to] = row.working();
        let (found_mv, from_mv, to_mv) = (millivolts(count), millivolts(from), millivolts(to));
        Ok(Some(InputVoltage { signal, found_mv, from_mv, to_mv }))
    }

    /// Whether the rod's place is known.
    pub fn place(&self) -> Place {
        self.state.place
    }

    /// One period, called once a tick.
    pub fn step(&mut self, request: &Request, log: &mut impl Log) -> Report {
        let before = self.state.mode;
        let mut found = Findings::new(self.state.active_faults, log);
        if request.timing == Timing::Overrun {
            found.note(&Fault::Overrun);
        }
        let predicted = self.state.mode.is_running().then(|| self.control.predicted());
        let (measured, read_back) = self.sense(predicted, &mut found);
        let spool_off = predicted.and_then(|_| self.control.spool_off(&measured));
        let alarm = self.monitor(predicted, spool_off, &measured, &mut found);
        self.deviate(predicted, spool_off, &measured, &mut found);

        self.heed_faults(&mut found, &measured);
        let answer = self.obey(request, &measured, &mut found);
        let given = self.state.given.take();
        self.accept(request.set_point, given, &measured, &mut found);

        let command = self.command(given, &measured);
        self.put_out(command, &measured, &mut found);

        self.state.active_faults = found.active_faults;
        self.state.energised &= self.state.mode.is_running() && !found.own;
        found.tell_mode(before, self.state.mode);
        Report {
            mode: self.state.mode,
            measured,
            read_back,
            predicted,
            command: self.state.command,
            followed: self.state.followed.at,
            answer,
            active_faults: self.state.active_faults,
            alarm,
            shut_off: self.needs_shut_off(),
            watchdog: if found.own { Watchdog::Withhold } else { Watchdog::Feed },
            energised: self.state.energised,
        }
    }

    /// Whether an independent valve must cut off the oil. A rod whose place is lost, and a controller that has only started, cannot judge what moves.
    fn needs_shut_off(&self) -> bool {
        let PeriodState { active_faults, released, place, .. } = self.state;
        active_faults.need_shut_off() || !released || place == Place::Lost
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

    /// The measured values, and the command that was read back.
    fn sense<L: Log>(
        &mut self,
        predicted: Option<Predicted>,
        found: &mut Findings<'_, L>,
    ) -> (Measured, Option<PerUnit>) {
        let Self { devices, rig, state, .. } = self;
        let limits = &rig.limits;
        let expected = Expected { predicted, put_out: state.put_out };
        let position = state.senses.position(&mut devices.position, &rig.travel, limits, &expected, found);
        let voltages = state.senses.voltages(&mut devices.inputs, &rig.calibration, limits, &expected, found);
        let (measured, read_back) = sorted(position, voltages);
        if let (Some(patience), Some(back), Some(command)) = (&limits.read_back, read_back, state.put_out) {
            let away = apart(back, command, patience.travel);
            state.away = if away { state.away.saturating_add(1) } else { 0 };
            if state.away > patience.periods {
                found.note(&Fault::OutputAway { command, found: back });
            }
        }
        (measured, read_back)
    }

    /// Passes the faults to the state machine.
    fn heed_faults<L: Log>(&mut self, found: &mut Findings<'_, L>, measured: &Measured) {
        if found.lost {
            self.state.place = Place::Lost;
        }
        if let Some(response) = found.worst {
            self.state.healthy = 0;
            self.change(Event::Faulty(response), measured, found);
        } else {
            self.state.healthy = self.state.healthy.saturating_add(1);
        }
    }

    /// Passes a command to the state machine, unless it must be refused.
    fn obey<L: Log>(&mut self, request: &Request, measured: &Measured, found: &mut Findings<'_, L>) -> Option<Answer> {
        let command = request.command?;
        let absurd = self.state.mode == Mode::Holding && self.absurd(request.set_point).is_some();
        let answer = match command {
            Command::Acknowledge | Command::Follow if found.worst.is_some() || absurd => Answer::Faulty,
            Command::Follow if self.state.healthy < self.rig.limits.settling => Answer::Unsettled,
            // Following may go on once the held set point has come to rest.
            Command::Acknowledge if self.state.mode == Mode::Holding && !self.state.followed.rests() => {
                Answer::Unsettled
            }
            Command::Follow if self.state.place == Place::Lost => Answer::Lost,
            Command::Stop | Command::Acknowledge | Command::Follow => Answer::Taken,
        };
        if answer == Answer::Taken {
            self.state.released |= command != Command::Stop;
            self.change(Event::Commanded(command), measured, found);
        }
        Some(answer)
    }

    /// The fault of an absurd set point, if it is absurd.
    fn absurd(&self, wanted: SetPoint) -> Option<Fault> {
        let resumed = Followed::resting(self.state.followed.at.position);
        self.next(&resumed, wanted).err()
    }

    /// The set point that follows another one, or the fault of an absurd one.
    fn next(&self, followed: &Followed, wanted: SetPoint) -> Result<Followed, Fault> {
        let limits = &self.rig.limits;
        let SetPoint { position, velocity } = wanted;
        limits.envelope.next(followed, wanted, limits.most_jump).map_err(|refusal| match refusal {
            Refusal::Outside => Fault::SetPointOutside { position, velocity },
            Refusal::Jump => Fault::SetPointJump { from: followed.at.position, to: position },
            Refusal::Steep => Fault::SetPointSteep { position, velocity },
        })
    }

    /// Where the model is that a given command drives, or the fault of one that leaves the bounds.
    fn driven(&self) -> Result<Followed, Fault> {
        let motion @ SetPoint { position, velocity } = self.control.motion();
        let driven = self.rig.limits.envelope.driven(&self.state.followed, motion);
        driven.ok_or(Fault::SetPointOutside { position, velocity })
    }

    /// Takes the set point while the rod follows, unless it is absurd; without one, the last comes to rest.
    fn accept<L: Log>(
        &mut self,
        wanted: SetPoint,
        given: Option<Given>,
        measured: &Measured,
        found: &mut Findings<'_, L>,
    ) {
        if self.state.mode == Mode::Following {
            let next = match given {
                Some(Given::Model(_)) => self.driven(),
                Some(Given::Output(_)) | None => self.next(&self.state.followed, wanted),
            };
            match next {
                Ok(next) => self.state.followed = next,
                Err(fault) => {
                    found.note(&fault);
                    self.heed_faults(found, measured);
                }
            }
        }
        if self.state.mode == Mode::Holding {
            self.state.followed = self.rig.limits.envelope.braked(&self.state.followed);
        }
    }

    /// The command of this period.
    fn command(&mut self, given: Option<Given>, measured: &Measured) -> PerUnit {
        let Limits { neutral, most_command, slew, ramp, .. } = self.rig.limits;
        let last = self.state.command;
        match (self.state.mode, given) {
            (Mode::Starting, Some(Given::Output(command))) => command.limited(most_command),
            (Mode::Starting | Mode::Neutral, _) => neutral,
            (Mode::Following, Some(Given::Output(wanted))) => {
                let command = last + (wanted.limited(most_command) - last).limited(slew);
                self.control.accompany(command, measured);
                command
            }
            (Mode::Following, Some(Given::Model(wanted))) => {
                let wanted = self.control.play(wanted, measured).limited(most_command);
                last + (wanted - last).limited(slew)
            }
            (Mode::Following | Mode::Holding, _) => {
                let wanted = self.control.follow(self.state.followed.at, measured).limited(most_command);
                last + (wanted - last).limited(slew)
            }
            (Mode::RampingDown, _) => {
                let command = last + (neutral - last).limited(ramp);
                self.control.accompany(command, measured);
                command
            }
        }
    }

    /// Puts the command out. If the output fails, neutral is written once more, because the valve must then be neutral.
    fn put_out<L: Log>(&mut self, command: PerUnit, measured: &Measured, found: &mut Findings<'_, L>) {
        let neutral = self.rig.limits.neutral;
        self.state.command = command;
        self.state.put_out = Some(command);
        let output = &mut self.devices.output;
        let count = self.rig.calibration.output.count(command);
        if let Err(error) = ask(self.rig.limits.attempts, || output.write(count)) {
            self.state.command = neutral;
            self.state.put_out = None;
            // This may fail as well; the next period tries again anyway.
            let _ = output.write(self.rig.calibration.output.count(neutral));
            found.note(&Fault::Silent { device: Device::Output, cause: error.cause() });
            self.heed_faults(found, measured);
        } else if self.state.mode == Mode::RampingDown && command == neutral {
            self.change(Event::Arrived, measured, found);
        }
        if self.state.mode.is_running() {
            self.control.applied(command);
        }
    }

    /// Passes an event to the state machine and carries out its action.
    fn change<L: Log>(&mut self, event: Event, measured: &Measured, found: &mut Findings<'_, L>) {
        let next = self.state.mode.next(event);
        if self.state.mode.is_running() && !next.mode.is_running() {
            // The valve still has to travel to its neutral.
            self.state.healthy = 0;
        }
        self.state.mode = next.mode;
        match next.action {
            Action::Nothing => {}
            Action::Synchronise => {
                self.control.start(measured);
                self.state.senses.rouse();
                self.state.energised = true;
                self.state.followed = Followed::resting(measured.position);
                self.state.deviating.begin(&self.rig.limits.deviation, measured.position, self.rig.limits.most_jump);
            }
            Action::Forget => {
                found.active_faults = ActiveFaults::NONE;
                self.arm_monitor();
                if next.mode == Mode::Following {
                    self.state.followed = Followed::resting(self.state.followed.at.position);
                    self.state.deviating.resume();
                }
            }
        }
    }
}
