//! What a drive settles at is where the physics says, however stiff a chamber is.

use std::cell::RefCell;

use model_core::chambers::ChamberState;
use model_core::drive::{Drive, DriveState, Entry, Load};
use model_core::fixed_point::PerUnit;
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, Source, Tick};
use model_core::number::Scalar;
use model_core::parameter::Parameter as P;
use model_core::valve::Slider;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use system_tests::any_machine::any_tick;

use super::cases;

/// A pump-controlled cylinder whose return line and chambers are as stiff as drawn.
fn pump_drive(return_coefficient: f64, capacity: f64) -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Pump);
    for (parameter, value) in [
        (P::SupplyPressure, 1e7),
        (P::TankPressure, 4e5),
        (P::PumpDisplacement, 1.6e-6),
        (P::ReturnCoefficient, return_coefficient),
        (P::AreaA, 1.9635e-3),
        (P::AreaB, 1.6493e-3),
        (P::Stroke, 0.075),
        (P::MovingMass, 10.0),
        (P::ViscousFriction, 2e3),
        (P::BulkModulus, 1.2e9),
        (P::VolumeA, capacity * 1.2e9),
        (P::VolumeB, capacity * 1.2e9),
    ] {
        machine.set(parameter, value);
    }
    machine
}

/// Pressure in the returning chamber after `ticks`, Pa.
fn settled_pa<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, pump: f64, ticks: u32) -> f64 {
    let drive = Drive::<N>::new::<64>(machine, tick).expect("the drive fits");
    let rest = N::saturated(0.04);
    let mut state: DriveState<N, 64> = drive.at_rest(N::ZERO, ChamberState { a: rest, b: rest }, N::travel(0.5));
    let entry = Entry::Pump(PumpDrive { speed: N::saturated(pump / 50.0), direction: 1 });
    for _ in 0..ticks {
        drive.step(&mut state, entry, Load::NONE);
    }
    state.chambers.b.to_f64() * drive.bases().pressure_pa
}

proptest! {
    #![proptest_config(cases(300))]

    /// With the tangent of the root as Jacobian one case in six settled far off, up to 0.16 of the supply.
    #[test]
    fn a_return_line_settles_where_its_flow_and_its_orifice_say(
        pump in 2.0..45.0_f64, exponent in -6.7..-5.5_f64, capacity in 5e-14..5e-13_f64, tick in any_tick(),
    ) {
        let coefficient = 10_f64.powf(exponent);
        let machine = pump_drive(coefficient, capacity);
        prop_assume!(Drive::<PerUnit>::new::<64>(&machine, tick).is_ok());
        let flow = 1.6e-6 * pump * machine.get(P::AreaB) / machine.get(P::AreaA);
        let expected = machine.get(P::TankPressure) + (flow / coefficient).powi(2);
        for found in [settled_pa::<f64>(&machine, tick, pump, 4000), settled_pa::<PerUnit>(&machine, tick, pump, 4000)] {
            // The orifice is laminar below 2 kPa: there it takes more than the square says.
            prop_assert!((found - expected).abs() < 3e3, "{found:.0} Pa, expected {expected:.0}");
        }
    }
}

/// A rod on its oil's spring, at this many radians a tick and hardly damped, behind a valve that would pass `ratio` times its limit; at that
/// a tick would fill chamber A, with the rod held, by `fill` times half the supply.
fn sprung_drive(tick: Tick, turn: f64, ratio: f64, fill: f64) -> Machine<f64> {
    const DAMPING: f64 = 0.02;
    let areas = [(P::AreaA, 2e-3), (P::AreaB, 1.2e-3), (P::VolumeA, 3e-4), (P::VolumeB, 3e-4), (P::BulkModulus, 1e9)];
    let machine = Machine::with_defaults(Source::Valve).with(&areas).with(&[(P::Stroke, 0.3)]);
    let (spring, turn_per_s) = (machine.oil_spring_n_per_m(), turn / tick.seconds());
    let mass = spring / (turn_per_s * turn_per_s);
    let limit = 2e-3 * 0.2;
    let filled_pa = tick.seconds() * limit * 1e9 / 3e-4;
    let supply_pa = 2.0 * filled_pa / fill;
    machine.with(&[
        (P::MovingMass, mass),
        (P::ViscousFriction, 2.0 * DAMPING * mass * turn_per_s),
        (P::SupplyPressure, supply_pa),
        (P::FlowLimit, limit),
        (P::FlowCoefficient, ratio * limit / (0.5 * supply_pa).sqrt()),
    ])
}

/// How much the pressure in A still swings over the last of 3000 ticks with the valve held open, in parts of the supply.
fn swing<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick) -> f64 {
    let drive = Drive::<N>::new::<64>(machine, tick).expect("the drive fits");
    let rest = N::saturated(0.5);
    let mut state: DriveState<N, 64> = drive.at_rest(N::ZERO, ChamberState { a: rest, b: rest }, N::travel(0.5));
    let open = N::saturated(1.0);
    let mut ends = (f64::INFINITY, f64::NEG_INFINITY);
    for tick in 0..3000 {
        drive.step(&mut state, Entry::Slider(Slider { from: open, to: open }), Load::NONE);
        if tick >= 2900 {
            let pressure = state.chambers.a.to_f64();
            ends = (ends.0.min(pressure), ends.1.max(pressure));
        }
    }
    ends.1 - ends.0
}

/// No pressure moves a flow at its limit. With the slope of its chord in every step, two of three such drives swung up and went on; what is left
/// are large swings of a quarter turn a tick.
#[test]
fn hardly_any_rod_on_its_oils_spring_swings_up_behind_a_limited_flow() {
    let any = (0.3..1.6_f64, 0.5..6.0_f64, 0.2..6.0_f64, any_tick());
    let swings = RefCell::new(Vec::new());
    TestRunner::new(cases(2000))
        .run(&any, |(turn, ratio, fill, tick)| {
            let machine = sprung_drive(tick, turn, ratio, fill);
            prop_assume!(Drive::<PerUnit>::new::<64>(&machine, tick).is_ok());
            swings.borrow_mut().push([swing::<f64>(&machine, tick), swing::<PerUnit>(&machine, tick)]);
            Ok(())
        })
        .unwrap();
    let swings = swings.into_inner();
    for of in 0..2 {
        let still = swings.iter().filter(|swing| swing[of] > 1e-3).count();
        println!("{still} of {} still swing", swings.len());
        assert!(200 * still < swings.len(), "{still} of {}", swings.len());
    }
}
