//! Can the machine run away? Spool, encoder, command's wires, oil, tick and load fail, at rest and on the way; each case ends in its state within
//! a stated distance and time, and the table beside this file is compared. `RENEW=1` writes it anew.
//!
//! No command closes a jammed spool: the firmware takes the valve's current and asks for the oil to be cut off. In the table's last column an
//! independent valve does so.

use std::fmt::Write;

use firmware::set_point::{Course, CourseState, Leg, SetPoint};
use firmware::supervision::{Command, Deviation, Fault, Mode};
use model_core::machine::{Machine, Parameter as P};

use crate::failing::{AS_SHIPPED, BOUNDS, RIGHT, Rig, Setup, Wrong};
use crate::following::press;
use crate::world::{STROKE_M, World};

/// Time that the independent valve takes to cut off the oil, periods.
const CUT_OFF: usize = 50;
/// Longest case, and the time for which the rod is watched after it is safe, periods.
const LONGEST: usize = 6000;
const AFTERWARDS: usize = 1000;
/// Within these every case as shipped is safe: time from the failure, ms, and distance between rod and set point, mm.
const SAFE_MS: usize = 400;
const SAFE_MM: f64 = 4.0;
/// The same once the independent valve has closed, mm.
const STOPPED_MM: f64 = 4.5;
/// The same where spool or alarm are missing, mm.
const BLIND_MM: f64 = 18.0;

type Fail = fn(&mut Wrong, &mut World);

/// What the rod does meanwhile.
#[derive(Clone, Copy, PartialEq)]
enum Moves {
    /// It rests.
    Not,
    /// 80 mm out and 120 mm in; it fails after so many periods.
    Far(usize),
    /// 3 mm to and fro, as fast as the bounds permit; it fails from the start.
    Shortly,
}

/// What fails, and how the firmware is set up meanwhile.
struct Case {
    name: &'static str,
    fail: Fail,
    moves: Moves,
    /// A load that the model knows, N.
    load_n: f64,
}

const CASES: [Case; 13] = {
    const fn case(name: &'static str, moves: Moves, fail: Fail) -> Case {
        Case { name, fail, moves, load_n: 0.0 }
    }
    // In the middle of the way out, where it is fastest.
    const ON_THE_WAY: Moves = Moves::Far(2200);
    [
        case("spool jams at rest, +0.25", Moves::Not, |wrong, _| wrong.jammed = Some(0.25)),
        case("spool jams at rest, -0.25", Moves::Not, |wrong, _| wrong.jammed = Some(-0.25)),
        case("spool jams at rest, +0.13", Moves::Not, |wrong, _| wrong.jammed = Some(0.13)),
        case("spool jams on the way, +0.5", ON_THE_WAY, |wrong, _| wrong.jammed = Some(0.5)),
        case("spool jams on the way, -0.25", ON_THE_WAY, |wrong, _| wrong.jammed = Some(-0.25)),
        case("encoder turned from the start", Moves::Far(0), |_, world| world.sense = -1),
        case("encoder turned on the way", ON_THE_WAY, |_, world| world.sense = -1),
        case("command's wires exchanged from the start", Moves::Far(0), |wrong, _| wrong.exchanged = true),
        case("command's wires exchanged on the way", ON_THE_WAY, |wrong, _| wrong.exchanged = true),
        case("no oil on the way", ON_THE_WAY, |wrong, _| wrong.dry = true),
        case("tick twice as long", Moves::Shortly, |wrong, _| wrong.ticks = 2 * RIGHT),
        case("tick half as long", Moves::Shortly, |wrong, _| wrong.ticks = RIGHT / 2),
        Case {
            load_n: -8000.0,
            ..case("load of 8 kN falls off at rest", Moves::Not, |wrong, _| wrong.force_n = 8000.0)
        },
    ]
};

/// What became of a case; times in periods from the failure, distances between rod and set point in mm.
struct Found {
    first: Fault,
    told: usize,
    safe: usize,
    safe_mm: f64,
    shut_off: bool,
    stopped_mm: f64,
}

