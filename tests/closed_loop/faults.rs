//! Faults provoked on the emulated target while the firmware follows on the virtual test bed: the mode over time, and the way back.

use std::fmt::Write;

use firmware::app::press;
use firmware::io::Cause;
use firmware::measured::AnalogSignal;
use firmware::period::Timing;
use firmware::set_point::SetPoint;
use firmware::supervision::{Device, Fault, Mode};
use model_core::machine::Bases;
use model_core::number::{Number, PerUnit};
use mps2::in_the_loop::lockstep::{Order, part};
use system_tests::at_hand::skipped;
use system_tests::emulator::Processor;
use system_tests::in_the_loop::{Board, Said, Wrong, rig};
use system_tests::rig::{Controller, Readings, Wanted, bases};
use system_tests::snapshot;

/// Periods of a case in which something begins: the last fault is acknowledged, the rod is homed, following is ordered, the rod moves.
const HOME: usize = 1;
const IGNORE: usize = 2;
const FOLLOW: usize = 120;
const MOVE: usize = 220;
/// After the fault's window its cause is removed. Then following is ordered, or acknowledgement where the rod is held; then it is stopped.
const TRIED: usize = 50;
const STOPPED: usize = 100;
const NEXT: usize = 350;

/// A move: 15 mm in a second, 28 mm/s at most.
const WAY_M: f64 = 0.015;
const MOVE_S: f64 = 1.0;

/// The set point and the timing of a period.
#[derive(Clone, Copy, Debug)]
struct Request {
    wanted: SetPoint,
    timing: Timing,
}

/// A fault, how it is provoked, and the reaction that is required.
struct Provoked {
    name: &'static str,
    /// Called in each period of the fault's window; the first is 0.
    bring: fn(&mut Board, &mut Request, usize, &Readings),
    fault: Fault,
    /// When the fault begins, in periods from the start of the move, and how long it lasts.
    after: usize,
    window: usize,
    mode: Mode,
    /// Periods within which it must be found.
    within: usize,
    fed: bool,
}

const HEAD: &str = "\
Faults provoked while the firmware follows, on an emulated Cortex-M4F around the virtual test bed.  Periods until a fault is told, until
the valve is neutral or the rod held; how far the rod moves within 0.1 s when it is followed again at rest, mm.  `watchdog`: it is not fed.
";
const ZERO: PerUnit = PerUnit::ZERO;

impl Provoked {
    /// A fault that is found in its first period, in the middle of the move.
    const fn at_once(
        name: &'static str,
        bring: fn(&mut Board, &mut Request, usize, &Readings),
        fault: Fault,
        mode: Mode,
    ) -> Self {
        let fed = !fault.is_own();
        Self { name, bring, fault, after: 400, window: 300, mode, within: 1, fed }
    }

    /// A fault that shows only while the rod is moved, and is found within the move.
    const fn stuck(
        name: &'static str,
        bring: fn(&mut Board, &mut Request, usize, &Readings),
        fault: Fault,
        mode: Mode,
    ) -> Self {
        Self { after: 0, window: 900, within: 900, ..Self::at_once(name, bring, fault, mode) }
    }
}

fn all() -> Vec<Provoked> {
    let silent = |device| Fault::Silent { device, cause: Cause::Bus };
    let spool = AnalogSignal::Spool;
    vec![
        Provoked::at_once(
            "open wire of the spool",
            |board, _, _, _| board.wrong.spool_v = Some(10.24),
            Fault::OpenWire { signal: spool, count: 0 },
            Mode::RampingDown,
        ),
        Provoked::at_once(
            "spool out of range",
            |board, _, _, _| board.wrong.spool_v = Some(-10.1),
            Fault::OutOfRange { signal: spool, count: 0 },
            Mode::RampingDown,
        ),
        Provoked::at_once(
            "open wire of pressure A",
            |board, _, _, _| board.wrong.pressure_a_v = Some(0.1),
            Fault::OpenWire { signal: AnalogSignal::PressureA, count: 0 },
            Mode::RampingDown,
        ),
        Provoked::stuck(
            "spool's sensor stuck",
            |board, _, period, seen| {
                if period == 0 {
                    board.wrong.spool_v = Some(10.0 * seen.spool / press::SPOOL_AT_10_V);
                }
            },
            Fault::SpoolDeviates { off: ZERO },
            Mode::Neutral,
        ),
        Provoked::stuck(
            "encoder stuck",
            |board, _, _, _| board.wrong.sense = Some(0),
            Fault::PositionStuck { position: ZERO },
            Mode::Neutral,
        ),
        Provoked::at_once(
            "encoder jumps",
            |board, _, period, _| {
                if period == 0 {
                    board.jump(400);
                }
            },
            Fault::EncoderJump { counts: 400 },
            Mode::Neutral,
        ),
        Provoked::at_once(
            "inputs do not answer",
            |board, _, _, _| board.wrong.hangs = Some((part::INPUTS, 0x00)),
            silent(Device::Inputs),
            Mode::RampingDown,
        ),
        Provoked::at_once(
            "counter answers wrongly",
            |board, _, _, _| board.wrong.hangs = Some((part::COUNTER, 0xff)),
            silent(Device::Position),
            Mode::Neutral,
        ),
        Provoked::at_once(
            "output does not answer",
            |board, _, _, _| board.wrong.hangs = Some((part::OUTPUT, 0x00)),
            silent(Device::Output),
            Mode::Neutral,
        ),
        Provoked::at_once(
            "output shorted",
            |board, _, _, _| board.wrong.shorted = true,
            silent(Device::Output),
            Mode::Neutral,
        ),
        Provoked::at_once(
            "overrun",
            |_, request, period, _| {
                if period == 0 {
                    request.timing = Timing::Overrun;
                }
            },
            Fault::Overrun,
            Mode::RampingDown,
        ),
        Provoked::at_once(
            "set point beyond the stroke",
            |_, request, _, _| request.wanted.position = PerUnit::saturated(1.5),
            Fault::SetPointOutside { position: ZERO, velocity: ZERO },
            Mode::Holding,
        ),
        Provoked::at_once(
            "set point accelerates",
            |_, request, _, _| request.wanted.velocity = ZERO,
            Fault::SetPointSteep { position: ZERO, velocity: ZERO },
            Mode::Holding,
        ),
        Provoked::at_once(
            "set point jumps",
            |_, request, _, _| request.wanted.position = request.wanted.position + PerUnit::saturated(0.05),
            Fault::SetPointJump { from: ZERO, to: ZERO },
            Mode::Holding,
        ),
    ]
}

