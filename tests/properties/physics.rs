//! Pressures stay where supply, load and inertia can bring them; energy is not created.

use std::cell::Cell;

use proptest::prelude::*;

use model_core::drive::{Drive, DriveInput, Load};
use model_core::machine::{Machine, Parameter as P, Tick};
use model_core::number::{PerUnit, Scalar};
use recording::excitation::signals::Excitation;
use system_tests::any_effects::{LOAD, LUGRE, NO_FLOOR, STOPS, any_effects, overlapped, without};
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{DELAY, State, at_rest, command, drive, larger};
use virtual_plant::InitialState;

use super::{cases, runner};

/// Allowed growth of energy, as a share of what the supply would compress: leakage is implicit on the diagonal only, which gives
/// up to 1e-7; fixed point rounds to 4e-9.
const ROUNDING: f64 = 1e-6;

/// The step keeps the energy of a mass that is smaller than the moving mass by up to this share, see `sprung_mass` in the core.
const SPRUNG: f64 = 0.041;

/// A drive in SI units, with the parameters of its stored energy.
struct Store {
    mass: f64,
    load_n: f64,
    areas_m2: [f64; 2],
    /// V/E and hose of each chamber, m³/Pa.
    capacities: [f64; 2],
    /// Where the stops begin, m, and the stiffness of both, N/m.
    stops_m: [f64; 2],
    stop_n_per_m: f64,
}

impl Store {
    fn of(machine: &Machine<f64>) -> Self {
        let capacity = |volume: P| machine.get(volume) / machine.get(P::BulkModulus) + machine.get(P::HoseCompliance);
        Self {
            mass: machine.get(P::MovingMass),
            load_n: machine.get(P::LoadForce),
            areas_m2: [machine.get(P::AreaA), machine.get(P::AreaB)],
            capacities: [capacity(P::VolumeA), capacity(P::VolumeB)],
            stops_m: [machine.get(P::StopRetracted), machine.get(P::StopExtended)],
            stop_n_per_m: machine.get(P::StopStiffness),
        }
    }

    /// Stiffness of both oil columns together, N/m.
    fn spring(&self) -> f64 {
        self.areas_m2.iter().zip(self.capacities).map(|(area, capacity)| area * area / capacity).sum()
    }

    /// Largest force of oil and load on the rod, N.
    fn largest_n(&self, state: &Si) -> f64 {
        let oil = self.areas_m2.iter().zip(state.pressures_pa).map(|(area, pressure)| area * pressure.abs());
        oil.sum::<f64>() + self.load_n.abs()
    }