/// The press with a load.
fn loaded(load_n: f64) -> Machine<f64> {
    press().with(&[(P::LoadForce, load_n)])
}

fn played(case: &Case, setup: Setup) -> Option<Found> {
    let machine = loaded(case.load_n);
    let mut rig = Rig::following(&machine, &machine, setup);
    rig.along(&[Leg::Rest { duration_s: 0.2 }]);
    assert_eq!(rig.bench.told.0, [], "{}", case.name);
    let bases = *rig.bench.period.control().reference().bases();
    let to_and_fro = [Leg::Fastest { to_m: 0.123 }, Leg::Fastest { to_m: 0.12 }];
    let (legs, fails) = match case.moves {
        Moves::Not => (vec![], 0),
        Moves::Far(after) => (vec![Leg::Fastest { to_m: 0.2 }, Leg::Fastest { to_m: 0.08 }], after),
        Moves::Shortly => (to_and_fro.repeat(5), 0),
    };
    let course = Course::<10>::new(&bases, &BOUNDS, rig.bench.wanted * STROKE_M, &legs).unwrap();
    let (mut state, mut found, mut wanted_m): (_, Option<Found>, _) = (CourseState::default(), None, 0.0);
    let (mut farthest_mm, mut cut_off_at) = (0.0_f64, None);
    for period in 0..fails + LONGEST {
        let wanted: SetPoint = course.step(&mut state);
        if period >= fails {
            let mut wrong = rig.wrong.get();
            (case.fail)(&mut wrong, &mut rig.bench.world);
            wrong.cut_off = cut_off_at.is_some_and(|at| period >= at);
            rig.wrong.set(wrong);
        }
        let report = rig.bench.step_to(wanted, None);
        let Some(since) = period.checked_sub(fails) else { continue };
        if report.mode == Mode::Following {
            wanted_m = wanted.position.to_f64() * STROKE_M;
        }
        farthest_mm = farthest_mm.max(1e3 * (rig.bench.world.position_m - wanted_m).abs());
        if report.shut_off && cut_off_at.is_none() {
            cut_off_at = Some(period + CUT_OFF);
        }
        if found.is_none()
            && let Some(&first) = rig.bench.told.0.first()
        {
            let (told, safe_mm, stopped_mm) = (since + 1, 0.0, 0.0);
            found = Some(Found { first, told, safe: 0, safe_mm, shut_off: false, stopped_mm });
        }
        let Some(found) = &mut found else { continue };
        if found.safe == 0 && report.mode == Mode::Neutral {
            assert!(!report.energised, "{}", case.name);
            (found.safe, found.safe_mm) = (since + 1, farthest_mm);
        }
        (found.shut_off, found.stopped_mm) = (report.shut_off, farthest_mm);
        if found.safe > 0 && since > found.safe + AFTERWARDS {
            break;
        }
    }
    found
}

const HEAD: &str = "\
A failure, what is told first, periods of 1 ms until it is told and until the valve is neutral and without current; how far the rod is from
its set point at most until then, and once an independent valve has cut off the oil 50 ms after the firmware asked for it, mm.
";
/// Where the numbers begin in a row.
const COLUMN: usize = 66;

fn row(table: &mut String, case: &Case, setup: Setup, within_mm: f64) {
    let Some(Found { first, told, safe, safe_mm, shut_off, stopped_mm }) = played(case, setup) else {
        panic!("{}: nothing is told", case.name)
    };
    let first = format!("{first:?}");
    let first = first.split(' ').next().unwrap();
    let name = format!("{}: {first}{}", case.name, if shut_off { ", shut off" } else { "" });
    writeln!(table, "{name:<COLUMN$} {told:>5} {safe:>5} {safe_mm:>7.2} {stopped_mm:>7.2}").unwrap();
    assert!(safe > 0 && stopped_mm <= within_mm, "{}: {safe} ms, {stopped_mm} mm", case.name);
    if within_mm == STOPPED_MM {
        assert!(safe <= SAFE_MS && safe_mm <= SAFE_MM, "{}: {safe} ms, {safe_mm} mm", case.name);
    }
}

