//! The drive as a task of RTIC, and the control period as one of Embassy: the emulated board prints what the host computes, and every period keeps its time.

use std::fmt::Write;

use model_core::drive::{BakedDrive, DriveInput, DriveState, Load};
use model_core::number::{Number, PerUnit};
use model_core::ports::ChamberState;
use simulated_press::short_run;
use system_tests::emulator::Processor;

/// The drive of the program.
#[expect(dead_code, unreachable_pub, reason = "an exported file is for anybody, and not all of it is needed")]
mod params {
    include!("../../firmware/baked.rs");
}

fn assert_rows(found: &str, expected: &str) {
    for (number, (found, expected)) in found.lines().zip(expected.lines()).enumerate() {
        assert_eq!(found, expected, "row {}: the board, then the host", number + 1);
    }
    assert_eq!(found.lines().count(), expected.lines().count(), "{found}");
}

/// The trace of the program with RTIC.
fn trace() -> String {
    let drive = BakedDrive::<params::Exported>::new();
    let half = PerUnit::ONE.halved();
    let pressures = ChamberState { a: half, b: half };
    let mut state: DriveState<PerUnit, { params::DELAY_LINE }> =
        drive.at_rest(PerUnit::ZERO, pressures, half.as_travel());
    let mut rows = String::new();
    for tick in 1..=600 {
        let volts = if tick <= 300 { 5.0 } else { -2.5 };
        drive.step(&mut state, DriveInput::Command(PerUnit::saturated(volts / 10.0)), Load::NONE);
        if tick % 50 == 0 {
            let words = [state.valve.spool(), state.chambers.a, state.chambers.b, state.motion.velocity];
            let [words, position] =
                [format!("{:?}", words.map(PerUnit::to_bits)), state.motion.position.to_bits().to_string()];
            writeln!(rows, "{tick} {words} {position}, overruns 0").unwrap();
        }
    }
    rows
}

#[test]
fn a_baked_drive_as_a_task_of_rtic_prints_the_hosts_trace_and_no_tick_is_late() {
    let processor = Processor::M4F;
    if processor.can_be_emulated() {
        let expected = trace();
        assert_eq!(expected.lines().count(), 12);
        assert_rows(&processor.run_program("mps2-rtic"), &expected);
    }
}

#[test]
fn a_control_period_that_awaits_its_buses_under_embassy_prints_what_the_blocking_one_does_on_the_host() {
    let processor = Processor::M4F;
    if processor.can_be_emulated() {
        let mut expected = String::new();
        short_run::blocking(&mut expected).unwrap();
        assert_eq!(expected.lines().count(), 20);
        assert_rows(&processor.run_program("mps2-embassy"), &expected);
    }
}
