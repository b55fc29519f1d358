//! Fixed point, single precision and f64 are the same model with each effect on, alone and all together, and no input overflows.

use proptest::prelude::*;

use model_core::drive::{Drive, DriveInput, Load};
use model_core::effects::Effect;
use model_core::machine::{BASE_FORMS, Form, Machine, Parameter as P, Tick};
use model_core::number::{Number, PerUnit, Scalar, Single};
use model_core::ports::ChamberState;

use super::bench::{State, at_rest, cases, command, commanded, drive, effects, every_effect, oil_at, press, with};

/// Tolerance of the sensed position over 1.2 s, strokes. Dry friction decides it: the last bit may let the rod go a tick earlier.
const POSITION: f64 = 2e-6;
/// Tolerance of the pressures at its end, supply pressures; a stop that is met a tick sooner presses sooner.
const PRESSURE: f64 = 1e-5;

fn run<N: Scalar<Real = f64>>(machine: &Machine<f64>) -> (Vec<f64>, [f64; 2]) {
    let drive = drive::<N>(machine);
    let mut state = at_rest(&drive, [0.3, 0.5], 0.4);
    let positions = (0..1200)
        .map(|tick| {
            // From 30 to 70 °C.
            oil_at(&drive, &mut state, 30.0 + tick as f64 / 30.0);
            commanded(&drive, &mut state, command(tick));
            N::strokes(drive.sensed(&state).position)
        })
        .collect();
    let sensed = drive.sensed(&state);
    (positions, [sensed.pressure_a.to_f64(), sensed.pressure_b.to_f64()])
}

fn apart<N: Scalar<Real = f64>>(machine: &Machine<f64>) -> (f64, f64) {
    let (fixed, real) = (run::<N>(machine), run::<f64>(machine));
    let position = fixed.0.iter().zip(&real.0).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    let pressure = fixed.1.iter().zip(&real.1).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    (position, pressure)
}

/// Distance from the farthest in to the farthest out, strokes.
fn travelled(machine: &Machine<f64>) -> f64 {
    let (positions, _) = run::<f64>(machine);
    positions.iter().copied().fold(f64::MIN, f64::max) - positions.iter().copied().fold(f64::MAX, f64::min)
}

#[test]
fn fixed_point_and_single_precision_agree_with_f64_with_each_effect_and_base_form() {
    let mut failed = false;
    let plain = run::<f64>(&press());
    // No chamber of this drive comes near a floor: cavitation has a file of its own.
    let strong = every_effect().filter(|(effect, _)| *effect != Effect::Cavitation).map(|(_, form)| form);
    for Form { name, values } in strong.chain(BASE_FORMS) {
        assert_ne!(run::<f64>(&with(&press(), values)), plain, "{name} changes nothing: no equation has it");
        let (position, pressure) = apart::<PerUnit>(&with(&press(), values));
        let single = apart::<Single>(&with(&press(), values));
        let ends = travelled(&with(&press(), values));
        assert!(ends > 0.03, "{name}: the drive moves, {ends}");
        println!(
            "{name:<36} {position:.1e} strokes, {pressure:.1e} supplies, in f32 {:.1e}, {:.1e}",
            single.0, single.1
        );
        failed |= !(position < POSITION && pressure < PRESSURE);
        failed |= !(single.0 < POSITION && single.1 < PRESSURE);
    }
    assert!(!failed);
}

fn all_on() -> Machine<f64> {
    effects().fold(press(), |machine, (_, form)| with(&machine, form.values))
}

#[test]
fn links_alone_reproduce_the_step_with_everything_on() {
    fn check<N: Scalar<Real = f64>>() {
        let drive = drive::<N>(&all_on());
        let mut whole = at_rest(&drive, [0.3, 0.5], 0.4);
        let (mut chambers, mut rest, mut voids, mut motion) = (whole.chambers, whole.rest, whole.voids, whole.motion);
        for tick in 0..1200 {
            let seen = commanded(&drive, &mut whole, command(tick));
            drive.chambers().step(
                &mut chambers,
                &mut rest,
                &mut voids,
                seen.flows,
                seen.velocity,
                (seen.midway, seen.position),
            );
            assert_eq!(
                (chambers, rest, voids),
                (whole.chambers, whole.rest, whole.voids),
                "the chambers alone, tick {tick}"
            );
            assert_eq!(drive.mechanics().step(&mut motion, seen.forces), seen.velocity, "tick {tick}");
            assert_eq!(motion, whole.motion, "the mechanics alone, tick {tick}");
        }
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

fn any_word() -> impl Strategy<Value = PerUnit> {
    let word = (any::<i32>(), 0_u32..31).prop_map(|(bits, small)| bits >> small);
    prop_oneof![3 => word, 1 => prop::sample::select(vec![i32::MIN, -1, 0, i32::MAX])].prop_map(PerUnit::from_bits)
}

proptest! {
    #![proptest_config(cases(3000))]

    #[test]
    fn no_state_and_no_input_overflows_with_any_effects(
        on in any::<u32>(),
        strength in 0.01..3.0_f64,
        tick in prop::sample::select(vec![Tick::HalfMillisecond, Tick::OneMillisecond, Tick::TwoMilliseconds]),
        words in prop::array::uniform6(any_word()),
        position in any::<i64>(),
        warmth in any::<i64>(),
        inputs in prop::collection::vec((any_word(), any_word(), any_word(), any::<bool>()), 1..20),
    ) {
        let mut machine = press();
        for (index, (_, form)) in effects().enumerate() {
            if on >> index & 1 == 1 {
                for &(parameter, value) in form.values {
                    let description = parameter.description();
                    machine.set(parameter, (strength * value).clamp(description.min, description.max.min(0.9 * description.max)));
                }
            }
        }
        if let Ok(drive) = Drive::<PerUnit>::new::<64>(&machine, tick) {
            let [a, b, velocity, bristles, rest_a, rest_b] = words;
            let travel = <PerUnit as Number>::Travel::from_bits;
            let mut state: State<PerUnit> = drive.at_rest(a, ChamberState { a, b }, travel(position));
            state.rest = ChamberState { a: rest_a, b: rest_b };
            state.motion.velocity = velocity;
            state.motion.bristles = bristles;
            state.warmth = travel(warmth);
            for (first, second, load, force) in inputs {
                state.oil_temperature = load;
                let drive_input = if force { DriveInput::Force { from: first, to: second } } else { DriveInput::Command(first) };
                drive.step(&mut state, drive_input, Load { from: load, to: second });
                let _ = drive.sensed(&state);
            }
        }
    }

}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn a_drive_thrown_far_off_with_everything_on_comes_to_rest(
        start in prop::array::uniform2(-1.5..1.5_f64), velocity in -8.0..8.0_f64, air in 0.0..0.05_f64,
    ) {
        // Without leakage: a drive that leaks creeps.
        let tight = [P::ExternalLeakageA, P::ExternalLeakageB, P::InternalLeakage].map(|leakage| (leakage, 0.0));
        let drive = drive::<PerUnit>(&with(&with(&all_on(), &tight), &[(P::AirShare, air)]));
        let mut state = at_rest(&drive, start, 0.5);
        state.motion.velocity = PerUnit::saturated(velocity);
        for _ in 0..3000 {
            commanded(&drive, &mut state, 0.0);
        }
        prop_assert!(state.motion.velocity.to_f64().abs() < 1e-3, "{:?}", state.motion);
    }
}
