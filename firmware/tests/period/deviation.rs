//! What the period does about deviations, alarms, set points that stop, and counts that cannot be.

use std::cell::RefCell;
use std::rc::Rc;

use firmware::app::press::SENSITIVITY;
use firmware::io::FromFn;
use firmware::monitor::Monitor;
use firmware::period::{Answer, Devices, Period, Place, Report, Request, Rig, Timing, Watchdog};
use firmware::set_point::{Bounds, Envelope, SetPoint};
use firmware::supervision::{Command, Delay, Deviation, DeviationLimits, Fault, Limits, Mode, Response};
use model_core::number::{Number, PerUnit};

use crate::bench::{Bench, STROKE, Told, Wanting, World, bases, deviation, devices, limits, percent, rig};

fn deviating(stated: &Deviation) -> Limits {
    Limits { deviation: DeviationLimits::new(stated, &bases()).unwrap(), ..limits() }
}

/// One period in which a count is wrong in so many of its readings; the attempts are 3.
fn miscounted(readings: u32) -> (Report, Vec<Fault>) {
    let world = Rc::new(RefCell::new(World { count: 7000, ..World::new() }));
    let wrong = Rc::new(RefCell::new(0_u32));
    let (devices, counter, left) = (devices(&world), world.clone(), wrong.clone());
    let position = FromFn::<_>(move || {
        let mut left = left.borrow_mut();
        let flipped = if *left > 0 { 1 << 20 } else { 0 };
        *left = left.saturating_sub(1);
        Ok::<i32, &str>(counter.borrow().count ^ flipped)
    });
    let devices = Devices { inputs: devices.inputs, position, output: devices.output };
    let mut period = Period::begin(devices, rig(limits()), Wanting(world), Place::Known).unwrap();
    let set_point = SetPoint { position: PerUnit::ZERO, velocity: PerUnit::ZERO };
    let request = Request { set_point, command: None, timing: Timing::Kept };
    let mut told = Told::default();
    period.step(&request, &mut told);
    *wrong.borrow_mut() = readings;
    (period.step(&request, &mut told), told.faults)
}

#[test]
fn a_count_that_cannot_be_is_read_again_before_the_place_is_lost() {
    let right = PerUnit::saturated(7000.0 / f64::from(STROKE));
    for readings in [1, 2] {
        let (report, faults) = miscounted(readings);
        assert_eq!((faults.as_slice(), report.watchdog), (&[][..], Watchdog::Feed), "{readings}");
        assert!((report.measured.position - right).magnitude() < PerUnit::saturated(1e-6));
    }
    let (report, faults) = miscounted(3);
    assert!(matches!(faults[..], [Fault::EncoderJump { counts: 1_048_576 }]), "{faults:?}");
    assert_eq!(report.mode, Mode::Neutral);
}

#[test]
fn an_alarm_leads_to_what_is_stated_is_told_once_and_comes_again_after_it_was_acknowledged() {
    let monitor = Some(Monitor::new(&SENSITIVITY, &bases()).unwrap());
    for (response, mode, ends) in [
        (None, Mode::Following, Mode::Following),
        (Some(Response::Hold), Mode::Holding, Mode::Holding),
        (Some(Response::RampDown), Mode::RampingDown, Mode::Neutral),
        (Some(Response::Neutral), Mode::Neutral, Mode::Neutral),
    ] {
        let set_up = Rig { monitor, ..rig(deviating(&Deviation { alarm: response, ..deviation() })) };
        let mut bench = Bench::of(&set_up);
        // The sensors show 2.5 and 3 V: 5 and 6.25 MPa of 7.
        let right = |bench: &Bench| {
            let mut world = bench.world.borrow_mut();
            (world.predicted.pressure_a, world.predicted.pressure_b) =
                (PerUnit::saturated(5.0 / 7.0), PerUnit::saturated(6.25 / 7.0));
        };
        right(&bench);
        bench = bench.follows();
        for round in 1..3 {
            bench.world.borrow_mut().predicted.pressure_a = percent(50);
            let alarm = (0..200).map(|_| bench.command(None)).find(|report| report.alarm.is_some());
            let report = alarm.unwrap_or_else(|| panic!("{response:?}: no alarm"));
            assert_eq!(report.mode, mode, "{response:?}");
            let faults = if response.is_some() { round } else { 0 };
            assert_eq!(bench.told.faults.len(), faults, "{:?}", bench.told.faults);
            let later = bench.run(100);
            assert_eq!((later.mode, later.alarm), (ends, None));
            right(&bench);
            bench.run(50);
            if ends == Mode::Following {
                break;
            }
            let acknowledged = bench.command(Some(Command::Acknowledge));
            assert_eq!(acknowledged.answer, Some(Answer::Taken));
            if ends == Mode::Neutral {
                bench.request.set_point.position = acknowledged.measured.position;
                bench.follow();
            }
        }
    }
}

