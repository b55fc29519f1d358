//! Does the whole edge work with parts that behave as their data sheets say, and does it find what can go wrong with them?

mod parts;

use std::cell::RefCell;
use std::rc::Rc;

use firmware::ads8688::{Ads8688, Range};
use firmware::calibration::{Actuator, Band, Calibration, Point, Sensor};
use firmware::control::Control;
use firmware::dac::{Ad5754, Channel, Reference};
use firmware::edge::{AnalogIn, AnalogOut, Cause};
use firmware::fault::{Device, Fault};
use firmware::limits::{Allowed, Delay, Limits};
use firmware::log::Log;
use firmware::ls7366r::{FilterClock, Ls7366r, Origin};
use firmware::measured::{Measured, Signal};
use firmware::mode::{Command, Mode};
use firmware::period::{Devices, Period, Place, Report, Request, Rig, Timing, Watchdog};
use firmware::reference::Predicted;
use firmware::set_point::SetPoint;
use firmware::travel::{Encoder, Rising, Travel};
use model_core::drive::Drive;
use model_core::fixed_point::PerUnit;
use model_core::machine::{Machine, Source, Tick};
use model_core::number::Number;
use model_core::parameter::Parameter;
use parts::{Adc, Counter, Dac, Line, Wire};

/// Counts of the encoder a metre: 3600 impulses, counted fourfold, on a pinion of 0.2 m circumference.
const COUNTS_PER_M: f64 = 72_000.0;
const STROKE_M: f64 = 0.3;
/// Valve: travel per volt and at none, overlap; rod: m/s per opening.
const GAIN_PER_V: f64 = 0.0559;
const OFFSET: f64 = 0.0345;
const OVERLAP: f64 = 0.1049;
const SPEED_M_PER_S: f64 = 0.2;

/// The parts, and the machine that they are wired to: a valve with overlap, and a rod as fast as it is open.
struct World {
    adc: Rc<RefCell<Adc>>,
    counter: Rc<RefCell<Counter>>,
    dac: Rc<RefCell<Dac>>,
    lines: [Rc<RefCell<Line>>; 3],
    bytes: Rc<RefCell<usize>>,
    position_m: f64,
    edges: i64,
    ticks: u32,
    /// Whether the wire of pressure A is whole.
    wired: bool,
    /// Whether 100 kΩ to ground are at its input.
    pulled: bool,
}

type Wired = Period<Ads8688<Wire<Adc>>, Ls7366r<Wire<Counter>>, Ad5754<Wire<Dac>>, Proportional>;

impl World {
    fn new() -> Self {
        let line = || Rc::new(RefCell::new(Line::Whole));
        let mut world = Self {
            adc: Rc::new(RefCell::new(Adc::new())),
            counter: Rc::new(RefCell::new(Counter::new())),
            dac: Rc::new(RefCell::new(Dac::new())),
            lines: [line(), line(), line()],
            bytes: Rc::default(),
            position_m: 0.0,
            edges: 0,
            ticks: 0,
            wired: true,
            pulled: true,
        };
        world.tick();
        world
    }

    fn wire<P>(&self, part: &Rc<RefCell<P>>, line: usize) -> Wire<P> {
        Wire { part: part.clone(), line: self.lines[line].clone(), bytes: self.bytes.clone() }
    }

