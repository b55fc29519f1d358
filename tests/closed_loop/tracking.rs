//! Tracking errors under conditions that the tuning did not know.

use rayon::prelude::*;

use firmware::set_point::{Bounds, Leg};
use model_core::control::Tuning;
use model_core::machine::{Machine, Parameter as P};
use system_tests::drives;
use system_tests::rig::{COMMAND_LIMIT_V, Rig, SLEW_V_PER_S, Wanted, course, largest_force_n, rms_mm, worst_mm};
use virtual_plant::sensor::sensors::PositionSensor;
use virtual_plant::{LoadProfile, PlantEffect};

use crate::following::{Following, Sight};
use crate::pi::{Gains, Pi, tuned};
use crate::table::{self, TableLine};

/// Dry friction that the model does not know, N: 9 % of the largest force.
const FRICTION_N: f64 = 2000.0;
/// Shares of the overlap that the better PI controller may jump over.
const JUMPS: [f64; 2] = [0.8, 0.95];

/// The press, with this number of counts a turn: 3600 impulses, with all four edges counted.
fn press(counts: f64) -> Machine<f64> {
    drives::press().with(&[(P::EncoderCounts, counts)])
}

/// Moves from rest to rest, in pairs that turn without a rest, at 0.03 m/s: half of what the press can do against the load.
fn moves(machine: &Machine<f64>) -> Vec<Wanted> {
    let bounds = Bounds { from_m: 0.01, to_m: 0.29, velocity_m_per_s: 0.03, acceleration_m_per_s2: 0.3 };
    let legs = [
        Leg::Rest { duration_s: 0.2 },
        Leg::Fastest { to_m: 0.17 },
        Leg::Rest { duration_s: 0.5 },
        Leg::Fastest { to_m: 0.12 },
        Leg::Smooth { to_m: 0.14, duration_s: 2.0 },
        Leg::Smooth { to_m: 0.16, duration_s: 1.3 },
        Leg::Smooth { to_m: 0.12, duration_s: 2.6 },
        Leg::Rest { duration_s: 0.5 },
    ];
    // In the middle of an encoder step, so that the reading at the start is the true position.
    let from_m = PositionSensor::encoder(machine).unwrap().measure(0.1);
    course(machine, &bounds, from_m, &legs)
}

/// The rule's tuning, with the limits of the output card and the largest step of the encoder on the rod.
fn tuning(machine: &Machine<f64>) -> Tuning {
    let sensor = PositionSensor::encoder(machine).unwrap();
    let seen = |k: u32| sensor.measure(1e-5 * f64::from(k));
    let position_resolution_m = (1..30_000).map(|k| seen(k) - seen(k - 1)).fold(0.0, f64::max);
    Tuning {
        command_limit_v: COMMAND_LIMIT_V,
        slew_v_per_s: SLEW_V_PER_S,
        position_resolution_m,
        ..Tuning::by_rule(machine, true)
    }
}

/// A machine and what the model knows about it.
struct Case {
    name: &'static str,
    rig: Rig,
    model: Machine<f64>,
}

fn cases(nominal: &Rig) -> Vec<Case> {
    let machine = nominal.machine;
    let half_n = -0.5 * largest_force_n(&machine);
    let loaded = machine.with(&[(P::LoadForce, half_n)]);
    let rubbing = machine.with(&[(P::CoulombFriction, FRICTION_N)]);
    let comes_on = LoadProfile::through(vec![(0.0, 0.0), (1.0, 0.0), (1.02, half_n)]).unwrap();
    let load_comes_on = Rig { load: comes_on, ..nominal.clone() };
    let under_load = Rig { machine: loaded, ..nominal.clone() };
    let effects = vec![PlantEffect::coulomb_friction(FRICTION_N)];
    let under_friction = Rig { effects, ..nominal.clone() };
    vec![
        Case { name: "nominal", rig: nominal.clone(), model: machine },
        Case { name: "half load comes on", rig: load_comes_on, model: machine },
        Case { name: "half load", rig: under_load.clone(), model: machine },
        Case { name: "half load, in model", rig: under_load, model: loaded },
        Case { name: "friction", rig: under_friction.clone(), model: machine },
        Case { name: "friction, in model", rig: under_friction, model: rubbing },
    ]
}

fn line(counts: f64, case: &Case, tuning: &Tuning, plain: Gains, jumping: Gains) -> TableLine {
    let Case { name, rig, model } = case;
    let followed = rig.run(&mut Following::new(model, tuning, rig));
    let with = |gains: Gains| rms_mm(&rig.run(&mut Pi::new(&rig.machine, gains)));
    TableLine {
        name: format!("{counts:<6} {name}"),
        following_mm: rms_mm(&followed),
        following_worst_mm: worst_mm(&followed),
        plain_mm: with(plain),
        jumping_mm: with(jumping),
    }
}

fn lines(counts: f64) -> Vec<TableLine> {
    let machine = press(counts);
    let nominal = Rig::new(&machine, moves(&machine));
    let (plain, _) = tuned(&nominal, 0.0);
    let (jumping, _) =
        JUMPS.map(|jumped| tuned(&nominal, jumped)).into_iter().min_by(|one, other| one.1.total_cmp(&other.1)).unwrap();
    println!("{counts} counts: {plain:?}, {jumping:?}");
    let tuning = tuning(&machine);
    cases(&nominal).iter().map(|case| line(counts, case, &tuning, plain, jumping)).collect()
}