    /// Largest pressure beyond the static one that the mass produces in a chamber when it is stopped from a velocity.
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

/// Energy of the oil, of the load's height, of the stops and of the moving mass, J.
fn energy(store: &Store, state: &Si) -> f64 {
    let compressed = store.capacities.iter().zip(state.pressures_pa).map(|(c, p)| 0.5 * c * p * p);
    let [retracted_m, extended_m] = store.stops_m;
    let depth_m = (retracted_m - state.position_m).max(state.position_m - extended_m).max(0.0);
    let moving = 0.5 * store.mass * state.velocity_m_per_s.powi(2);
    let pressed = 0.5 * store.stop_n_per_m * depth_m * depth_m;
    moving + compressed.sum::<f64>() + pressed - store.load_n * state.position_m
}

/// A valve so small that a stop from full speed raises no pressure by more than a supply pressure.
pub(crate) fn gentle(mut machine: Machine<f64>) -> Machine<f64> {
    let supply_pa = machine.get(P::SupplyPressure);
    let full_speed = 2.0 * machine.get(P::FlowCoefficient) * supply_pa.sqrt() / machine.get(P::AreaB);
    let share = (supply_pa / Store::of(&machine).shock_pa(full_speed)).min(1.0);
    machine.set(P::FlowCoefficient, share * machine.get(P::FlowCoefficient));
    machine
}

/// Without parts that store energy, or feed a chamber, in a way that [`Store`] does not know: air, volumes that follow the piston, springs,
/// bristles, edges that are open at the centre, voids (the floor of the pressure pulls the rod back).
fn storing_nothing_else(machine: &Machine<f64>) -> Machine<f64> {
    let none = [P::AirShare, P::VolumeShare, P::ValveLeakageOpening, P::EdgeRounding];
    without(machine, &[&none[..], &LOAD, &LUGRE].concat()).with(&[NO_FLOOR])
}

/// Without stops either.
fn free(machine: &Machine<f64>) -> Machine<f64> {
    without(machine, &STOPS)
}

/// The valve is closed at command 0, and the tank is without pressure: leaked oil gives no energy to it.
fn closed(machine: &Machine<f64>) -> Machine<f64> {
    overlapped(&without(machine, &[P::ValveOffset, P::NullDriftTravel, P::TankPressure]))
}

/// The largest sum of all kinds of dry friction at these pressures, N.
fn dry_n(machine: &Machine<f64>, pressures_pa: [f64; 2]) -> f64 {
    let get = |parameter| machine.get(parameter);
    let [extending, retracting] = [P::AsymmetricExtending, P::AsymmetricRetracting].map(get);
    let along = get(P::PositionFriction) + get(P::PositionFrictionSlope).abs() + get(P::PositionFrictionBow).abs();
    let pressed = get(P::PressureFriction) * pressures_pa.iter().map(|pressure| pressure.abs()).sum::<f64>();
    let stribeck = get(P::StribeckForce) + get(P::StribeckExcess);
    get(P::CoulombFriction) + stribeck + extending.max(retracting) + along + pressed + get(P::PreslidingForce)
}

/// Where a drive without command starts: pressures in supply pressures; velocity as a share of the fastest whose shock is at most one supply
/// pressure; distance to a stop as a share of the stroke, and which stop. Without stops the rod starts in the middle.
#[derive(Clone, Copy, Debug)]
struct Start {
    pressures: [f64; 2],
    velocity: f64,
    before_stop: f64,
    extended: bool,
}

fn any_start() -> impl Strategy<Value = Start> {
    (prop::array::uniform2(0.0..1.0_f64), -1.0..1.0_f64, 0.0..0.002_f64, any::<bool>())
        .prop_map(|(pressures, velocity, before_stop, extended)| Start { pressures, velocity, before_stop, extended })
}

/// How much the energy of a drive without command grew, as a share of what the supply would compress.
#[derive(Clone, Copy, Debug)]
struct Growth {
    /// The most in any tick that does not end on the face of a stop, and over the run, without what dry friction that reverses in a tick may give.
    tick: f64,
    run: f64,
    /// Whether the rod met a stop.
    met: bool,
}

fn growth<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, start: Start) -> Growth {
    let drive = drive::<N>(machine, tick);
    let (store, bases) = (Store::of(machine), drive.bases());
    let (supply_pa, stroke_m) = (machine.get(P::SupplyPressure), machine.get(P::Stroke));
    let [retracted_m, extended_m] = store.stops_m;
    let position_m = match (store.stop_n_per_m > 0.0, start.extended) {
        (true, true) => extended_m - start.before_stop * stroke_m,
        (true, false) => retracted_m + start.before_stop * stroke_m,
        (false, _) => 0.5 * stroke_m,
    };
    let mut state: State<N> = at_rest(&drive, 0.0, &InitialState::at_rest(machine, position_m));
    state.chambers.a = N::saturated(start.pressures[0]);
    state.chambers.b = N::saturated(start.pressures[1]);
    // Not faster than a stop whose shock is one supply pressure.
    let fastest = (supply_pa / store.shock_pa(1.0) / bases.velocity_m_per_s).min(1.0);
    state.motion.velocity = N::saturated(fastest * start.velocity);
    let scale = store.capacities.iter().sum::<f64>() * supply_pa * supply_pa;
    let first = energy(&store, &si(&state, bases));
    let (mut growth, mut allowed) = (Growth { tick: 0.0, run: 0.0, met: false }, 0.0);
    for _ in 0..500 {
        let before = si(&state, bases);
        drive.step(&mut state, DriveInput::Command(N::ZERO), Load::NONE);
        let after = si(&state, bases);
        // Dry friction that reverses within the tick may have pushed the rod for a part of its way.
        let way_m = after.position_m - before.position_m;
        let (from, to) = (before.velocity_m_per_s, after.velocity_m_per_s);
        let has_turned = from * to <= 0.0 || from * way_m <= 0.0 || to * way_m <= 0.0;
        let most_n = dry_n(machine, before.pressures_pa).max(dry_n(machine, after.pressures_pa));
        let turned = if has_turned { 2.0 * most_n * way_m.abs() } else { 0.0 };
        let sprung = |state: &Si| SPRUNG * 0.5 * store.mass * state.velocity_m_per_s.powi(2);
        let more = energy(&store, &after) - energy(&store, &before);
        let risen = more - sprung(&before).max(sprung(&after));
        // A rod that is set down on a face keeps its velocity, and what pushed it on the way beyond the face has given it more energy.
        let on_a_face = store.stops_m.iter().any(|face| (after.position_m - face).abs() < 1e-7 * stroke_m);
        growth.met |= on_a_face;
        let beyond_m = if on_a_face { from.abs().max(to.abs()) * tick.seconds() } else { 0.0 };
        let pushed_n = store.largest_n(&before).max(store.largest_n(&after));
        allowed += more.clamp(0.0, turned + pushed_n * beyond_m);
        if !on_a_face {
            growth.tick = larger(growth.tick, (risen - turned) / scale);
        }
        growth.run = larger(growth.run, (energy(&store, &after) - sprung(&after) - first - allowed) / scale);
    }
    growth
}

