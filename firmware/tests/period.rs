//! Does every fault have its state in time, and does nothing but a command lead back? One rig of closures, whole periods.

use std::cell::RefCell;
use std::rc::Rc;

use firmware::calibration::{Actuator, Band, Calibration, Point, Sensor};
use firmware::control::Control;
use firmware::edge::{AnalogIn, AnalogOut, Cause, FromFn, PositionIn};
use firmware::fault::{Device, Fault, Response};
use firmware::limits::{Limits, LimitsError};
use firmware::log::Log;
use firmware::measured::{Measured, Signal};
use firmware::mode::{Command, Mode};
use firmware::period::{Answer, BeginError, Devices, Period, Place, Report, Request, Rig, Timing, Watchdog};
use firmware::reference::{Predicted, Reference};
use firmware::set_point::SetPoint;
use firmware::still::Patience;
use firmware::travel::{Encoder, Rising, Travel};
use model_core::fixed_point::PerUnit;
use model_core::machine::{Bases, Machine, Source, Tick};
use model_core::number::Number;
use model_core::parameter::Parameter;
use proptest::prelude::*;

const INPUTS_UV: u32 = 5_120_000;
const OUTPUT_UV: u32 = 20_000_000;
/// Counts of 78.125 µV in a volt.
const VOLT: i32 = 12_800;
/// Counts of the encoder over the stroke.
const STROKE: i32 = 21_600;

/// Everything outside of the firmware.
#[derive(Clone, Debug)]
struct World {
    count: i32,
    voltages: [i32; 4],
    position_silent: bool,
    inputs_silent: bool,
    output_silent: bool,
    asked: u32,
    written: i32,
    predicted: Predicted,
    wanted: PerUnit,
    started: u32,
}

impl World {
    fn new() -> Self {
        let zero = PerUnit::ZERO;
        Self {
            count: 0,
            // Read back: neutral.  Slider in the middle; pressures of 2.5 and 3 V.
            voltages: [-6172 * 128 / 1000, 0, 5 * VOLT / 2, 3 * VOLT],
            position_silent: false,
            inputs_silent: false,
            output_silent: false,
            asked: 0,
            written: 0,
            predicted: Predicted { slider: zero, pressure_a: zero, pressure_b: zero, velocity: zero, position: zero },
            wanted: neutral(),
            started: 0,
        }
    }
}

type Shared = Rc<RefCell<World>>;

/// A control that wants whatever the test does.
struct Wanting(Shared);

impl Control for Wanting {
    fn start(&mut self, measured: &Measured) {
        let mut world = self.0.borrow_mut();
        world.started += 1;
        world.predicted.position = measured.position;
    }
    fn predicted(&self) -> Predicted {
        self.0.borrow().predicted
    }
    fn follow(&mut self, _: SetPoint, _: &Measured) -> PerUnit {
        self.0.borrow().wanted
    }
    fn accompany(&mut self, _: PerUnit, _: &Measured) {}
}

/// Keeps what it is told.
#[derive(Default)]
struct Told {
    faults: Vec<Fault>,
    modes: Vec<(Mode, Mode)>,
}

impl Log for Told {
    fn fault(&mut self, fault: &Fault) {
        self.faults.push(*fault);
    }
    fn mode(&mut self, from: Mode, to: Mode) {
        self.modes.push((from, to));
    }
}

fn percent(value: i32) -> PerUnit {
    PerUnit::saturated(f64::from(value) / 100.0)
}

/// −0.0345/0.0559 V: the middle of the press's dead zone.
fn neutral() -> PerUnit {
    PerUnit::saturated(-0.061_72)
}

fn limits() -> Limits {
    let patience = |travel, periods| Some(Patience { travel: percent(travel), periods });
    Limits {
        attempts: 3,
        settling: 5,
        least_position: percent(0),
        most_position: percent(100),
        most_velocity: percent(150),
        most_jump: percent(10),
        neutral: neutral(),
        most_command: percent(95),
        slew: percent(5),
        ramp: percent(2),
        still_position: patience(2, 50),
        still: [None, patience(5, 40), patience(5, 60), patience(5, 60), None],
        read_back: patience(3, 4),
    }
}

fn bases() -> Bases {
    let mut machine = Machine::with_defaults(Source::Valve);
    machine.set(Parameter::AreaA, 3.117e-3);
    machine.set(Parameter::AreaB, 1.861e-3);
    machine.set(Parameter::VolumeA, 5.2e-4);
    machine.set(Parameter::VolumeB, 3.3e-4);
    *Reference::<64>::at_rest(&machine, Tick::OneMillisecond, 0.5).unwrap().bases()
}

