//! What a chamber holds agrees with the flow equations of its ports and gaps, which are written here without the core. (1)–(4), (7), (9)–(11)

use std::cell::RefCell;

use proptest::prelude::*;

use model_core::machine::{Machine, Parameter as P, Tick};

use super::runner;
use super::smooth::{At, Smooth, TICKS, any_smooth, quantile};

/// Flow into A and out of B by (3) and (4), with leakage past the piston and out of both chambers: in SI units, without the core.
fn flows(machine: &Machine<f64>, at: &At) -> [f64; 2] {
    let get = |parameter| machine.get(parameter);
    let (supply, tank) = (get(P::SupplyPressure), get(P::TankPressure));
    let [a, b] = [at.row.pressure_a, at.row.pressure_b].map(|pressure| pressure * supply);
    let edge = |over: f64| {
        let transition = get(P::LaminarTransition);
        get(P::FlowCoefficient) * at.spool * over / (over * over + transition * transition).powf(0.25)
    };
    let (a_over, b_over) = if at.spool > 0.0 { (supply - a, b - tank) } else { (a - tank, supply - b) };
    let past = get(P::InternalLeakage) * (a - b);
    [
        edge(a_over) - past - get(P::ExternalLeakageA) * (a - tank),
        edge(b_over) - past + get(P::ExternalLeakageB) * (b - tank),
    ]
}

/// Oil in a chamber beyond what its volume at rest holds, m³: (7), (11).
fn held(machine: &Machine<f64>, at: &At) -> [f64; 2] {
    let get = |parameter| machine.get(parameter);
    let oil = |volume, pressure: f64| {
        (get(volume) / get(P::BulkModulus) + get(P::HoseCompliance)) * pressure * get(P::SupplyPressure)
    };
    let position_m = at.row.position * get(P::Stroke);
    [
        oil(P::VolumeA, at.row.pressure_a) + get(P::AreaA) * position_m,
        oil(P::VolumeB, at.row.pressure_b) - get(P::AreaB) * position_m,
    ]
}

/// Largest difference over a run between the oil that each chamber has gained since the start and the integral of the flow equations by the
/// trapezoidal rule, m³; `None` near a corner.
fn not_come(smooth: &Smooth, tick: Tick) -> Option<[f64; 2]> {
    let run = smooth.run(tick)?;
    let machine = &smooth.machine;
    let (start, mut came, mut missed) = (held(machine, &run[0]), [0.0; 2], [0.0_f64; 2]);
    for pair in run.windows(2) {
        let (from, to, now) = (flows(machine, &pair[0]), flows(machine, &pair[1]), held(machine, &pair[1]));
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            came[side] += 0.5 * tick.seconds() * sign * (from[side] + to[side]);
            missed[side] = missed[side].max((now[side] - start[side] - came[side]).abs());
        }
    }
    Some(missed)
}

/// The integral of the flow equations and the oil in the chambers differ by the truncation of the step and of the sum, both of second order.
#[test]
fn what_a_chamber_holds_is_what_ports_and_gaps_pass_by_their_equations_to_second_order() {
    let found = RefCell::new(Vec::new());
    let leaking = (any_smooth(), prop::array::uniform2(0.0..0.05_f64)).prop_map(|(mut smooth, [a, b])| {
        let machine = &smooth.machine;
        let laminar = machine.get(P::FlowCoefficient) / machine.get(P::SupplyPressure).sqrt();
        smooth.machine = machine.with(&[(P::ExternalLeakageA, a * laminar), (P::ExternalLeakageB, b * laminar)]);
        smooth
    });
    runner(500, file!())
        .run(&leaking, |smooth| {
            let missed = TICKS.map(|tick| not_come(&smooth, tick));
            prop_assume!(missed.iter().all(Option::is_some));
            let missed: Vec<[f64; 2]> = missed.into_iter().flatten().collect();
            let full = smooth.machine.get(P::FlowCoefficient) * smooth.machine.get(P::SupplyPressure).sqrt();
            for side in 0..2 {
                // The flow of the fully open valve in half of the shortest tick.
                prop_assert!(
                    missed[2][side] < 0.5 * TICKS[2].seconds() * full,
                    "{:e} m³ of {full:e} m³/s",
                    missed[2][side]
                );
                found.borrow_mut().extend(missed.windows(2).map(|pair| pair[0][side] / pair[1][side]));
            }
            Ok(())
        })
        .unwrap();
    let mut ratios = found.into_inner();
    let [low, middle] = [0.05, 0.5].map(|share| quantile(&mut ratios, share));
    println!("one in twenty below {low:.2}, half below {middle:.2}");
    assert!((3.7..4.3).contains(&middle) && low > 2.7, "{low} {middle}");
}
