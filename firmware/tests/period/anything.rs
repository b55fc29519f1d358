//! Whatever the input is: limits of the output, faults and their modes, the way back.

use std::cell::RefCell;
use std::rc::Rc;

use firmware::control::Predicted;
use firmware::period::{Period, Place, Request, Timing, Watchdog};
use firmware::set_point::{Bounds, Envelope, SetPoint};
use firmware::supervision::{Command, Delay, Deviation, DeviationLimits, Fault, Limits, Mode, Response};
use model_core::number::{Number, PerUnit};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::bench::{STROKE, Told, Wanting, World, bases, deviation, devices, limits, percent, rig};

/// Any values at all, in one period.
#[derive(Clone, Debug)]
pub(crate) struct Anything {
    count: i32,
    voltages: [i32; 4],
    silent: [bool; 3],
    predicted: [i32; 4],
    wanted: i32,
    set_point: [i32; 2],
    command: Option<Command>,
    overrun: bool,
    pub(crate) home: bool,
}

impl Anything {
    /// The world becomes so.
    pub(crate) fn enter(&self, world: &mut World) {
        let [position_silent, inputs_silent, output_silent] = self.silent;
        let [spool, pressure_a, pressure_b, position] = self.predicted.map(PerUnit::from_bits);
        *world = World {
            count: world.count.wrapping_add(self.count),
            voltages: self.voltages,
            position_silent,
            inputs_silent,
            output_silent,
            predicted: Predicted { spool, pressure_a, pressure_b, velocity: PerUnit::ZERO, position },
            spool_off: Some(spool),
            wanted: PerUnit::from_bits(self.wanted),
            ..*world
        };
    }

    /// What is asked of the period while the rod is at this place.
    pub(crate) fn request(&self, place: PerUnit) -> Request {
        let [from_place, velocity] = self.set_point.map(PerUnit::from_bits);
        let timing = if self.overrun { Timing::Overrun } else { Timing::Kept };
        let set_point = SetPoint { position: place + from_place, velocity };
        Request { set_point, command: self.command, timing }
    }
}

/// Wide limits, so that most set points are followed.
pub(crate) fn wide() -> Limits {
    let bases = bases();
    let bounds = Bounds { from_m: 0.0, to_m: bases.stroke_m, velocity_m_per_s: 100.0, acceleration_m_per_s2: 1e5 };
    let near = |by, for_s| Some(Delay { by, for_s });
    let deviation = Deviation {
        position: near(0.02 * bases.stroke_m, 3e-3),
        velocity: near(0.5, 5e-3),
        spool: near(0.9, 2e-3),
        rest: near(2e-3, 5e-3),
        ..deviation()
    };
    Limits {
        settling: 1,
        read_back: None,
        envelope: Envelope::new(&bounds, &bases, 0.0).unwrap(),
        deviation: DeviationLimits::new(&deviation, &bases).unwrap(),
        ..limits()
    }
}

/// Mostly what a healthy rig gives, so that every mode is reached; sometimes anything.
pub(crate) fn anything() -> impl Strategy<Value = Anything> {
    let seldom = || prop::bool::weighted(0.006);
    let count = prop_oneof![200 => -3..=3_i32, 1 => any::<i32>()];
    let voltage = || prop_oneof![300 => 6_000..50_000_i32, 1 => any::<i32>()];
    let word = || prop_oneof![200 => -(1_i32 << 28)..1 << 28, 1 => any::<i32>()];
    let position = prop_oneof![100 => -(1_i32 << 23)..1 << 23, 1 => any::<i32>()];
    let command = prop_oneof![
        30 => Just(None),
        10 => Just(Some(Command::Follow)),
        1 => Just(Some(Command::Stop)),
        10 => Just(Some(Command::Acknowledge)),
    ];
    (
        (count, [voltage(), voltage(), voltage(), voltage()], [seldom(), seldom(), seldom()]),
        ([word(), word(), word(), word()], word(), position, word()),
        (command, seldom(), prop::bool::weighted(0.1)),
    )
        .prop_map(
            |((count, voltages, silent), (predicted, wanted, position, velocity), (command, overrun, home))| Anything {
                count,
                voltages,
                silent,
                predicted,
                wanted,
                set_point: [position, velocity],
                command,
                overrun,
                home,
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, rng_seed: RngSeed::Fixed(20_200), ..ProptestConfig::default() })]
    #[test]
    fn whatever_comes_the_output_keeps_its_limits_and_faults_their_states(steps in prop::collection::vec(anything(), 1..250)) {
        let limits = wide();
        let world = Rc::new(RefCell::new(World { count: STROKE / 2, ..World::new() }));
        let mut period = Period::begin(devices(&world), rig(limits), Wanting(world.clone()), Place::Known).unwrap();
        let [lowest, highest] = rig(limits).calibration.output.limits();
        let (mut mode, mut last, mut ramping) = (Mode::Starting, limits.neutral, 0);
        let mut place = percent(50);
        for step in steps {
            step.enter(&mut world.borrow_mut());
            let request = step.request(place);
            if step.home {
                period.home(percent(50));
            }
            let mut told = Told::default();
            let report = period.step(&request, &mut told);
            place = report.measured.position;

            // Size and slope of the output.
            prop_assert!(report.command.magnitude() <= limits.most_command);
            prop_assert!((lowest..=highest).contains(&world.borrow().written));
            let changed = (report.command - last).magnitude();
            match report.mode {
                Mode::Following | Mode::Holding => prop_assert!(changed <= limits.slew),
                Mode::RampingDown => prop_assert!(changed <= limits.ramp),
                Mode::Starting | Mode::Neutral => prop_assert_eq!(report.command, limits.neutral),
            }

            // A fault takes effect in its period.
            if let Some(worst) = told.faults.iter().map(Fault::response).max() {
                match worst {
                    Response::Hold => prop_assert_ne!(report.mode, Mode::Following),
                    Response::RampDown => prop_assert!(matches!(report.mode, Mode::RampingDown | Mode::Neutral)),
                    Response::Neutral => prop_assert_eq!(report.mode, Mode::Neutral),
                }
            }
            let own = step.overrun || step.silent.contains(&true);
            prop_assert_eq!(report.watchdog == Watchdog::Withhold, own);

            // A ramp arrives in its time, and only a command leads back.
            ramping = if report.mode == Mode::RampingDown { ramping + 1 } else { 0 };
            prop_assert!(ramping <= limits.periods_to_neutral());
            let back = match (mode, report.mode) {
                (Mode::Starting, Mode::Following) => step.command == Some(Command::Follow),
                (Mode::Holding, Mode::Following) | (Mode::Neutral, Mode::Starting) => step.command == Some(Command::Acknowledge),
                (Mode::RampingDown, now) => matches!(now, Mode::RampingDown | Mode::Neutral),
                (Mode::Neutral, now) => now == Mode::Neutral,
                (before, Mode::Starting) => before == Mode::Starting,
                _ => true,
            };
            prop_assert!(back, "{mode:?} → {:?} by {:?}", report.mode, step.command);
            (mode, last) = (report.mode, report.command);
        }
    }
}