fn rig(limits: Limits) -> Rig {
    let band = |from_v, to_v| Band { from_v, to_v };
    let ten_volts = |channel, value: f64| Sensor {
        channel,
        low: Point { volts: -10.0, value: -value },
        high: Point { volts: 10.0, value },
        working: band(-9.9, 9.9),
        open: Some(band(10.1, 10.3)), // 100 kΩ to +15 V
    };
    let pressure = |channel| Sensor {
        channel,
        low: Point { volts: 0.5, value: 0.0 },
        high: Point { volts: 4.5, value: 1e7 },
        working: band(0.4, 4.6),
        open: Some(band(-0.1, 0.3)), // 100 kΩ to ground
    };
    let sensors = [
        (Signal::Command, ten_volts(0, 10.0)),
        (Signal::Slider, ten_volts(1, 1.0)),
        (Signal::PressureA, pressure(2)),
        (Signal::PressureB, pressure(3)),
    ];
    let actuator = Actuator { zero_v: 0.0, full_v: 10.0, lowest_v: -9.6, highest_v: 9.6 };
    let encoder = Encoder { counts_per_m: 72_000.0, rising: Rising::Extends, reference_m: 0.0, fastest_m_per_s: 0.5 };
    let bases = bases();
    Rig {
        calibration: Calibration::new(&sensors, INPUTS_UV, &actuator, OUTPUT_UV, &bases).unwrap(),
        travel: Travel::straight(&encoder, &bases).unwrap(),
        limits,
    }
}

fn devices(world: &Shared) -> Devices<impl AnalogIn + use<>, impl PositionIn + use<>, impl AnalogOut + use<>> {
    let (inputs, position, output) = (world.clone(), world.clone(), world.clone());
    Devices {
        inputs: FromFn::<_, INPUTS_UV>(move |channel: u8| {
            let mut world = inputs.borrow_mut();
            world.asked += 1;
            if world.inputs_silent { Err("no clock") } else { Ok(world.voltages[usize::from(channel)]) }
        }),
        position: FromFn::<_>(move || {
            let mut world = position.borrow_mut();
            world.asked += 1;
            if world.position_silent { Err("no clock") } else { Ok(world.count) }
        }),
        output: FromFn::<_, OUTPUT_UV>(move |count: i32| {
            let mut world = output.borrow_mut();
            world.asked += 1;
            if world.output_silent {
                return Err("no clock");
            }
            world.written = count;
            // The wire back.  A count of the output is 305.2 µV, one of the inputs 78.1 µV.
            world.voltages[0] = i32::try_from(i64::from(count) * 20_000_000 / 5_120_000).unwrap();
            Ok(())
        }),
    }
}

/// One rig, its world, and what it told.
struct Bench {
    world: Shared,
    period: Box<dyn Steps>,
    told: Told,
    request: Request,
}

/// `Period` without its types.
trait Steps {
    fn step(&mut self, request: &Request, log: &mut Told) -> Report;
    fn refer(&mut self, position: PerUnit) -> bool;
}

impl<A: AnalogIn, P: PositionIn, O: AnalogOut, C: Control> Steps for Period<A, P, O, C> {
    fn step(&mut self, request: &Request, log: &mut Told) -> Report {
        Period::step(self, request, log)
    }
    fn refer(&mut self, position: PerUnit) -> bool {
        Period::refer(self, position)
    }
}

impl Bench {
    fn new() -> Self {
        let world = Rc::new(RefCell::new(World::new()));
        let period = Period::begin(devices(&world), rig(limits()), Wanting(world.clone()), Place::Known).unwrap();
        let set_point = SetPoint { position: PerUnit::ZERO, velocity: PerUnit::ZERO };
        let request = Request { set_point, command: None, timing: Timing::Kept };
        Self { world, period: Box::new(period), told: Told::default(), request }
    }

    /// The rod follows, at 30 % of the stroke, and the valve is open.
    fn following() -> Self {
        let mut bench = Self::new();
        bench.travel(STROKE * 3 / 10);
        bench.request.set_point.position = percent(30);
        bench.follow();
        bench.world.borrow_mut().wanted = percent(50);
        bench.run(50);
        assert_eq!(bench.command(None).command, percent(50));
        assert_eq!(bench.told.faults, []);
        bench.told = Told::default();
        bench
    }

