//! Every fault is caused: it leads to its mode in time, is logged once, and is cleared only by command.

use firmware::io::Cause;
use firmware::measured::AnalogSignal;
use firmware::period::{Answer, Report, Request, Timing, Watchdog};
use firmware::supervision::{Command, Device, Fault, Mode};

use crate::bench::{Bench, VOLT, World, limits, neutral, percent};

/// How a fault is caused, and which fault it must be.
struct Case {
    name: &'static str,
    /// Whether it is caused again in every period, because something else undoes it.
    anew: bool,
    bring: fn(&mut World, &mut Request),
    is: fn(&Fault) -> bool,
    /// Mode in the period that finds it.
    mode: Mode,
    /// Periods in which it must be found.
    within: u16,
    watchdog: Watchdog,
}

const CASES: [Case; 20] = [
    Case {
        name: "pressure above its sensor's range",
        anew: false,
        bring: |world, _| world.voltages[2] = 5 * VOLT,
        is: |fault| *fault == Fault::OutOfRange { signal: AnalogSignal::PressureA, count: 64_000 },
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "pressure's wire open, pulled to ground",
        anew: false,
        bring: |world, _| world.voltages[3] = VOLT / 5,
        is: |fault| *fault == Fault::OpenWire { signal: AnalogSignal::PressureB, count: 2560 },
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "spool's wire open, pulled to the rail",
        anew: false,
        bring: |world, _| world.voltages[1] = 131_068, // 10.24 V
        is: |fault| matches!(fault, Fault::OpenWire { signal: AnalogSignal::Spool, .. }),
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "spool stuck",
        anew: false,
        bring: |world, _| world.predicted.spool = percent(20),
        is: |fault| matches!(fault, Fault::Stuck { signal: AnalogSignal::Spool, .. }),
        mode: Mode::RampingDown,
        within: 41,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "pressure stuck",
        anew: false,
        bring: |world, _| world.predicted.pressure_a = percent(70),
        is: |fault| matches!(fault, Fault::Stuck { signal: AnalogSignal::PressureA, .. }),
        mode: Mode::RampingDown,
        within: 61,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "position stuck",
        anew: false,
        bring: |world, _| world.predicted.position = percent(40),
        is: |fault| matches!(fault, Fault::PositionStuck { .. }),
        mode: Mode::Neutral,
        within: 51,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "encoder jump",
        anew: false,
        bring: |world, _| world.count += 400,
        is: |fault| matches!(fault, Fault::EncoderJump { counts: 399..=401 }),
        mode: Mode::Neutral,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "inputs silent",
        anew: false,
        bring: |world, _| world.inputs_silent = true,
        is: |fault| *fault == Fault::Silent { device: Device::Inputs, cause: Cause::Bus },
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Withhold,
    },
    Case {
        name: "counter silent",
        anew: false,
        bring: |world, _| world.position_silent = true,
        is: |fault| *fault == Fault::Silent { device: Device::Position, cause: Cause::Bus },
        mode: Mode::Neutral,
        within: 1,
        watchdog: Watchdog::Withhold,
    },
    Case {
        name: "output silent",
        anew: false,
        bring: |world, _| world.output_silent = true,
        is: |fault| *fault == Fault::Silent { device: Device::Output, cause: Cause::Bus },
        mode: Mode::Neutral,
        within: 1,
        watchdog: Watchdog::Withhold,
    },
    Case {
        name: "overrun",
        anew: false,
        bring: |_, request| request.timing = Timing::Overrun,
        is: |fault| *fault == Fault::Overrun,
        mode: Mode::RampingDown,
        within: 1,
        watchdog: Watchdog::Withhold,
    },
    Case {
        name: "set point beyond the stroke",
        anew: false,
        bring: |_, request| request.set_point.position = percent(101),
        is: |fault| matches!(fault, Fault::SetPointOutside { .. }),
        mode: Mode::Holding,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "set point too fast",
        anew: false,
        bring: |_, request| request.set_point.velocity = percent(-700),
        is: |fault| matches!(fault, Fault::SetPointOutside { .. }),
        mode: Mode::Holding,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "set point jumps",
        anew: false,
        bring: |_, request| request.set_point.position = percent(45),
        is: |fault| *fault == Fault::SetPointJump { from: percent(30), to: percent(45) },
        mode: Mode::Holding,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "set point accelerates",
        anew: false,
        bring: |_, request| request.set_point.velocity = percent(5),
        is: |fault| matches!(fault, Fault::SetPointSteep { .. }),
        mode: Mode::Holding,
        within: 1,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "rod leaves its set point slowly",
        anew: true,
        bring: |world, _| world.count -= 15, // 0.21 m/s: a fifth of the stroke in 288 periods
        is: |fault| matches!(fault, Fault::FollowingError { off } if *off < percent(-20)),
        mode: Mode::Neutral,
        within: 310,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "rod leaves its set point fast",
        anew: true,
        bring: |world, _| world.count -= 30, // 0.42 m/s
        is: |fault| matches!(fault, Fault::VelocityError { .. }),
        mode: Mode::Neutral,
        within: 30,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "spool is elsewhere than its model",
        anew: false,
        bring: |world, _| world.spool_off = Some(percent(11)),
        is: |fault| *fault == Fault::SpoolDeviates { off: percent(11) },
        mode: Mode::Neutral,
        within: 5,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "rod leaves its range",
        anew: true,
        bring: |world, _| world.count += 15, // 15 % of the stroke in 216 periods
        is: |fault| matches!(fault, Fault::PositionOutside { .. }),
        mode: Mode::Neutral,
        within: 217,
        watchdog: Watchdog::Feed,
    },
    Case {
        name: "another voltage at the valve",
        anew: true, // the output writes the voltage that is read back
        bring: |world, _| world.voltages[0] = VOLT,
        is: |fault| matches!(fault, Fault::OutputAway { .. }),
        mode: Mode::Neutral,
        within: 6,
        watchdog: Watchdog::Feed,
    },
];

