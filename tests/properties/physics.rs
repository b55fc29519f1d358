//! Pressures stay where supply, load and inertia can bring them; energy is not created.

use host_sim::testbed::{Excitation, InitialState};
use model_core::drive::{Entry, Load};
use model_core::fixed_point::PerUnit;
use model_core::machine::{Machine, Tick};
use model_core::number::Scalar;
use model_core::parameter::Parameter as P;
use proptest::prelude::*;
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{State, at_rest, command, drive};

use super::cases;

/// Allowance for growing energy, in shares of what the supply would compress: leakage is implicit on the diagonal only, which gives
/// up to 1e-7; fixed point rounds to 4e-9.
const ROUNDING: f64 = 1e-6;

/// The mass that the step keeps the energy of is smaller than the moving mass by up to this share, see `sprung_mass` in the core.
const SPRUNG: f64 = 0.041;

/// A drive in SI units, and what is stored in it.
struct Store {
    mass: f64,
    load_n: f64,
    areas_m2: [f64; 2],
    /// V/E and hose of each chamber, m³/Pa.
    capacities: [f64; 2],
}

impl Store {
    fn of(machine: &Machine<f64>) -> Self {
        let capacity = |volume: P| machine.get(volume) / machine.get(P::BulkModulus) + machine.get(P::HoseCompliance);
        Self {
            mass: machine.get(P::MovingMass),
            load_n: machine.get(P::LoadForce),
            areas_m2: [machine.get(P::AreaA), machine.get(P::AreaB)],
            capacities: [capacity(P::VolumeA), capacity(P::VolumeB)],
        }
    }

    /// Stiffness of both oil columns together, N/m.
    fn spring(&self) -> f64 {
        self.areas_m2.iter().zip(self.capacities).map(|(area, capacity)| area * area / capacity).sum()
    }

    /// Largest pressure that the mass, stopped from a velocity, presses into a chamber beyond the static one.
    fn shock_pa(&self, velocity_m_per_s: f64) -> f64 {
        let compressed_m = velocity_m_per_s * (self.mass / self.spring()).sqrt();
        let of = |side: usize| self.areas_m2[side] / self.capacities[side] * compressed_m;
        of(0).max(of(1))
    }
}

/// A drive's state in SI units: pressures, velocity, position.
#[derive(Clone, Copy)]
struct Si {
    pressures_pa: [f64; 2],
    velocity_m_per_s: f64,
    position_m: f64,
}

fn si<N: Scalar<Real = f64>>(state: &State<N>, bases: &model_core::machine::Bases) -> Si {
    Si {
        pressures_pa: [state.chambers.a, state.chambers.b].map(|pressure| pressure.to_f64() * bases.pressure_pa),
        velocity_m_per_s: state.motion.velocity.to_f64() * bases.velocity_m_per_s,
        position_m: N::strokes(state.motion.position) * bases.stroke_m,
    }
}

/// Moving, compressed and lifted energy, J.
fn energy(store: &Store, state: &Si) -> f64 {
    let compressed = store.capacities.iter().zip(state.pressures_pa).map(|(c, p)| 0.5 * c * p * p);
    0.5 * store.mass * state.velocity_m_per_s.powi(2) + compressed.sum::<f64>() - store.load_n * state.position_m
}

/// A valve so small that a stop from full speed cannot press more than a supply pressure.
pub(crate) fn gentle(mut machine: Machine<f64>) -> Machine<f64> {
    let supply_pa = machine.get(P::SupplyPressure);
    let full_speed = 2.0 * machine.get(P::FlowCoefficient) * supply_pa.sqrt() / machine.get(P::AreaB);
    let share = (supply_pa / Store::of(&machine).shock_pa(full_speed)).min(1.0);
    machine.set(P::FlowCoefficient, share * machine.get(P::FlowCoefficient));
    machine
}

/// The valve stands closed at command 0.
fn closed(mut machine: Machine<f64>) -> Machine<f64> {
    machine.set(P::ValveOffset, 0.0);
    machine.set(P::DeadZone, machine.get(P::DeadZone).max(0.01));
    machine
}

/// Largest growth of the energy in any tick with the valve closed, beside what dry friction that turns within the tick may give,
/// and over the whole run; in shares of what the supply would compress.
fn growth<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, start: [f64; 3]) -> (f64, f64) {
    let drive = drive::<N>(machine, tick);
    let (store, bases) = (Store::of(machine), drive.bases());
    let supply_pa = machine.get(P::SupplyPressure);
    let mut state: State<N> = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.0));
    state.chambers.a = N::saturated(start[0]);
    state.chambers.b = N::saturated(start[1]);
    // No faster than a stop that presses one supply pressure.
    let fastest = (supply_pa / store.shock_pa(1.0) / bases.velocity_m_per_s).min(1.0);
    state.motion.velocity = N::saturated(fastest * start[2]);
    let scale = store.capacities.iter().sum::<f64>() * supply_pa * supply_pa;
    let first = energy(&store, &si(&state, bases));
    let mut growth = (0.0_f64, 0.0_f64);
    for _ in 0..500 {
        let before = si(&state, bases);
        drive.step(&mut state, Entry::Command(N::ZERO), Load::NONE);
        let after = si(&state, bases);
        let turned = 2.0 * machine.get(P::CoulombFriction) * (after.position_m - before.position_m).abs();
        let sprung = |state: &Si| SPRUNG * 0.5 * store.mass * state.velocity_m_per_s.powi(2);
        let risen = energy(&store, &after) - energy(&store, &before) - sprung(&before).max(sprung(&after));
        growth.0 = growth.0.max((risen - turned) / scale);
        growth.1 = growth.1.max((energy(&store, &after) - sprung(&after) - first) / scale);
    }
    growth
}

