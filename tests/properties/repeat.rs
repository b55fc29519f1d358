//! The same run gives the same result, bit for bit: run twice, stored and continued, or with effects of nothing.

use proptest::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use model_core::drive::{Drive, DriveInput, Interfaces, Load};
use model_core::machine::{Machine, Parameter as P, Tick};
use model_core::number::{PerUnit, Scalar};
use recording::excitation::signals::Excitation;
use system_tests::any_effects::any_effects;
use system_tests::any_machine::{any_machine, any_plain_machine, any_tick};
use system_tests::simulate::{DELAY, State, at_rest, command, drive};
use virtual_plant::InitialState;

use super::cases;

fn run<N: Scalar<Real = f64>>(drive: &Drive<N>, state: &mut State<N>, volts: &[f64]) -> Vec<Interfaces<N>> {
    volts.iter().map(|&volts| drive.step(state, DriveInput::Command(command(volts)), Load::NONE)).collect()
}

fn stored_and_continued<N>(machine: &Machine<f64>, tick: Tick, volts: &[f64], at: usize)
where
    N: Scalar<Real = f64> + Serialize + DeserializeOwned,
    N::Travel: Serialize + DeserializeOwned,
{
    let drive = drive::<N>(machine, tick);
    let start = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.5 * machine.get(P::Stroke)));
    let (mut through, mut first) = (start, start);
    let whole = run(&drive, &mut through, volts);
    run(&drive, &mut first, &volts[..at]);
    let text = serde_json::to_string(&first).unwrap();
    let mut second: State<N> = serde_json::from_str(&text).unwrap();
    assert_eq!(first, second, "what is read is what was stored");
    assert_eq!(run(&drive, &mut second, &volts[at..]), whole[at..], "it goes on as if nothing had been");
    assert_eq!(second, through);
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn a_run_that_is_stored_and_continued_is_the_run(
        machine in any_machine(),
        tick in any_tick(),
        effects in any_effects(),
        seed in any::<u64>(),
        at in 0_usize..1000,
    ) {
        let machine = effects.on(&machine);
        prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
        let volts = Excitation::random_steps(seed).sample(1e-3);
        stored_and_continued::<PerUnit>(&machine, tick, &volts[..1000], at);
        stored_and_continued::<f64>(&machine, tick, &volts[..1000], at);
    }

    #[test]
    fn a_run_can_be_repeated(
        machine in any_machine(),
        tick in any_tick(),
        effects in any_effects(),
        seed in any::<u64>(),
    ) {
        let machine = effects.on(&machine);
        prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
        let volts = &Excitation::random_steps(seed).sample(1e-3)[..1000];
        let once = || {
            let drive = drive::<PerUnit>(&machine, tick);
            let mut state = at_rest(&drive, 0.0, &InitialState::at_rest(&machine, 0.5 * machine.get(P::Stroke)));
            (run(&drive, &mut state, volts), state)
        };
        prop_assert_eq!(once(), once());
    }

    /// With effects too small for the format, the result is that of the model without them: their mere presence adds nothing.
    #[test]
    fn an_effect_of_nothing_changes_nothing(machine in any_plain_machine(), tick in any_tick(), seed in any::<u64>()) {
        let volts = &Excitation::random_steps(seed).sample(1e-3)[..1000];
        let with = |leakage: f64, hose: f64, friction_n: f64| {
            let mut machine = machine;
            machine.set(P::InternalLeakage, leakage);
            machine.set(P::HoseCompliance, hose);
            machine.set(P::CoulombFriction, friction_n);
            let drive = drive::<PerUnit>(&machine, tick);
            let mut state = at_rest(&drive, 0.0, &InitialState::at_rest(&machine, 0.5 * machine.get(P::Stroke)));
            (run(&drive, &mut state, volts), state)
        };
        let without = with(0.0, 0.0, 0.0);
        prop_assert_eq!(&with(1e-30, 0.0, 0.0), &without, "leakage");
        prop_assert_eq!(&with(0.0, 1e-30, 0.0), &without, "hose");
        prop_assert_eq!(&with(0.0, 0.0, 1e-12), &without, "friction");
    }
}