#[test]
fn a_rod_that_moves_although_the_valve_is_neutral_asks_for_the_oil_to_be_cut_off() {
    let rest = Some(Delay { by: 0.01 * bases().stroke_m, for_s: 0.05 });
    let mut bench = Bench::with(deviating(&deviation())).follows();
    bench.command(Some(Command::Stop));
    assert!(!bench.run(300).shut_off, "nothing is watched");

    let limits = deviating(&Deviation { rest, ..deviation() });
    let world = Rc::new(RefCell::new(World::new()));
    let begun = Period::begin(devices(&world), rig(limits), Wanting(world.clone()), Place::Lost).unwrap();
    let mut bench = Bench { period: Box::new(begun), world, ..Bench::new() };
    // Nobody knows its place yet: somebody pushes it to its reference.
    bench.travel(STROKE / 10);
    assert_eq!(bench.told.faults, []);
    assert!(bench.period.home(percent(30)));
    bench.run(100);
    bench.world.borrow_mut().count += 37;
    bench.run(100);
    assert_eq!(bench.told.faults, [], "0.2 % of the stroke");
    bench.travel(STROKE / 50);
    assert!(matches!(bench.told.faults[..], [Fault::MovesAtNeutral { .. }]), "{:?}", bench.told.faults);
    let report = bench.command(None);
    assert_eq!((report.mode, report.shut_off), (Mode::Neutral, true));
    assert!(!bench.command(Some(Command::Acknowledge)).shut_off);
}

#[test]
fn a_set_point_that_is_refused_at_speed_comes_to_rest_at_the_permitted_acceleration() {
    let bases = bases();
    let bounds = Bounds { from_m: 0.0, to_m: bases.stroke_m, velocity_m_per_s: 0.06, acceleration_m_per_s2: 1.0 };
    let mut bench = Bench::with(Limits { envelope: Envelope::new(&bounds, &bases, 0.0).unwrap(), ..limits() });
    bench = bench.follows();
    let strokes = |way_m: f64| PerUnit::saturated(way_m / bases.stroke_m);
    // Up to 50 mm/s at 1 m/s².
    for period in 1..=50 {
        let pace = strokes(1e-6 * f64::from(period));
        bench.request.set_point.position = bench.request.set_point.position + pace;
        assert_eq!(bench.command(None).mode, Mode::Following, "{period} {:?}", bench.told.faults);
    }
    bench.request.set_point.position = percent(101);
    let (mut before, mut pace) = (bench.world.borrow().set_point.unwrap().position, strokes(50e-6));
    let from = before;
    for _ in 0..60 {
        assert_eq!(bench.command(None).mode, Mode::Holding);
        let now = bench.world.borrow().set_point.unwrap().position;
        assert!((pace - (now - before)).magnitude() <= strokes(1.01e-6), "no faster than permitted");
        (before, pace) = (now, now - before);
    }
    assert_eq!(pace, PerUnit::ZERO);
    // v²/2a
    let way_m = (before - from).to_f64() * bases.stroke_m;
    assert!((way_m - 1.25e-3).abs() < 0.05e-3, "{way_m}");
}

#[test]
fn a_command_by_hand_holds_for_a_period_of_starting_or_following_and_for_none_of_another_mode() {
    let mut bench = Bench::new();
    bench.run(20);
    bench.period.put_out_by_hand(percent(5));
    let report = bench.command(None);
    assert_eq!((report.mode, report.command, report.energised), (Mode::Starting, percent(5), false));
    assert_eq!(bench.command(None).command, limits().neutral);

    let mut bench = Bench::following();
    bench.period.put_out_by_hand(percent(-90));
    let (report, slew) = (bench.command(None), limits().slew);
    assert_eq!((report.mode, report.command), (Mode::Following, percent(50) - slew));
    assert!(bench.command(None).command > report.command, "the loops go on");

    bench.command(Some(Command::Stop));
    for _ in 0..100 {
        bench.period.put_out_by_hand(percent(90));
        let report = bench.command(None);
        assert!(report.mode != Mode::Neutral || report.command == limits().neutral, "{report:?}");
        assert!(report.command < percent(50));
    }
}

#[test]
fn a_controller_that_has_only_started_and_a_lost_place_ask_for_the_oil_to_be_cut_off() {
    // Whoever stops does not say that all is well.
    let mut bench = Bench::new();
    assert!(bench.run(100).shut_off && bench.command(Some(Command::Stop)).shut_off);
    assert!(!bench.command(Some(Command::Acknowledge)).shut_off && !bench.run(100).shut_off);

    let world = Rc::new(RefCell::new(World::new()));
    let begun = Period::begin(devices(&world), rig(limits()), Wanting(world.clone()), Place::Lost).unwrap();
    let mut bench = Bench { period: Box::new(begun), world, ..Bench::new() };
    assert!(bench.command(Some(Command::Acknowledge)).shut_off && bench.run(100).shut_off);
    assert!(bench.period.home(percent(30)));
    assert!(!bench.run(1).shut_off);
}