/// What an open drive holds more than its supply gave and its tank took, largest over a run, in shares of what the supply gave.
fn created(machine: &Machine<f64>, tick: Tick, seed: u64) -> f64 {
    let drive = drive::<f64>(machine, tick);
    let (store, bases) = (Store::of(machine), drive.bases());
    let mut state = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.0));
    let first = energy(&store, &si(&state, bases));
    let (supply_pa, tank_pa) = (machine.get(P::SupplyPressure), machine.get(P::TankPressure));
    let scale = store.capacities.iter().sum::<f64>() * supply_pa * supply_pa;
    let (mut given, mut passed, mut created) = (0.0, scale, 0.0_f64);
    for volts in Excitation::random_steps(seed).sample(tick.seconds()) {
        let seen = drive.step(&mut state, Entry::Command(command(volts)), Load::NONE);
        let slider = seen.slider.unwrap();
        let [into_a, out_of_b] = [seen.flows.a, seen.flows.b].map(|flow| flow * bases.flow_m3_per_s * bases.tick_s);
        let (from_supply, to_tank) =
            if slider.from + slider.to > 0.0 { (into_a, out_of_b) } else { (-out_of_b, -into_a) };
        given += supply_pa * from_supply - tank_pa * to_tank;
        passed += supply_pa * (from_supply.abs() + to_tank.abs());
        created = created.max((energy(&store, &si(&state, bases)) - first - given) / passed);
    }
    created
}

/// Lowest and highest pressure of a run, Pa, and its largest velocity without sign, m/s.
fn extremes<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, volts: &[f64]) -> [f64; 3] {
    let drive = drive::<N>(machine, tick);
    let mut state: State<N> = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.0));
    let [mut lowest, mut highest, mut fastest] = [0.0_f64; 3];
    for &volts in volts {
        drive.step(&mut state, Entry::Command(command(volts)), Load::NONE);
        let now = si(&state, drive.bases());
        highest = now.pressures_pa.into_iter().fold(highest, f64::max);
        lowest = now.pressures_pa.into_iter().fold(lowest, f64::min);
        fastest = fastest.max(now.velocity_m_per_s.abs());
    }
    [lowest, highest, fastest]
}

proptest! {
    #![proptest_config(cases(200))]

    /// Meter-out raises a pressure to the supply's times the area ratio, a load adds its own, and a stop of the mass its shock.
    ///
    /// Downwards the same: the model has no vapour pressure. (7) is linear and oil can pull, so that what a chamber may fall to is what the
    /// load, dry friction and the mass can draw, in fixed point and in f64 alike, and no floor holds it.
    #[test]
    fn pressures_stay_where_supply_load_and_inertia_can_bring_them(
        machine in any_machine().prop_map(gentle),
        tick in any_tick(),
        seed in any::<u64>(),
    ) {
        let volts = Excitation::random_steps(seed).sample(tick.seconds());
        let store = Store::of(&machine);
        let (supply_pa, area_b) = (machine.get(P::SupplyPressure), machine.get(P::AreaB));
        let forced = (machine.get(P::LoadForce).abs() + machine.get(P::CoulombFriction)) / area_b;
        let fixed = extremes::<PerUnit>(&machine, tick, &volts);
        for [lowest, highest, fastest] in [fixed, extremes::<f64>(&machine, tick, &volts)] {
            let shock = store.shock_pa(fastest);
            let most = supply_pa * machine.get(P::AreaA) / area_b + forced + shock + 0.01 * supply_pa;
            let least = -forced - shock - 0.01 * supply_pa;
            prop_assert!(highest <= most, "{highest:e} Pa over {most:e} Pa");
            prop_assert!(lowest >= least, "{lowest:e} Pa under {least:e} Pa");
            prop_assert!(highest < 7.9 * supply_pa && lowest > -7.9 * supply_pa, "held at the end of the format");
        }
    }

    #[test]
    fn a_closed_drive_gains_no_energy(
        machine in any_machine().prop_map(closed),
        tick in any_tick(),
        start in prop::array::uniform3(0.0..1.0_f64),
    ) {
        let (real, fixed) = (growth::<f64>(&machine, tick, start), growth::<PerUnit>(&machine, tick, start));
        prop_assert!(real.0 < ROUNDING && fixed.0 < ROUNDING, "in a tick: {real:?} {fixed:?}");
        prop_assert!(real.1 < ROUNDING && fixed.1 < ROUNDING, "in the run: {real:?} {fixed:?}");
    }

    #[test]
    fn an_open_drive_holds_no_more_than_its_supply_gave(
        machine in any_machine(),
        tick in any_tick(),
        seed in any::<u64>(),
    ) {
        let mut machine = machine;
        machine.set(P::InternalLeakage, 0.0);
        let created = created(&machine, tick, seed);
        prop_assert!(created < 1e-9, "{created:e}");
    }
}
