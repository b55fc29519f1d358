//! Can the machine run away on the emulated target? Spool, encoder, command's wires, oil, tick and load fail while the firmware, as it is shipped,
//! holds or moves the rod of the virtual test bed; each case ends in its state within a stated distance and time.

use std::fmt::Write;
use std::thread;

use firmware::app::press;
use firmware::period::Timing;
use firmware::set_point::Leg;
use firmware::supervision::{Fault, Mode};
use model_core::machine::{Machine, Parameter as P};
use model_core::number::PerUnit;
use mps2::in_the_loop::lockstep::Order;
use system_tests::at_hand::skipped;
use system_tests::emulator::Processor;
use system_tests::in_the_loop::{Board, Said, Wrong, rig};
use system_tests::rig::{Controller, Readings, Rig, TICK, Wanted, course};
use system_tests::snapshot;
use virtual_plant::LoadProfile;

/// Periods in which following is ordered, the move begins, and something fails at rest or on the way.
const FOLLOW: usize = 200;
const MOVE: usize = 400;
const ON_THE_WAY: usize = MOVE + 900;
/// Within these every case is safe: time from the failure, ms, and way of the rod from its set point, mm.
const SAFE_MS: usize = 500;
const SAFE_MM: f64 = 6.5;

/// What fails.
struct Case {
    name: &'static str,
    wrong: Wrong,
    /// Period in which it fails; a machine that fails by itself begins with the move.
    at: usize,
    /// The machine and its surroundings, if they are not as the model says.
    other: fn(Rig) -> Rig,
    /// Short moves to and fro instead of a long one.
    shortly: bool,
    /// Whether the valve cannot be closed, so that the oil must be cut off in the end.
    jammed: bool,
}

fn cases() -> Vec<Case> {
    let nothing = Wrong::default();
    let case = |name, wrong: Wrong, at| Case {
        name,
        wrong,
        at,
        other: |rig| rig,
        shortly: false,
        jammed: wrong.jammed_v.is_some(),
    };
    let machine = press::machine();
    // The command that would open the spool so far.
    let volts = |spool: f64| (spool - machine.get(P::ValveOffset)) / machine.get(P::ValveGain);
    let jammed = |spool| Wrong { jammed_v: Some(volts(spool)), ..nothing };
    let turned = Wrong { sense: Some(-1), ..nothing };
    let exchanged = Wrong { exchanged: true, ..nothing };
    vec![
        case("spool jams at rest, +0.25", jammed(0.25), MOVE),
        case("spool jams at rest, -0.25", jammed(-0.25), MOVE),
        case("spool jams on the way, +0.5", jammed(0.5), ON_THE_WAY),
        case("spool jams on the way, -0.25", jammed(-0.25), ON_THE_WAY),
        case("encoder turned from the start", turned, MOVE),
        case("encoder turned on the way", turned, ON_THE_WAY),
        case("command's wires exchanged from the start", exchanged, MOVE),
        case("command's wires exchanged on the way", exchanged, ON_THE_WAY),
        Case { other: dry, ..case("no oil from the start", nothing, MOVE) },
        Case { other: slow, shortly: true, ..case("tick twice as long", nothing, MOVE) },
        Case { other: fast, shortly: true, ..case("tick half as long", nothing, MOVE) },
        Case { other: falling, ..case("load of 8 kN falls on", nothing, ON_THE_WAY) },
    ]
}

fn dry(rig: Rig) -> Rig {
    Rig { machine: rig.machine.with(&[(P::SupplyPressure, 1e5)]), ..rig }
}

fn slow(rig: Rig) -> Rig {
    Rig { period_s: 2.0 * TICK.seconds(), ..rig }
}

fn fast(rig: Rig) -> Rig {
    Rig { period_s: 0.5 * TICK.seconds(), ..rig }
}

fn falling(rig: Rig) -> Rig {
    let at_s = ON_THE_WAY as f64 * TICK.seconds();
    let load = LoadProfile::through(vec![(0.0, 0.0), (at_s, 0.0), (at_s + 5e-3, 8000.0)]).unwrap();
    Rig { load, ..rig }
}

/// Set points: rest, then a move or several.
fn wanted(machine: &Machine<f64>, shortly: bool) -> Vec<Wanted> {
    let rest = Leg::Rest { duration_s: MOVE as f64 * TICK.seconds() };
    let moves = if shortly {
        [Leg::Fastest { to_m: 0.153 }, Leg::Fastest { to_m: 0.15 }].repeat(4)
    } else {
        vec![Leg::Fastest { to_m: 0.2 }]
    };
    let legs: Vec<Leg> = [rest].into_iter().chain(moves).collect();
    course(machine, &press::BOUNDS, 0.15, &legs)
}

/// What became of a case: times in periods from the failure.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    first: u8,
    told: usize,
    safe: usize,
    safe_mm: f64,
    shut_off: bool,
}

