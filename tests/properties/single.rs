//! Single precision: nothing infinite and no NaN arises, whatever a drive is given, and it is the model that `f64` computes.

use proptest::prelude::*;

use model_core::drive::{Drive, Load};
use model_core::machine::{Parameter as P, Source};
use model_core::number::{Number, Single};
use model_core::ports::ChamberState;
use serde_json::{Value, json};
use system_tests::any_effects::any_effects;
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{DELAY, State};

use super::agreement::{Budget, assert_agrees};
use super::cases;
use super::extremes::any_drive_input;

/// Any bits, and values of usual size as often.
fn any_word() -> impl Strategy<Value = Single> {
    prop_oneof![
        2 => any::<u32>().prop_map(f32::from_bits),
        2 => (-8.0_f32..8.0, 0_i32..40).prop_map(|(value, small)| value * 0.5_f32.powi(small)),
        1 => prop::sample::select(vec![f32::NAN, f32::INFINITY, -f32::INFINITY, 8.0, -8.0, 0.0, -0.0]),
    ]
    .prop_map(Single::from)
}

/// Replaces every real number of a stored state.
fn scramble(stored: &mut Value, words: &mut impl Iterator<Item = f64>) {
    match stored {
        Value::Number(number) if number.is_f64() => *stored = json!(words.next().unwrap()),
        Value::Array(items) => items.iter_mut().for_each(|item| scramble(item, words)),
        Value::Object(fields) => fields.values_mut().for_each(|field| scramble(field, words)),
        _ => {}
    }
}

/// A state in which every signal is arbitrary, the private ones too: what a damaged store might hold.
fn any_state(drive: &Drive<Single>, words: &[Single]) -> State<Single> {
    let pressures = ChamberState { a: Single::ZERO, b: Single::ZERO };
    let mut stored =
        serde_json::to_value(drive.at_rest::<DELAY>(Single::ZERO, pressures, Single::travel(0.5))).unwrap();
    // Above the range, as well.
    let mut words = words.iter().cycle().enumerate().map(|(index, word)| word.to_f64() * [1.0, 1e3, 1e-3][index % 3]);
    scramble(&mut stored, &mut words);
    serde_json::from_value(stored).unwrap()
}

proptest! {
    #![proptest_config(cases(3000))]

    #[test]
    fn no_state_and_no_input_makes_anything_infinite(
        machine in any_machine(),
        tick in any_tick(),
        source in prop::sample::select(vec![Source::Valve, Source::Valve, Source::Pump, Source::Force]),
        effects in prop::option::of(any_effects()),
        words in prop::collection::vec(any_word(), 61),
        inputs in prop::collection::vec((any_drive_input(any_word), any_word(), any_word(), any_word()), 1..30),
    ) {
        let mut machine = machine;
        machine.source = source;
        if source == Source::Pump {
            machine.set(P::PumpDisplacement, machine.get(P::AreaB) / 50.0 * 0.2);
            machine.set(P::PumpSlip, machine.get(P::InternalLeakage));
        }
        if let Some(effects) = effects {
            machine = effects.on(&machine);
        }
        let drive = Drive::<Single>::new::<DELAY>(&machine, tick);
        prop_assume!(drive.is_ok());
        let drive = drive.unwrap();
        let mut state = any_state(&drive, &words);
        for (drive_input, from, to, temperature) in inputs {
            state.oil_temperature = temperature;
            let seen = drive.step(&mut state, drive_input, Load { from, to });
            let text = format!("{state:?} {seen:?} {:?}", drive.sensed(&state));
            prop_assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
            for kept in [state.chambers.a, state.chambers.b, state.motion.velocity] {
                prop_assert!(kept.value().abs() <= 8.0, "{kept:?}");
            }
        }
    }
}

/// Ten times that of fixed point; over the travel, less.
const BUDGET: Budget = Budget { position: 1e-4, pressure: 1e-3, travel_share: 1e-5 };

#[test]
fn single_precision_and_f64_agree_for_every_drive() {
    assert_agrees::<Single>(&BUDGET, file!());
}