#[test]
fn whatever_fails_the_machine_ends_in_its_state_within_the_stated_distance_and_time() {
    let alarm_ignored =
        Setup { deviation: |deviation| Deviation { alarm: None, ..deviation }, spool_is_measured: true };
    let blind = Setup { spool_is_measured: false, ..AS_SHIPPED };
    let mut table =
        format!("{HEAD}{:<COLUMN$} {:>5} {:>5} {:>7} {:>7}\n", "as shipped", "told", "safe", "mm", "stopped");
    for case in &CASES {
        row(&mut table, case, AS_SHIPPED, STOPPED_MM);
    }
    for (name, setup) in [("spool not measured", blind), ("alarm of the monitor ignored", alarm_ignored)] {
        writeln!(table, "{name}").unwrap();
        // A load that falls off moves the rod by a fraction of a millimetre: this is no deviation, only the alarm tells it.
        for case in CASES.iter().filter(|case| case.load_n == 0.0) {
            row(&mut table, case, setup, BLIND_MM);
        }
    }
    compare(&table);
}

#[test]
fn a_spool_that_is_still_jammed_when_the_fault_is_acknowledged_is_told_again() {
    let mut rig = Rig::following(&press(), &press(), AS_SHIPPED);
    rig.along(&[Leg::Rest { duration_s: 0.2 }]);
    // The independent valve does what it is asked for, each time 50 ms later.
    let mut asked = std::collections::VecDeque::from([false; CUT_OFF]);
    let mut period = |rig: &mut Rig, command| {
        let report = rig.bench.step(command);
        asked.push_back(report.shut_off);
        rig.wrong.set(Wrong { jammed: Some(0.25), cut_off: asked.pop_front().unwrap(), ..rig.wrong.get() });
        report
    };
    for _ in 0..500 {
        period(&mut rig, None);
    }
    let rested_m = rig.bench.world.position_m;
    let report = period(&mut rig, Some(Command::Acknowledge));
    assert_eq!((report.mode, report.shut_off), (Mode::Starting, false));
    let reports: Vec<_> = (0..1000).map(|_| period(&mut rig, None)).collect();
    assert!(matches!(rig.bench.told.0.last(), Some(Fault::MovesAtNeutral { .. })), "{:?}", rig.bench.told.0);
    let until = reports.iter().position(|report| report.shut_off).unwrap();
    let moved_mm = 1e3 * (rig.bench.world.position_m - rested_m);
    println!("told again after {until} ms, moved by {moved_mm:.2} mm");
    assert!(until < 300 && moved_mm.abs() < 7.0, "{until} ms, {moved_mm} mm");
}

#[test]
fn without_limits_a_jammed_spool_and_a_turned_encoder_run_the_rod_to_its_end_and_nobody_is_told() {
    let unwatched = Setup { deviation: |_| Deviation::UNWATCHED, spool_is_measured: true };
    for case in [&CASES[0], &CASES[5]] {
        let mut rig = Rig::following(&press(), &press(), unwatched);
        let mut wrong = rig.wrong.get();
        (case.fail)(&mut wrong, &mut rig.bench.world);
        rig.wrong.set(wrong);
        rig.along(&[Leg::Smooth { to_m: 0.125, duration_s: 1.0 }]);
        for _ in 0..20_000 {
            rig.bench.step(None);
            if !(0.01..0.29).contains(&rig.bench.world.position_m) {
                break;
            }
        }
        assert_eq!(rig.bench.told.0, [], "{}", case.name);
        assert!(!(0.01..0.29).contains(&rig.bench.world.position_m), "{}: {}", case.name, rig.bench.world.position_m);
    }
}