    /// One millisecond of the machine.
    fn tick(&mut self) {
        self.ticks += 1;
        // A valve whose wire carries nothing is held by its spring.
        let volts = self.dac.borrow().volts(1);
        let slider = volts.map_or(0.0, |volts| GAIN_PER_V * volts + OFFSET);
        let opening = slider.signum() * (slider.abs() - OVERLAP).max(0.0);
        self.position_m = (self.position_m + opening * SPEED_M_PER_S * 1e-3).clamp(0.0, STROKE_M);
        #[expect(clippy::cast_possible_truncation, reason = "some 20 000 over the stroke")]
        let edges = (self.position_m * COUNTS_PER_M).round() as i64;
        self.counter.borrow_mut().turn(i32::try_from(edges - self.edges).unwrap());
        self.edges = edges;
        // Sensors never give just the same twice.
        let noise_v = f64::from(self.ticks % 2) * 6e-4;
        let pressure_a_v = 2.5 + noise_v;
        let open_v = if self.pulled { Some(0.2) } else { None };
        let pressure_a = if self.wired { Some(pressure_a_v) } else { open_v };
        self.adc.borrow_mut().inputs_v =
            [volts, Some(slider * 10.0 + noise_v), pressure_a, Some(3.0 + noise_v), None, None, None, None];
    }

    fn begin(&self) -> (Wired, Origin) {
        let machine = machine();
        let drive = Drive::<PerUnit>::new::<64>(&machine, Tick::OneMillisecond).unwrap();
        let bases = drive.bases();
        let ranges = [
            Some(Range::Bipolar10V),
            Some(Range::Bipolar10V),
            Some(Range::Unipolar5V),
            Some(Range::Unipolar5V),
            None,
            None,
            None,
            None,
        ];
        let limits = Limits::new(&allowed(), &machine, bases).unwrap();
        let calibration = Calibration::new(
            &sensors(),
            <Ads8688<Wire<Adc>> as AnalogIn>::SPAN_UV,
            &Actuator { zero_v: 0.0, full_v: 10.0, lowest_v: -9.6, highest_v: 9.6 },
            <Ad5754<Wire<Dac>> as AnalogOut>::SPAN_UV,
            bases,
        )
        .unwrap();
        let encoder =
            Encoder { counts_per_m: COUNTS_PER_M, rising: Rising::Extends, reference_m: 0.0, fastest_m_per_s: 0.5 };
        let travel = Travel::straight(&encoder, bases).unwrap();
        let delay = &mut embedded_hal_mock::eh1::delay::NoopDelay::new();
        let neutral = calibration.output.count(limits.neutral);
        let output = Ad5754::begin(self.wire(&self.dac, 2), delay, Channel::B, Reference::External, neutral).unwrap();
        let inputs = Ads8688::begin(self.wire(&self.adc, 0), ranges).unwrap();
        let (position, origin) = Ls7366r::resume(self.wire(&self.counter, 1), FilterClock::Undivided).unwrap();
        let control = Proportional { neutral: limits.neutral };
        let rig = Rig { calibration, travel, limits };
        let place = if origin == Origin::Kept { Place::Known } else { Place::Lost };
        (Period::begin(Devices { inputs, position, output }, rig, control, place).unwrap(), origin)
    }
}

fn machine() -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Valve);
    machine.set(Parameter::AreaA, 3.117e-3);
    machine.set(Parameter::AreaB, 1.861e-3);
    machine.set(Parameter::VolumeA, 5.2e-4);
    machine.set(Parameter::VolumeB, 3.3e-4);
    machine.set(Parameter::Stroke, STROKE_M);
    machine.set(Parameter::ValveGain, GAIN_PER_V);
    machine.set(Parameter::ValveOffset, OFFSET);
    machine.set(Parameter::DeadZone, OVERLAP);
    machine
}

fn allowed() -> Allowed {
    Allowed {
        attempts: 3,
        settling_s: 0.02,
        from_m: 0.0,
        to_m: STROKE_M,
        velocity_m_per_s: 0.1,
        jump_m: 0.3,
        command_v: 9.5,
        slew_v_per_s: 1000.0,
        ramp_v_per_s: 100.0,
        still_position: None,
        still_slider: None,
        still_pressure: None,
        read_back: Some(Delay { by: 0.05, for_s: 0.005 }),
    }
}

