//! Valve, chambers and mechanics alone, and the drive driven by its spool: bit for bit.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

use model_core::drive::{DriveInput, Load};
use model_core::machine::{Machine, Tick};
use model_core::number::{PerUnit, Scalar};
use recording::excitation::signals::Excitation;
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::drives;
use system_tests::simulate::{State, at_rest, command, drive};
use virtual_plant::InitialState;

fn chain_and_links_agree<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, seed: u64) {
    let drive = drive::<N>(machine, tick);
    let valve = drive.valve().unwrap();
    let mut chain: State<N> = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.1));
    let (mut valve_alone, mut from_spool, mut followed) = (chain.valve, chain, chain);
    let (mut chambers_alone, mut rest_alone, mut voids_alone) = (chain.chambers, chain.rest, chain.voids);
    let mut mechanics_alone = chain.motion;
    for (tick, volts) in Excitation::random_steps(seed).sample(1e-3).into_iter().enumerate() {
        // A load that comes and goes, so that the whole model gets a load too.
        let load =
            if tick % 700 < 300 { Load::NONE } else { Load { from: N::saturated(0.05), to: N::saturated(0.05) } };
        let seen = drive.step(&mut chain, DriveInput::Command(command(volts)), load);
        let spool = seen.spool.unwrap();

        assert_eq!(valve.step(&mut valve_alone, command(volts)), spool, "the valve alone");
        assert_eq!(valve_alone, chain.valve);
        assert_eq!(spool.to, chain.valve.spool());

        assert_eq!(drive.step(&mut from_spool, DriveInput::Spool(spool), load), seen, "the drive from its spool on");
        assert_eq!(
            (from_spool.chambers, from_spool.rest, from_spool.motion),
            (chain.chambers, chain.rest, chain.motion)
        );

        let drive_input = DriveInput::Followed { command: command(volts), spool };
        assert_eq!(drive.step(&mut followed, drive_input, load), seen, "the valve beside a spool that is its own");
        assert_eq!(followed, chain);

        let alone = (&mut chambers_alone, &mut rest_alone, &mut voids_alone);
        drive.chambers().step(alone.0, alone.1, alone.2, seen.flows, seen.velocity, (seen.midway, seen.position));
        let chambers = (chain.chambers, chain.rest, chain.voids);
        assert_eq!((chambers_alone, rest_alone, voids_alone), chambers, "the chambers alone");

        assert_eq!(drive.mechanics().step(&mut mechanics_alone, seen.forces), seen.velocity, "the mechanics alone");
        assert_eq!(mechanics_alone, chain.motion);
    }
}

#[test]
fn a_followed_spool_keeps_what_the_valve_misses_from_the_rod() {
    let named = &drives::named()[0];
    let drive = drive::<f64>(&named.machine, Tick::OneMillisecond);
    let mut chain: State<f64> = at_rest(&drive, 0.0, &InitialState::at_rest(&named.machine, 0.1));
    let mut followed = chain;
    for _ in 0..300 {
        let seen = drive.step(&mut chain, DriveInput::Command(command(5.0)), Load::NONE);
        let drive_input = DriveInput::Followed { command: command(4.0), spool: seen.spool.unwrap() };
        drive.step(&mut followed, drive_input, Load::NONE);
    }
    assert_eq!((followed.motion, followed.chambers), (chain.motion, chain.chambers));
    assert!(followed.valve.spool() < 0.9 * chain.valve.spool(), "{} {}", followed.valve.spool(), chain.valve.spool());
}

#[test]
fn links_alone_reproduce_the_chain_of_each_named_drive() {
    for named in drives::named() {
        for tick in [Tick::HalfMillisecond, Tick::OneMillisecond, Tick::TwoMilliseconds] {
            chain_and_links_agree::<PerUnit>(&named.machine, tick, 1);
            chain_and_links_agree::<f64>(&named.machine, tick, 1);
        }
    }
}

proptest! {
    #![proptest_config(Config { cases: 100, rng_seed: RngSeed::Fixed(20_201), ..Config::default() })]

    #[test]
    fn links_alone_reproduce_the_chain_of_any_drive(machine in any_machine(), tick in any_tick(), seed in any::<u64>()) {
        chain_and_links_agree::<PerUnit>(&machine, tick, seed);
        chain_and_links_agree::<f64>(&machine, tick, seed);
    }
}
