//! A drive settles where the physics says, however stiff a chamber is.

use std::cell::RefCell;

use proptest::prelude::*;

use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, Parameter as P, Source, Tick};
use model_core::number::{PerUnit, Scalar};
use model_core::ports::{ChamberState, Spool};
use system_tests::any_machine::any_tick;
use system_tests::simulate::{Row, core, larger, oracle_with};
use virtual_plant::{Commands, InitialState, LoadEffect, PlantEffect};

use super::{cases, runner};

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
    let drive_input = DriveInput::Pump(PumpDrive { speed: N::saturated(pump / 50.0), direction: 1 });
    for _ in 0..ticks {
        drive.step(&mut state, drive_input, Load::NONE);
    }
    state.chambers.b.to_f64() * drive.bases().pressure_pa
}

proptest! {
    #![proptest_config(cases(300))]

    /// With the tangent of the square root as Jacobian, one case in six settled far off, up to 0.16 of the supply.
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
            // The orifice is laminar below 2 kPa: there it needs more pressure than the square law says.
            prop_assert!((found - expected).abs() < 3e3, "{found:.0} Pa, expected {expected:.0}");
        }
    }
}

/// Initial position of the rods below: half a stroke.
const MIDDLE_M: f64 = 0.15;

/// A hardly damped rod on its oil spring, with this natural frequency in radians a tick, behind a valve that would pass `ratio` times its flow limit;
/// at this limit, one tick would raise the pressure in chamber A, with the rod held, by `fill` times half the supply.
fn sprung_drive(tick: Tick, turn: f64, ratio: f64, fill: f64) -> Machine<f64> {
    const DAMPING: f64 = 0.02;
    let areas = [(P::AreaA, 2e-3), (P::AreaB, 1.2e-3), (P::VolumeA, 3e-4), (P::VolumeB, 3e-4), (P::BulkModulus, 1e9)];
    let machine =
        Machine::with_defaults(Source::Valve).with(&areas).with(&[(P::Stroke, 2.0 * MIDDLE_M), (P::ValveGain, 0.1)]);
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

/// Other paths of the oil, beside the edges that the spool opens.
#[derive(Clone, Copy, Debug, Default)]
struct Passing {
    /// Opening of all four edges at the centre.
    valve: f64,
    /// Flow past the piston and out of each chamber at the supply pressure, as a share of the flow limit.
    piston: f64,
}

impl Passing {
    fn on(self, machine: &Machine<f64>) -> Machine<f64> {
        let conductance = self.piston * machine.get(P::FlowLimit) / machine.get(P::SupplyPressure);
        machine.with(&[
            (P::ValveLeakageOpening, self.valve),
            (P::ValveLeakageReach, 1.0),
            (P::InternalLeakage, conductance),
            (P::ExternalLeakageA, conductance),
            (P::ExternalLeakageB, conductance),
        ])
    }
}

/// Direction of the spool.
fn any_way() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1.0), Just(-1.0)]
}

fn any_passing() -> impl Strategy<Value = Passing> {
    let valve = (0.0..0.5_f64).prop_map(|valve| Passing { valve, ..Passing::default() });
    let piston = (0.0..0.3_f64).prop_map(|piston| Passing { piston, ..Passing::default() });
    prop_oneof![Just(Passing::default()), valve, piston]
}

/// How much the pressure in A still oscillates over the last of 3000 ticks with the spool held at `open`, as a share of the supply.
fn swing<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, open: f64) -> f64 {
    let drive = Drive::<N>::new::<64>(machine, tick).expect("the drive fits");
    let rest = N::saturated(0.5);
    let mut state: DriveState<N, 64> = drive.at_rest(N::ZERO, ChamberState { a: rest, b: rest }, N::travel(0.5));
    let open = N::saturated(open);
    let mut ends = (f64::INFINITY, f64::NEG_INFINITY);
    for tick in 0..3000 {
        drive.step(&mut state, DriveInput::Spool(Spool { from: open, to: open }), Load::NONE);
        if tick >= 2900 {
            let pressure = state.chambers.a.to_f64();
            ends = (ends.0.min(pressure), ends.1.max(pressure));
        }
    }
    ends.1 - ends.0
}

/// A flow at its limit does not depend on pressure. With the slope of its chord in every step, two of three such drives started to oscillate and
/// did not stop. Now only a few oscillate: strongly at a radian a tick, weakly where leakage holds a pressure at the beginning of the limit.
#[test]
fn hardly_any_rod_on_its_oils_spring_swings_up_behind_a_limited_flow() {
    let any = (0.3..1.6_f64, 0.5..6.0_f64, 0.2..6.0_f64, any_tick(), any_way(), any_passing());
    let swings = RefCell::new(Vec::new());
    runner(2500, file!())
        .run(&any, |(turn, ratio, fill, tick, way, passing)| {
            let machine = passing.on(&sprung_drive(tick, turn, ratio, fill));
            prop_assume!(Drive::<PerUnit>::new::<64>(&machine, tick).is_ok());
            let swing = [swing::<f64>(&machine, tick, way), swing::<PerUnit>(&machine, tick, way)];
            swings.borrow_mut().push((passing, swing));
            Ok(())
        })
        .unwrap();
    let swings = swings.into_inner();
    for (what, of) in [("leakage", true), ("none", false)] {
        for number in 0..2 {
            let such =
                swings.iter().filter(|(passing, _)| (passing.piston > 0.0) == of).map(|(_, swing)| swing[number]);
            let (all, still): (Vec<f64>, f64) = (such.clone().collect(), such.fold(0.0, larger));
            let moved = all.iter().filter(|swing| **swing > 1e-3).count();
            println!("{what}: {moved} of {} still swing, by {still:.2} at most", all.len());
            let far = all.iter().filter(|swing| **swing > 0.3).count();
            let share = if of { 25 } else { 200 };
            assert!(share * moved < all.len() && 200 * far < all.len(), "{what}: {moved}, {far} far, of {}", all.len());
        }
    }
}

