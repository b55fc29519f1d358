extern crate std;

use proptest::prelude::*;

use super::*;
use crate::drive::{Drive, DriveInput, DriveState, Load};
use crate::machine::{Machine, MachineError, Parameter as P, Source, Tick};
use crate::number::{Number, Single};

fn press() -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Valve);
    for (parameter, value) in [
        (P::AreaA, 3.117e-3),
        (P::AreaB, 1.861e-3),
        (P::VolumeA, 5.2e-4),
        (P::VolumeB, 3.3e-4),
        (P::FlowLimit, 3.0e-4),
        (P::ValveGain, 0.0559),
        (P::ValveOffset, 0.0345),
        (P::DeadZone, 0.105),
        (P::DeadZoneDifference, 0.02),
        (P::RateLimit, 12.0),
        (P::TimeConstant1, 0.018),
        (P::TimeConstant2, 0.0279),
        (P::TransportDelay, 0.007),
        (P::ViscousFriction, 1e5),
    ] {
        machine.set(parameter, value);
    }
    machine
}

fn tuning() -> Tuning {
    Tuning { slew_v_per_s: 2000.0, pressure_damping_m_per_s_n: 1e-7, ..Tuning::by_rule(&press(), true) }
}

fn follower() -> Follower {
    Follower::new(&press(), &tuning(), Tick::OneMillisecond).unwrap()
}

fn seen_as<N: Scalar>(model: &Predicted<N>) -> Observed<N> {
    Observed { position: model.position, spool: Some(model.spool), pressures: Some(pressures(model)) }
}

fn resting(position: f64) -> Predicted {
    Predicted {
        spool: PerUnit::saturated(0.01),
        pressure_a: PerUnit::saturated(0.3),
        pressure_b: PerUnit::saturated(0.5),
        velocity: PerUnit::ZERO,
        position: PerUnit::saturated(position),
    }
}

fn volts(command: PerUnit) -> f64 {
    10.0 * command.to_f64()
}

#[test]
fn neutral_is_the_middle_of_the_overlap() {
    // Overlaps of 0.115 and 0.095: their middle is at +0.01, where the spool is at (0.01 − 0.0345)/0.0559 V.
    assert!((volts(follower().neutral()) + 0.438_282).abs() < 1e-5);
}

#[test]
fn a_start_bumps_nowhere() {
    let follower = follower();
    for (position, found) in [(0.02, 0.3), (0.5, -0.2), (0.97, 1.1)] {
        let model = resting(position);
        let pressures = Some(ChamberState { a: PerUnit::saturated(found), b: model.pressure_b });
        let seen = Observed { pressures, ..seen_as(&model) };
        let mut state = follower.at_rest(&model, &seen);
        let wanted = SetPoint { position: model.position, velocity: PerUnit::ZERO };
        for _ in 0..10 {
            let model_command = follower.model_command(&mut state, wanted, &model);
            let command = follower.command(&mut state, model_command, &model, &seen);
            assert!(volts(model_command - follower.neutral()).abs() < 1e-5);
            assert!(volts(command - follower.neutral()).abs() < 1e-5);
        }
    }
}

#[test]
fn a_machine_that_is_where_the_model_is_gets_the_models_command() {
    let follower = follower();
    let model = resting(0.4);
    let mut state = follower.at_rest(&model, &seen_as(&model));
    for tick in 0..400 {
        let velocity = PerUnit::saturated(0.3 * f64::sin(f64::from(tick) * 0.03));
        let wanted = SetPoint { position: model.position, velocity };
        let model_command = follower.model_command(&mut state, wanted, &model);
        let command = follower.command(&mut state, model_command, &model, &seen_as(&model));
        assert!(volts(command - model_command).abs() < 2e-3, "{tick}: {model_command:?} {command:?}");
    }
}