/// What became of a fault: periods from its first one, which is counted.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// Periods until it was reported, and until the valve was neutral or the rod held.
    told: usize,
    safe: usize,
    /// How far the rod moved in 0.1 s after following was ordered again at rest, mm.
    bump_mm: f64,
}

/// Plays all cases, one after the other.
struct Play {
    board: Board,
    bases: Bases,
    cases: Vec<Provoked>,
    found: Vec<Found>,
    /// Period of the case.
    at: usize,
    /// Where the move begins, and where the rod was when following began.
    from: f64,
    rest_m: f64,
    last: Said,
    /// Faults reported before the case.
    before: u8,
    /// What has become of this case's fault so far.
    now: Found,
}

impl Play {
    /// The set point of this case's move after this number of periods.
    fn moving(&self, period: usize) -> SetPoint {
        let Bases { stroke_m, velocity_m_per_s, tick_s, .. } = self.bases;
        let way_m = if self.found.len().is_multiple_of(2) { WAY_M } else { -WAY_M };
        let s = (period as f64 * tick_s / MOVE_S).min(1.0);
        let (share, rate) = (s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * s * s * (1.0 - s).powi(2) / MOVE_S);
        SetPoint {
            position: PerUnit::saturated(self.from + way_m * share / stroke_m),
            velocity: PerUnit::saturated(way_m * rate / velocity_m_per_s),
        }
    }

    /// The set point and the order of this period; after the last case the rod rests.
    fn plan(&mut self, seen: &Readings) -> (Request, Order) {
        let kept = |wanted| Request { wanted, timing: Timing::Kept };
        let order = match self.at {
            0 => Order::Acknowledge,
            HOME => {
                self.from = seen.position_m / self.bases.stroke_m;
                Order::Home
            }
            // The monitor would see some of these faults first; `runaway` is about that.
            IGNORE => Order::IgnoreAlarms,
            FOLLOW => {
                self.from = self.last.position.to_f64();
                Order::Follow
            }
            _ => Order::None,
        };
        let here = SetPoint { position: PerUnit::saturated(self.from), velocity: ZERO };
        let Some(case) = self.cases.get(self.found.len()).filter(|_| self.at >= MOVE) else {
            return (kept(here), order);
        };
        let (from, cured) = (MOVE + case.after, MOVE + case.after + case.window);
        let mut request = kept(self.moving(self.at.min(from) - MOVE));
        request.wanted.velocity = if self.at > from { ZERO } else { request.wanted.velocity };
        if (from..cured).contains(&self.at) {
            // A stuck sensor shows only while the rod is moved.
            if case.within > 1 {
                request.wanted = self.moving(self.at - MOVE);
            }
            (case.bring)(&mut self.board, &mut request, self.at - from, seen);
        }
        if self.at == cured {
            self.board.wrong = Wrong::default();
        }
        let order = match self.at.checked_sub(cured) {
            Some(TRIED) if case.mode == Mode::Holding => Order::Acknowledge,
            Some(TRIED) => Order::Follow,
            Some(STOPPED) => Order::Stop,
            _ => order,
        };
        (request, order)
    }

    /// Compares what the firmware reported with what is required.
    fn heed(&mut self, said: Said, seen: &Readings) {
        let name = self.cases.get(self.found.len()).map_or("the end", |case| case.name);
        match self.at {
            0..FOLLOW => assert!(said.is(Mode::Starting) && !said.refused, "{name}: {said:?}"),
            FOLLOW..MOVE => {
                assert!(said.is(Mode::Following) && !said.refused && said.fed, "{name}: {said:?}");
                if self.at == FOLLOW {
                    self.rest_m = seen.position_m;
                }
                let moved_mm = 1e3 * (seen.position_m - self.rest_m).abs();
                if let Some(last) = self.found.last_mut() {
                    last.bump_mm = last.bump_mm.max(moved_mm);
                }
                self.before = said.faults;
            }
            _ => self.heed_fault(said),
        }
    }

