//! A mass that a force moves and that has neither valve nor oil.

use proptest::prelude::*;

use model_core::drive::{Drive, DriveInput, Load};
use model_core::machine::{Machine, Parameter as P, Source, Tick};
use model_core::number::{Field, Number, PerUnit, Scalar};
use model_core::ports::{ChamberState, Spool};
use recording::excitation::signals::Excitation;
use simulation::number::dual::Dual;
use system_tests::any_effects::any_effects;
use system_tests::any_machine::{any_axis, any_tick};
use system_tests::simulate::{DELAY, State, drive};

use super::{cases, runner};

/// A mass on a guide.
fn axis() -> Machine<f64> {
    let values = [(P::MovingMass, 80.0), (P::ViscousFriction, 250.0), (P::Stroke, 0.3)];
    Machine::with_defaults(Source::Force).with(&values)
}

/// Seconds of a force of random steps, as shares of `largest_n`.
fn forces(seed: u64, tick: Tick, largest_n: f64) -> Vec<f64> {
    Excitation::random_steps(seed).sample(tick.seconds()).into_iter().map(|volts| 0.1 * volts * largest_n).collect()
}

fn at_rest<N: Number>(drive: &Drive<N>) -> State<N> {
    drive.at_rest(N::ZERO, ChamberState { a: N::ZERO, b: N::ZERO }, N::travel(N::Real::constant(0.5)))
}

/// Position in strokes and velocity in m/s after every tick.
fn moved<N: Scalar>(machine: &Machine<N::Real>, tick: Tick, forces: &[f64]) -> Vec<[N::Real; 2]> {
    let drive = Drive::<N>::new::<DELAY>(machine, tick).unwrap();
    let (mut state, bases) = (at_rest(&drive), *drive.bases());
    let step = |pair: &[f64]| {
        let at = |index: usize| N::saturated(pair[index] / bases.force_n);
        drive.step(&mut state, DriveInput::Force { from: at(0), to: at(1) }, Load::NONE);
        let velocity = state.motion.velocity.to_real() * N::Real::constant(bases.velocity_m_per_s);
        [N::strokes(state.motion.position), velocity]
    };
    forces.windows(2).map(step).collect()
}

/// As accurate as a hydraulic drive's position: see `agreement`.
const POSITION: f64 = 1e-5;
const TRAVEL_SHARE: f64 = 4e-4;
/// The format of the position: a signal ends at eight strokes, the position itself at 128.
const STROKES: f64 = 100.0;

#[test]
fn fixed_point_and_f64_agree_for_every_mass() {
    runner(1000, file!())
        .run(&(any_axis(), any_tick(), any::<u64>(), 0.01..1.0_f64), |(machine, tick, seed, share)| {
            let forces = forces(seed, tick, share * machine.full_force_n());
            let real = moved::<f64>(&machine, tick, &forces);
            let fastest = real.iter().fold(0.0_f64, |most, [_, velocity]| most.max(velocity.abs()));
            let travel = real.iter().fold(0.0_f64, |most, [position, _]| most.max((position - 0.5).abs()));
            let velocity_m_per_s = drive::<f64>(&machine, tick).bases().velocity_m_per_s;
            prop_assume!(fastest < 7.5 * velocity_m_per_s && travel < STROKES);
            let fixed = moved::<PerUnit>(&machine, tick, &forces);
            let apart = real.iter().zip(&fixed).fold(0.0_f64, |most, (a, b)| most.max((a[0] - b[0]).abs()));
            let per_tick = real.windows(2).fold(0.0_f64, |most, pair| most.max((pair[1][0] - pair[0][0]).abs()));
            // Dry friction decides: the last bit may release or stop the mass a tick earlier.
            let decided = if machine.get(P::CoulombFriction) > 0.0 { 2.0 * per_tick } else { 0.0 };
            let most = POSITION + TRAVEL_SHARE * travel + decided;
            prop_assert!(apart <= most, "{apart:e} of {travel}, {most:e} allowed");
            Ok(())
        })
        .unwrap();
}

/// m·dv/dt = F − D·v under a constant force.
#[test]
fn a_mass_moves_as_the_closed_form_says() {
    let (force_n, machine) = (40.0, axis());
    let [mass, damping] = [P::MovingMass, P::ViscousFriction].map(|parameter| machine.get(parameter));
    let moved = moved::<f64>(&machine, Tick::OneMillisecond, &vec![force_n; 2001]);
    let memory_s = mass / damping;
    for (tick, [position, velocity]) in moved.iter().enumerate() {
        let time_s = (tick + 1) as f64 * 1e-3;
        let settled = 1.0 - (-time_s / memory_s).exp();
        let expected = force_n / damping * settled;
        let way_m = force_n / damping * (time_s - memory_s * settled);
        assert!((velocity - expected).abs() < 1e-6 * force_n / damping, "{time_s} s: {velocity} instead of {expected}");
        assert!((position - 0.5 - way_m / 0.3).abs() < 1e-5, "{time_s} s: {position}, {way_m}");
    }
}