fn sensors() -> [(Signal, Sensor); 4] {
    let volts = |volts, value| Point { volts, value };
    let pressure = |channel| Sensor {
        channel,
        low: volts(0.5, 0.0),
        high: volts(4.5, 1e7),
        working: Band { from_v: 0.4, to_v: 4.6 },
        open: Some(Band { from_v: 0.0, to_v: 0.3 }),
    };
    let ten_volts = |channel, value: f64| Sensor {
        channel,
        low: volts(-10.0, -value),
        high: volts(10.0, value),
        working: Band { from_v: -10.1, to_v: 10.1 },
        open: None,
    };
    [
        (Signal::Command, ten_volts(0, 10.0)),
        (Signal::Slider, ten_volts(1, 1.0)),
        (Signal::PressureA, pressure(2)),
        (Signal::PressureB, pressure(3)),
    ]
}

/// Enough to move the rod: proportional, with the overlap jumped.
struct Proportional {
    neutral: PerUnit,
}

impl Control for Proportional {
    fn start(&mut self, _: &Measured) {}
    fn predicted(&self) -> Predicted {
        let zero = PerUnit::ZERO;
        Predicted { slider: zero, pressure_a: zero, pressure_b: zero, velocity: zero, position: zero }
    }
    fn follow(&mut self, set_point: SetPoint, measured: &Measured) -> PerUnit {
        let apart = set_point.position - measured.position;
        if apart.magnitude() < PerUnit::saturated(2e-4) {
            return self.neutral;
        }
        let overlap = PerUnit::saturated(OVERLAP / GAIN_PER_V / 10.0);
        self.neutral + apart.select_positive(overlap, -overlap) + apart + apart + apart
    }
    fn accompany(&mut self, _: PerUnit, _: &Measured) {}
}

#[derive(Default)]
struct Told(Vec<Fault>);

impl Log for Told {
    fn fault(&mut self, fault: &Fault) {
        self.0.push(*fault);
    }
    fn mode(&mut self, _: Mode, _: Mode) {}
}

struct Bench {
    world: World,
    period: Wired,
    told: Told,
    wanted: f64,
}

impl Bench {
    /// Follows, on its way from 0 to 60 % of the stroke.
    fn on_the_way() -> Self {
        let world = World::new();
        let (mut period, origin) = world.begin();
        assert_eq!(origin, Origin::Cleared);
        assert!(period.refer(PerUnit::ZERO));
        let mut bench = Self { world, period, told: Told::default(), wanted: 0.0 };
        bench.run(20);
        assert_eq!(bench.step(Some(Command::Follow)).mode, Mode::Following);
        bench.wanted = 0.6;
        bench.run(1000);
        assert!(bench.world.position_m > 0.02, "{}", bench.world.position_m);
        bench
    }

    fn step(&mut self, command: Option<Command>) -> Report {
        let set_point = SetPoint { position: PerUnit::saturated(self.wanted), velocity: PerUnit::ZERO };
        let report = self.period.step(&Request { set_point, command, timing: Timing::Kept }, &mut self.told);
        self.world.tick();
        report
    }

    fn run(&mut self, periods: u32) -> Option<Report> {
        (0..periods).map(|_| self.step(None)).last()
    }
}

#[test]
fn the_rod_goes_where_it_is_wanted_through_every_part() {
    let mut bench = Bench::on_the_way();
    let report = bench.run(20_000).unwrap();
    assert_eq!((report.mode, report.watchdog), (Mode::Following, Watchdog::Feed));
    assert_eq!(bench.told.0, []);
    assert!((bench.world.position_m - 0.18).abs() < 1e-4, "{}", bench.world.position_m);
    // What is measured is what is there, to a step of each part.
    let position = report.measured.position.to_f64() * STROKE_M;
    assert!((position - bench.world.position_m).abs() <= 1.0 / COUNTS_PER_M);
    let pressure = report.measured.pressure_a.unwrap().to_f64();
    assert!((pressure - 5.0 / 7.0).abs() < 3e-4, "{pressure}");
}

