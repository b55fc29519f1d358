//! An operator at a keyboard: characters become commands and target positions, and from these the set point of each period.
//!
//! | typed | does |
//! |---|---|
//! | `150z` | sets the rod's present position to 150 mm; only while the valve is neutral |
//! | `f` | follow, from where the rod stands |
//! | `160g` | go to 160 mm, from rest to rest within the bounds; only while the rod follows, and after the last move has ended |
//! | `s` | stop |
//! | `a` | acknowledge the faults |
//! | `t` | trigger the recorder |
//! | `d` | send what the recorder holds |
//! | `n` | delete that, and wait for the next alarm or fault |
//! | `1c` to `7c` | begin this step of the [commissioning](crate::commissioning); `0c` leaves it |
//! | `2e` | play the second [excitation](super::press::EXCITATIONS) about where the rod stands, and trigger the recorder; as `g`, only while the rod follows and rests |
//! | `4e` | play the [plan](super::press::PLAN), from the place where it begins |
//! | `i` | from now on an alarm of the monitor is told and stops nothing, until the controller restarts |
//!
//! Spaces and line ends do nothing. Positions are whole millimetres. After an unknown character, or one that was lost on the line,
//! everything except `s` is ignored until the next space or line end: half a number would be another position.

use model_core::machine::Bases;
use model_core::number::{Number, PerUnit};
use thiserror::Error;

use crate::excitation::plan::{Permitted, Plan, Play, PlayState};
use crate::excitation::{Excitation, ExcitationError, PlanError, Wave, WaveState};
use crate::period::{Report, Request, Timing};
use crate::set_point::{Bounds, Course, CourseState, Leg, SetPoint, SetPointError};
use crate::supervision::{Command, Mode};

/// Largest position that can be typed, mm.
const MOST_MM: u32 = 100_000;

/// A task outside the control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Errand {
    /// The rod is here, as a share of the stroke.
    Home {
        /// The position.
        position: PerUnit,
    },
    /// Trigger the recorder.
    Trigger,
    /// Send what the recorder holds.
    Send,
    /// Arm the recorder for the next trigger.
    Arm,
    /// From now on an alarm of the monitor leads to nothing.
    IgnoreAlarms,
    /// Begin a step of the commissioning, or leave it.
    Commission {
        /// Number of the step from 1 on; 0 leaves.
        step: u32,
    },
}