    fn heed_fault(&mut self, said: Said) {
        let Some(case) = self.cases.get(self.found.len()) else { return };
        let Provoked { name, fault, after, window, mode, within, fed, .. } = case;
        let Some(since) = self.at.checked_sub(MOVE + after) else {
            return assert!(said.is(Mode::Following) && said.faults == self.before, "{name}: {said:?}");
        };
        if since == 0 {
            self.now = Found::default();
        }
        let settled = if *mode == Mode::Holding { Mode::Holding } else { Mode::Neutral };
        let now = &mut self.now;
        if now.told == 0 && said.faults != self.before {
            now.told = since + 1;
            assert_eq!((said.last_fault, said.fed), (fault.kind(), *fed), "{name}: {said:?}");
            assert!(said.is(*mode) || said.is(settled), "{name}: {said:?}");
        }
        if now.safe == 0 && said.is(settled) {
            now.safe = since + 1;
        }
        if since < *window {
            return;
        }
        // The cause of the fault is removed.
        let (told, safe) = (now.told, now.safe);
        assert!((1..=*within).contains(&told) && safe >= told, "{name}: told after {told}, safe after {safe}");
        assert_eq!(said.faults, self.before + 1, "{name}: told once");
        match since - window {
            0..TRIED => assert!(said.is(settled) && said.fed, "{name}: {said:?}"),
            TRIED..STOPPED if *mode == Mode::Holding => assert!(said.is(Mode::Following), "{name}: {said:?}"),
            TRIED..STOPPED => assert!(said.is(settled), "{name}: by command only: {said:?}"),
            _ => {}
        }
    }

    /// Ends the case in its last period.
    fn turn(&mut self) {
        self.at += 1;
        if let Some(case) = self.cases.get(self.found.len())
            && self.at == MOVE + case.after + case.window + NEXT
        {
            self.found.push(self.now);
            self.at = 0;
        }
    }
}

impl Controller for Play {
    fn command_v(&mut self, _: Wanted, seen: &Readings) -> f64 {
        let (Request { wanted, timing }, order) = self.plan(seen);
        let said = self.board.period(wanted, order, timing, seen);
        self.heed(said, seen);
        self.last = said;
        self.turn();
        self.board.volts()
    }
}

/// Where the numbers begin in a row.
const COLUMN: usize = 44;
/// Largest change of a figure against the snapshot.
const RELATIVE: f64 = 0.15;
const ABSOLUTE: f64 = 0.02;

#[test]
fn each_fault_has_its_state_in_time_is_told_once_and_goes_by_command_only_and_without_a_bump() {
    if !Processor::M4F.can_be_emulated() {
        return skipped("no processor in the loop");
    }
    let machine = press::machine();
    let bases = bases(&machine);
    let limits = press::rig(&machine, &bases, 5_120_000, 20_000_000).unwrap().limits;
    let to_neutral = usize::try_from(limits.periods_to_neutral()).unwrap();
    let cases = all();
    let periods: usize = cases.iter().map(|case| MOVE + case.after + case.window + NEXT).sum();
    let start = SetPoint { position: PerUnit::saturated(0.5), velocity: ZERO };
    let wanted = vec![Wanted { position_m: 0.5 * bases.stroke_m, per_unit: start }; periods + MOVE];
    let rig = rig(&machine, wanted);

    let board = Board::start(Processor::M4F, &Processor::M4F.built("loop", None), &rig.at_rest());
    let mut play = Play {
        board,
        bases,
        cases,
        found: Vec::new(),
        at: 0,
        from: 0.5,
        rest_m: 0.0,
        last: Said::default(),
        before: 0,
        now: Found::default(),
    };
    rig.run(&mut play);
    let mut table = format!("{HEAD}{:<COLUMN$} {:>6} {:>6} {:>8}\n", "fault: state", "told", "safe", "bump");
    for (case, found) in play.cases.iter().zip(&play.found) {
        let name = format!("{}: {:?}{}", case.name, case.mode, if case.fed { "" } else { ", watchdog" });
        let Found { told, safe, bump_mm } = found;
        writeln!(table, "{name:<COLUMN$} {told:>6} {safe:>6} {bump_mm:>8.3}").unwrap();
    }
    snapshot::compare("closed_loop/faults.txt", &table, |found, kept| {
        snapshot::numbers_near(found, kept, COLUMN, RELATIVE, ABSOLUTE)
    });
    assert_eq!(play.found.len(), play.cases.len());
    for (case, found) in play.cases.iter().zip(&play.found) {
        let later = if case.mode == Mode::RampingDown { to_neutral } else { 0 };
        assert!(found.safe <= found.told + later, "{}: {found:?}", case.name);
        assert!(found.bump_mm < 0.1, "{}: {found:?}", case.name);
    }
    let _ = play.board.end();
}
