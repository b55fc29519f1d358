//! Model-following control through every part, around a machine that is not quite the model.

use firmware::control::{Following, Reference};
use firmware::period::{Report, Watchdog};
use firmware::set_point::{Course, CourseState, Leg, SetPoint};
use firmware::supervision::{Command, Fault, Mode};
use model_core::control::{Follower, Tuning};
use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::machine::{Machine, Parameter, Tick};
use model_core::number::{Number, PerUnit};
use model_core::ports::ChamberState;

use crate::world::{BOUNDS, Plant, STROKE_M, Seen, World, machine};
use crate::{Bench, Told};

/// A move to 60 % of the stroke.
const OUT: Leg = Leg::Smooth { to_m: 0.18, duration_s: 3.0 };
/// As a share of the stroke.
pub(crate) const START: f64 = 0.4;

/// The press in f64, at rest at [`START`].
pub(crate) fn plant(machine: &Machine<f64>) -> Plant {
    let drive = Drive::<f64>::new::<64>(machine, Tick::OneMillisecond).unwrap();
    let bases = *drive.bases();
    let ratio = machine.get(Parameter::AreaB) / machine.get(Parameter::AreaA);
    let load = machine.get(Parameter::LoadForce) / bases.force_n;
    let pressures = ChamberState { a: 0.5 * ratio - load, b: 0.5 };
    let neutral = -machine.get(Parameter::ValveOffset) / machine.get(Parameter::ValveGain) / bases.command_v;
    let mut state: DriveState<f64, 64> = drive.at_rest(neutral, pressures, START);
    Box::new(move |volts| {
        drive.step(&mut state, DriveInput::Command(volts.unwrap_or(0.0) / bases.command_v), Load::NONE);
        Seen {
            spool: drive.spool(&state),
            position_m: state.motion.position * bases.stroke_m,
            pressure_a_pa: state.chambers.a * bases.pressure_pa,
            pressure_b_pa: state.chambers.b * bases.pressure_pa,
        }
    })
}

/// The press as the model describes it.
pub(crate) fn press() -> Machine<f64> {
    let mut machine = machine();
    machine.set(Parameter::RateLimit, 12.0);
    machine.set(Parameter::TimeConstant1, 0.018);
    machine.set(Parameter::TimeConstant2, 0.0279);
    machine.set(Parameter::TransportDelay, 0.007);
    machine.set(Parameter::FlowLimit, 3e-4);
    machine.set(Parameter::ViscousFriction, 1e5);
    machine
}

/// Begins at rest, and follows as soon as this is permitted.
fn bench(real: &Machine<f64>) -> Bench<Following<64>> {
    let tick = Tick::OneMillisecond;
    let reference = Reference::at_rest(&press(), tick, 0.5).unwrap();
    let follower = Follower::new(&press(), &Tuning::by_rule(&press(), true), tick).unwrap();
    let world = World::new(plant(real));
    let mut period = world.begin(Following::new(follower, reference));
    assert!(period.home(PerUnit::saturated(START)));
    let mut bench = Bench { world, period, told: Told::default(), wanted: START, sent: START };
    bench.run(20);
    bench
}

/// Largest distance between rod and set point, m, and the last report.
fn drive_along(bench: &mut Bench<Following<64>>, leg: Leg) -> (f64, Report) {
    let bases = *bench.period.control().reference().bases();
    let course = Course::<1>::new(&bases, &BOUNDS, START * STROKE_M, &[leg]).unwrap();
    let mut state = CourseState::default();
    let (mut farthest, mut report) = (0.0_f64, bench.step(None));
    while !course.is_done(&state) {
        let wanted: SetPoint = course.step(&mut state);
        report = bench.step_to(wanted, None);
        farthest = farthest.max((wanted.position.to_f64() * STROKE_M - bench.world.position_m).abs());
    }
    (farthest, report)
}

#[test]
fn following_begins_without_a_bump_and_stays_at_rest() {
    let mut bench = bench(&press());
    let before = bench.world.position_m;
    let first = bench.step(Some(Command::Follow));
    assert_eq!(first.mode, Mode::Following);
    bench.wanted = first.measured.position.to_f64();
    for _ in 0..1000 {
        let report = bench.step(None);
        assert!((report.command - first.command).magnitude() < PerUnit::saturated(0.2), "{:?}", report.command);
        assert!((bench.world.position_m - before).abs() < 5e-5, "{}", bench.world.position_m - before);
    }
    assert_eq!(bench.told.0, []);
}

#[test]
fn the_rod_follows_a_move_through_every_part() {
    for load_n in [0.0, 5000.0] {
        let mut real = press();
        real.set(Parameter::LoadForce, load_n);
        real.set(Parameter::ViscousFriction, 0.8e5);
        let mut bench = bench(&real);
        assert_eq!(bench.step(Some(Command::Follow)).mode, Mode::Following);
        let (farthest, report) = drive_along(&mut bench, OUT);
        assert_eq!((report.mode, report.watchdog), (Mode::Following, Watchdog::Feed));
        assert_eq!(bench.told.0, []);
        // 0.07 mm; a count of the encoder is 0.014 mm.
        println!("{load_n} N: {:.3} mm at most", farthest * 1e3);
        assert!(farthest < 0.2e-3, "{load_n} N: {farthest} m");
    }
}

#[test]
fn an_encoder_that_lost_its_coupling_stops_the_rod_before_it_went_far() {
    let mut bench = bench(&press());
    bench.step(Some(Command::Follow));
    bench.world.sense = 0;
    let (_, report) = drive_along(&mut bench, OUT);
    assert!(matches!(bench.told.0[..], [Fault::PositionStuck { .. }]), "{:?}", bench.told.0);
    assert_eq!((report.mode, report.watchdog), (Mode::Neutral, Watchdog::Feed));
    let went_m = bench.world.position_m - START * STROKE_M;
    // 2 mm, 20 ms, the loop's push meanwhile and the valve's lags give 9 mm.
    println!("{:.1} mm", went_m * 1e3);
    assert!(went_m < 0.012, "{went_m} m");
}