/// Runs with a fault present, until it is logged or so many periods are over.
fn run_with(bench: &mut Bench, case: &Case, periods: u32, until_told: bool) -> Option<Report> {
    let mut report = None;
    for period in 0..periods {
        if period == 0 || case.anew {
            (case.bring)(&mut bench.world.borrow_mut(), &mut bench.request);
        }
        report = Some(bench.command(None));
        if until_told && !bench.told.faults.is_empty() {
            break;
        }
    }
    report
}

/// Restores everything except the rod and the voltage that is read back.
fn cure(bench: &mut Bench, before: &World, request: Request) {
    let (count, voltage) = (bench.world.borrow().count, bench.world.borrow().voltages[0]);
    let [_, others @ ..] = before.voltages;
    let voltages = [voltage, others[0], others[1], others[2]];
    *bench.world.borrow_mut() = World { count, voltages, ..before.clone() };
    bench.request = request;
}

#[test]
fn every_fault_has_its_state_in_time_is_told_once_and_goes_by_command_only() {
    for case in &CASES {
        let Case { name, is, mode, within, watchdog, .. } = *case;
        let mut bench = Bench::following();
        let (world, request) = (bench.world.borrow().clone(), bench.request);
        let report = run_with(&mut bench, case, within.into(), true).unwrap();
        assert!(matches!(bench.told.faults[..], [ref fault] if is(fault)), "{name}: {:?}", bench.told.faults);
        assert!(report.active_faults.has(&bench.told.faults[0]), "{name}");
        assert_eq!((report.mode, report.watchdog), (mode, watchdog), "{name}");
        let fault = bench.told.faults[0];
        assert_eq!(report.shut_off, fault.needs_shut_off() || fault.loses_place(), "{name}");
        if mode == Mode::Neutral {
            assert_eq!(report.command, neutral(), "{name}");
        }

        // The fault remains: nothing new is logged, and a ramp arrives in its time.
        let settled = if mode == Mode::Holding { Mode::Holding } else { Mode::Neutral };
        let later = run_with(&mut bench, case, limits().periods_to_neutral(), false).unwrap();
        assert_eq!((later.mode, bench.told.faults.len()), (settled, 1), "{name}");

        // Its cause is removed: still only a command changes the mode.
        cure(&mut bench, &world, request);
        assert_eq!(bench.run(300).mode, settled, "{name}");
        assert_eq!(bench.command(Some(Command::Follow)).mode, settled, "{name}");
        let acknowledged = bench.command(Some(Command::Acknowledge));
        assert_eq!(acknowledged.answer, Some(Answer::Taken), "{name}");
        assert!(acknowledged.active_faults.is_empty(), "{name}");
        if settled == Mode::Neutral {
            assert_eq!(acknowledged.mode, Mode::Starting, "{name}");
            if bench.told.faults[0].loses_place() {
                assert_eq!(bench.command(Some(Command::Follow)).answer, Some(Answer::Lost), "{name}");
                assert!(bench.period.home(percent(30)));
            }
            // The rod may have moved.
            bench.request.set_point.position = acknowledged.measured.position;
            if bench.told.faults[0].loses_place() {
                bench.request.set_point.position = percent(30);
            }
            bench.follow();
        }
        assert_eq!(bench.run(20).mode, Mode::Following, "{name}");
        assert_eq!(bench.told.faults.len(), 1, "{name}: {:?}", bench.told.faults);

        // The same fault again is logged again.
        run_with(&mut bench, case, within.into(), false);
        assert_eq!(bench.told.faults.len(), 2, "{name}: {:?}", bench.told.faults);
    }
}