/// How much further than in the true solution either pressure moves from half the supply, in supply pressures.
fn beyond_truth<N: Scalar<Real = f64>>(
    machine: &Machine<f64>,
    stop: Option<PlantEffect>,
    tick: Tick,
    volts: &[f64],
) -> f64 {
    let half = 0.5 * machine.get(P::SupplyPressure);
    let at_middle = InitialState::at_rest(machine, MIDDLE_M);
    let initial = InitialState { pressure_a_pa: half, pressure_b_pa: half, ..at_middle };
    let largest = |rows: &[Row]| {
        let of_row = |row: &Row| f64::max((row.pressure_a - 0.5).abs(), (row.pressure_b - 0.5).abs());
        rows.iter().map(of_row).fold(0.0, f64::max)
    };
    let commands = Commands::Valve(volts.to_vec());
    largest(&core::<N>(machine, tick, volts, &initial))
        - largest(&oracle_with(machine, stop.as_slice(), tick, &commands, &initial))
}

/// Fails if more than one of a hundred errors exceeds one supply pressure.
fn hardly_any_above_a_supply(errors: &[[f64; 2]]) {
    for number in 0..2 {
        let above = errors.iter().filter(|error| error[number] > 1.0).count();
        println!("{above} of {} err by more than a supply", errors.len());
        assert!(100 * above <= errors.len(), "{above} of {}", errors.len());
    }
}

/// A stopped rod makes no room for oil. With the room of a free rod, one in fifteen drives of this draw ended up to two supplies too high.
#[test]
fn a_rod_that_a_stop_catches_behind_a_limited_flow_drives_no_pressure_beyond_the_true_one() {
    let any = (0.3..1.6_f64, 0.5..6.0_f64, 0.2..6.0_f64, any_tick(), any_way(), 0.005..0.2_f64);
    let errors = RefCell::new(Vec::new());
    runner(400, file!())
        .run(&any, |(turn, ratio, fill, tick, way, strokes)| {
            let free = sprung_drive(tick, turn, ratio, fill);
            let (at_m, extending) = (MIDDLE_M + way * strokes * 2.0 * MIDDLE_M, way > 0.0);
            let face = if extending { P::StopExtended } else { P::StopRetracted };
            let machine = free.with(&[(face, at_m), (P::StopStiffness, 1e8), (P::StopDamping, 1e4)]);
            prop_assume!(Drive::<PerUnit>::new::<64>(&machine, tick).is_ok());
            let stop = LoadEffect::EndStop { at_m, extending, stiffness: 1e11, damping_s_per_m: 3.0 };
            let (stop, volts) = (Some(PlantEffect::Load(stop)), [10.0 * way; 400]);
            let error = [
                beyond_truth::<f64>(&machine, stop, tick, &volts),
                beyond_truth::<PerUnit>(&machine, stop, tick, &volts),
            ];
            errors.borrow_mut().push(error);
            Ok(())
        })
        .unwrap();
    hardly_any_above_a_supply(&errors.into_inner());
}

/// A spool that leaves the limit and comes back within some ticks.
#[test]
fn a_spool_that_goes_back_through_its_dead_centre_drives_no_pressure_beyond_the_true_one() {
    let any = (0.3..1.6_f64, 0.5..6.0_f64, 0.2..6.0_f64, any_tick(), 0.0..1.0_f64, 1.0..4.0_f64);
    let errors = RefCell::new(Vec::new());
    runner(300, file!())
        .run(&any, |(turn, ratio, fill, tick, back, lag)| {
            let machine = sprung_drive(tick, turn, ratio, fill).with(&[(P::TimeConstant1, lag * tick.seconds())]);
            prop_assume!(Drive::<PerUnit>::new::<64>(&machine, tick).is_ok());
            let volts: Vec<f64> = (0..200).map(|k| if k % 40 < 20 { 10.0 } else { -10.0 * back }).collect();
            let error = [
                beyond_truth::<f64>(&machine, None, tick, &volts),
                beyond_truth::<PerUnit>(&machine, None, tick, &volts),
            ];
            errors.borrow_mut().push(error);
            Ok(())
        })
        .unwrap();
    hardly_any_above_a_supply(&errors.into_inner());
}
