//! What a whole control period costs: drivers, calibration, faults, model, control, monitor, recorder; without its parts.

use core::cell::RefCell;
use core::fmt::Write;
use core::hint::black_box;

use cortex_m::asm::delay;
use embedded_hal::delay::DelayNs;
use firmware::app::press::BOUNDS;
use firmware::app::{Assembly, Ring, Wired};
use firmware::io::ad5754::Ad5754;
use firmware::io::ads8688::Ads8688;
use firmware::io::{AnalogIn, AnalogOut};
use firmware::period::{Request, Timing};
use firmware::set_point::{Bounds, Course, CourseState, Leg, SetPoint, SetPointError};
use firmware::supervision::{ActiveFaults, Command, Delay, Deviation, Mode, Reach};
use model_core::machine::Machine;
use model_core::number::{Number, PerUnit};
use mps2::trial::{every_effect, press};
use mps2::{Counter, INSTRUCTIONS_PER_COUNT};
use simulated_press::parts::{PLACE, Part, Parts, Plant, Wire, ask_again};

use crate::on_target::BudgetError;

/// µV of 2¹⁶ counts of the inputs and of the output.
const INPUT_UV: u32 = <Ads8688<Wire<'static>> as AnalogIn>::SPAN_UV;
const OUTPUT_UV: u32 = <Ad5754<Wire<'static>> as AnalogOut>::SPAN_UV;

/// The firmware did not do what should be counted.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub(crate) enum SceneError {
    /// It is in an unexpected mode.
    #[error("{scene}: the mode is {found:?}; {active_faults:?}")]
    Mode { scene: &'static str, found: Mode, active_faults: ActiveFaults },
    /// The moves are not valid.
    #[error(transparent)]
    Moves(#[from] SetPointError),
}

/// Counts of a scene.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    sum: u32,
    periods: u32,
    worst: u32,
}

impl Cost {
    fn written(&self, out: &mut impl Write, name: &str) -> core::fmt::Result {
        let [mean, worst] = [self.sum * INSTRUCTIONS_PER_COUNT / self.periods, self.worst * INSTRUCTIONS_PER_COUNT];
        writeln!(out, "period {mean:>6} {worst:>6} {name}")
    }
}

struct Waits;

impl DelayNs for Waits {
    fn delay_ns(&mut self, nanoseconds: u32) {
        delay(nanoseconds / INSTRUCTIONS_PER_COUNT);
    }
}

struct Bench<'a> {
    station: Wired<'a, Wire<'a>, Wire<'a>, Wire<'a>>,
    parts: &'a RefCell<Parts>,
    plant: Plant,
    counter: &'a mut Counter,
    wanted: SetPoint,
    /// Faults that nobody has acknowledged.
    active_faults: ActiveFaults,
    cost: Cost,
}

/// Everything is watched and nothing is told: the plant lacks most of the effects that a model here has.
const WIDE: Deviation = Deviation {
    position: Some(Delay { by: 0.2, for_s: 0.05 }),
    velocity: Some(Delay { by: 0.5, for_s: 0.05 }),
    spool: Some(Delay { by: 2.0, for_s: 0.05 }),
    range: Some(Reach { from_m: 0.0, to_m: 0.3 }),
    rest: Some(Delay { by: 0.2, for_s: 0.1 }),
    alarm: None,
};

impl<'a> Bench<'a> {
    /// A controller whose model of the press is `model`.
    fn begin(
        model: &Machine<f64>,
        parts: &'a RefCell<Parts>,
        counter: &'a mut Counter,
        memory: &'a mut Option<Ring>,
    ) -> Result<Self, BudgetError> {
        let wire = |part| Wire { parts, part };
        let [inputs, output, counts] = [Part::Inputs, Part::Output, Part::Counter].map(wire);
        let assembly = Assembly::of(model, INPUT_UV, OUTPUT_UV)?.deviating(&WIDE)?;
        let mut station = assembly.wired(inputs, counts, output, &mut Waits, memory)?;
        let mut plant = Plant::new(&press())?;
        plant.tick(parts);
        parts.borrow_mut().forget();
        let place = PerUnit::saturated(PLACE);
        station.home(place);
        let wanted = SetPoint { position: place, velocity: PerUnit::ZERO };
        Ok(Self { station, parts, plant, counter, wanted, active_faults: ActiveFaults::NONE, cost: Cost::default() })
    }