#[test]
fn a_driven_model_gets_its_command_by_the_slew_and_within_the_limit() {
    let follower = follower();
    let model = resting(0.4);
    let mut state = follower.at_rest(&model, &seen_as(&model));
    let from_v = volts(follower.neutral());
    // 2000 V/s are 2 V in a tick.
    for expected_v in [from_v - 2.0, from_v - 4.0, -6.0, -6.0] {
        let command = follower.driven_command(&mut state, PerUnit::saturated(-0.6), &model);
        assert!((volts(command) - expected_v).abs() < 1e-5, "{command:?} {expected_v}");
    }
    for _ in 0..10 {
        follower.driven_command(&mut state, PerUnit::from_bits(i32::MIN), &model);
    }
    assert!((volts(state.model_command) + 10.0).abs() < 1e-6, "{:?}", state.model_command);
}

#[test]
fn after_a_model_was_driven_its_loop_goes_on_as_fast_as_it_moves() {
    let follower = follower();
    let model = Predicted { velocity: PerUnit::saturated(0.1), ..resting(0.4) };
    let wanted = SetPoint { position: model.position, velocity: model.velocity };
    let mut led = follower.at_rest(&model, &seen_as(&model));
    for _ in 0..2000 {
        follower.model_command(&mut led, wanted, &model);
    }
    let mut driven = follower.at_rest(&model, &seen_as(&model));
    for _ in 0..2000 {
        follower.driven_command(&mut driven, led.model_command, &model);
    }
    let [led, driven] = [led, driven].map(|mut state| volts(follower.model_command(&mut state, wanted, &model)));
    assert!((led - driven).abs() < 1e-4, "{led} {driven}");
    // It is not the neutral command.
    assert!(led > volts(follower.neutral()) + 0.5, "{led}");
}

#[test]
fn the_integral_stands_still_while_the_output_is_held_and_turns_back_at_once() {
    let follower = follower();
    let model = resting(0.9);
    let far = Observed { position: PerUnit::ZERO, ..seen_as(&model) };
    let mut state = follower.at_rest(&model, &seen_as(&model));
    let mut run = |seen: &Observed, ticks: u32| {
        for _ in 0..ticks {
            follower.command(&mut state, follower.neutral(), &model, seen);
        }
        (state.integral(), state.command)
    };
    let (held, output) = run(&far, 50);
    assert!((volts(output) - 10.0).abs() < 1e-6);
    assert_eq!(run(&far, 5000), (held, output));
    let beyond = Observed { position: PerUnit::ONE, ..far };
    assert!(run(&beyond, 50).1 < output);
}

#[test]
fn the_integral_stands_still_while_the_velocity_is_held() {
    // The rod is held 20 % behind, while the output, at a tenth of its largest velocity, is far from its own limit.
    let tuning = Tuning { velocity_limit_m_per_s: 0.1 * tuning().velocity_limit_m_per_s, ..tuning() };
    let follower = Follower::new(&press(), &tuning, Tick::OneMillisecond).unwrap();
    let model = resting(0.5);
    let behind = Observed { position: PerUnit::saturated(0.3), ..seen_as(&model) };
    let mut state = follower.at_rest(&model, &seen_as(&model));
    for _ in 0..1000 {
        let command = follower.command(&mut state, follower.neutral(), &model, &behind);
        assert!(volts(command).abs() < 0.9 * tuning.command_limit_v);
    }
    assert_eq!(state.integral(), PerUnit::ZERO);
}

#[test]
fn what_the_sensor_cannot_tell_corrects_nothing() {
    let blunt = Tuning { position_resolution_m: 1e-3, ..tuning() };
    let follower = Follower::new(&press(), &blunt, Tick::OneMillisecond).unwrap();
    let model = resting(0.5);
    let mut state = follower.at_rest(&model, &seen_as(&model));
    let apart = |millimetres: f64| Observed {
        position: model.position - PerUnit::saturated(1e-3 * millimetres / 0.3),
        ..seen_as(&model)
    };
    for _ in 0..100 {
        let command = follower.command(&mut state, follower.neutral(), &model, &apart(0.49));
        assert!(volts(command - follower.neutral()).abs() < 1e-4);
    }
    let command = follower.command(&mut state, follower.neutral(), &model, &apart(0.7));
    assert!(volts(command - follower.neutral()) > 0.1);
}

