//! From what the devices answered to the command, and from what became of it to the report: no device is asked here.

use model_core::number::{Number, PerUnit};

use super::report::{Answer, Report, Request, Timing, Watchdog};
use super::{Given, Period, PeriodState, Place};
use crate::control::{Control, Predicted};
use crate::io::Cause;
use crate::measured::Measured;
use crate::monitor::Miss;
use crate::set_point::{Followed, Refusal, SetPoint};
use crate::supervision::sense::{Expected, Sample, apart, sorted};
use crate::supervision::{Action, ActiveFaults, Command, Device, Event, Fault, Findings, Limits, Log, Mode};

/// A period between its readings and its output.
pub(super) struct Decided<'a, L> {
    found: Findings<'a, L>,
    /// The mode before the period.
    before: Mode,
    measured: Measured,
    read_back: Option<PerUnit>,
    predicted: Option<Predicted>,
    alarm: Option<Miss>,
    answer: Option<Answer>,
    command: PerUnit,
    /// The output's count of the command.
    pub(super) count: i32,
}

impl<A, P, O, C: Control> Period<A, P, O, C> {
    /// From what the devices answered to the command of this period.
    pub(super) fn decide<'a, L: Log>(&mut self, request: &Request, sample: &Sample, log: &'a mut L) -> Decided<'a, L> {
        let before = self.state.mode;
        let mut found = Findings::new(self.state.active_faults, log);
        if request.timing == Timing::Overrun {
            found.note(&Fault::Overrun);
        }
        let predicted = self.state.mode.is_running().then(|| self.control.predicted());
        let (measured, read_back) = self.sense(sample, predicted, &mut found);
        let spool_off = predicted.and_then(|_| self.control.spool_off(&measured));
        let alarm = self.monitor(predicted, spool_off, &measured, &mut found);
        self.deviate(predicted, spool_off, &measured, &mut found);

        self.heed_faults(&mut found, &measured);
        let answer = self.obey(request, &measured, &mut found);
        let given = self.state.given.take();
        self.accept(request.set_point, given, &measured, &mut found);

        let command = self.command(given, &measured);
        let count = self.rig.calibration.output.count(command);
        Decided { found, before, measured, read_back, predicted, alarm, answer, command, count }
    }

    /// The rest of the period, once the command was put out or failed to be.
    pub(super) fn conclude<L: Log>(&mut self, decided: Decided<'_, L>, done: Result<(), Cause>) -> Report {
        let Decided { mut found, before, measured, read_back, predicted, alarm, answer, command, .. } = decided;
        self.put_out(command, done, &measured, &mut found);

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

    /// The measured values, and the command that was read back.
    fn sense<L: Log>(
        &mut self,
        sample: &Sample,
        predicted: Option<Predicted>,
        found: &mut Findings<'_, L>,
    ) -> (Measured, Option<PerUnit>) {
        let Self { rig, state, .. } = self;
        let limits = &rig.limits;
        let expected = Expected { predicted, put_out: state.put_out };
        let position = state.senses.position(sample.position, &rig.travel, limits, &expected, found);
        let voltages = state.senses.voltages(&sample.voltages, &rig.calibration, limits, &expected, found);
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

    /// Takes note of the command that was put out. If the output failed, neutral was written after it.
    fn put_out<L: Log>(
        &mut self,
        command: PerUnit,
        done: Result<(), Cause>,
        measured: &Measured,
        found: &mut Findings<'_, L>,
    ) {
        let neutral = self.rig.limits.neutral;
        self.state.command = command;
        self.state.put_out = Some(command);
        if let Err(cause) = done {
            self.state.command = neutral;
            self.state.put_out = None;
            found.note(&Fault::Silent { device: Device::Output, cause });
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