/// Why the input is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum OperatorError {
    /// No such command.
    #[error("{found:#04x} is none of f, g, e, s, a, z, c, t, d, n, i")]
    Unknown {
        /// What was typed.
        found: u8,
    },
    /// The position that this command needs is missing.
    #[error("{letter:#04x} needs a position before it, mm")]
    NoPosition {
        /// What was typed.
        letter: u8,
    },
    /// The step's number is missing.
    #[error("c needs the number of a step before it")]
    NoStep,
    /// There is no excitation of this number.
    #[error("e needs the number of an excitation before it, 1 to {most}")]
    NoExcitation {
        /// How many there are.
        most: usize,
    },
    /// The rod does not follow.
    #[error("not following: type f first")]
    NotFollowing,
    /// The last move has not ended.
    #[error("the last move has not ended")]
    Moving,
    /// A period takes only one command.
    #[error("the previous command has not been taken yet")]
    Pending,
    /// There is no valid move to that position.
    #[error(transparent)]
    SetPoint(#[from] SetPointError),
    /// The excitation does not fit here.
    #[error(transparent)]
    Excitation(#[from] ExcitationError),
    /// The plan is for another machine, or does not fit here.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// Where and how fast the operator may send the rod: configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operator {
    bases: Bases,
    bounds: Bounds,
    excitations: &'static [Excitation],
    plan: Option<(&'static Plan<'static>, Permitted)>,
}

/// What was typed so far, and where the rod is wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatorState {
    typed_mm: Option<u32>,
    /// An unknown character was typed, and no space or line end since.
    garbled: bool,
    command: Option<Command>,
    mode: Mode,
    course: Option<(Course<1>, CourseState)>,
    wave: Option<(Wave, WaveState)>,
    /// A plan that is played; it is forgotten when it has ended.
    play: Option<(Play<'static>, PlayState)>,
    wanted: SetPoint,
}

impl Operator {
    /// An operator with these bounds and bases, who may play these excitations.
    #[must_use]
    pub fn new(bounds: Bounds, bases: Bases, excitations: &'static [Excitation]) -> Self {
        Self { bases, bounds, excitations, plan: None }
    }

    /// The same with a plan, whose number is the next after the excitations, and what it may do.
    #[must_use]
    pub fn with_plan(self, plan: &'static Plan<'static>, permitted: Permitted) -> Self {
        Self { plan: Some((plan, permitted)), ..self }
    }

    /// The initial state: nothing was typed and nothing is known.
    #[must_use]
    pub fn at_rest(&self) -> OperatorState {
        let wanted = SetPoint { position: PerUnit::ZERO, velocity: PerUnit::ZERO };
        OperatorState {
            typed_mm: None,
            garbled: false,
            command: None,
            mode: Mode::Starting,
            course: None,
            wave: None,
            play: None,
            wanted,
        }
    }

    /// Takes a character; returns what must be done now, if anything.
    ///
    /// # Errors
    /// It is not a command, or not permitted at this time; the position before it is forgotten.
    pub fn typed(&self, state: &mut OperatorState, character: u8) -> Result<Option<Errand>, OperatorError> {
        if character.is_ascii_whitespace() {
            state.garbled = false;
            return Ok(None);
        }
        if state.garbled && character != b's' {
            return Ok(None);
        }
        if character.is_ascii_digit() {
            let typed_mm = state.typed_mm.unwrap_or(0) * 10 + u32::from(character - b'0');
            state.typed_mm = Some(typed_mm.min(MOST_MM));
            return Ok(None);
        }
        let typed = state.typed_mm.take();
        let position_m = typed.map(|typed_mm| f64::from(typed_mm) * 1e-3);
        let position_m = position_m.ok_or(OperatorError::NoPosition { letter: character });
        match character {
            b'f' => Self::give(state, Command::Follow)?,
            b's' => self.stop(state),
            b'a' => Self::give(state, Command::Acknowledge)?,
            b'g' => self.go(state, position_m?)?,
            b'z' => {
                let position = PerUnit::saturated(position_m? / self.bases.stroke_m);
                if !state.mode.is_running() {
                    // Following may begin before the next period has measured this position.
                    state.wanted = SetPoint { position, velocity: PerUnit::ZERO };
                }
                return Ok(Some(Errand::Home { position }));
            }
            b'c' => {
                let step = typed.ok_or(OperatorError::NoStep)?;
                return Ok(Some(Errand::Commission { step }));
            }
            b'e' => {
                self.play(state, typed)?;
                return Ok(Some(Errand::Trigger));
            }
            b't' => return Ok(Some(Errand::Trigger)),
            b'd' => return Ok(Some(Errand::Send)),
            b'n' => return Ok(Some(Errand::Arm)),
            b'i' => return Ok(Some(Errand::IgnoreAlarms)),
            found => {
                state.garbled = true;
                return Err(OperatorError::Unknown { found });
            }
        }
        Ok(None)
    }

    /// Sets the command of the next period, which takes only one; another command cannot replace a pending stop.
    fn give(state: &mut OperatorState, command: Command) -> Result<(), OperatorError> {
        if state.command.is_some() {
            return Err(OperatorError::Pending);
        }
        state.command = Some(command);
        Ok(())
    }

    /// The number that was typed is forgotten: its letter is refused.
    pub fn forget(&self, state: &mut OperatorState) {
        state.typed_mm = None;
    }

    /// Stops in the next period, whatever else was requested for it.
    pub fn stop(&self, state: &mut OperatorState) {
        state.command = Some(Command::Stop);
    }

    /// The rod may be moved: it follows, and the last move has ended.
    fn rests(state: &OperatorState) -> Result<(), OperatorError> {
        if state.mode != Mode::Following {
            return Err(OperatorError::NotFollowing);
        }
        let moves = state.course.as_ref().is_some_and(|(course, along)| !course.is_done(along))
            || state.wave.as_ref().is_some_and(|(wave, along)| !wave.is_done(along))
            || state.play.is_some();
        if moves { Err(OperatorError::Moving) } else { Ok(()) }
    }

    fn play(&self, state: &mut OperatorState, number: Option<u32>) -> Result<(), OperatorError> {
        Self::rests(state)?;
        let index = number.and_then(|number| (number as usize).checked_sub(1));
        let from = state.wanted.position;
        if let Some(excitation) = index.and_then(|index| self.excitations.get(index)) {
            let wave = excitation.about(from, &self.bases, &self.bounds)?;
            (state.course, state.wave) = (None, Some((wave, WaveState::default())));
            return Ok(());
        }
        let most = self.excitations.len() + usize::from(self.plan.is_some());
        match &self.plan {
            Some((plan, permitted)) if index == Some(self.excitations.len()) => {
                let play = plan.at(from, permitted)?;
                (state.course, state.wave, state.play) = (None, None, Some((play, PlayState::default())));
                Ok(())
            }
            _ => Err(OperatorError::NoExcitation { most }),
        }
    }

    fn go(&self, state: &mut OperatorState, to_m: f64) -> Result<(), OperatorError> {
        Self::rests(state)?;
        // The wanted position, once rounded, may lie just beyond a bound.
        let from_m = state.wanted.position.to_f64() * self.bases.stroke_m;
        let from_m = from_m.max(self.bounds.from_m).min(self.bounds.to_m);
        let course = Course::new(&self.bases, &self.bounds, from_m, &[Leg::Fastest { to_m }])?;
        state.course = Some((course, CourseState::default()));
        state.wave = None;
        Ok(())
    }

    /// The request for the next period.
    pub fn request(&self, state: &mut OperatorState, timing: Timing) -> Request {
        if let Some((course, along)) = &mut state.course {
            state.wanted = course.step(along);
        }
        if let Some((wave, along)) = &mut state.wave {
            state.wanted = wave.step(along);
        }
        Request { set_point: state.wanted, command: state.command.take(), timing }
    }

    /// The command for the model in the next period, in units of 10 V, while a plan is played: it takes the place of the set point.
    pub fn played(&self, state: &mut OperatorState) -> Option<PerUnit> {
        let (play, along) = state.play.as_mut()?;
        let command = play.step(along);
        if command.is_none() {
            state.play = None;
        }
        command
    }

    /// Takes the report of a period: until the rod follows, its set point is its measured position.
    pub fn seen(&self, state: &mut OperatorState, report: &Report) {
        state.mode = report.mode;
        match report.mode {
            Mode::Following if state.play.is_none() => {}
            Mode::Following => state.wanted = SetPoint { velocity: PerUnit::ZERO, ..report.followed },
            Mode::Holding => {
                (state.course, state.wave, state.play) = (None, None, None);
                state.wanted = SetPoint { velocity: PerUnit::ZERO, ..report.followed };
            }
            Mode::Starting | Mode::RampingDown | Mode::Neutral => {
                (state.course, state.wave, state.play) = (None, None, None);
                state.wanted = SetPoint { position: report.measured.position, velocity: PerUnit::ZERO };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use model_core::machine::Tick;

    use super::*;
    use crate::control::Reference;
    use crate::measured::Measured;
    use crate::mock::press;
    use crate::period::Watchdog;
    use crate::supervision::ActiveFaults;

    const BOUNDS: Bounds = Bounds { from_m: 0.01, to_m: 0.29, velocity_m_per_s: 0.02, acceleration_m_per_s2: 0.2 };

    fn operator() -> Operator {
        let reference: Reference<64> = Reference::at_rest(&press(), Tick::OneMillisecond, 0.5).unwrap();
        Operator::new(BOUNDS, *reference.bases(), &crate::app::press::EXCITATIONS)
    }

    fn millimetres(operator: &Operator, position: PerUnit) -> f64 {
        position.to_f64() * operator.bases.stroke_m * 1e3
    }

    fn report(operator: &Operator, mode: Mode, position_mm: f64) -> Report {
        let position = PerUnit::saturated(position_mm * 1e-3 / operator.bases.stroke_m);
        let nothing = Measured { position, spool: None, pressure_a: None, pressure_b: None, oil_temperature: None };
        Report {
            mode,
            measured: nothing,
            read_back: None,
            predicted: None,
            command: PerUnit::ZERO,
            followed: SetPoint { position, velocity: PerUnit::ZERO },
            answer: None,
            active_faults: ActiveFaults::NONE,
            alarm: None,
            shut_off: false,
            watchdog: Watchdog::Feed,
            energised: mode.is_running(),
        }
    }

    fn type_in(operator: &Operator, state: &mut OperatorState, text: &str) -> Result<Option<Errand>, OperatorError> {
        text.bytes().map(|byte| operator.typed(state, byte)).last().unwrap()
    }

    #[test]
    fn a_command_is_given_once_and_the_rod_is_wanted_where_it_stands() {
        let operator = operator();
        let mut state = operator.at_rest();
        operator.seen(&mut state, &report(&operator, Mode::Starting, 150.0));
        assert_eq!(type_in(&operator, &mut state, "f\r\n"), Ok(None));
        let request = operator.request(&mut state, Timing::Kept);
        assert_eq!(request.command, Some(Command::Follow));
        assert!((millimetres(&operator, request.set_point.position) - 150.0).abs() < 1e-3);
        assert_eq!(operator.request(&mut state, Timing::Overrun).command, None);
    }

    #[test]
    fn the_rod_is_sent_to_a_place_and_stays_there() {
        let operator = operator();
        let mut state = operator.at_rest();
        operator.seen(&mut state, &report(&operator, Mode::Starting, 150.0));
        let following = report(&operator, Mode::Following, 151.0);
        operator.seen(&mut state, &following);
        assert_eq!(type_in(&operator, &mut state, "160g"), Ok(None));
        let way: Vec<f64> = (0..2000)
            .map(|_| {
                operator.seen(&mut state, &following);
                millimetres(&operator, operator.request(&mut state, Timing::Kept).set_point.position)
            })
            .collect();
        assert!((way[0] - 150.0).abs() < 1e-3 && (way[1999] - 160.0).abs() < 1e-3, "{} {}", way[0], way[1999]);
        assert!(way.windows(2).all(|pair| (-1e-6..=0.0201).contains(&(pair[1] - pair[0]))), "20 mm/s at most");
        // From where it has arrived, and to a bound and back.
        assert_eq!(type_in(&operator, &mut state, "290g"), Ok(None));
        assert_eq!(type_in(&operator, &mut state, "10g"), Err(OperatorError::Moving));
        for _ in 0..20_000 {
            operator.request(&mut state, Timing::Kept);
        }
        assert_eq!(type_in(&operator, &mut state, "289g"), Ok(None));
    }

    #[test]
    fn a_stop_ends_the_move_and_what_comes_after_starts_where_the_rod_is() {
        let operator = operator();
        let mut state = operator.at_rest();
        operator.seen(&mut state, &report(&operator, Mode::Starting, 100.0));
        operator.seen(&mut state, &report(&operator, Mode::Following, 100.0));
        assert_eq!(type_in(&operator, &mut state, "200g"), Ok(None));
        operator.stop(&mut state);
        assert_eq!(operator.request(&mut state, Timing::Kept).command, Some(Command::Stop));
        operator.seen(&mut state, &report(&operator, Mode::RampingDown, 123.0));
        let request = operator.request(&mut state, Timing::Kept);
        assert!((millimetres(&operator, request.set_point.position) - 123.0).abs() < 1e-3);
        assert_eq!(request.set_point.velocity, PerUnit::ZERO);
        assert_eq!(type_in(&operator, &mut state, "200g"), Err(OperatorError::NotFollowing));
    }

    #[test]
    fn a_place_that_is_none_and_a_letter_that_is_none_are_refused() {
        let operator = operator();
        let mut state = operator.at_rest();
        operator.seen(&mut state, &report(&operator, Mode::Following, 100.0));
        let refused = type_in(&operator, &mut state, "400g").unwrap_err();
        assert!(matches!(refused, OperatorError::SetPoint(SetPointError::Position { .. })), "{refused}");
        assert_eq!(type_in(&operator, &mut state, "g"), Err(OperatorError::NoPosition { letter: b'g' }));
        assert_eq!(type_in(&operator, &mut state, "12x"), Err(OperatorError::Unknown { found: b'x' }));
        assert_eq!(type_in(&operator, &mut state, "34z"), Ok(None));
        assert_eq!(type_in(&operator, &mut state, "fs"), Ok(None));
        assert_eq!(operator.request(&mut state, Timing::Kept).command, Some(Command::Stop));
        assert_eq!(type_in(&operator, &mut state, "\nz"), Err(OperatorError::NoPosition { letter: b'z' }));
        for (typed, taken) in [("sf", Command::Stop), ("sa", Command::Stop), ("af", Command::Acknowledge)] {
            assert_eq!(type_in(&operator, &mut state, typed), Err(OperatorError::Pending), "{typed}");
            assert_eq!(operator.request(&mut state, Timing::Kept).command, Some(taken), "{typed}");
        }
        let far = type_in(&operator, &mut state, "99999999999g").unwrap_err();
        assert!(matches!(far, OperatorError::SetPoint(SetPointError::Position { .. })), "{far}");
    }

    #[test]
    fn errands_are_handed_on() {
        let operator = operator();
        let mut state = operator.at_rest();
        let Ok(Some(Errand::Home { position })) = type_in(&operator, &mut state, "150z") else { panic!("no errand") };
        assert!((millimetres(&operator, position) - 150.0).abs() < 1e-3);
        assert_eq!(type_in(&operator, &mut state, "3c"), Ok(Some(Errand::Commission { step: 3 })));
        assert_eq!(type_in(&operator, &mut state, "c"), Err(OperatorError::NoStep));
        for (letter, errand) in
            [("t", Errand::Trigger), ("d", Errand::Send), ("n", Errand::Arm), ("i", Errand::IgnoreAlarms)]
        {
            assert_eq!(type_in(&operator, &mut state, letter), Ok(Some(errand)));
        }
    }
}