    /// The rod travels by so many counts, no faster than it can.
    fn travel(&mut self, counts: i32) {
        for _ in 0..counts / 30 {
            self.world.borrow_mut().count += 30;
            self.command(None);
        }
    }

    fn follow(&mut self) {
        assert_eq!(self.command(Some(Command::Follow)).mode, Mode::Following);
    }

    fn command(&mut self, command: Option<Command>) -> Report {
        self.request.command = command;
        let report = self.period.step(&self.request, &mut self.told);
        self.request.command = None;
        report
    }

    /// Sensors move by a count to and fro, as working ones do.
    fn run(&mut self, periods: u16) -> Report {
        let mut report = self.command(None);
        for period in 1..periods {
            let noise = i32::from(period % 2) * 2 - 1;
            {
                let mut world = self.world.borrow_mut();
                world.count += noise;
                world.voltages.iter_mut().skip(1).for_each(|volts| *volts += noise);
            }
            report = self.command(None);
        }
        report
    }
}

/// A fault as it is brought about, and what it must be.
struct Case {
    name: &'static str,
    bring: fn(&mut World, &mut Request),
    is: fn(&Fault) -> bool,
    /// Mode in the period that finds it.
    mode: Mode,
    /// Periods in which it must be found.
    within: u16,
    watchdog: Watchdog,
}

const CASES: [Case; 15] = [
    Case {
        name: "pressure above its sensor's range",
        bring: |world, _| world.voltages[2] = 5 * VOLT,
        is: |fault| *fault == Fault::OutOfRange { signal: Signal::PressureA, count: 64_000 },
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "pressure's wire open, pulled to ground",
        bring: |world, _| world.voltages[3] = VOLT / 5,
        is: |fault| *fault == Fault::OpenWire { signal: Signal::PressureB, count: 2560 },
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "slider's wire open, pulled to the rail",
        bring: |world, _| world.voltages[1] = 131_068, // 10.24 V
        is: |fault| matches!(fault, Fault::OpenWire { signal: Signal::Slider, .. }),
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "slider stuck",
        bring: |world, _| world.predicted.slider = percent(20),
        is: |fault| matches!(fault, Fault::Stuck { signal: Signal::Slider, .. }),
        mode: Mode::RampingDown,
        within: 41,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "pressure stuck",
        bring: |world, _| world.predicted.pressure_a = percent(70),
        is: |fault| matches!(fault, Fault::Stuck { signal: Signal::PressureA, .. }),
        mode: Mode::RampingDown,
        within: 61,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "position stuck",
        bring: |world, _| world.predicted.position = percent(40),
        is: |fault| matches!(fault, Fault::PositionStuck { .. }),
        mode: Mode::Neutral,
        within: 51,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "encoder jump",
        bring: |world, _| world.count += 400,
        is: |fault| matches!(fault, Fault::EncoderJump { counts: 399..=401 }),
        mode: Mode::Neutral,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "inputs silent",
        bring: |world, _| world.inputs_silent = true,
        is: |fault| *fault == Fault::Silent { device: Device::Inputs, cause: Cause::Bus },
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Withhold,
    },
    Case {
        name: "counter silent",
        bring: |world, _| world.position_silent = true,
        is: |fault| *fault == Fault::Silent { device: Device::Position, cause: Cause::Bus },
        mode: Mode::Neutral,
        within: 1,
        watchdog: Watchdog::Withhold,
    },
    Case {
        name: "output silent",
        bring: |world, _| world.output_silent = true,
        is: |fault| *fault == Fault::Silent { device: Device::Output, cause: Cause::Bus },
        mode: Mode::Neutral,
        within: 1,
        watchdog: Watchdog::Withhold,
    },
    Case {
        name: "overrun",
        bring: |_, request| request.timing = Timing::Overrun,
        is: |fault| *fault == Fault::Overrun,
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Withhold,
    },
    Case {
        name: "set point beyond the stroke",
        bring: |_, request| request.set_point.position = percent(101),
        is: |fault| matches!(fault, Fault::SetPointOutside { .. }),
        mode: Mode::Holding,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "set point too fast",
        bring: |_, request| request.set_point.velocity = percent(-700),
        is: |fault| matches!(fault, Fault::SetPointOutside { .. }),
        mode: Mode::Holding,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "set point jumps",
        bring: |_, request| request.set_point.position = percent(45),
        is: |fault| *fault == Fault::SetPointJump { from: percent(30), to: percent(45) },
        mode: Mode::Holding,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "another voltage at the valve",
        // The wire back is cut where the output writes it, so the world overwrites it period by period: see the test.
        bring: |world, _| world.voltages[0] = VOLT,
        is: |fault| matches!(fault, Fault::OutputAway { .. }),
        mode: Mode::Neutral,
        within: 6,
        watchdog: Watchdog::Feed,
    },
];

