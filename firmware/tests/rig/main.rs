//! Does the whole io layer work with parts that behave as their data sheets say, and does it find what can go wrong with them?

mod commissioning;
mod desk;
mod excitation;
mod failing;
mod following;
mod parts;
mod plan;
mod power;
mod runaway;
mod world;

use firmware::commissioning::Note;
use firmware::control::{Control, Predicted};
use firmware::io::Cause;
use firmware::measured::{AnalogSignal, Measured};
use firmware::monitor::Miss;
use firmware::period::{Answer, Report, Request, Timing, Watchdog};
use firmware::set_point::SetPoint;
use firmware::supervision::{Command, Device, Fault, Log, Mode};
use model_core::number::{Number, PerUnit};
use parts::{Part, WireState};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use world::{COUNTS_PER_M, GAIN_PER_V, OFFSET, OVERLAP, STROKE_M, Wired, World, simple_plant};

/// Enough to move the rod: a proportional control that jumps over the dead zone.
struct Proportional {
    neutral: PerUnit,
}

impl Proportional {
    fn new() -> Self {
        Self { neutral: PerUnit::saturated(-OFFSET / GAIN_PER_V / 10.0) }
    }
}

impl Control for Proportional {
    fn start(&mut self, _: &Measured) {}
    fn predicted(&self) -> Predicted {
        let zero = PerUnit::ZERO;
        Predicted { spool: zero, pressure_a: zero, pressure_b: zero, velocity: zero, position: zero }
    }
    fn follow(&mut self, set_point: SetPoint, measured: &Measured) -> PerUnit {
        let apart = set_point.position - measured.position;
        if apart.magnitude() < PerUnit::saturated(2e-4) {
            return self.neutral;
        }
        let overlap = PerUnit::saturated(OVERLAP / GAIN_PER_V / 10.0);
        self.neutral + apart.select_positive(overlap, -overlap) + apart + apart + apart
    }
    fn play(&mut self, command: PerUnit, _: &Measured) -> PerUnit {
        command
    }
    fn motion(&self) -> SetPoint {
        SetPoint { position: PerUnit::ZERO, velocity: PerUnit::ZERO }
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
    fn alarm(&mut self, _: &Miss) {}
    fn commissioning(&mut self, _: &Note) {}
}

/// Change of a set point in a period, of the stroke: 90 mm/s.
const PACE: f64 = 0.09e-3 / STROKE_M;

struct Bench<C> {
    world: World,
    period: Wired<C>,
    told: Told,
    /// Where the rod is wanted in the end, and the set point on its way there.
    wanted: f64,
    sent: f64,
}

impl Bench<Proportional> {
    /// Follows, and is on the way from 0 to 60 % of the stroke.
    fn on_the_way() -> Self {
        let world = World::new(simple_plant());
        let mut period = world.begin(Proportional::new());
        assert!(period.home(PerUnit::ZERO));
        let mut bench = Self { world, period, told: Told::default(), wanted: 0.0, sent: 0.0 };
        bench.run(20);
        assert_eq!(bench.step(Some(Command::Follow)).mode, Mode::Following);
        bench.wanted = 0.6;
        bench.run(1000);
        assert!(bench.world.position_m > 0.02, "{}", bench.world.position_m);
        bench
    }
}

impl<C: Control> Bench<C> {
    fn step(&mut self, command: Option<Command>) -> Report {
        self.sent += (self.wanted - self.sent).clamp(-PACE, PACE);
        self.step_to(SetPoint { position: PerUnit::saturated(self.sent), velocity: PerUnit::ZERO }, command)
    }

    fn step_to(&mut self, set_point: SetPoint, command: Option<Command>) -> Report {
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
    // The measured values are the true ones, to a step of each part.
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
        for line in [WireState::Hangs(0x00), WireState::Hangs(0xFF), WireState::Fails] {
            let mut bench = Bench::on_the_way();
            *bench.world.lines[device as usize].borrow_mut() = line;
            let report = bench.step(None);
            let [Fault::Silent { device: found, cause }] = bench.told.0[..] else { panic!("{:?}", bench.told.0) };
            assert_eq!((found, cause == Cause::Bus), (device, line == WireState::Fails), "{line:?} {cause:?}");
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
    assert!(
        matches!(bench.told.0[..], [Fault::OpenWire { signal: AnalogSignal::PressureA, .. }]),
        "{:?}",
        bench.told.0
    );
    assert_eq!(bench.run(200).unwrap().mode, Mode::Neutral);

    let mut bench = Bench::on_the_way();
    bench.world.pulled = false;
    bench.world.wired = false;
    bench.run(200);
    assert_eq!(bench.told.0, [], "2.2 V are 4.25 MPa as well");
}

#[test]
fn after_a_restart_of_the_controller_somebody_says_where_the_rod_is() {
    let mut bench = Bench::on_the_way();
    let before = bench.world.position_m;
    bench.period = bench.world.begin(Proportional::new());
    bench.world.tick();
    assert!(bench.world.dac.borrow().volts(1).unwrap().abs() < 1.0, "neutral first of all");
    bench.run(20);
    // The counter has kept its count, but the position that belongs to it is lost.
    let refused = bench.step(Some(Command::Follow));
    assert_eq!((refused.answer, refused.mode), (Some(Answer::Lost), Mode::Starting));
    assert!(bench.period.home(PerUnit::saturated(before / STROKE_M)));
    let report = bench.step(Some(Command::Follow));
    assert_eq!(report.mode, Mode::Following);
    assert!((report.measured.position.to_f64() * STROKE_M - before).abs() < 1e-3);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, rng_seed: RngSeed::Fixed(20_200), ..ProptestConfig::default() })]
    #[test]
    fn whatever_the_parts_say_nothing_panics_and_all_is_well_again_afterwards(
        disturbances in prop::collection::vec((0..3_usize, 1..u32::MAX, any::<bool>(), 1..20_u32), 1..8),
    ) {
        let mut bench = Bench::on_the_way();
        for (line, seed, fails, periods) in disturbances {
            *bench.world.lines[line].borrow_mut() = if fails { WireState::Fails } else { WireState::Noise(seed) };
            bench.run(periods);
            let volts = bench.world.dac.borrow().volts(1).unwrap();
            prop_assert!(volts.abs() <= 9.6 + 1e-3, "{volts}");
            *bench.world.lines[line].borrow_mut() = WireState::Whole;
        }
        bench.run(200);
        if bench.step(None).mode != Mode::Following {
            prop_assert_eq!(bench.step(Some(Command::Acknowledge)).mode, Mode::Starting);
            let place = PerUnit::saturated(bench.world.position_m / STROKE_M);
            prop_assert!(bench.period.home(place));
            bench.run(30);
            prop_assert_eq!(bench.step(Some(Command::Follow)).mode, Mode::Following);
        }
        let report = bench.run(20_000).unwrap();
        prop_assert_eq!(report.mode, Mode::Following);
        prop_assert!((bench.world.position_m - 0.18).abs() < 1e-4, "{}", bench.world.position_m);
    }
}
