//! A drive that is driven by its flows or by its force, as they were simulated at the ticks, moves as the whole model did.

use model_core::drive::{Drive, DriveInput, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Parameter as P, Tick};
use model_core::number::{PerUnit, Scalar};
use model_core::ports::{ChamberState, Flows};
use recording::excitation::signals::Excitation;
use system_tests::drives::{self, NamedDrive};
use system_tests::simulate::{ORACLE_TOLERANCE, Row, State, at_rest, command, distance, drive, row};
use virtual_plant::{Commands, InitialState, Plant};

const TICK: Tick = Tick::OneMillisecond;

/// Largest error of the flow link alone against the oracle's flow, at the oracle's own spool and pressures, of the flow base.
const FLOW: f64 = 3e-8;

/// Largest error of the motion of a drive that is driven by flows sampled at the ticks, strokes.
const FROM_FLOW: f64 = 1e-5;
/// The same for a drive that is driven by the force sampled at the ticks, strokes: straight lines between the ticks cut the peaks of an oil
/// spring's ringing.
const FROM_FORCE: f64 = 3e-4;

const NO_PUMP: f64 = 0.0;

fn port_flows<N: Scalar<Real = f64>>(drive: &Drive<N>, state: &State<N>) -> Flows<N> {
    drive.flows(state.valve.spool(), PumpDrive { speed: N::saturated(NO_PUMP), direction: 0 }, state.chambers)
}

/// pa − α·pb: the reading of a force sensor between the piston and the rod without friction.
fn oil_force<N: Scalar<Real = f64>>(named: &NamedDrive, pressures: ChamberState<N>) -> N {
    let ratio = named.machine.get(P::AreaB) / named.machine.get(P::AreaA);
    N::saturated(pressures.a.to_f64() - ratio * pressures.b.to_f64())
}

fn runs<N: Scalar<Real = f64>>(named: &NamedDrive, excitation: &Excitation) -> [Vec<Row>; 3] {
    let drive = drive::<N>(&named.machine, TICK);
    let volts = excitation.sample(TICK.seconds());
    let start = at_rest(&drive, volts[0], &InitialState::at_rest(&named.machine, 0.15));
    let (mut chain, mut from_flow, mut from_force): (State<N>, _, _) = (start, start, start);
    let mut rows = [vec![], vec![], vec![]];
    for volts in volts {
        let before = chain;
        drive.step(&mut chain, DriveInput::Command(command(volts)), Load::NONE);
        let (from, to) = (port_flows(&drive, &before), port_flows(&drive, &chain));
        drive.step(&mut from_flow, DriveInput::Flow { from, to }, Load::NONE);
        let (from, to) = (oil_force(named, before.chambers), oil_force(named, chain.chambers));
        drive.step(&mut from_force, DriveInput::Force { from, to }, Load::NONE);
        for (rows, state) in rows.iter_mut().zip([&chain, &from_flow, &from_force]) {
            rows.push(row(state));
        }
    }
    rows
}

fn entered_downstream<N: Scalar<Real = f64>>(named: &NamedDrive, excitation: &Excitation) {
    let [chain, from_flow, from_force] = runs::<N>(named, excitation);
    let flow = distance(&from_flow, &chain).position;
    let force = distance(&from_force, &chain).position;
    println!("{:<8} {excitation:?}: from flow {flow:.1e}, from force {force:.1e}", named.name);
    assert!(flow < FROM_FLOW, "{}: {flow:e}", named.name);
    assert!(force < FROM_FORCE, "{}: {force:e}", named.name);
}

#[test]
fn entered_at_flow_or_force_the_drive_moves_as_the_chain_did() {
    for named in drives::named() {
        for excitation in [Excitation::paper_steps(10.0), Excitation::paper_sweep(), Excitation::random_steps(1)] {
            entered_downstream::<PerUnit>(&named, &excitation);
            entered_downstream::<f64>(&named, &excitation);
        }
    }
}

fn flow_link<N: Scalar<Real = f64>>(named: &NamedDrive) -> f64 {
    let drive = drive::<N>(&named.machine, TICK);
    let bases = drive.bases();
    let volts = Excitation::random_steps(2).sample(TICK.seconds());
    let times_s: Vec<f64> = (0..volts.len()).map(|tick| tick as f64 * TICK.seconds()).collect();
    let initial = InitialState::at_rest(&named.machine, 0.15);
    let plant = Plant::new(&named.machine, ORACLE_TOLERANCE).unwrap();
    let states = plant.simulate(&Commands::Valve(volts), &initial, &times_s).unwrap();
    let misses = states.iter().map(|state| {
        let pressures = ChamberState {
            a: N::saturated(state.pressure_a_pa / bases.pressure_pa),
            b: N::saturated(state.pressure_b_pa / bases.pressure_pa),
        };
        let pump = PumpDrive { speed: N::saturated(NO_PUMP), direction: 0 };
        let flows = drive.flows(N::saturated(state.spool), pump, pressures);
        let a = flows.a.to_f64() - state.flow_a_m3_per_s / bases.flow_m3_per_s;
        let b = flows.b.to_f64() - state.flow_b_m3_per_s / bases.flow_m3_per_s;
        a.abs().max(b.abs())
    });
    misses.fold(0.0, f64::max)
}

#[test]
fn the_flow_link_alone_passes_what_the_oracle_passes() {
    for named in drives::named() {
        let (fixed, real) = (flow_link::<PerUnit>(&named), flow_link::<f64>(&named));
        println!("{:<8} flow: fixed {fixed:.1e}, f64 {real:.1e}", named.name);
        assert!(fixed < FLOW && real < 1e-12, "{}: {fixed:e} {real:e}", named.name);
    }
}