#[test]
fn every_fault_has_its_state_in_time_is_told_once_and_goes_by_command_only() {
    for Case { name, bring, is, mode, within, watchdog } in CASES {
        let mut bench = Bench::following();
        let before = (bench.world.borrow().clone(), bench.request);
        let mut report = None;
        for _ in 0..within {
            {
                let mut world = bench.world.borrow_mut();
                if report.is_none() || name.contains("voltage") {
                    bring(&mut world, &mut bench.request);
                }
            }
            report = Some(bench.command(None));
            if !bench.told.faults.is_empty() {
                break;
            }
        }
        let report = report.unwrap();
        assert!(matches!(bench.told.faults[..], [ref fault] if is(fault)), "{name}: {:?}", bench.told.faults);
        assert!(report.standing.has(&bench.told.faults[0]), "{name}");
        assert_eq!((report.mode, report.watchdog), (mode, watchdog), "{name}");
        if mode == Mode::Neutral {
            assert_eq!(report.command, neutral(), "{name}");
        }

        // It stands on: nothing new is told, and a ramp arrives in its time.
        let arrives = u16::try_from(limits().periods_to_neutral()).unwrap();
        for _ in 0..arrives {
            if name.contains("voltage") {
                bench.world.borrow_mut().voltages[0] = VOLT;
            }
            bench.command(None);
        }
        let settled = if mode == Mode::Holding { Mode::Holding } else { Mode::Neutral };
        assert_eq!((bench.command(None).mode, bench.told.faults.len()), (settled, 1), "{name}");

        // Its cause goes: still nothing changes but by command.
        let count = bench.world.borrow().count;
        let voltage = bench.world.borrow().voltages[0];
        *bench.world.borrow_mut() = World { count, ..before.0 };
        bench.world.borrow_mut().voltages[0] = voltage;
        bench.request = before.1;
        assert_eq!(bench.run(300).mode, settled, "{name}");
        assert_eq!(bench.command(Some(Command::Follow)).mode, settled, "{name}");
        let acknowledged = bench.command(Some(Command::Acknowledge));
        assert_eq!(acknowledged.answer, Some(Answer::Taken), "{name}");
        assert!(acknowledged.standing.is_empty(), "{name}");
        if settled == Mode::Neutral {
            assert_eq!(acknowledged.mode, Mode::Starting, "{name}");
            if bench.told.faults[0].loses_place() {
                assert_eq!(bench.command(Some(Command::Follow)).answer, Some(Answer::Lost), "{name}");
                assert!(bench.period.refer(percent(30)));
            }
            bench.follow();
        }
        assert_eq!(bench.run(20).mode, Mode::Following, "{name}");
        assert_eq!(bench.told.faults.len(), 1, "{name}: {:?}", bench.told.faults);

        // The same again is told again.
        {
            let mut world = bench.world.borrow_mut();
            bring(&mut world, &mut bench.request);
        }
        for _ in 0..within {
            if name.contains("voltage") {
                bench.world.borrow_mut().voltages[0] = VOLT;
            }
            bench.command(None);
        }
        assert_eq!(bench.told.faults.len(), 2, "{name}: {:?}", bench.told.faults);
    }
}

#[test]
fn a_device_that_answers_at_its_last_attempt_is_no_fault() {
    let world = Rc::new(RefCell::new(World::new()));
    let mut calls = 0;
    let devices = devices(&world);
    let counter = world.clone();
    let position = FromFn::<_>(move || {
        calls += 1;
        if calls % 3 == 0 { Ok(counter.borrow().count) } else { Err("disturbed") }
    });
    let devices = Devices { inputs: devices.inputs, position, output: devices.output };
    let mut period = Period::begin(devices, rig(limits()), Wanting(world), Place::Known).unwrap();
    let set_point = SetPoint { position: PerUnit::ZERO, velocity: PerUnit::ZERO };
    let request = Request { set_point, command: None, timing: Timing::Kept };
    let mut told = Told::default();
    for _ in 0..100 {
        assert_eq!(period.step(&request, &mut told).watchdog, Watchdog::Feed);
    }
    assert_eq!(told.faults, []);
}