/// Homes, follows, brings what fails, and looks what becomes of it.
struct Play<'a> {
    board: Board,
    case: &'a Case,
    at: usize,
    farthest_m: f64,
    wanted_m: f64,
    found: Found,
}

impl Controller for Play<'_> {
    fn command_v(&mut self, wanted: Wanted, seen: &Readings) -> f64 {
        let order = match self.at {
            0 => Order::Home,
            FOLLOW => Order::Follow,
            _ => Order::None,
        };
        if self.at == self.case.at {
            self.board.wrong = self.case.wrong;
        }
        let said = self.board.period(wanted.per_unit, order, Timing::Kept, seen);
        if let Some(since) = self.at.checked_sub(self.case.at) {
            self.heed(said, since, wanted, seen);
        } else {
            assert_eq!((said.faults, said.alarm), (0, 0), "{}: {said:?}", self.case.name);
        }
        self.at += 1;
        self.board.volts()
    }
}

impl Play<'_> {
    fn heed(&mut self, said: Said, since: usize, wanted: Wanted, seen: &Readings) {
        if said.is(Mode::Following) {
            self.wanted_m = wanted.position_m;
        }
        self.farthest_m = self.farthest_m.max((seen.position_m - self.wanted_m).abs());
        if self.found.told == 0 && said.faults > 0 {
            (self.found.first, self.found.told) = (said.last_fault, since + 1);
        }
        if self.found.safe == 0 && said.is(Mode::Neutral) {
            (self.found.safe, self.found.safe_mm) = (since + 1, 1e3 * self.farthest_m);
        }
        self.found.shut_off = said.shut_off;
    }
}

fn played(image: &std::path::Path, case: &Case) -> Found {
    let machine = press::machine();
    let rig = (case.other)(rig(&machine, wanted(&machine, case.shortly)));
    let board = Board::start(Processor::M4F, image, &rig.at_rest());
    let mut play = Play { board, case, at: 0, farthest_m: 0.0, wanted_m: 0.15, found: Found::default() };
    rig.run(&mut play);
    play.found
}

/// The name of a fault that is told by its kind.
fn name(kind: u8) -> &'static str {
    let zero = PerUnit::from_bits(0);
    let response = press::ALARM.unwrap();
    let named = [
        (Fault::FollowingError { off: zero }, "following error"),
        (Fault::VelocityError { off: zero }, "velocity error"),
        (Fault::SpoolDeviates { off: zero }, "spool deviates"),
        (Fault::PositionStuck { position: zero }, "position stuck"),
        (Fault::Alarm { signal: firmware::monitor::MonitoredSignal::Spool, response }, "alarm"),
    ];
    named.into_iter().find(|(fault, _)| fault.kind() == kind).unwrap_or_else(|| panic!("kind {kind}")).1
}

const HEAD: &str = "\
A failure on the emulated Cortex-M4F around the virtual test bed, and what is told first; periods until it is told, and until the valve is
neutral and without current; how far the rod is from its set point at most until then, mm.
";
/// Where the numbers begin in a row.
const COLUMN: usize = 68;
/// Largest change of a figure against the snapshot.
const RELATIVE: f64 = 0.15;
const ABSOLUTE: f64 = 0.06;

#[test]
fn whatever_fails_the_emulated_firmware_ends_in_its_state_within_the_stated_distance_and_time() {
    if !Processor::M4F.can_be_emulated() {
        return skipped("no processor in the loop");
    }
    let image = Processor::M4F.built("loop", None);
    let cases = cases();
    // An emulator and its test bed wait for each other most of the time.
    let found: Vec<Found> = thread::scope(|scope| {
        let runs: Vec<_> = cases.iter().map(|case| scope.spawn(|| played(&image, case))).collect();
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    let mut table = format!("{HEAD}{:<COLUMN$} {:>5} {:>5} {:>7}\n", "failure: first fault", "told", "safe", "mm");
    for (case, found) in cases.iter().zip(&found) {
        let Found { first, told, safe, safe_mm, shut_off } = *found;
        println!("{}: {found:?}", case.name);
        let named = format!("{}: {}{}", case.name, name(first), if shut_off { ", shut off" } else { "" });
        writeln!(table, "{named:<COLUMN$} {told:>5} {safe:>5} {safe_mm:>7.2}").unwrap();
    }
    println!("{table}");
    for (case, found) in cases.iter().zip(&found) {
        let Found { safe, safe_mm, shut_off, .. } = *found;
        assert!((1..=SAFE_MS).contains(&safe) && safe_mm <= SAFE_MM, "{}: {found:?}", case.name);
        assert!(shut_off || !case.jammed, "{}", case.name);
    }
    snapshot::compare("closed_loop/runaway.txt", &table, |found, kept| {
        snapshot::numbers_near(found, kept, COLUMN, RELATIVE, ABSOLUTE)
    });
}
