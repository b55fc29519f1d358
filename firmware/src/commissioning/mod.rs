//! Commissioning: seven steps from a machine without oil to one whose limits are on. Each is begun by the operator, told on the log with what was
//! measured, and refused with the value found and the value expected; a step waits for those before it.
//!
//! | step | does | passes when |
//! |---|---|---|
//! | 1 no oil | watches the pressures | both are below a twentieth of the supply's |
//! | 2 voltages | reads every analogue input | each voltage is within its sensor's band |
//! | 3 output | puts small voltages out; the valve has no current | each is read back at the valve |
//! | 4 place | watches the encoder; the rod has been homed | the rod rests within its bounds |
//! | 5 direction | 1 mm each way at low pressure, without loops | spool, encoder and pressures have the right signs |
//! | 6 tuning | 5 mm and back with the loops, the monitor's alarm ignored | the following error is within its limit |
//! | 7 limits | the same with everything watched | no fault and no alarm |
//!
//! The period does what it always does: every fault is found, and leads where it leads. What the period gets from here are set points, commands, and
//! in steps 3 and 5 a voltage in place of the loops' ([`Period::put_out_by_hand`](crate::period::Period::put_out_by_hand)).

mod direction;
mod reading;
mod rules;
mod step;
mod work;

use model_core::machine::{Bases, Machine};
use model_core::number::PerUnit;

use crate::measured::AnalogSignal;
use crate::period::{Answer, InputVoltage, Place, Report};
use crate::set_point::{Bounds, SetPoint};
use crate::supervision::{Command, Limits, Log, Mode};
use rules::Rules;
use work::{Now, Work};

pub use reading::{Expected, Reading, Refusal, Way, What};
pub use step::{CommissioningError, Note, Step};

/// What the steps expect of this machine: configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Commissioning {
    rules: Rules,
}

/// Which steps were passed, and the one that is under way.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CommissioningState {
    passed: usize,
    /// It was begun, and has neither ended nor been left.
    begun: bool,
    running: Option<Running>,
    last: Option<Report>,
    stopped: bool,
}

/// What is asked of the next period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ask {
    /// A command in place of the loops'.
    pub by_hand: Option<PerUnit>,
    /// A command of the state machine.
    pub command: Option<Command>,
    /// A set point in place of the operator's.
    pub set_point: Option<SetPoint>,
    /// An input whose voltage is asked for.
    pub input: Option<AnalogSignal>,
}

#[derive(Clone, Debug, PartialEq)]
struct Running {
    step: Step,
    phase: Phase,
    /// Periods in this phase.
    since: u32,
    work: Work,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Faults that were none are acknowledged; the valve settles.
    Preparing,
    Working,
    /// The valve goes to neutral.
    Ending,
}

/// Tells a value that is as expected; another one is a refusal.
fn check(log: &mut impl Log, step: Step, reading: Reading) -> Result<(), Refusal> {
    if reading.holds() {
        log.commissioning(&Note::Measured(step, reading));
        Ok(())
    } else {
        Err(Refusal::Value(reading))
    }
}

impl Commissioning {
    /// For this machine within these limits.
    #[must_use]
    pub fn new(machine: &Machine<f64>, bases: &Bases, limits: &Limits) -> Self {
        Self { rules: Rules::new(machine, bases, limits) }
    }

    /// The same within other limits.
    #[must_use]
    pub fn within(mut self, limits: &Limits) -> Self {
        self.rules.limit(limits);
        self
    }

    /// Begins a step, between two periods; 0 leaves the commissioning. Whoever begins a step again passes those after it again.
    ///
    /// # Errors
    /// The step cannot begin now.
    pub fn begin(
        &self,
        state: &mut CommissioningState,
        number: u32,
        bounds: &Bounds,
    ) -> Result<(), CommissioningError> {
        if state.running.is_some() {
            return Err(CommissioningError::Busy);
        }
        if number == 0 {
            *state = CommissioningState { last: state.last, ..CommissioningState::default() };
            return Ok(());
        }
        let index = number as usize - 1;
        let &step = Step::ALL.get(index).ok_or(CommissioningError::NoStep { found: number })?;
        if index > state.passed {
            let next = u32::try_from(state.passed + 1).unwrap_or(number);
            return Err(CommissioningError::Order { asked: number, next });
        }
        let Some(last) = state.last.filter(|last| !last.mode.is_running()) else {
            return Err(CommissioningError::NotNeutral);
        };
        // The first two are there to find what is wrong with the sensors.
        if step >= Step::Output && !last.active_faults.is_empty() {
            return Err(CommissioningError::Faulty);
        }
        let work = Work::of(step, &self.rules, &last, bounds)?;
        *state = CommissioningState {
            passed: index,
            begun: true,
            running: Some(Running { step, phase: Phase::Preparing, since: 0, work }),
            last: Some(last),
            stopped: false,
        };
        Ok(())
    }

    /// Why a key of the operator is refused now.
    ///
    /// # Errors
    /// A step is under way, or the commissioning has not ended.
    pub fn permits(&self, state: &CommissioningState, key: u8) -> Result<(), CommissioningError> {
        match key {
            b'f' | b'g' | b'e' | b'a' | b'z' | b'i' | b'c' if state.running.is_some() => Err(CommissioningError::Busy),
            b'f' | b'g' | b'e' | b'i' if state.begun => Err(CommissioningError::Unfinished),
            _ => Ok(()),
        }
    }