#[test]
fn silent_inputs_cost_their_attempts_once_a_period() {
    let mut bench = Bench::following();
    bench.world.borrow_mut().inputs_silent = true;
    bench.world.borrow_mut().asked = 0;
    let report = bench.command(None);
    // One count, three attempts at the first voltage, one write.
    assert_eq!(bench.world.borrow().asked, 5);
    let measured = report.measured;
    assert_eq!((measured.slider, measured.pressure_a, measured.pressure_b), (None, None, None));
}

#[test]
fn following_begins_where_the_rod_is_without_a_bump() {
    let mut bench = Bench::new();
    bench.travel(STROKE / 2);
    let waiting = bench.command(None);
    assert_eq!((waiting.mode, waiting.command, waiting.predicted), (Mode::Starting, neutral(), None));
    bench.request.set_point.position = waiting.measured.position;
    bench.follow();
    assert_eq!(bench.world.borrow().started, 1);
    let first = bench.command(None);
    assert_eq!(first.command, neutral());
    assert_eq!(first.predicted.map(|predicted| predicted.position), Some(waiting.measured.position));
}

#[test]
fn following_from_far_away_holds_the_rod_where_it_is() {
    let mut bench = Bench::new();
    bench.travel(STROKE / 2);
    bench.request.set_point.position = percent(80);
    let report = bench.command(Some(Command::Follow));
    assert_eq!((report.mode, report.command), (Mode::Holding, neutral()));
    assert!(matches!(bench.told.faults[..], [Fault::SetPointJump { .. }]));
}

#[test]
fn commands_are_refused_while_a_fault_is_there_or_the_sensors_have_not_settled() {
    let mut bench = Bench::new();
    for _ in 0..4 {
        assert_eq!(bench.command(Some(Command::Follow)).answer, Some(Answer::Unsettled));
    }
    assert_eq!(bench.command(Some(Command::Follow)).answer, Some(Answer::Taken));
    bench.world.borrow_mut().inputs_silent = true;
    bench.run(100);
    let refused = bench.command(Some(Command::Acknowledge));
    assert_eq!((refused.mode, refused.answer), (Mode::Neutral, Some(Answer::Faulty)));
    assert_eq!(bench.command(Some(Command::Stop)).answer, Some(Answer::Taken));
}

#[test]
fn after_a_fault_the_sensors_settle_anew() {
    let mut bench = Bench::following();
    bench.world.borrow_mut().count += 400;
    assert_eq!(bench.command(None).mode, Mode::Neutral);
    assert_eq!(bench.command(Some(Command::Acknowledge)).mode, Mode::Starting);
    bench.request.set_point.position = percent(32);
    for _ in 0..3 {
        assert_eq!(bench.command(Some(Command::Follow)).answer, Some(Answer::Unsettled));
    }
    assert!(bench.period.refer(percent(32)));
    bench.follow();
}

#[test]
fn a_rod_that_nobody_knows_the_place_of_does_not_follow() {
    let world = Rc::new(RefCell::new(World::new()));
    let begun = Period::begin(devices(&world), rig(limits()), Wanting(world.clone()), Place::Lost);
    let mut bench = Bench { period: Box::new(begun.unwrap()), world, ..Bench::new() };
    bench.run(10);
    assert_eq!(bench.command(Some(Command::Follow)).answer, Some(Answer::Lost));
    assert!(bench.period.refer(percent(70)));
    assert_eq!(bench.command(None).measured.position, percent(70));
    bench.request.set_point.position = percent(70);
    bench.follow();
    assert!(!bench.period.refer(percent(10)), "not while the valve may be open");
}

#[test]
fn a_stop_ramps_to_neutral_within_its_periods() {
    let mut bench = Bench::following();
    let mut last = bench.command(Some(Command::Stop)).command;
    assert_eq!(last, percent(48));
    let mut periods = 1;
    while last != neutral() {
        let next = bench.command(None).command;
        assert!(last - next <= percent(2) && next < last);
        last = next;
        periods += 1;
    }
    assert!(periods <= limits().periods_to_neutral());
    assert_eq!(bench.command(None).mode, Mode::Neutral);
    assert_eq!(bench.told.faults, []);
}

