//! A second of the press's control period over the simulated parts: the same requests, period by period, whoever runs it. The host runs it blocking;
//! `firmware/boards/mps2-embassy` awaits its buses. Both print the same rows.

use core::cell::RefCell;
use core::fmt::{self, Write};

use embedded_hal::delay::DelayNs;
use firmware::app::{Press, StationError, press};
use firmware::control::{Following, Reference};
use firmware::io::ad5754::{self, Ad5754};
use firmware::io::ads8688::Ads8688;
use firmware::io::ls7366r::{FilterClock, Ls7366r};
use firmware::io::{AnalogIn, AnalogOut};
use firmware::period::{Devices, Period, Place, Report, Request, Rig, Timing};
use firmware::set_point::{Bounds, Course, CourseState, Leg, SetPoint, SetPointError};
use firmware::supervision::Command;
use model_core::control::Follower;
use model_core::machine::Bases;
use model_core::number::{Number, PerUnit};

use crate::parts::{PLACE, Part, Parts, Plant, Wire};

/// Periods of the run, and of which one is printed.
pub const PERIODS: u32 = 1000;
const PRINTED: u32 = 50;
/// The period in which it begins to follow.
const FOLLOW: u32 = 150;

/// Why it does not run.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum RunError {
    /// The values do not become a drive that can be controlled.
    #[error(transparent)]
    Station(#[from] StationError),
    /// The moves are not valid.
    #[error(transparent)]
    Moves(#[from] SetPointError),
    /// A part does not answer as it must at the start.
    #[error("the {0:?} do not begin")]
    Part(Part),
    /// The rows cannot be written.
    #[error("the console failed")]
    Written,
}

impl From<fmt::Error> for RunError {
    fn from(_: fmt::Error) -> Self {
        Self::Written
    }
}

/// The press's wiring and limits, its control, and what 1 per unit is.
///
/// # Errors
/// The exported values do not become a drive that can be controlled.
pub fn rig() -> Result<(Rig, Press, Bases), StationError> {
    let (machine, tick) = (press::machine(), press::values::TICK);
    let reference = Reference::at_rest(&machine, tick, PLACE)?;
    let bases = *reference.bases();
    let control = Following::new(Follower::new(&machine, &press::tuning(&machine), tick)?, reference);
    let spans = (<Ads8688<Wire<'_>> as AnalogIn>::SPAN_UV, <Ad5754<Wire<'_>> as AnalogOut>::SPAN_UV);
    Ok((press::rig(&machine, &bases, spans.0, spans.1)?, control, bases))
}

/// What is asked of the period: to follow a move of 5 mm and back.
#[derive(Debug)]
pub struct Script {
    course: Course<3>,
    state: CourseState,
    wanted: SetPoint,
}

impl Script {
    /// From where the rod stands at the start.
    ///
    /// # Errors
    /// The moves do not fit the machine.
    pub fn new(bases: &Bases) -> Result<Self, SetPointError> {
        let bounds = Bounds { velocity_m_per_s: 0.03, acceleration_m_per_s2: 0.3, ..press::BOUNDS };
        let from_m = PLACE * bases.stroke_m;
        let legs =
            [Leg::Rest { duration_s: 0.05 }, Leg::Fastest { to_m: from_m + 0.005 }, Leg::Fastest { to_m: from_m }];
        let course = Course::new(bases, &bounds, from_m, &legs)?;
        let wanted = SetPoint { position: home(), velocity: PerUnit::ZERO };
        Ok(Self { course, state: CourseState::default(), wanted })
    }

    /// In this period.
    pub fn request(&mut self, period: u32, timing: Timing) -> Request {
        if period > FOLLOW && !self.course.is_done(&self.state) {
            self.wanted = self.course.step(&mut self.state);
        }
        Request { set_point: self.wanted, command: (period == FOLLOW).then_some(Command::Follow), timing }
    }
}

/// Where the rod stands at the start.
#[must_use]
pub fn home() -> PerUnit {
    PerUnit::saturated(PLACE)
}

/// What is printed of a period.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    period: u32,
    report: Report,
}

impl Row {
    /// Of this period, if it is one that is printed.
    #[must_use]
    pub fn of(period: u32, report: &Report) -> Option<Self> {
        period.is_multiple_of(PRINTED).then_some(Self { period, report: *report })
    }
}

impl fmt::Display for Row {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self { period, report } = self;
        let Report { mode, measured, command, predicted, watchdog, active_faults, .. } = report;
        let words = [Some(*command), Some(measured.position), measured.spool, measured.pressure_a, measured.pressure_b];
        let words = words.map(|word| word.map(PerUnit::to_bits));
        let predicted = predicted.map(|model| model.position.to_bits());
        write!(formatter, "{period} {mode:?} {words:?} {predicted:?} {watchdog:?} {active_faults:?}")
    }
}

/// Nothing has to be waited for.
struct AtOnce;

impl DelayNs for AtOnce {
    fn delay_ns(&mut self, _: u32) {}
}

/// Runs it blocking and writes its rows.
///
/// # Errors
/// It does not begin, or the rows cannot be written.
pub fn blocking(out: &mut impl Write) -> Result<(), RunError> {
    let (rig, control, bases) = rig()?;
    let (parts, mut script) = (RefCell::new(Parts::new()), Script::new(&bases)?);
    let mut plant = Plant::new(&press::machine()).map_err(StationError::from)?;
    let wire = |part| Wire { parts: &parts, part };
    let neutral = rig.calibration.output.count(rig.limits.neutral);
    let (channel, reference) = (ad5754::Channel::A, ad5754::Reference::External);
    let output = Ad5754::begin(wire(Part::Output), &mut AtOnce, channel, reference, neutral);
    let inputs = Ads8688::begin(wire(Part::Inputs), press::RANGES).map_err(|_| RunError::Part(Part::Inputs))?;
    let position = Ls7366r::begin(wire(Part::Counter), FilterClock::Undivided);
    let position = position.map_err(|_| RunError::Part(Part::Counter))?;
    let output = output.map_err(|_| RunError::Part(Part::Output))?;
    let begun = Period::begin(Devices { inputs, position, output }, rig, control, Place::Lost);
    let mut period = begun.map_err(|_| RunError::Part(Part::Output))?;
    plant.tick(&parts);
    period.home(home());
    for number in 1..=PERIODS {
        let report = period.step(&script.request(number, Timing::Kept), &mut ());
        plant.tick(&parts);
        if let Some(row) = Row::of(number, &report) {
            writeln!(out, "{row}")?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::string::String;

    use super::*;

    #[test]
    fn the_rod_follows_there_and_back_and_nothing_is_told() {
        let mut rows = String::new();
        blocking(&mut rows).unwrap();
        let modes = rows.lines().filter(|row| row.contains("Following")).count();
        assert_eq!(modes, 18, "{rows}");
        assert!(rows.lines().all(|row| row.contains("Feed") && !row.contains("Withhold")), "{rows}");
        let place = |number: &str| -> i64 {
            let row = rows.lines().find(|row| row.starts_with(number)).unwrap();
            row.split(['(', ')']).nth(3).unwrap().parse().unwrap()
        };
        // Bits of the stroke of 300 mm: it has been 5 mm away and is back within 0.1 mm.
        let mm = |bits: i64| bits as f64 / f64::from(1 << 28) * 300.0;
        let farthest = rows.lines().map(|row| row.split(['(', ')']).nth(3).unwrap().parse().unwrap()).max().unwrap();
        assert!((mm(farthest) - 95.0).abs() < 0.2, "{rows}");
        assert!((mm(place("1000 ")) - 90.0).abs() < 0.1, "{rows}");
    }
}
