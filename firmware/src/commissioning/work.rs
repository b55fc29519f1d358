//! What each step does in a period, and its verdict.

use model_core::number::{Number, PerUnit};

use super::check;
use super::direction::Direction;
use super::reading::{Expected, Reading, Refusal, Way, What};
use super::rules::{READ_BACK_MV, Rules, Seen};
use super::step::{Note, Step};
use crate::measured::AnalogSignal;
use crate::period::{InputVoltage, Place, Report};
use crate::set_point::{Bounds, Course, CourseState, Leg, SetPointError};
use crate::supervision::{Fault, Log};

/// Voltages beyond neutral that the third step puts out, µV.
const VOLTAGES_UV: [i32; 6] = [0, 500_000, -500_000, 1_000_000, -1_000_000, 0];
/// Periods from a voltage to its first judgement: fewer than the limits leave until it is a fault.
const ANSWERED: u32 = 2;
/// Periods for which each voltage is put out.
const HELD: u32 = 50;
/// How far the rod may move while it is said to rest, µm.
const CREEP_UM: i32 = 100;
/// The small step of the tuning check, and the rest at its ends.
const STEP_M: f64 = 5e-3;
const STEP_REST_S: f64 = 0.5;

/// What a step remembers.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Work {
    NoOil {
        most_kpa: Option<[i32; 2]>,
    },
    /// Lowest and highest voltage of each signal.
    Voltages {
        seen: [Option<[InputVoltage; 2]>; AnalogSignal::COUNT],
    },
    Output,
    Place {
        bounds_um: [i32; 2],
        between_um: Option<[i32; 2]>,
    },
    Direction(Direction),
    Follow {
        course: Course<4>,
        along: CourseState,
        most_um: i32,
    },
}

/// What a period shows of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now<'a> {
    pub(super) step: Step,
    /// Periods since it began to work.
    pub(super) since: u32,
    pub(super) report: &'a Report,
    /// The report of the last period.
    pub(super) before: Option<&'a Report>,
    /// The voltage that was asked for.
    pub(super) input: Option<Result<InputVoltage, Refusal>>,
    pub(super) place: Place,
}

/// The lower and the higher.
fn widened(ends: Option<[i32; 2]>, value: i32) -> [i32; 2] {
    ends.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)])
}

impl Work {
    /// A step that begins where the rod is, within these bounds.
    pub(super) fn of(step: Step, rules: &Rules, last: &Report, bounds: &Bounds) -> Result<Self, SetPointError> {
        let bases = &rules.bases;
        let position_m = f64::from(rules.micrometres(last.measured.position)) * 1e-6;
        // Towards the middle there is room.
        let out = position_m < 0.5 * (bounds.from_m + bounds.to_m);
        Ok(match step {
            Step::NoOil => Work::NoOil { most_kpa: None },
            Step::Voltages => Work::Voltages { seen: [None; AnalogSignal::COUNT] },
            Step::Output => Work::Output,
            Step::Place => {
                let um = |at_m: f64| rules.micrometres(PerUnit::saturated(at_m / bases.stroke_m));
                Work::Place { bounds_um: [um(bounds.from_m), um(bounds.to_m)], between_um: None }
            }
            Step::Direction => Work::Direction(Direction::new(if out { Way::Extends } else { Way::Retracts })),
            Step::Tuning | Step::Limits => {
                let from_m = position_m.max(bounds.from_m).min(bounds.to_m);
                let to_m = if out { from_m + STEP_M } else { from_m - STEP_M };
                let rest = Leg::Rest { duration_s: STEP_REST_S };
                let legs = [Leg::Fastest { to_m }, rest, Leg::Fastest { to_m: from_m }, rest];
                let course = Course::new(bases, bounds, from_m, &legs)?;
                Work::Follow { course, along: CourseState::default(), most_um: 0 }
            }
        })
    }

    /// The voltage that is put out in place of the loops', µV beyond neutral.
    pub(super) fn by_hand(&self, since: u32) -> Option<i32> {
        match self {
            Work::Output => VOLTAGES_UV.get((since / HELD) as usize).copied(),
            Work::Direction(direction) => Some(direction.hand_uv()),
            Work::NoOil { .. } | Work::Voltages { .. } | Work::Place { .. } | Work::Follow { .. } => None,
        }
    }