/// The model on its own, commanded far in one step: its overshoot, and its largest error in the last second, m.
fn jump<N: Scalar<Real = f64>>(tuning: &Tuning) -> (f64, f64) {
    let follower = Follower::<N>::new(&press(), tuning, Tick::OneMillisecond).unwrap();
    let drive = Drive::<N>::new::<64>(&press(), Tick::OneMillisecond).unwrap();
    let pressures = ChamberState { a: N::saturated(0.2985), b: N::saturated(0.5) };
    let mut state: DriveState<N> = drive.at_rest(follower.neutral(), pressures, N::travel(0.2));
    let predicted = |state: &DriveState<N>| Predicted {
        spool: drive.spool(state),
        pressure_a: state.chambers.a,
        pressure_b: state.chambers.b,
        velocity: state.motion.velocity,
        position: N::of_travel(state.motion.position),
    };
    let mut loops = follower.at_rest(&predicted(&state), &seen_as(&predicted(&state)));
    let wanted = SetPoint { position: N::saturated(0.6), velocity: N::ZERO };
    let (mut over_m, mut left_m) = (0.0_f64, 0.0_f64);
    for tick in 0..4000 {
        let command = follower.model_command(&mut loops, wanted, &predicted(&state));
        drive.step(&mut state, DriveInput::Command(command), Load::NONE);
        let beyond_m = 0.3 * (predicted(&state).position - wanted.position).to_f64();
        over_m = over_m.max(beyond_m);
        if tick >= 3000 {
            left_m = left_m.max(beyond_m.abs());
        }
    }
    (over_m, left_m)
}

#[test]
fn a_model_that_is_sent_far_at_once_arrives_and_hardly_overshoots() {
    let (over_m, left_m) = jump::<PerUnit>(&tuning());
    assert!(over_m < 3e-4 && left_m < 2e-4, "{over_m} {left_m}");
    let single = jump::<Single>(&tuning());
    assert!((single.0 - over_m).abs() < 1e-6 && (single.1 - left_m).abs() < 1e-6, "{single:?}: {over_m} {left_m}");
}

#[test]
fn half_as_much_gain_again_does_not_make_it_swing() {
    let gains = tuning();
    for factor in [0.5, 1.2, 1.5] {
        let model_gain_per_s = factor * gains.model_gain_per_s;
        let (over_m, left_m) = jump::<PerUnit>(&Tuning { model_gain_per_s, ..gains });
        assert!(over_m < 2e-3 && left_m < 4e-4, "{factor}: {over_m} {left_m}");
    }
}

#[test]
fn what_does_not_fit_is_refused_with_its_value() {
    let refused = |machine: &Machine<f64>, tuning: &Tuning| {
        Follower::<PerUnit>::new(machine, tuning, Tick::OneMillisecond).unwrap_err()
    };
    let mut pump = press();
    pump.source = Source::Pump;
    assert_eq!(refused(&pump, &tuning()), FollowError::Source { found: Source::Pump });
    let mut none = press();
    none.set(P::AreaA, f64::NAN);
    let found = refused(&none, &tuning());
    assert!(matches!(found, FollowError::Machine(MachineError::OutOfRange { .. })), "{found}");
    let found = refused(&press(), &Tuning { model_gain_per_s: f64::NAN, ..tuning() });
    assert!(matches!(found, FollowError::Tuning { name: "model_gain_per_s", .. }), "{found}");
    let found = refused(&press(), &Tuning { kept_overlap: 0.0, ..tuning() });
    assert!(matches!(found, FollowError::Tuning { name: "kept_overlap", .. }), "{found}");
    let mut insensitive = press();
    insensitive.set(P::ValveGain, 0.001);
    let found = refused(&insensitive, &tuning());
    assert!(matches!(found, FollowError::DoesNotFit { coefficient: "command per spool travel", .. }), "{found}");
}

