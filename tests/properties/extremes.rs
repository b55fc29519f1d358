//! No input of any size overflows or panics: debug builds check every sum.

use proptest::prelude::*;
use serde_json::Value;

use model_core::drive::{Drive, DriveInput, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, Parameter as P, Source, Tick};
use model_core::number::{Number, PerUnit, Scalar, Single};
use model_core::ports::{ChamberState, Flows, Forces, MotionState, Spool, Surroundings};
use system_tests::any_effects::any_effects;
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{DELAY, State, any_word, drive};

use super::cases;

/// Any drive input of such words.
pub(crate) fn any_drive_input<N: Number, W: Strategy<Value = N>>(
    any_word: impl Fn() -> W,
) -> impl Strategy<Value = DriveInput<N>> {
    prop_oneof![
        any_word().prop_map(DriveInput::Command),
        (any_word(), any_word()).prop_map(|(from, to)| DriveInput::Spool(Spool { from, to })),
        (any_word(), any_word(), any_word())
            .prop_map(|(command, from, to)| DriveInput::Followed { command, spool: Spool { from, to } }),
        (any_word(), any::<i8>()).prop_map(|(speed, direction)| DriveInput::Pump(PumpDrive { speed, direction })),
        (any_word(), any_word(), any_word(), any_word())
            .prop_map(|(a, b, c, d)| DriveInput::Flow { from: Flows { a, b }, to: Flows { a: c, b: d } }),
        (any_word(), any_word()).prop_map(|(from, to)| DriveInput::Force { from, to }),
    ]
}

fn any_load() -> impl Strategy<Value = Load<PerUnit>> {
    (any_word(), any_word()).prop_map(|(from, to)| Load { from, to })
}

/// Replaces every word of a stored state.
fn scramble(stored: &mut Value, words: &mut impl Iterator<Item = i64>) {
    match stored {
        Value::Number(number) => {
            let word = words.next().unwrap();
            let fits = number.as_i64().is_some_and(|old| i32::try_from(old).is_ok());
            *number = if fits { (word >> 32).into() } else { word.into() };
        }
        Value::Array(items) => items.iter_mut().for_each(|item| scramble(item, words)),
        Value::Object(fields) => fields.values_mut().for_each(|field| scramble(field, words)),
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// A state in which every word is arbitrary, the private ones too: what a damaged store might hold.
fn any_state(drive: &Drive<PerUnit>, seed: u64) -> State<PerUnit> {
    // A position beyond 32 bits marks the one word that is 64 bits wide.
    let rest = drive.at_rest::<DELAY>(
        PerUnit::ZERO,
        ChamberState { a: PerUnit::ZERO, b: PerUnit::ZERO },
        PerUnit::travel(0.5),
    );
    let mut stored = serde_json::to_value(rest).unwrap();
    let head = stored["valve"]["head"].clone();
    let rings = ["valve", "sensed"];
    let mut state = seed;
    let mut words = std::iter::repeat_with(|| {
        // SplitMix64
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let word = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (word ^ (word >> 31)).cast_signed()
    });
    scramble(&mut stored, &mut words);
    for ring in rings {
        stored[ring]["head"] = if seed & 1 == 0 { head.clone() } else { u32::MAX.into() };
    }
    serde_json::from_value(stored).unwrap()
}

proptest! {
    #![proptest_config(cases(3000))]

    #[test]
    fn no_state_and_no_input_overflows(
        machine in any_machine(),
        tick in any_tick(),
        source in prop::sample::select(vec![Source::Valve, Source::Pump, Source::Force]),
        effects in prop::option::of(any_effects()),
        seed in any::<u64>(),
        inputs in prop::collection::vec((any_drive_input(any_word), any_load()), 1..30),
    ) {
        let mut machine = machine;
        machine.source = source;
        if source == Source::Pump {
            machine.set(P::PumpDisplacement, machine.get(P::AreaB) / 50.0 * 0.2);
            machine.set(P::PumpSlip, machine.get(P::InternalLeakage));
        }
        let plain = effects.is_none();
        if let Some(effects) = effects {
            machine = effects.on(&machine);
        }
        let drive = Drive::<PerUnit>::new::<DELAY>(&machine, tick);
        prop_assume!(source != Source::Pump && plain || drive.is_ok());
        let drive = drive.unwrap();
        let mut state = any_state(&drive, seed);
        for (drive_input, load) in inputs {
            drive.step(&mut state, drive_input, load);
        }
    }

    #[test]
    fn no_link_alone_overflows(
        machine in any_machine(),
        tick in any_tick(),
        seed in any::<u64>(),
        words in prop::array::uniform10(any_word()),
        others in prop::array::uniform4(any_word()),
        position in any::<i64>(),
    ) {
        let drive = Drive::<PerUnit>::new::<DELAY>(&machine, tick).unwrap();
        let [command, spool, a, b, flow_a, flow_b, velocity, speed, first, second] = words;
        let mut state = any_state(&drive, seed);
        drive.valve().unwrap().step(&mut state.valve, command);
        let _ = drive.flows(spool, PumpDrive { speed: command, direction: 1 }, ChamberState { a, b });
        let before = state.chambers;
        drive.chambers().step(&mut state.chambers, &mut state.rest, &mut state.voids, Flows { a: flow_a, b: flow_b }, speed, (before, b));
        let position = <PerUnit as Number>::Travel::from_bits(position);
        let [bristles, pressed, viscosity, _] = others;
        let mut motion = MotionState { velocity, position, bristles };
        let around = Surroundings { pressed, viscosity, ..Surroundings::NONE };
        drive.mechanics().step(&mut motion, Forces { start: speed, first, second, around });
    }
}

/// The drive with its valve closed, started far from rest: pressures in supply pressures, velocity in its base. Returns its largest velocity in the
/// second half of 3000 ticks.
fn thrown<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, [a, b, velocity]: [f64; 3]) -> f64 {
    let drive = drive::<N>(machine, tick);
    let pressures = ChamberState { a: N::saturated(a), b: N::saturated(b) };
    let mut state: State<N> = drive.at_rest(N::ZERO, pressures, N::travel(0.0));
    state.motion.velocity = N::saturated(velocity);
    let mut speed = || {
        drive.step(&mut state, DriveInput::Command(N::ZERO), Load::NONE);
        state.motion.velocity.to_f64().abs()
    };
    (0..3000).map(|tick| if tick < 1500 { 0.0 * speed() } else { speed() }).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(cases(1000))]

    /// In fixed point the stages of a stiff drive are limited to ±8: this limit must not keep the rod moving.
    #[test]
    fn a_drive_thrown_far_off_comes_to_rest(
        machine in any_machine(),
        tick in any_tick(),
        pressures in prop::array::uniform2(-1.5..1.5_f64),
        velocity in -8.0..8.0_f64,
    ) {
        let mut machine = machine;
        machine.set(P::ValveOffset, 0.0);
        machine.set(P::DeadZone, 0.05);
        let start = [pressures[0], pressures[1], velocity];
        let real = thrown::<f64>(&machine, tick, start);
        let fixed = thrown::<PerUnit>(&machine, tick, start);
        prop_assert!(fixed <= 0.05 + 2.0 * real, "{fixed}, {real} in f64");
        let single = thrown::<Single>(&machine, tick, start);
        prop_assert!(single <= 0.05 + 2.0 * real, "{single} in f32, {real} in f64");
    }
}