    /// A period of the step; the verdict, once there is one.
    pub(super) fn seen(&mut self, rules: &Rules, now: &Now<'_>, log: &mut impl Log) -> Option<Result<(), Refusal>> {
        let Now { step, since, report, before, input, place } = *now;
        let seen = rules.seen(report);
        let ended = since >= rules.rest;
        match self {
            Work::NoOil { most_kpa } => {
                if let Some([a, b]) = seen.pressures_kpa {
                    *most_kpa = Some(most_kpa.map_or([a, b], |most| [most[0].max(a), most[1].max(b)]));
                }
                ended.then(|| without_oil(rules, step, *most_kpa, log))
            }
            Work::Voltages { seen } => {
                match input {
                    Some(Err(refusal)) => return Some(Err(refusal)),
                    Some(Ok(found)) => note_voltage(seen, found),
                    None => {}
                }
                ended.then(|| voltages(step, seen, log))
            }
            Work::Output => put_out(rules, since, &seen, before?, log),
            Work::Place { bounds_um, between_um } => {
                let between = widened(*between_um, seen.position_um);
                *between_um = Some(between);
                if place == Place::Lost {
                    return Some(Err(Refusal::Lost));
                }
                ended.then(|| {
                    let expected = Expected::Between(bounds_um[0], bounds_um[1]);
                    check(log, step, Reading { what: What::Position, found: seen.position_um, expected })?;
                    let (found, expected) = (between[1] - between[0], Expected::AtMost(CREEP_UM));
                    check(log, step, Reading { what: What::Creep, found, expected })
                })
            }
            Work::Direction(direction) => {
                let stuck = Fault::PositionStuck { position: report.measured.position };
                // The encoder stands, and the model's rod has gone.
                let stands = report.active_faults.has(&stuck).then(|| Err(direction.rod(seen.position_um)));
                stands.or_else(|| direction.seen(rules, &seen, log))
            }
            Work::Follow { course, along, most_um } => {
                let Some(limit) = rules.error_um else { return Some(Err(Refusal::Unwatched)) };
                if step == Step::Limits && !rules.watched {
                    return Some(Err(Refusal::Unwatched));
                }
                if let Some(before) = before {
                    let off = seen.position_um - rules.micrometres(before.followed.position);
                    *most_um = off.abs().max(*most_um);
                }
                let expected = Expected::AtMost(limit);
                let reading = Reading { what: What::FollowingError, found: *most_um, expected };
                if !reading.holds() {
                    return Some(Err(Refusal::Value(reading)));
                }
                course.is_done(along).then(|| check(log, step, reading))
            }
        }
    }
}

/// The third step: each voltage is judged as soon as it must be there, before it is a fault, and told when its time is over.
fn put_out(rules: &Rules, since: u32, seen: &Seen, before: &Report, log: &mut impl Log) -> Option<Result<(), Refusal>> {
    let (voltage, held) = (since.checked_sub(1)? / HELD, (since - 1) % HELD);
    if VOLTAGES_UV.get(voltage as usize).is_none() {
        return Some(Ok(()));
    }
    let Some(found) = seen.read_back_mv else { return Some(Err(Refusal::NotReadBack)) };
    if held < ANSWERED {
        return None;
    }
    let most_kpa = seen.pressures_kpa.filter(|most| most.iter().any(|&kpa| kpa > rules.no_oil_kpa));
    if most_kpa.is_some() {
        return Some(without_oil(rules, Step::Output, most_kpa, log));
    }
    let (put_out, off) = (rules.millivolts(before.command), READ_BACK_MV);
    let reading = Reading { what: What::ReadBack, found, expected: Expected::Between(put_out - off, put_out + off) };
    if !reading.holds() {
        return Some(Err(Refusal::Value(reading)));
    }
    if held == HELD - 1 {
        log.commissioning(&Note::Measured(Step::Output, reading));
    }
    None
}

/// The first step's verdict; without sensors there is only the operator's word.
fn without_oil(rules: &Rules, step: Step, most_kpa: Option<[i32; 2]>, log: &mut impl Log) -> Result<(), Refusal> {
    let expected = Expected::AtMost(rules.no_oil_kpa);
    let Some([a, b]) = most_kpa else { return Ok(()) };
    check(log, step, Reading { what: What::PressureA, found: a, expected })?;
    check(log, step, Reading { what: What::PressureB, found: b, expected })
}

fn note_voltage(seen: &mut [Option<[InputVoltage; 2]>; AnalogSignal::COUNT], found: InputVoltage) {
    if let Some(ends) = seen.get_mut(found.signal as usize) {
        let [mut low, mut high] = ends.unwrap_or([found; 2]);
        low.found_mv = low.found_mv.min(found.found_mv);
        high.found_mv = high.found_mv.max(found.found_mv);
        *ends = Some([low, high]);
    }
}

/// The second step's verdict: of each input both ends of what was read.
fn voltages(
    step: Step,
    seen: &[Option<[InputVoltage; 2]>; AnalogSignal::COUNT],
    log: &mut impl Log,
) -> Result<(), Refusal> {
    for InputVoltage { signal, found_mv, from_mv, to_mv } in seen.iter().flatten().flatten() {
        let (what, expected) = (What::Input(*signal), Expected::Between(*from_mv, *to_mv));
        check(log, step, Reading { what, found: *found_mv, expected })?;
    }
    Ok(())
}
