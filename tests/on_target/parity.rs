//! Host and target compute the same, bit for bit: coefficients, every word of the state, every output, of every trial.

use std::collections::BTreeSet;

use model_core::number::{PerUnit, Single};
use mps2::trial::cases;
use system_tests::emulator::Processor;

fn host() -> String {
    let mut text = String::new();
    for case in cases() {
        case.trace::<PerUnit>(&mut text).unwrap_or_else(|error| panic!("{case}: {error:?}"));
    }
    for case in cases() {
        case.trace::<Single>(&mut text).unwrap_or_else(|error| panic!("{case} in f32: {error:?}"));
    }
    text
}

fn assert_parity(processor: Processor) {
    if !processor.can_be_emulated() {
        return;
    }
    let (host, target) = (host(), processor.run("parity"));
    for (number, (here, there)) in host.lines().zip(target.lines()).enumerate() {
        assert_eq!(here, there, "line {} of the trace: the host, then {processor:?}", number + 1);
    }
    assert_eq!(host.lines().count(), target.lines().count());
}

#[test]
fn a_cortex_m4f_computes_what_the_host_does_bit_for_bit() {
    assert_parity(Processor::M4F);
}

#[test]
fn a_cortex_m3_computes_what_the_host_does_bit_for_bit() {
    assert_parity(Processor::M3);
}

#[test]
fn two_runs_of_a_trial_are_alike_and_no_two_moments_of_it() {
    let case = cases().next().unwrap();
    let (mut once, mut again) = (String::new(), String::new());
    case.trace::<PerUnit>(&mut once).unwrap();
    case.trace::<PerUnit>(&mut again).unwrap();
    assert_eq!(once, again);
    let samples: BTreeSet<&str> = once.lines().skip(1).filter_map(|line| line.rsplit(' ').next()).collect();
    assert_eq!(samples.len(), 9, "one a second of 9.8 s");
}