/// Energy that an open drive holds beyond what its supply gave less what its tank took: the largest over a run, as a share of what the supply gave.
fn created<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, seed: u64) -> f64 {
    let drive = drive::<N>(machine, tick);
    let (store, bases) = (Store::of(machine), drive.bases());
    let mut state: State<N> = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.0));
    let first = energy(&store, &si(&state, bases));
    let (supply_pa, tank_pa) = (machine.get(P::SupplyPressure), machine.get(P::TankPressure));
    let scale = store.capacities.iter().sum::<f64>() * supply_pa * supply_pa;
    let full_j = 4.0 * machine.get(P::FlowCoefficient) * supply_pa.powf(1.5) * bases.tick_s;
    let (mut given, mut passed, mut created, mut held) = (0.0, scale, 0.0, first);
    for volts in Excitation::random_steps(seed).sample(tick.seconds()) {
        let seen = drive.step(&mut state, DriveInput::Command(command(volts)), Load::NONE);
        let spool = seen.spool.unwrap();
        let [into_a, out_of_b] =
            [seen.flows.a, seen.flows.b].map(|flow| flow.to_f64() * bases.flow_m3_per_s * bases.tick_s);
        let (from_supply, to_tank) =
            if spool.from.to_f64() + spool.to.to_f64() > 0.0 { (into_a, out_of_b) } else { (-out_of_b, -into_a) };
        let holds = energy(&store, &si(&state, bases));
        // If the spool crosses the centre within a tick, a port was open to both sides: any energy is allowed, up to what the valve passes.
        let crosses = spool.from.to_f64() * spool.to.to_f64() < 0.0;
        let known = supply_pa * from_supply - tank_pa * to_tank;
        given += if crosses { (holds - held).min(full_j) } else { known };
        passed += supply_pa * (from_supply.abs() + to_tank.abs());
        created = larger(created, (holds - first - given) / passed);
        held = holds;
    }
    created
}

/// Lowest and highest pressure of a run, Pa, and its largest velocity without sign, m/s.
fn extremes<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, volts: &[f64]) -> [f64; 3] {
    let drive = drive::<N>(machine, tick);
    let mut state: State<N> = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.0));
    let [mut lowest, mut highest, mut fastest] = [0.0_f64; 3];
    for &volts in volts {
        drive.step(&mut state, DriveInput::Command(command(volts)), Load::NONE);
        let now = si(&state, drive.bases());
        highest = now.pressures_pa.into_iter().fold(highest, larger);
        lowest = now.pressures_pa.into_iter().fold(lowest, |lowest, found| -larger(-lowest, -found));
        fastest = larger(fastest, now.velocity_m_per_s.abs());
    }
    [lowest, highest, fastest]
}