/// What takes no part decides nothing: beside rounding, the scales of the oil change nothing.
#[test]
fn a_valve_drive_entered_at_the_same_force_moves_alike() {
    for damping in [0.0, 250.0, 1e5] {
        let friction = [(P::CoulombFriction, 8.0), (P::ViscousFriction, damping), (P::LoadForce, 3.0)];
        let machine = axis().with(&friction);
        let mut hydraulic = Machine::with_defaults(Source::Valve).with(&[
            (P::AreaA, 1e-3),
            (P::AreaB, 1e-3),
            (P::VolumeA, 1.6e-4),
            (P::VolumeB, 1.6e-4),
            (P::SupplyPressure, 1e6),
        ]);
        for parameter in [P::MovingMass, P::ViscousFriction, P::Stroke, P::CoulombFriction, P::LoadForce] {
            hydraulic.set(parameter, machine.get(parameter));
        }
        let forces = forces(4, Tick::OneMillisecond, 60.0);
        let alike = moved::<f64>(&hydraulic, Tick::OneMillisecond, &forces);
        for (alone, beside) in moved::<f64>(&machine, Tick::OneMillisecond, &forces).iter().zip(&alike) {
            assert!((alone[0] - beside[0]).abs() < 1e-9, "{damping} N s/m: {alone:?}, {beside:?}");
        }
    }
}

#[test]
fn an_input_of_a_hydraulic_drive_is_no_force() {
    let machine = axis().with(&[(P::LoadForce, 30.0)]);
    let drive = drive::<PerUnit>(&machine, Tick::OneMillisecond);
    let after = |input: DriveInput<PerUnit>| {
        let mut state = at_rest(&drive);
        for _ in 0..100 {
            drive.step(&mut state, input, Load::NONE);
        }
        state
    };
    let nothing = after(DriveInput::Force { from: PerUnit::ZERO, to: PerUnit::ZERO });
    assert!(nothing.motion.velocity > PerUnit::ZERO);
    let half = PerUnit::saturated(0.5);
    assert_eq!(after(DriveInput::Command(half)), nothing);
    assert_eq!(after(DriveInput::Spool(Spool { from: half, to: half })), nothing);
}

#[test]
fn derivatives_by_each_value_of_a_mass_are_the_differences() {
    let machine = axis().with(&[(P::LoadForce, -4.0), (P::LoadSpring, 300.0)]);
    let forces = &forces(3, Tick::OneMillisecond, 60.0)[..1500];
    for (parameter, step) in
        [(P::MovingMass, 1e-4), (P::ViscousFriction, 1e-3), (P::LoadForce, 1e-5), (P::LoadSpring, 1e-3)]
    {
        let at = |by: f64| {
            moved::<f64>(&machine.with(&[(parameter, machine.get(parameter) + by)]), Tick::OneMillisecond, forces)
        };
        let mut lifted = machine.map(Dual::<1>::constant);
        lifted.set(parameter, Dual::variable(machine.get(parameter), 0, 1.0));
        let exact = moved::<Dual<1>>(&lifted, Tick::OneMillisecond, forces);
        let largest = exact.iter().fold(0.0_f64, |most, row| most.max(f64::from(row[0].partials()[0]).abs()));
        assert!(largest > 0.0, "{parameter:?} moves nothing");
        for (exact, (above, below)) in exact.iter().zip(at(step).iter().zip(at(-step))) {
            let difference = (above[0] - below[0]) / (2.0 * step);
            let miss = (f64::from(exact[0].partials()[0]) - difference).abs();
            assert!(miss <= 2e-4 * largest, "{parameter:?}: {miss:e} of {largest:e}");
        }
    }
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn every_mass_becomes_a_drive_in_fixed_point(machine in any_axis(), tick in any_tick()) {
        let built = Drive::<PerUnit>::new::<DELAY>(&machine, tick);
        prop_assert!(built.is_ok(), "{:?} of {machine:?}", built.err());
    }

    #[test]
    fn effects_of_valve_and_oil_change_nothing_of_a_mass(machine in any_axis(), effects in any_effects(), seed in any::<u64>()) {
        let with = effects.on(&machine);
        let mut without = with;
        for &parameter in P::ALL.iter().filter(|parameter| !parameter.is_of(Source::Force)) {
            without.set(parameter, machine.get(parameter));
        }
        let forces = &forces(seed, Tick::OneMillisecond, 0.3 * machine.full_force_n())[..500];
        prop_assume!(Drive::<f64>::new::<DELAY>(&with, Tick::OneMillisecond).is_ok());
        let [with, without] = [with, without].map(|machine| moved::<f64>(&machine, Tick::OneMillisecond, forces));
        prop_assert_eq!(with, without);
    }
}