/// Healthy presses that are not quite the model: within what data sheets permit, warm or cold, loaded or not.
fn healthy() -> Vec<(&'static str, Machine<f64>)> {
    let times = |parameter, factor: f64| press().with(&[(parameter, factor * press().get(parameter))]);
    let lags = |factor: f64| {
        let both = [P::TimeConstant1, P::TimeConstant2].map(|lag| (lag, factor * press().get(lag)));
        press().with(&both)
    };
    vec![
        ("as the model says", press()),
        ("valve's gain +10 %", times(P::ValveGain, 1.1)),
        ("valve's gain -10 %", times(P::ValveGain, 0.9)),
        ("zero +0.02", press().with(&[(P::ValveOffset, press().get(P::ValveOffset) + 0.02)])),
        ("zero -0.02", press().with(&[(P::ValveOffset, press().get(P::ValveOffset) - 0.02)])),
        ("overlap +15 %", times(P::DeadZone, 1.15)),
        ("overlap -15 %", times(P::DeadZone, 0.85)),
        ("lags +30 %", lags(1.3)),
        ("lags -30 %", lags(0.7)),
        ("delay doubled", times(P::TransportDelay, 2.0)),
        ("rate limit -30 %", times(P::RateLimit, 0.7)),
        ("flow +20 %", times(P::FlowCoefficient, 1.2)),
        ("flow -20 %", times(P::FlowCoefficient, 0.8)),
        ("friction +50 %", times(P::ViscousFriction, 1.5)),
        ("friction -50 %", times(P::ViscousFriction, 0.5)),
        ("supply -10 %", times(P::SupplyPressure, 0.9)),
        ("oil half as stiff", times(P::BulkModulus, 0.5)),
        ("mass tenfold", times(P::MovingMass, 10.0)),
        ("load of +3 kN, unknown", loaded(3000.0)),
        ("load of -3 kN, unknown", loaded(-3000.0)),
    ]
}

/// The whole range, small steps, and a reversal, as fast as the bounds permit.
const MOVES: [Leg; 7] = [
    Leg::Fastest { to_m: 0.28 },
    Leg::Fastest { to_m: 0.02 },
    Leg::Fastest { to_m: 0.15 },
    Leg::Fastest { to_m: 0.151 },
    Leg::Fastest { to_m: 0.14 },
    Leg::Fastest { to_m: 0.16 },
    Leg::Rest { duration_s: 0.5 },
];

#[test]
fn healthy_drives_that_are_not_quite_the_model_are_not_stopped() {
    let limits_alone =
        |spool_is_measured| Setup { deviation: |deviation| Deviation { alarm: None, ..deviation }, spool_is_measured };
    for (name, real) in healthy() {
        for setup in [limits_alone(true), limits_alone(false)] {
            let mut rig = Rig::following(&press(), &real, setup);
            let farthest_m = rig.along(&MOVES);
            println!("{name}: {:.2} mm", 1e3 * farthest_m);
            assert_eq!(rig.bench.told.0, [], "{name}");
        }
    }
    // The monitor is stricter: it is about the model, and quiet where the model is right.
    let mut rig = Rig::following(&press(), &press(), AS_SHIPPED);
    rig.along(&MOVES);
    assert_eq!(rig.bench.told.0, []);
}

/// Largest change of a figure against the table: another processor's libm may move a controller to the next step of the encoder.
const RELATIVE: f64 = 0.1;
const ABSOLUTE: f64 = 0.06;

fn compare(table: &str) {
    println!("{table}");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/rig/runaway.txt");
    if std::env::var_os("RENEW").is_some() {
        return std::fs::write(path, table).unwrap();
    }
    let kept = std::fs::read_to_string(path).unwrap();
    assert_eq!(kept.lines().count(), table.lines().count(), "other rows; RENEW=1 writes them anew");
    let numbers = |line: &str| -> Vec<f64> {
        let numbers = line.get(COLUMN..).unwrap_or_default().split_whitespace();
        numbers.filter_map(|number| number.parse().ok()).collect()
    };
    let named = |line: &str| line.get(..COLUMN).unwrap_or(line).trim().to_owned();
    for (found, kept) in table.lines().zip(kept.lines()) {
        let (ours, theirs) = (numbers(found), numbers(kept));
        let near = ours.iter().zip(&theirs).all(|(found, kept)| (found - kept).abs() <= RELATIVE * kept + ABSOLUTE);
        let same = named(found) == named(kept) && ours.len() == theirs.len();
        assert!(same && near, "no longer `{kept}` but `{found}`; RENEW=1 writes the table anew");
    }
}