proptest! {
    #![proptest_config(cases(2000))]

    /// Meter-out raises a pressure to the supply's times the area ratio; a load adds its own pressure, and stopping the mass adds its shock.
    ///
    /// Downwards the same holds: the model has no vapour pressure. (7) is linear and oil can pull. So a chamber may fall as far as the
    /// load, dry friction and the mass can pull it, in fixed point and in f64 alike, and no floor holds the pressure.
    #[test]
    fn pressures_stay_where_supply_load_and_inertia_can_bring_them(
        machine in any_machine().prop_map(gentle),
        tick in any_tick(),
        effects in any_effects(),
        seed in any::<u64>(),
    ) {
        let machine = free(&storing_nothing_else(&effects.on(&machine))).with(&[(P::PressureFriction, 0.0)]);
        prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
        let volts = Excitation::random_steps(seed).sample(tick.seconds());
        let store = Store::of(&machine);
        let (supply_pa, area_b) = (machine.get(P::SupplyPressure), machine.get(P::AreaB));
        let forced_n = machine.get(P::LoadForce).abs() + dry_n(&machine, [0.0; 2]);
        // Leakage past the piston makes both pressures equal; the pressure then acts on the difference of the areas.
        let differs_m2 = machine.get(P::AreaA) - area_b;
        let leaks = machine.get(P::InternalLeakage) > 0.0 && differs_m2 > 1e-9;
        let forced = forced_n / if leaks { differs_m2 } else { area_b };
        let fixed = extremes::<PerUnit>(&machine, tick, &volts);
        for [lowest, highest, fastest] in [fixed, extremes::<f64>(&machine, tick, &volts)] {
            let shock = store.shock_pa(fastest);
            let most = supply_pa * machine.get(P::AreaA) / area_b + forced + shock + 0.01 * supply_pa;
            let least = -forced - shock - 0.01 * supply_pa;
            prop_assert!(highest <= most, "{highest:e} Pa over {most:e} Pa");
            prop_assert!(lowest >= least, "{lowest:e} Pa under {least:e} Pa");
            prop_assert!(leaks || highest.max(-lowest) < 7.9 * supply_pa, "held at the end of the format");
        }
    }

    #[test]
    fn an_open_drive_holds_no_more_than_its_supply_gave(
        machine in any_machine(),
        tick in any_tick(),
        effects in any_effects(),
        seed in any::<u64>(),
    ) {
        let leaks = [P::InternalLeakage, P::ExternalLeakageA, P::ExternalLeakageB];
        let machine = overlapped(&without(&free(&storing_nothing_else(&effects.on(&machine))), &leaks));
        prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
        let (real, fixed) = (created::<f64>(&machine, tick, seed), created::<PerUnit>(&machine, tick, seed));
        prop_assert!(real < 1e-9 && fixed < ROUNDING, "{real:e}, in fixed point {fixed:e}");
    }
}

#[test]
fn a_closed_drive_gains_no_energy() {
    let (with_stops, met) = (Cell::new(0), Cell::new(0));
    runner(2000, file!())
        .run(&(any_machine(), any_tick(), any_effects(), any_start()), |(machine, tick, effects, start)| {
            let machine = closed(&storing_nothing_else(&effects.on(&machine)));
            prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
            let found = [growth::<f64>(&machine, tick, start), growth::<PerUnit>(&machine, tick, start)];
            with_stops.set(with_stops.get() + u32::from(machine.get(P::StopStiffness) > 0.0));
            met.set(met.get() + u32::from(found[0].met));
            prop_assert!(found.iter().all(|growth| growth.tick < ROUNDING && growth.run < ROUNDING), "{found:?}");
            Ok(())
        })
        .unwrap();
    let (with_stops, met) = (with_stops.get(), met.get());
    println!("{met} of {with_stops} rods between stops met one");
    assert!(met > 80, "{met} of {with_stops}");
}