fn any_signal() -> impl Strategy<Value = PerUnit> {
    prop_oneof![
        3 => (any::<i32>(), 0_u32..31).prop_map(|(bits, small)| PerUnit::from_bits(bits >> small)),
        1 => prop::sample::select(std::vec![i32::MIN, -1, 0, 1, i32::MAX]).prop_map(PerUnit::from_bits),
    ]
}

fn any_period() -> impl Strategy<Value = (SetPoint, Predicted, Observed)> {
    let signals = prop::collection::vec(any_signal(), 11);
    (signals, any::<bool>(), any::<bool>()).prop_map(|(signals, has_spool, has_pressures)| {
        let [position, velocity, spool, pressure_a, pressure_b, speed, at, seen, x, a, b] = signals[..] else {
            unreachable!("eleven signals")
        };
        let predicted = Predicted { spool, pressure_a, pressure_b, velocity: speed, position: at };
        let pressures = has_pressures.then_some(ChamberState { a, b });
        (
            SetPoint { position, velocity },
            predicted,
            Observed { position: seen, spool: has_spool.then_some(x), pressures },
        )
    })
}

proptest! {
    #[test]
    fn whatever_arrives_both_commands_keep_to_limit_and_slew(periods in prop::collection::vec(any_period(), 1..20)) {
        let follower = follower();
        let model = resting(0.5);
        let mut state = follower.at_rest(&model, &seen_as(&model));
        let mut before = (follower.neutral(), follower.neutral());
        for (wanted, model, seen) in periods {
            let model_command = follower.model_command(&mut state, wanted, &model);
            let command = follower.command(&mut state, model_command, &model, &seen);
            for (now, last) in [(model_command, before.0), (command, before.1)] {
                prop_assert!(volts(now.magnitude()) <= 10.0 + 1e-6);
                prop_assert!(volts((now - last).magnitude()) <= 2.0 + 1e-6);
            }
            before = (model_command, command);
        }
    }
}

/// Any words, those of NaN and of the infinities too.
fn any_period_in_single() -> impl Strategy<Value = [Single; 11]> {
    let signal = prop_oneof![1 => any::<u32>().prop_map(f32::from_bits), 2 => -2.0_f32..2.0].prop_map(Single::from);
    prop::collection::vec(signal, 11).prop_map(|signals| signals.try_into().unwrap())
}

proptest! {
    #[test]
    fn whatever_arrives_in_single_precision_both_commands_keep_to_limit_and_slew(
        periods in prop::collection::vec(any_period_in_single(), 1..20),
    ) {
        let follower = Follower::<Single>::new(&press(), &tuning(), Tick::OneMillisecond).unwrap();
        let [spool, pressure_a, pressure_b, position] = [0.01, 0.3, 0.5, 0.5].map(Single::new);
        let model = Predicted { spool, pressure_a, pressure_b, velocity: Single::ZERO, position };
        let mut state = follower.at_rest(&model, &seen_as(&model));
        let mut before = (follower.neutral(), follower.neutral());
        for [position, velocity, spool, pressure_a, pressure_b, speed, at, seen, x, a, b] in periods {
            let model = Predicted { spool, pressure_a, pressure_b, velocity: speed, position: at };
            let seen = Observed { position: seen, spool: Some(x), pressures: Some(ChamberState { a, b }) };
            let model_command = follower.model_command(&mut state, SetPoint { position, velocity }, &model);
            let command = follower.command(&mut state, model_command, &model, &seen);
            for (now, last) in [(model_command, before.0), (command, before.1)] {
                prop_assert!(10.0 * now.magnitude().to_f64() <= 10.0 + 1e-5, "{now:?}");
                prop_assert!(10.0 * (now - last).magnitude().to_f64() <= 2.0 + 1e-5, "{now:?} after {last:?}");
            }
            before = (model_command, command);
        }
    }
}
