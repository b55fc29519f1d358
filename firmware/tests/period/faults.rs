//! Every fault, brought about: its state in time, told once, gone by command only.

use firmware::edge::Cause;
use firmware::fault::{Device, Fault};
use firmware::measured::Signal;
use firmware::mode::{Command, Mode};
use firmware::period::{Answer, Request, Timing, Watchdog};

use crate::bench::{Bench, VOLT, World, limits, neutral, percent};

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