    /// A period, counted.
    fn period(&mut self, command: Option<Command>, timing: Timing) -> Mode {
        let request = black_box(Request { set_point: self.wanted, command, timing });
        let (mut mode, mut active_faults) = (Mode::Starting, ActiveFaults::NONE);
        let whole = self.counter.counts(|| {
            let report = black_box(self.station.step(&request, &mut ()));
            (mode, active_faults) = (report.mode, report.active_faults);
        });
        self.active_faults = active_faults;
        let parts = self.counter.counts(|| ask_again(self.parts));
        self.parts.borrow_mut().forget();
        let own = whole.saturating_sub(parts);
        self.cost.sum += own;
        self.cost.periods += 1;
        self.cost.worst = self.cost.worst.max(own);
        self.plant.tick(self.parts);
        mode
    }

    fn periods(&mut self, count: usize) -> Mode {
        (0..count).map(|_| self.period(None, Timing::Kept)).last().unwrap_or(Mode::Starting)
    }

    /// Where the rod is, at rest.
    fn here(&self) -> SetPoint {
        SetPoint { position: self.station.predicted().position, velocity: PerUnit::ZERO }
    }

    /// What has been counted since the last time.
    fn cost(&mut self, scene: &'static str, found: Mode, expected: Mode) -> Result<Cost, SceneError> {
        let cost = core::mem::take(&mut self.cost);
        if found == expected {
            Ok(cost)
        } else {
            Err(SceneError::Mode { scene, found, active_faults: self.active_faults })
        }
    }

    /// Four moves and the rests after them.
    fn moves(&mut self) -> Result<Mode, SceneError> {
        let bounds = Bounds { velocity_m_per_s: 0.03, acceleration_m_per_s2: 0.3, ..BOUNDS };
        let from_m = 0.3 * PLACE;
        let legs = [
            Leg::Rest { duration_s: 0.2 },
            Leg::Fastest { to_m: from_m + 0.02 },
            Leg::Fastest { to_m: from_m - 0.01 },
            Leg::Smooth { to_m: from_m, duration_s: 0.8 },
            Leg::Rest { duration_s: 0.3 },
        ];
        let course = Course::<5>::new(self.station.bases(), &bounds, from_m, &legs)?;
        let (mut state, mut mode) = (CourseState::default(), Mode::Starting);
        while !course.is_done(&state) {
            self.wanted = course.step(&mut state);
            mode = self.period(None, Timing::Kept);
        }
        Ok(mode)
    }

    /// A fault that lasts for a while, then its cause removed, and the return to following.
    fn fault(&mut self, silent: Option<Part>, timing: Timing) -> Mode {
        self.parts.borrow_mut().silent = silent;
        for _ in 0..40 {
            self.period(None, timing);
        }
        self.parts.borrow_mut().silent = None;
        self.periods(300);
        self.period(Some(Command::Acknowledge), Timing::Kept);
        self.wanted = self.here();
        self.station.home(self.wanted.position);
        self.periods(120);
        self.period(Some(Command::Follow), Timing::Kept)
    }
}

pub(crate) fn report(
    counter: &mut Counter,
    memory: &mut Option<Ring>,
    out: &mut impl Write,
) -> Result<(), BudgetError> {
    let parts = RefCell::new(Parts::new());
    let mut bench = Bench::begin(&press(), &parts, counter, memory)?;
    let mode = bench.periods(500);
    bench.cost("waiting", mode, Mode::Starting)?.written(out, "waiting")?;
    let mode = bench.period(Some(Command::Follow), Timing::Kept);
    bench.cost("begins", mode, Mode::Following)?.written(out, "begins to follow")?;
    let mode = bench.moves()?;
    bench.cost("following", mode, Mode::Following)?.written(out, "following")?;
    for (silent, timing) in [
        (Some(Part::Inputs), Timing::Kept),
        (Some(Part::Output), Timing::Kept),
        (Some(Part::Counter), Timing::Kept),
        (None, Timing::Overrun),
    ] {
        let mode = bench.fault(silent, timing);
        bench.cost = bench.cost("faults", mode, Mode::Following)?;
    }
    bench.cost("faults", Mode::Following, Mode::Following)?.written(out, "faults and the way back")?;

    let parts = RefCell::new(Parts::new());
    let mut bench = Bench::begin(&every_effect(&press()), &parts, counter, memory)?;
    bench.periods(200);
    bench.period(Some(Command::Follow), Timing::Kept);
    bench.cost = Cost::default();
    let mode = bench.moves()?;
    bench.cost("every effect", mode, Mode::Following)?.written(out, "following, every effect")?;
    Ok(())
}
