//! Machines drawn at random, as a builder of drives might meet them.

use std::f64::consts::PI;

use proptest::prelude::*;

use model_core::machine::{Machine, Parameter as P, Source, Tick};

/// Evenly over the decades between two values.
fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..=to.ln()).prop_map(f64::exp)
}

/// Cylinder areas (A, B) in m²: 25 to 200 mm bore, rods of 0.4 to 0.75 of it; one in four has a rod on both sides.
fn areas_m2() -> impl Strategy<Value = (f64, f64)> {
    let cylinder = (0.025..0.2_f64, 0.4..0.75_f64, prop::bool::weighted(0.25));
    cylinder.prop_map(|(bore_m, rod, through): (f64, f64, bool)| {
        let full = PI / 4.0 * bore_m * bore_m;
        let annulus = full * (1.0 - rod * rod);
        (if through { annulus } else { full }, annulus)
    })
}

/// Both lags in s: none, one, two different ones, or two equal ones.
fn time_constants_s() -> impl Strategy<Value = (f64, f64)> {
    prop_oneof![
        Just((0.0, 0.0)),
        (5e-4..0.05).prop_map(|lag| (lag, 0.0)),
        (5e-4..0.05).prop_map(|lag| (0.0, lag)),
        (5e-4..0.05).prop_map(|lag| (lag, lag)),
        (5e-4..0.05, 5e-4..0.05),
    ]
}

fn or_none(none: f64, value: impl Strategy<Value = f64>) -> impl Strategy<Value = f64> {
    prop_oneof![Just(none), value]
}

/// Shares that determine the other sizes of a machine: of nominal flow, volume, capacity and force.
#[derive(Clone, Copy, Debug)]
struct Shares {
    full_speed_m_per_s: f64,
    flow_limit: f64,
    volume_a: f64,
    volume_b: f64,
    load: f64,
    leakage: f64,
    hose: f64,
    friction: f64,
}

fn shares(effects: bool) -> impl Strategy<Value = Shares> {
    let on = if effects { 1.0 } else { 0.0 };
    let flows = (decades(0.02, 2.0), or_none(f64::INFINITY, 0.2..1.5));
    let volumes = (decades(0.25, 1.5), decades(0.25, 1.5));
    let effects = (or_none(0.0, 0.0..0.05), or_none(0.0, 0.0..0.5), or_none(0.0, 0.0..0.1));
    (flows, volumes, -0.6..0.6, effects).prop_map(move |(flows, volumes, load, (leakage, hose, friction))| Shares {
        full_speed_m_per_s: flows.0,
        flow_limit: flows.1,
        volume_a: volumes.0,
        volume_b: volumes.1,
        load,
        leakage: leakage * on,
        hose: hose * on,
        friction: friction * on,
    })
}

/// Any valve-controlled machine; its effects as drawn.
pub fn any_machine() -> impl Strategy<Value = Machine<f64>> {
    machines(true)
}

/// Any valve-controlled machine without effects: what the oracle can be compared with.
pub fn any_plain_machine() -> impl Strategy<Value = Machine<f64>> {
    machines(false)
}

fn machines(effects: bool) -> impl Strategy<Value = Machine<f64>> {
    let cylinder = (areas_m2(), decades(0.05, 2.0), 0.4e9..1.6e9);
    let load = (decades(5.0, 2000.0), decades(1e3, 1e6));
    let supply = (decades(2e6, 35e6), or_none(0.0, 0.0..5e5));
    let characteristic = (0.02..0.12, -0.05..0.05, or_none(0.0, 0.0..0.25), decades(100.0, 2e4));
    let dynamics = (or_none(f64::INFINITY, decades(1.0, 100.0)), time_constants_s(), or_none(0.0, 0.0..0.02));
    (cylinder, load, supply, characteristic, dynamics, shares(effects)).prop_map(
        |((areas, stroke_m, modulus_pa), (mass, damping), (supply_pa, tank_pa), valve, dynamics, shares)| {
            let (area_a, area_b) = areas;
            let nominal = shares.full_speed_m_per_s * area_b;
            let (volume_a, volume_b) = (shares.volume_a * area_a * stroke_m, shares.volume_b * area_b * stroke_m);
            // Hoses, so large that the oil columns are just soft enough for the format at the longest tick, with a small margin.
            let tick_s = Tick::TwoMilliseconds.seconds();
            let mobile_m_per_s = tick_s * area_a * supply_pa / (mass + 0.29 * tick_s * damping);
            let filling = tick_s * area_a * modulus_pa / (3.8 * supply_pa);
            let least_m3 = filling * (mobile_m_per_s / 3.8).max(1.5 * nominal / area_b);
            let (volume_a, volume_b) = (volume_a.max(least_m3), volume_b.max(least_m3));
            let mut machine = Machine::with_defaults(Source::Valve);
            for (parameter, value) in [
                (P::AreaA, area_a),
                (P::AreaB, area_b),
                (P::Stroke, stroke_m),
                (P::BulkModulus, modulus_pa),
                (P::VolumeA, volume_a),
                (P::VolumeB, volume_b),
                (P::MovingMass, mass),
                (P::ViscousFriction, damping),
                (P::SupplyPressure, supply_pa),
                (P::TankPressure, tank_pa),
                (P::FlowCoefficient, nominal / (0.5 * supply_pa).sqrt()),
                (P::FlowLimit, nominal * shares.flow_limit),
                (P::ValveGain, valve.0),
                (P::ValveOffset, valve.1),
                (P::DeadZone, valve.2),
                (P::LaminarTransition, valve.3),
                (P::RateLimit, dynamics.0),
                (P::TimeConstant1, dynamics.1.0),
                (P::TimeConstant2, dynamics.1.1),
                (P::TransportDelay, dynamics.2),
                (P::LoadForce, shares.load * area_b * supply_pa),
                (P::InternalLeakage, shares.leakage * nominal / supply_pa),
                (P::HoseCompliance, shares.hose * volume_b.min(volume_a) / modulus_pa),
                (P::CoulombFriction, shares.friction * area_b * supply_pa),
            ] {
                machine.set(parameter, value);
            }
            machine
        },
    )
}

/// Any mass that a force moves: 50 g to 5 t, with and without viscous and dry friction, load and the areas of a cylinder.
pub fn any_axis() -> impl Strategy<Value = Machine<f64>> {
    let mass = (decades(0.05, 5000.0), or_none(0.0, decades(1e-2, 1e3)), decades(0.005, 5.0));
    let forces = (-2.0..2.0_f64, or_none(0.0, 0.0..0.5));
    let areas = prop::option::weighted(0.25, areas_m2());
    (mass, forces, areas).prop_map(|((mass, fades_per_s, stroke_m), (load, friction), areas)| {
        let (area_a, area_b) = areas.unwrap_or((0.0, 0.0));
        let weight_n = 9.81 * mass;
        Machine::with_defaults(Source::Force).with(&[
            (P::MovingMass, mass),
            (P::ViscousFriction, fades_per_s * mass),
            (P::Stroke, stroke_m),
            (P::LoadForce, load * weight_n),
            (P::CoulombFriction, friction * weight_n),
            (P::AreaA, area_a),
            (P::AreaB, area_b),
        ])
    })
}

/// Any tick.
pub fn any_tick() -> impl Strategy<Value = Tick> {
    prop_oneof![Just(Tick::HalfMillisecond), Just(Tick::OneMillisecond), Just(Tick::TwoMilliseconds)]
}