#[test]
fn more_severe_faults_overtake_and_less_severe_ones_do_not_soften() {
    let mut bench = Bench::following();
    bench.request.set_point.position = percent(101);
    assert_eq!(bench.command(None).mode, Mode::Holding);
    bench.world.borrow_mut().voltages[2] = 5 * VOLT;
    assert_eq!(bench.command(None).mode, Mode::RampingDown);
    bench.world.borrow_mut().position_silent = true;
    assert_eq!(bench.command(None).mode, Mode::Neutral);
    bench.world.borrow_mut().position_silent = false;
    assert_eq!(bench.command(None).mode, Mode::Neutral);
    let steps =
        [(Mode::Following, Mode::Holding), (Mode::Holding, Mode::RampingDown), (Mode::RampingDown, Mode::Neutral)];
    assert_eq!(bench.told.modes, steps);
}

#[test]
fn the_valve_is_neutral_before_anything_else_and_a_rig_without_a_counter_does_not_begin() {
    let world = Rc::new(RefCell::new(World::new()));
    world.borrow_mut().position_silent = true;
    let refused = Period::begin(devices(&world), rig(limits()), Wanting(world.clone()), Place::Known).err();
    assert!(matches!(refused, Some(BeginError::Position(_))));
    assert_eq!(world.borrow().written, -2022); // −0.6172 V
    let none = Limits { ramp: PerUnit::ZERO, ..limits() };
    let refused = Period::begin(devices(&world), rig(none), Wanting(world), Place::Known).err();
    let named = LimitsError::NotPositive { name: "ramp", value: PerUnit::ZERO };
    assert!(matches!(refused, Some(BeginError::Limits(error)) if error == named));
}

/// Anything at all, in one period.
#[derive(Clone, Debug)]
struct Anything {
    count: i32,
    voltages: [i32; 4],
    silent: [bool; 3],
    predicted: [i32; 4],
    wanted: i32,
    set_point: [i32; 2],
    command: Option<Command>,
    overrun: bool,
    refer: bool,
}

/// Mostly what a sound rig gives, so that every mode is reached; sometimes anything.
fn anything() -> impl Strategy<Value = Anything> {
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
            |((count, voltages, silent), (predicted, wanted, position, velocity), (command, overrun, refer))| {
                Anything {
                    count,
                    voltages,
                    silent,
                    predicted,
                    wanted,
                    set_point: [position, velocity],
                    command,
                    overrun,
                    refer,
                }
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn whatever_comes_the_output_keeps_its_limits_and_faults_their_states(steps in prop::collection::vec(anything(), 1..250)) {
        let limits = Limits { settling: 1, read_back: None, least_position: percent(-50), ..limits() };
        let world = Rc::new(RefCell::new(World::new()));
        let mut period = Period::begin(devices(&world), rig(limits), Wanting(world.clone()), Place::Known).unwrap();
        let [lowest, highest] = rig(limits).calibration.output.limits();
        let (mut mode, mut last, mut ramping) = (Mode::Starting, limits.neutral, 0);
        let mut place = PerUnit::ZERO;
        for step in steps {
            {
                let mut world = world.borrow_mut();
                let [position_silent, inputs_silent, output_silent] = step.silent;
                let [slider, pressure_a, pressure_b, position] = step.predicted.map(PerUnit::from_bits);
                *world = World {
                    count: world.count.wrapping_add(step.count),
                    voltages: step.voltages,
                    position_silent,
                    inputs_silent,
                    output_silent,
                    predicted: Predicted { slider, pressure_a, pressure_b, velocity: PerUnit::ZERO, position },
                    wanted: PerUnit::from_bits(step.wanted),
                    ..*world
                };
            }
            let [from_place, velocity] = step.set_point.map(PerUnit::from_bits);
            let position = place + from_place;
            let timing = if step.overrun { Timing::Overrun } else { Timing::Kept };
            let request = Request { set_point: SetPoint { position, velocity }, command: step.command, timing };
            if step.refer {
                period.refer(place);
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

            // A fault is answered in its period.
            if let Some(worst) = told.faults.iter().map(Fault::response).max() {
                match worst {
                    Response::Hold => prop_assert_ne!(report.mode, Mode::Following),
                    Response::RampDown => prop_assert!(matches!(report.mode, Mode::RampingDown | Mode::Neutral)),
                    Response::Neutral => prop_assert_eq!(report.mode, Mode::Neutral),
                }
            }
            let own = step.overrun || step.silent.contains(&true);
            prop_assert_eq!(report.watchdog == Watchdog::Withhold, own);

            // A ramp arrives in its time, and nothing but a command leads back.
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
