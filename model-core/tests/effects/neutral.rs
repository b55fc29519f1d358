//! An effect whose amount is 0 is the model without it, bit for bit, whatever its other parameters are.

use proptest::prelude::*;

use model_core::drive::DriveInput;
use model_core::effects::{Effect, Link};
use model_core::machine::{Machine, Parameter as P};
use model_core::number::{PerUnit, Scalar};

use super::bench::{State, at_rest, cases, command, commanded, drive, press, with};

fn run<N: Scalar<Real = f64>>(machine: &Machine<f64>) -> Vec<State<N>> {
    let drive = drive::<N>(machine);
    let mut state = at_rest(&drive, [0.3, 0.5], 0.4);
    let step = |tick: usize| {
        if tick % 500 < 450 {
            commanded(&drive, &mut state, command(tick));
        } else {
            let force = N::saturated(0.1);
            drive.step(&mut state, DriveInput::Force { from: force, to: force }, model_core::drive::Load::NONE);
        }
        let sensed = drive.sensed(&state);
        assert_eq!(sensed.position, state.motion.position, "the exact position is sensed");
        assert_eq!((sensed.pressure_a, sensed.pressure_b), (state.chambers.a, state.chambers.b));
        assert_eq!((sensed.spool, sensed.velocity), (state.valve.spool(), state.motion.velocity));
        state
    };
    (0..1200).map(step).collect()
}

/// Parameters without any influence while the amount of their effect is 0.
const SECONDARY: [(P, f64, f64); 11] = [
    (P::StribeckVelocity, 1e-5, 10.0),
    (P::StopRetracted, -1.0, 1.0),
    (P::StopExtended, -1.0, 1.0),
    (P::WarmingTime, 1e-2, 1e5),
    (P::ReferenceTemperature, -20.0, 120.0),
    (P::ValveLeakageReach, 4e-3, 1.0),
    (P::NullDriftTime, 1e-2, 1e5),
    (P::PilotRatio, 0.0, 15.0),
    (P::HoldingSpan, 1e4, 1e9),
    (P::HoldingSize, 0.01, 2.0),
    (P::HoldingTime, 2e-3, 1.0),
];

proptest! {
    #![proptest_config(cases(20))]

    #[test]
    fn nothing_of_an_effect_is_the_model_without_it(
        shares in prop::array::uniform11(0.0..1.0_f64),
        friction_n in prop::sample::select(vec![0.0, 700.0]),
        leakage in prop::sample::select(vec![0.0, 3e-12]),
    ) {
        let plain = with(&press(), &[(P::CoulombFriction, friction_n), (P::InternalLeakage, leakage)]);
        let mut neutral = plain;
        for ((parameter, low, high), share) in SECONDARY.into_iter().zip(shares) {
            neutral.set(parameter, low + share * (high - low));
        }
        prop_assert!(run::<PerUnit>(&neutral) == run::<PerUnit>(&plain));
        prop_assert!(run::<f64>(&neutral) == run::<f64>(&plain));
    }
}

/// Where an amount is too small to change a bit, the code that it switches on computes the same as the code without it.
#[test]
fn next_to_nothing_of_an_effect_is_next_to_nothing() {
    let plain = run::<f64>(&press());
    for (_, form) in
        super::bench::effects().filter(|(effect, _)| effect.link() != Link::Sensing && *effect != Effect::Cavitation)
    {
        let faint: Vec<(P, f64)> = form
            .values
            .iter()
            .map(|&(parameter, value)| match parameter {
                P::StribeckVelocity | P::WarmingTime | P::ReferenceTemperature | P::PreslidingStiffness => {
                    (parameter, value)
                }
                P::StopRetracted => (parameter, -1.0),
                P::StopExtended => (parameter, 1.0),
                _ => (parameter, 1e-12 * value),
            })
            .collect();
        let found = run::<f64>(&with(&press(), &faint));
        for (a, b) in found.iter().zip(&plain) {
            let apart = (a.motion.position - b.motion.position).abs().max((a.chambers.a - b.chambers.a).abs());
            assert!(apart < 1e-9, "{}: {apart:e}", form.name);
        }
    }
}
