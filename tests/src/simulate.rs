//! The core and the oracle on the same commands, in the same units.

use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, Parameter, Tick};
use model_core::number::{Number, Scalar};
use model_core::ports::ChamberState;
use virtual_plant::{Commands, InitialState, Plant, PlantEffect, PumpCommand};

/// The tolerance that the oracle is solved to, per unit.
pub const ORACLE_TOLERANCE: f64 = 1e-10;

/// Delay line of the states in these tests, ticks: more than 20 ms at a tick of 0.5 ms.
pub const DELAY: usize = 64;

/// State of a drive in these tests.
pub type State<N> = DriveState<N, DELAY>;

/// What is compared, at one tick: pressures in supply pressures, position in strokes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// pa / p0
    pub pressure_a: f64,
    /// pb / p0
    pub pressure_b: f64,
    /// y / stroke
    pub position: f64,
}

/// Largest differences between two runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    /// Of the position, strokes.
    pub position: f64,
    /// Of either pressure, supply pressures.
    pub pressure: f64,
}

impl Distance {
    /// The larger of two runs' differences, for position and pressure separately.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { position: self.position.max(other.position), pressure: self.pressure.max(other.pressure) }
    }
}

/// The larger of two, and NaN if the found value is NaN: a run that ends in NaN must not look calm.
#[must_use]
pub fn larger(worst: f64, found: f64) -> f64 {
    if found <= worst { worst } else { found }
}

/// Largest differences over all ticks; a NaN anywhere makes it NaN.
///
/// # Panics
/// The runs differ in length.
#[must_use]
pub fn distance(one: &[Row], other: &[Row]) -> Distance {
    assert_eq!(one.len(), other.len(), "two runs of one signal");
    one.iter().zip(other).fold(Distance::default(), |worst, (a, b)| {
        let pressure = larger((a.pressure_a - b.pressure_a).abs(), (a.pressure_b - b.pressure_b).abs());
        Distance {
            position: larger(worst.position, (a.position - b.position).abs()),
            pressure: larger(worst.pressure, pressure),
        }
    })
}

/// The drive of `machine` in number type `N`.
///
/// # Panics
/// The machine is invalid, or does not fit the format.
#[must_use]
pub fn drive<N: Number<Real = f64>>(machine: &Machine<f64>, tick: Tick) -> Drive<N> {
    Drive::new::<DELAY>(machine, tick).unwrap_or_else(|error| panic!("{error}"))
}

/// A command in V as the core takes it.
#[must_use]
pub fn command<N: Number<Real = f64>>(volts: f64) -> N {
    N::saturated(volts / 10.0)
}

/// The drive at rest at `initial` after the command was held for long.
#[must_use]
pub fn at_rest<N: Number<Real = f64>>(drive: &Drive<N>, volts: f64, initial: &InitialState) -> State<N> {
    let bases = drive.bases();
    let pressures = ChamberState {
        a: N::saturated(initial.pressure_a_pa / bases.pressure_pa),
        b: N::saturated(initial.pressure_b_pa / bases.pressure_pa),
    };
    drive.at_rest(command(volts), pressures, N::travel(initial.position_m / bases.stroke_m))
}

/// The compared values of a state.
#[must_use]
pub fn row<N: Scalar<Real = f64>, const LINE: usize>(state: &DriveState<N, LINE>) -> Row {
    Row {
        pressure_a: state.chambers.a.to_f64(),
        pressure_b: state.chambers.b.to_f64(),
        position: N::strokes(state.motion.position),
    }
}

/// The core's run: row k is the state at tick k, before its command acts.
#[must_use]
pub fn core<N: Scalar<Real = f64>>(
    machine: &Machine<f64>,
    tick: Tick,
    volts: &[f64],
    initial: &InitialState,
) -> Vec<Row> {
    let drive_inputs = volts.iter().map(|&volts| DriveInput::Command(command(volts)));
    run::<N>(machine, tick, volts.first().copied().unwrap_or(0.0), drive_inputs, initial)
}

/// The core's run of a pump drive.
#[must_use]
pub fn core_pump<N: Scalar<Real = f64>>(
    machine: &Machine<f64>,
    tick: Tick,
    commands: &[PumpCommand],
    initial: &InitialState,
) -> Vec<Row> {
    let full_speed = drive::<N>(machine, tick).bases().pump_speed_rev_per_s;
    let drive_input = |command: &PumpCommand| {
        let speed = N::saturated(command.speed_rev_per_s / full_speed);
        DriveInput::Pump(PumpDrive { speed, direction: command.direction })
    };
    run::<N>(machine, tick, 0.0, commands.iter().map(drive_input), initial)
}

fn run<N: Scalar<Real = f64>>(
    machine: &Machine<f64>,
    tick: Tick,
    first_v: f64,
    drive_inputs: impl Iterator<Item = DriveInput<N>>,
    initial: &InitialState,
) -> Vec<Row> {
    let drive = drive::<N>(machine, tick);
    let mut state = at_rest(&drive, first_v, initial);
    let step = |drive_input: DriveInput<N>| {
        let row = row(&state);
        drive.step(&mut state, drive_input, Load::NONE);
        row
    };
    drive_inputs.map(step).collect()
}

/// The oracle's run on the same commands.
///
/// # Panics
/// The oracle cannot solve it.
#[must_use]
pub fn oracle(machine: &Machine<f64>, tick: Tick, volts: &[f64], initial: &InitialState) -> Vec<Row> {
    oracle_with(machine, &[], tick, &Commands::Valve(volts.to_vec()), initial)
}

/// The oracle's run with effects.
///
/// # Panics
/// The oracle cannot solve it.
#[must_use]
pub fn oracle_with(
    machine: &Machine<f64>,
    effects: &[PlantEffect],
    tick: Tick,
    commands: &Commands,
    initial: &InitialState,
) -> Vec<Row> {
    let plant = Plant::new(machine, ORACLE_TOLERANCE).unwrap_or_else(|error| panic!("{error}")).with_effects(effects);
    let times_s: Vec<f64> = (0..commands.len()).map(|k| k as f64 * tick.seconds()).collect();
    let states = plant.simulate(commands, initial, &times_s);
    let (supply_pa, stroke_m) = (machine.get(Parameter::SupplyPressure), machine.get(Parameter::Stroke));
    let states = states.unwrap_or_else(|error| panic!("{error}"));
    let row = |state: &virtual_plant::PlantState| Row {
        pressure_a: state.pressure_a_pa / supply_pa,
        pressure_b: state.pressure_b_pa / supply_pa,
        position: state.position_m / stroke_m,
    };
    states.iter().map(row).collect()
}

/// The words of a drive input, a load or a state: every word is possible, small and large ones equally often.
pub fn any_word() -> impl proptest::strategy::Strategy<Value = model_core::number::PerUnit> {
    use proptest::prelude::*;
    let word = (any::<i32>(), 0_u32..31).prop_map(|(bits, small)| bits >> small);
    prop_oneof![3 => word, 1 => prop::sample::select(vec![i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX])]
        .prop_map(model_core::number::PerUnit::from_bits)
}
