//! Does every fault lead to its mode in time, and does only a command lead back? Tested with whole periods.

mod anything;
#[cfg(feature = "async")]
mod awaited;
mod bench;
mod deviation;
mod faults;

use std::cell::RefCell;
use std::rc::Rc;

use bench::{Bench, STROKE, Told, VOLT, Wanting, World, devices, limits, neutral, percent, rig};
use firmware::io::FromFn;
use firmware::period::{Answer, BeginError, Devices, Period, Place, Request, Timing, Watchdog};
use firmware::set_point::SetPoint;
use firmware::supervision::{Command, Fault, Limits, LimitsError, Mode};
use model_core::number::{Number, PerUnit};

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
fn a_stored_state_goes_on_just_so() {
    let mut bench = Bench::following();
    bench.request.set_point.position = percent(101);
    bench.run(3);
    let (state, world) = (bench.period.state(), bench.world.borrow().clone());
    let first = (bench.run(30), bench.command(Some(Command::Stop)), bench.run(30));
    bench.period.restore(&state);
    *bench.world.borrow_mut() = world;
    let again = (bench.run(30), bench.command(Some(Command::Stop)), bench.run(30));
    assert_eq!(first, again);
    assert_ne!(bench.period.state(), state);
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
    assert_eq!((measured.spool, measured.pressure_a, measured.pressure_b), (None, None, None));
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
fn an_absurd_set_point_is_not_acknowledged_while_it_is_there() {
    let mut bench = Bench::following();
    bench.request.set_point.position = percent(101);
    bench.run(5);
    let refused = bench.command(Some(Command::Acknowledge));
    assert_eq!((refused.mode, refused.answer), (Mode::Holding, Some(Answer::Faulty)));
    bench.request.set_point.position = percent(35);
    assert_eq!(bench.command(Some(Command::Acknowledge)).mode, Mode::Following);
    assert_eq!(bench.told.faults.len(), 1);
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
    assert!(bench.period.home(percent(32)));
    bench.follow();
}

#[test]
fn a_rod_that_nobody_knows_the_place_of_does_not_follow() {
    let world = Rc::new(RefCell::new(World::new()));
    let begun = Period::begin(devices(&world), rig(limits()), Wanting(world.clone()), Place::Lost);
    let mut bench = Bench { period: Box::new(begun.unwrap()), world, ..Bench::new() };
    bench.run(10);
    assert_eq!(bench.command(Some(Command::Follow)).answer, Some(Answer::Lost));
    assert!(bench.period.home(percent(70)));
    assert_eq!(bench.command(None).measured.position, percent(70));
    bench.request.set_point.position = percent(70);
    bench.follow();
    assert!(!bench.period.home(percent(10)), "not while the valve may be open");
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
fn a_valve_that_went_to_neutral_settles_before_it_follows_again() {
    let mut bench = Bench::following();
    bench.command(Some(Command::Stop));
    while bench.command(None).mode != Mode::Neutral {}
    assert_eq!(bench.command(Some(Command::Acknowledge)).mode, Mode::Starting);
    assert_eq!(bench.command(Some(Command::Follow)).answer, Some(Answer::Unsettled));
    bench.run(limits().settling);
    bench.follow();
}

#[test]
fn a_period_that_was_not_healthy_takes_the_valves_current_until_a_command_gives_it_back() {
    let overrun: fn(&mut Bench, bool) = |bench, bad| {
        bench.request.timing = if bad { Timing::Overrun } else { Timing::Kept };
    };
    let silent: fn(&mut Bench, bool) = |bench, bad| bench.world.borrow_mut().output_silent = bad;
    for fault in [overrun, silent] {
        let mut bench = Bench::following();
        assert!(bench.command(None).energised);
        fault(&mut bench, true);
        assert!(!bench.command(None).energised);
        fault(&mut bench, false);
        let report = bench.run(limits().periods_to_neutral().try_into().unwrap());
        assert_eq!((report.mode, report.watchdog, report.energised), (Mode::Neutral, Watchdog::Feed, false));
        assert!(!bench.command(Some(Command::Acknowledge)).energised);
        bench.run(limits().settling);
        assert!(bench.command(Some(Command::Follow)).energised);
    }
    // A sensor's fault is not a fault of the controller: the ramp needs the current.
    let mut bench = Bench::following();
    bench.world.borrow_mut().voltages[2] = 5 * VOLT;
    let ramping = bench.command(None);
    assert_eq!((ramping.mode, ramping.energised), (Mode::RampingDown, true));
    let neutral = bench.run(limits().periods_to_neutral().try_into().unwrap());
    assert_eq!((neutral.mode, neutral.energised), (Mode::Neutral, false));
}

#[test]
fn a_model_that_is_driven_is_what_is_wanted_and_the_rod_is_held_where_it_would_leave_the_bounds() {
    let mut bench = Bench::following();
    let moves_to = |bench: &mut Bench, position: i32| {
        bench.world.borrow_mut().predicted.position = percent(position);
        bench.period.play(percent(49));
        bench.command(None)
    };
    // The set point that is sent meanwhile does not count.
    bench.request.set_point.position = percent(101);
    let report = moves_to(&mut bench, 31);
    assert_eq!((report.mode, report.followed.position), (Mode::Following, percent(31)));
    assert!(report.command <= percent(49) && report.command > percent(0), "{:?}", report.command);
    assert_eq!(moves_to(&mut bench, 32).followed.position, percent(32));
    assert_eq!(bench.told.faults, []);
    let held = moves_to(&mut bench, 101);
    assert_eq!(held.mode, Mode::Holding);
    assert!(matches!(bench.told.faults[..], [Fault::SetPointOutside { .. }]), "{:?}", bench.told.faults);
    assert!(held.followed.position < percent(40), "{:?}", held.followed);
    // It is given for one period, and does nothing in another mode.
    let report = moves_to(&mut bench, 33);
    assert_eq!(report.mode, Mode::Holding);
    assert_ne!(report.followed.position, percent(33));
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