    /// How many steps have been passed.
    #[must_use]
    pub fn passed(&self, state: &CommissioningState) -> usize {
        state.passed
    }

    /// The step that is under way.
    #[must_use]
    pub fn running(&self, state: &CommissioningState) -> Option<Step> {
        state.running.as_ref().map(|running| running.step)
    }

    /// The operator stops: the step that is under way is refused.
    pub fn stop(&self, state: &mut CommissioningState) {
        state.stopped = state.running.is_some();
    }

    /// What is asked of the next period.
    pub fn ask(&self, state: &mut CommissioningState) -> Ask {
        let (mut ask, rules) = (Ask::default(), &self.rules);
        let Some(running) = &mut state.running else { return ask };
        match running.phase {
            Phase::Preparing => {
                // Neutral after a stop: there was no fault.
                let healthy = |last: &Report| last.mode == Mode::Neutral && last.active_faults.is_empty();
                if running.since == 0 && state.last.as_ref().is_some_and(healthy) {
                    ask.command = Some(Command::Acknowledge);
                }
                if running.step.moves() && running.since == rules.settling + rules.rest {
                    ask.command = Some(Command::Follow);
                    if let Work::Follow { course, along, .. } = &mut running.work {
                        ask.set_point = Some(course.step(along));
                    }
                }
            }
            Phase::Working => {
                ask.by_hand = running.work.by_hand(running.since).map(|uv| rules.command(uv));
                match &mut running.work {
                    Work::Voltages { .. } => {
                        let index = running.since as usize % AnalogSignal::COUNT;
                        ask.input = AnalogSignal::ALL.get(index).copied();
                    }
                    Work::Follow { course, along, .. } => ask.set_point = Some(course.step(along)),
                    Work::NoOil { .. } | Work::Output | Work::Place { .. } | Work::Direction(_) => {}
                }
            }
            Phase::Ending => {
                match &mut running.work {
                    // At neutral before the ramp begins, which is slower.
                    Work::Direction(_) => ask.by_hand = Some(rules.neutral),
                    Work::Follow { course, along, .. } => ask.set_point = Some(course.step(along)),
                    Work::NoOil { .. } | Work::Voltages { .. } | Work::Output | Work::Place { .. } => {}
                }
                ask.command = (running.since == 1).then_some(Command::Stop);
            }
        }
        ask
    }

    /// Takes the report of a period, the voltage that was asked for, and whether the rod's place is known.
    pub fn seen(
        &self,
        state: &mut CommissioningState,
        report: &Report,
        input: Option<Result<InputVoltage, Refusal>>,
        place: Place,
        log: &mut impl Log,
    ) {
        let before = state.last.replace(*report);
        if place == Place::Lost {
            state.passed = state.passed.min(Step::Place as usize);
        }
        let Some(mut running) = state.running.take() else { return };
        running.since += 1;
        let stopped = core::mem::take(&mut state.stopped);
        if running.phase == Phase::Ending {
            if report.mode.is_running() {
                state.running = Some(running);
            }
            return;
        }
        if running.since == 1 && running.phase == Phase::Preparing {
            log.commissioning(&Note::Begun(running.step));
        }
        let verdict = match running.phase {
            _ if stopped => Some(Err(Refusal::Stopped)),
            Phase::Preparing => self.prepared(&mut running, report).err().map(Err),
            Phase::Working | Phase::Ending => {
                let Running { step, since, .. } = running;
                let now = Now { step, since, report, before: before.as_ref(), input, place };
                running.work.seen(&self.rules, &now, log)
            }
        };
        // A fault in the last period of a step is one of the step.
        let verdict = match verdict {
            Some(Err(refusal)) => Some(Err(refusal)),
            other => left(&running, report).map(Err).or(other),
        };
        let Some(verdict) = verdict else {
            state.running = Some(running);
            return;
        };
        match verdict {
            Ok(()) => {
                state.passed += 1;
                state.begun = state.passed < Step::ALL.len();
                log.commissioning(&Note::Passed(running.step));
            }
            Err(refusal) => log.commissioning(&Note::Refused(running.step, refusal)),
        }
        if report.mode.is_running() {
            state.running = Some(Running { phase: Phase::Ending, since: 0, ..running });
        }
    }

    /// Preparing: settles, and follows where the step moves the rod.
    fn prepared(&self, running: &mut Running, report: &Report) -> Result<(), Refusal> {
        let begins = if running.step.moves() { self.rules.settling + self.rules.rest + 1 } else { 2 };
        if running.since < begins {
            return Ok(());
        }
        (running.phase, running.since) = (Phase::Working, 0);
        match report.answer {
            Some(Answer::Taken) => Ok(()),
            Some(answer) if running.step.moves() => Err(Refusal::NotFollowing(answer)),
            _ => Ok(()),
        }
    }
}

/// Why a step that has not ended cannot go on: a fault, or a mode that it did not ask for.
fn left(running: &Running, report: &Report) -> Option<Refusal> {
    if running.step >= Step::Output && !report.active_faults.is_empty() {
        return Some(Refusal::Fault);
    }
    let wanted = running.step.moves() && running.phase == Phase::Working;
    (wanted && report.mode != Mode::Following).then_some(Refusal::Stopped)
}