#[test]
fn a_period_with_four_voltages_is_40_bytes_on_the_bus() {
    // 4 conversions of 6, status and count of 2 and 5, code, question and answer of 3 each.
    let mut bench = Bench::on_the_way();
    *bench.world.bytes.borrow_mut() = 0;
    bench.step(None);
    assert_eq!(*bench.world.bytes.borrow(), 40);
}

#[test]
fn parts_that_lose_their_supply_are_found_in_the_next_period() {
    let adc: (fn(&World), _, _) = (|world| world.adc.borrow_mut().lose_power(), Device::Inputs, Mode::RampingDown);
    let counter: (fn(&World), _, _) =
        (|world| world.counter.borrow_mut().lose_power(), Device::Position, Mode::Neutral);
    let dac: (fn(&World), _, _) = (|world| world.dac.borrow_mut().lose_power(), Device::Output, Mode::Neutral);
    for (lose, device, mode) in [adc, counter, dac] {
        let mut bench = Bench::on_the_way();
        lose(&bench.world);
        let report = bench.step(None);
        assert!(
            matches!(bench.told.0[..], [Fault::Silent { device: found, .. }] if found == device),
            "{:?}",
            bench.told.0
        );
        assert_eq!((report.mode, report.watchdog), (mode, Watchdog::Withhold));
    }
}

#[test]
fn lines_that_hang_or_fail_are_found_in_their_period() {
    for (device, mode) in
        [(Device::Inputs, Mode::RampingDown), (Device::Position, Mode::Neutral), (Device::Output, Mode::Neutral)]
    {
        for line in [Line::Hangs(0x00), Line::Hangs(0xFF), Line::Fails] {
            let mut bench = Bench::on_the_way();
            *bench.world.lines[device as usize].borrow_mut() = line;
            let report = bench.step(None);
            let [Fault::Silent { device: found, cause }] = bench.told.0[..] else { panic!("{:?}", bench.told.0) };
            assert_eq!((found, cause == Cause::Bus), (device, line == Line::Fails), "{line:?} {cause:?}");
            assert_eq!((report.mode, report.watchdog), (mode, Watchdog::Withhold));
        }
    }
}

#[test]
fn a_shorted_output_is_found_in_its_period() {
    let mut bench = Bench::on_the_way();
    bench.world.dac.borrow_mut().shorted = Some(1);
    assert_eq!(bench.step(None).mode, Mode::Neutral);
    assert_eq!(bench.told.0, [Fault::Silent { device: Device::Output, cause: Cause::Overloaded }]);
}

#[test]
fn an_open_wire_is_found_where_a_resistor_pulls_it_out_of_the_range_and_not_where_it_floats() {
    let mut bench = Bench::on_the_way();
    bench.world.wired = false;
    bench.run(2);
    assert!(matches!(bench.told.0[..], [Fault::OpenWire { signal: Signal::PressureA, .. }]), "{:?}", bench.told.0);
    assert_eq!(bench.run(200).unwrap().mode, Mode::Neutral);

    let mut bench = Bench::on_the_way();
    bench.world.pulled = false;
    bench.world.wired = false;
    bench.run(200);
    assert_eq!(bench.told.0, [], "2.2 V are 4.25 MPa as well");
}

#[test]
fn a_restart_of_the_controller_alone_goes_on_where_the_rod_is() {
    let mut bench = Bench::on_the_way();
    let before = bench.world.position_m;
    let (period, origin) = bench.world.begin();
    assert_eq!(origin, Origin::Kept);
    bench.period = period;
    bench.world.tick();
    assert!(bench.world.dac.borrow().volts(1).unwrap().abs() < 1.0, "neutral first of all");
    bench.run(20);
    let report = bench.step(Some(Command::Follow));
    assert_eq!(report.mode, Mode::Following);
    assert!((report.measured.position.to_f64() * STROKE_M - before).abs() < 1e-3);
}