#[test]
fn the_machine_follows_with_a_third_of_a_tuned_pi_controllers_error_and_better_still_with_what_was_missing() {
    let lines: Vec<TableLine> = [3600.0, 14_400.0].into_par_iter().flat_map_iter(lines).collect();
    table::compare(&lines);
    for found in &lines {
        let TableLine { name, following_mm, plain_mm, jumping_mm, .. } = found;
        assert!(following_mm <= &(plain_mm / 3.0), "{name}: {following_mm} mm, PI {plain_mm} mm");
        // Not required, but an even fairer comparison: a PI controller that knows the overlap.
        assert!(following_mm <= &(jumping_mm / 2.0), "{name}: {following_mm} mm, PI over overlap {jumping_mm} mm");
    }
    for pair in lines.windows(2).filter(|pair| pair[1].name.ends_with("in model")) {
        let [before, after] = [&pair[0], &pair[1]].map(|line| line.following_mm);
        assert!(after < 0.8 * before, "{}: {before} mm, then {after} mm", pair[1].name);
    }
}

#[test]
fn a_machine_that_is_sent_far_at_once_arrives_and_comes_to_rest() {
    let machine = press(14_400.0);
    let bounds = Bounds { from_m: 0.01, to_m: 0.29, velocity_m_per_s: 0.1, acceleration_m_per_s2: 1.0 };
    let from_m = PositionSensor::encoder(&machine).unwrap().measure(0.1);
    let legs = [Leg::Rest { duration_s: 0.1 }, Leg::Jump { to_m: 0.15 }, Leg::Rest { duration_s: 16.0 }];
    let nominal = Rig::new(&machine, course(&machine, &bounds, from_m, &legs));
    let tuning = tuning(&machine);
    for case in cases(&nominal) {
        let rows = case.rig.run(&mut Following::new(&case.model, &tuning, &case.rig));
        let over_mm = rows.iter().map(|row| 1e3 * (row.true_m - 0.15)).fold(0.0, f64::max);
        let last = &rows[rows.len() - 2000..];
        let [least, most] =
            [f64::min, f64::max].map(|pick| last.iter().map(|row| 1e3 * row.true_m).reduce(pick).unwrap());
        println!(
            "{}: over by {over_mm:.3} mm, then {:.3} mm off, moving {:.3} mm",
            case.name,
            worst_mm(last),
            most - least
        );
        // One step of the encoder is 0.2 mm. The integral takes seconds to correct the error within it, and then rests.
        assert!(over_mm < 0.5 && worst_mm(last) < 0.2 && most - least < 0.01, "{}", case.name);
    }
}

#[test]
fn with_the_position_alone_a_load_is_corrected_once_it_shows() {
    let machine = press(14_400.0);
    let nominal = Rig::new(&machine, moves(&machine));
    let rule = Tuning::by_rule(&machine, false);
    let tuning = Tuning { position_resolution_m: tuning(&machine).position_resolution_m, ..rule };
    for case in cases(&nominal) {
        let mut following = Following::seeing(Sight::PositionOnly, &case.model, &tuning, &case.rig);
        let rows = case.rig.run(&mut following);
        println!("{}: {:.3} mm, at most {:.3} mm", case.name, rms_mm(&rows), worst_mm(&rows));
        let known = case.name == "nominal" || case.name.ends_with("in model");
        // What the model knows needs no sensor; what it does not know is corrected only after it has become a position error.
        assert!(rms_mm(&rows) < if known { 0.05 } else { 0.7 }, "{}", case.name);
    }
}

#[test]
fn a_heavy_load_on_a_fast_valve_is_damped_by_its_pressures() {
    // Two tonnes on an oil spring of 21 Hz that nothing else damps.
    let heavy = [(P::MovingMass, 2000.0), (P::ViscousFriction, 2e3)];
    let fast = [(P::TimeConstant1, 0.002), (P::TimeConstant2, 0.0), (P::TransportDelay, 0.0), (P::RateLimit, 100.0)];
    let machine = press(14_400.0).with(&heavy).with(&fast);
    let nominal = Rig::new(&machine, moves(&machine));
    let damped = tuning(&machine);
    let ringing = Tuning { pressure_damping_m_per_s_n: 0.0, ..damped };
    for case in cases(&nominal) {
        let [with, without] =
            [damped, ringing].map(|tuning| rms_mm(&case.rig.run(&mut Following::new(&case.model, &tuning, &case.rig))));
        println!("{}: {with:.3} mm, {without:.3} mm without", case.name);
        assert!(with < 0.1 && with < 0.2 * without, "{}: {with} mm, {without} mm without", case.name);
    }
}

#[test]
fn a_slow_valve_follows_with_a_spring_that_it_cannot_damp() {
    let machine = press(14_400.0).with(&[(P::MovingMass, 200.0), (P::ViscousFriction, 5e3)]);
    let nominal = Rig::new(&machine, moves(&machine));
    let tuning = tuning(&machine);
    assert!(tuning.pressure_damping_m_per_s_n <= 0.0);
    for case in cases(&nominal) {
        let found_mm = rms_mm(&case.rig.run(&mut Following::new(&case.model, &tuning, &case.rig)));
        println!("{}: {found_mm:.3} mm", case.name);
        assert!(found_mm < 0.1, "{}: {found_mm} mm", case.name);
    }
}
