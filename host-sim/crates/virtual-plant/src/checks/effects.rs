//! What each effect of flow, chambers and mechanics must do, by hand calculation. (Valve: `shaped_spool_tests`; sensing: `sight`.)

use model_core::machine::Machine;
use model_core::machine::Parameter::*;

use super::validation::press;
use crate::*;

fn ticks(count: usize) -> Vec<f64> {
    (0..count).map(|k| k as f64 * 1e-3).collect()
}

fn run(machine: &Machine<f64>, effects: &[PlantEffect], load_n: f64, volts: f64, rows: usize) -> Vec<PlantState> {
    let load = LoadProfile::through(vec![(0.0, 0.0), (0.02, 0.0), (0.05, load_n)]).unwrap();
    let plant = Plant::new(machine, 1e-8).unwrap().with_effects(effects).with_load(load);
    let mut commands = vec![volts; rows];
    commands[..20.min(rows)].fill(0.0);
    let initial = InitialState::at_rest(machine, 0.15);
    plant.simulate(&Commands::Valve(commands), &initial, &ticks(rows)).unwrap()
}

/// A rod in chambers so large that their pressures stay constant: its speed is (force − friction)/damping.
fn free_rod() -> Machine<f64> {
    let mut machine = press();
    for (parameter, value) in [(VolumeA, 10.0), (VolumeB, 10.0), (BulkModulus, 1.0e7), (ViscousFriction, 1.0e4)] {
        machine.set(parameter, value);
    }
    machine
}

/// Friction on a rod that slides under a load of ±2 kN, after a time, N.
fn felt(effect: PlantEffect, load_n: f64, rows: usize) -> f64 {
    let machine = free_rod();
    let speed = |effects: &[PlantEffect]| run(&machine, effects, load_n, 0.0, rows)[rows - 1].velocity_m_per_s;
    (speed(&[]) - speed(&[effect])).abs() * 1e4
}

fn named(name: &str, strength: f64) -> PlantEffect {
    PlantEffect::named(name, strength).unwrap()
}

#[test]
fn every_name_on_the_command_line_makes_an_effect_of_that_name() {
    for (name, _) in PlantEffect::known() {
        assert_eq!(named(name, 0.01).name(), name);
    }
    assert!(PlantEffect::named("rust", 1.0).is_none());
}

#[test]
fn stribeck_friction_holds_more_than_it_slides_with() {
    let effect = named("stribeck-friction", 1000.0);
    // Break-away is at 1.8 times this friction: 1.5 kN does not move the rod; under 2 kN it slides at 100 mm/s against 1 kN.
    let held = run(&free_rod(), &[effect], 1500.0, 0.0, 400);
    assert!(held[399].velocity_m_per_s.abs() < 1e-5);
    assert!((felt(effect, 2000.0, 300) - 1000.0).abs() < 30.0);
}

#[test]
fn asymmetric_friction_differs_with_the_direction() {
    let effect = named("friction-asymmetry", 600.0);
    assert!((felt(effect, 2000.0, 200) - 1.35 * 600.0).abs() < 15.0);
    assert!((felt(effect, -2000.0, 200) - 0.65 * 600.0).abs() < 15.0);
}

#[test]
fn a_tight_place_brakes_there_only() {
    let effect = named("position-dependent-friction", 300.0);
    let states = run(&free_rod(), &[effect], 2500.0, 0.0, 700);
    let at = |position_m: f64| {
        states.iter().find(|state| state.position_m > position_m).map_or(0.0, |state| state.velocity_m_per_s)
    };
    // 2500 − 900 N in the middle of the tight place, 2500 − 300 N well beyond it, less the force of the oil.
    assert!((at(0.16) - 0.16).abs() < 0.01, "{}", at(0.16));
    assert!(at(0.25) > 0.2, "{}", at(0.25));
}

#[test]
fn a_narrow_bore_brakes_by_the_speed_and_away_from_where_it_fits() {
    let (most_n_s_per_m, width_m) = (2e4, 0.05);
    let effect = PlantEffect::Load(LoadEffect::NarrowBore { most_n_s_per_m, fits_at_m: 0.16, width_m });
    let machine = free_rod();
    let states = run(&machine, &[effect], 2500.0, 0.0, 700);
    let damping = machine.get(ViscousFriction);
    for position_m in [0.16, 0.19, 0.21] {
        let square = ((position_m - 0.16) / width_m).powi(2);
        let expected = 2500.0 / (damping + most_n_s_per_m * square / (1.0 + square));
        let found =
            states.iter().find(|state| state.position_m > position_m).map_or(0.0, |state| state.velocity_m_per_s);
        assert!((found / expected - 1.0).abs() < 0.1, "{position_m}: {found} {expected}");
    }
}

#[test]
fn pressure_dependent_friction_goes_mostly_by_the_higher_pressure() {
    let effect = named("pressure-dependent-friction", 1e-4);
    let level = |level_pa: f64| {
        let machine = free_rod();
        let initial = InitialState::at_rest_with_level(&machine, 0.15, level_pa);
        let load = LoadProfile::through(vec![(0.0, 0.0), (0.05, 2000.0)]).unwrap();
        let plant = Plant::new(&machine, 1e-8).unwrap().with_effects(&[effect]).with_load(load);
        let states = plant.simulate(&Commands::Valve(vec![0.0; 200]), &initial, &ticks(200)).unwrap();
        let (a, b) = (initial.pressure_a_pa, initial.pressure_b_pa);
        let expected = 1e-4 * (0.75 * a.max(b) + 0.25 * a.min(b)) + 30.0;
        (2000.0 - 1e4 * states[199].velocity_m_per_s, expected)
    };
    for level_pa in [2e6, 5e6] {
        let (found, expected) = level(level_pa);
        assert!((found - expected).abs() < 0.05 * expected, "{found} {expected}");
    }
}

#[test]
fn presliding_gives_elastically_and_comes_back() {
    let effect = named("presliding", 1000.0);
    let load = LoadProfile::through(vec![(0.0, 0.0), (0.05, 500.0), (0.2, 500.0), (0.3, 0.0)]).unwrap();
    let plant = Plant::new(&free_rod(), 1e-8).unwrap().with_effects(&[effect]).with_load(load);
    let initial = InitialState::at_rest(&free_rod(), 0.15);
    let states = plant.simulate(&Commands::Valve(vec![0.0; 500]), &initial, &ticks(500)).unwrap();
    let (given, left) = (states[190].position_m - 0.15, states[499].position_m - 0.15);
    assert!((1.5e-4..4e-4).contains(&given), "{given}");
    assert!(left < 0.5 * given, "{left} of {given}");
}

#[test]
fn a_stop_holds_the_load_and_does_not_pull() {
    let effect = named("end-stop", 0.2);
    let pressed = run(&free_rod(), &[effect], 2000.0, 0.0, 1500);
    let at = pressed[1499].position_m;
    // k·d^1.5 = 2 kN less the force that the oil carries, with k = 2e9
    assert!((0.2..0.2002).contains(&at), "{at}");
    let away = run(&free_rod(), &[effect], -1000.0, 0.0, 300);
    assert_eq!(away, run(&free_rod(), &[], -1000.0, 0.0, 300));
}

#[test]
fn a_linkage_loads_by_position_whatever_the_direction() {
    let effect = named("position-dependent-load", 1000.0);
    let pull = |load_n: f64| {
        let machine = free_rod();
        let [with, without] =
            [&[effect][..], &[]].map(|effects| run(&machine, effects, load_n, 0.0, 60)[59].velocity_m_per_s);
        1e4 * (with - without)
    };
    let expected = -1000.0 * (0.05_f64 / 0.12).sin();
    // A position 4 mm further out or in changes the force by 30 N.
    assert!((pull(2000.0) - expected).abs() < 60.0 && (pull(-2000.0) - expected).abs() < 60.0);
}

#[test]
fn warm_oil_lets_the_rod_run_faster() {
    let effect =
        PlantEffect::OilTemperature(OilTemperature { rise_k_per_s: 10.0, share_of_power: 0.0, reference_power_w: 1.0 });
    let states = run(&free_rod(), &[effect], 1000.0, 0.0, 1501);
    let cold = run(&free_rod(), &[], 1000.0, 0.0, 1501);
    let ratio = states[1500].velocity_m_per_s / cold[1500].velocity_m_per_s;
    // 15 K: exp(800/155 − 800/140) = 0.575; the oil spring reduces the gain a little.
    assert!((1.6..1.78).contains(&ratio), "{ratio}");
}

#[test]
fn the_supply_falls_with_the_flow_remembers_it_and_recovers() {
    let machine = press();
    let effect = named("supply-droop", 4e9);
    let plant = Plant::new(&machine, 1e-8).unwrap().with_effects(&[effect]);
    let volts = (0..900).map(|k| if (50..350).contains(&k) { 7.0 } else { 0.0 }).collect();
    let states = plant.simulate(&Commands::Valve(volts), &InitialState::at_rest(&machine, 0.1), &ticks(900)).unwrap();
    let supply = |k: usize| states[k].supply_pressure_pa;
    assert!((supply(50) - 7e6).abs() < 1e3);
    let expected = 7e6 - 4e9 * states[340].flow_a_m3_per_s;
    assert!(supply(340) < 6.7e6 && (supply(340) - expected).abs() < 2e5, "{} {expected}", supply(340));
    assert!(supply(450) < supply(340) + 0.9 * (7e6 - supply(340)), "it takes its time");
    assert!((supply(899) - 7e6).abs() < 2e4);
}

#[test]
fn back_pressure_stands_on_the_tank_side_only_while_oil_flows() {
    let machine = press();
    let effect = named("tank-back-pressure", 2e13);
    let [with, without] = [&[effect][..], &[]].map(|effects| run(&machine, effects, 0.0, 6.0, 600));
    assert!(with[599].pressure_b_pa > without[599].pressure_b_pa + 1.5e5);
    assert!(with[599].flow_b_m3_per_s < without[599].flow_b_m3_per_s);
    assert!((with[15].pressure_b_pa - without[15].pressure_b_pa).abs() < 1.0);
}

#[test]
fn a_leaking_valve_fills_the_chambers_and_lets_the_rod_creep() {
    let machine = press();
    let initial = InitialState { pressure_a_pa: 1.5e6, pressure_b_pa: 2.5e6, ..InitialState::at_rest(&machine, 0.15) };
    let run = |effects: &[PlantEffect]| {
        let plant = Plant::new(&machine, 1e-8).unwrap().with_effects(effects);
        plant.simulate(&Commands::Valve(vec![-0.6; 3000]), &initial, &ticks(3000)).unwrap()[2999]
    };
    let (leaking, tight) = (run(&[named("valve-leakage", 0.02)]), run(&[]));
    // The leakage drives both pressures towards half the supply; the larger piston area prevails.
    assert!(leaking.pressure_b_pa > 3.5e6 && leaking.pressure_a_pa < 3.5e6 && leaking.pressure_a_pa > 2e6);
    assert!(leaking.position_m > 0.152 && (tight.position_m - 0.15).abs() < 1e-4);
}

#[test]
fn oil_that_leaks_out_of_one_chamber_lowers_its_pressure_and_the_rod() {
    let states = run(&press(), &[PlantEffect::external_leakage([1e-11, 0.0])], 0.0, 0.0, 1000);
    assert!(states[999].pressure_a_pa < 0.9 * states[0].pressure_a_pa);
    assert!(states[999].position_m < states[0].position_m);
}

#[test]
fn air_softens_the_oil_at_low_pressure_only() {
    let give = |effects: &[PlantEffect], level_pa: f64| {
        let machine = press();
        let initial = InitialState::at_rest_with_level(&machine, 0.15, level_pa);
        let load = LoadProfile::through(vec![(0.0, 0.0), (0.1, 300.0)]).unwrap();
        let plant = Plant::new(&machine, 1e-9).unwrap().with_effects(effects).with_load(load);
        plant.simulate(&Commands::Valve(vec![0.0; 1500]), &initial, &ticks(1500)).unwrap()[1499].position_m - 0.15
    };
    let softer = |level_pa: f64| give(&[PlantEffect::entrained_air(0.02)], level_pa) / give(&[], level_pa);
    let (low, high) = (softer(6e5), softer(1.2e7));
    assert!(low > 2.0 && high < 1.1, "{low} {high}");
}

/// 20 kN pull the rod of a closed drive outwards and release it: 1.6 mm, of which the oil of A alone would allow less than a tenth.
fn drawn_on(effects: &[PlantEffect]) -> Vec<PlantState> {
    let machine = press();
    let load = LoadProfile::through(vec![(0.0, 0.0), (0.05, 0.0), (0.25, 2e4), (0.4, 2e4), (0.6, 0.0)]).unwrap();
    let plant = Plant::new(&machine, 1e-9).unwrap().with_effects(effects).with_load(load);
    let initial = InitialState::at_rest_with_level(&machine, 0.15, 5e5);
    plant.simulate(&Commands::Valve(vec![0.0; 1000]), &initial, &ticks(1000)).unwrap()
}

#[test]
fn oil_that_boils_stays_at_its_pressure_until_the_rod_is_back() {
    let floor_pa = -8e4;
    let states = drawn_on(&[named("cavitation", floor_pa)]);
    let (start, most) = (states[0], states[400]);
    // The oil of B alone carries the load: F·V/(E·A²).
    let given_m = (2e4 - 3.117e-3 * (start.pressure_a_pa - floor_pa)) / (3.6e12 * 1.861e-3_f64.powi(2));
    assert!((most.position_m - start.position_m - given_m).abs() < 0.01 * given_m, "{}", most.position_m);
    // The pressure is a few δ (1.5 kPa) above the floor: the void is a small part of the swept volume.
    let flat = states.iter().filter(|state| (floor_pa..floor_pa + 2e4).contains(&state.pressure_a_pa)).count();
    assert!(flat > 350 && states.iter().all(|state| state.pressure_a_pa > floor_pa), "{flat}");
    let back = states[999];
    assert!(
        (back.position_m - start.position_m).abs() < 1e-7 && (back.pressure_a_pa - start.pressure_a_pa).abs() < 100.0
    );
}

#[test]
fn vapour_and_released_air_fill_what_the_rod_leaves() {
    // Bubbles by the law, and the volume that the oil of the chamber does not fill, both as shares of what the piston sweeps.
    for released in [0.0, 0.02, 0.5] {
        let (floor_pa, steepness_pa) = (-8e4, 1.5e3);
        let states = drawn_on(&[PlantEffect::Cavitation(Cavitation { floor_pa, steepness_pa, released })]);
        let (start, most) = (states[0], states[400]);
        let (area_m2, capacity) = (3.117e-3, 1.0 / 2.3e12);
        let fallen_pa = start.pressure_a_pa - most.pressure_a_pa;
        let left_m3 = area_m2 * (most.position_m - start.position_m) - capacity * fallen_pa;
        let share = left_m3 / (area_m2 * press().get(Stroke));
        let above = (most.pressure_a_pa - floor_pa) / steepness_pa;
        let absolute = |pressure_pa: f64| pressure_pa + 1.013e5;
        let air = released * absolute(floor_pa) / absolute(most.pressure_a_pa) / (1.0 + above.exp());
        let bubbles = (-above).exp() + air;
        assert!(share > 4e-3 && (bubbles / share - 1.0).abs() < 0.02, "{released}: {bubbles} {share}");
        // Half of the oil as air is more than any oil dissolves; but then its part counts.
        assert!(released < 0.5 || air > 0.2 * share, "{air} of {share}");
        let back = states[999];
        assert!((back.position_m - start.position_m).abs() < 1e-7, "{released}: what it gave off is dissolved again");
    }
}

#[test]
fn moving_volumes_make_the_oil_spring_softest_in_the_middle() {
    let stiffness = |position_m: f64| {
        let machine = press();
        let initial = InitialState::at_rest(&machine, position_m);
        let load = LoadProfile::through(vec![(0.0, 0.0), (0.1, 1000.0)]).unwrap();
        let plant =
            Plant::new(&machine, 1e-9).unwrap().with_effects(&[PlantEffect::PositionDependentVolume]).with_load(load);
        let states = plant.simulate(&Commands::Valve(vec![0.0; 1500]), &initial, &ticks(1500)).unwrap();
        1000.0 / (states[1499].position_m - position_m)
    };
    // E·A²/V with V = V0 + A·(y − ½ stroke), by hand
    let expected = |y: f64| {
        let (va, vb) = (1.2e9 / 2.3e12 + 3.117e-3 * (y - 0.15), 1.2e9 / 3.6e12 - 1.861e-3 * (y - 0.15));
        1.2e9 * (3.117e-3_f64.powi(2) / va + 1.861e-3_f64.powi(2) / vb)
    };
    for y in [0.04, 0.15, 0.26] {
        assert!((stiffness(y) / expected(y) - 1.0).abs() < 0.01, "{y}");
    }
}

#[test]
fn metering_and_notches_change_the_flow_as_they_say() {
    let machine = press();
    let flow = |effect: &[PlantEffect], volts: f64| run(&machine, effect, 0.0, volts, 400)[399].velocity_m_per_s;
    let small = named("metering-asymmetry", 0.6);
    assert!(flow(&[small], 6.0) < 0.95 * flow(&[], 6.0));
    let notch = named("flow-gain-nonlinearity", 0.4);
    let ratio = |volts: f64| flow(&[notch], volts) / flow(&[], volts);
    assert!((ratio(2.5) - 0.4).abs() < 0.1 && ratio(7.0) > ratio(2.5) + 0.15, "{} {}", ratio(2.5), ratio(7.0));
    let late = named("dead-zone-asymmetry", 0.08);
    assert!(flow(&[late], 6.0) < flow(&[], 6.0));
    assert!((flow(&[late], -6.0) - flow(&[], -6.0)).abs() < 1e-6);
}

#[test]
fn a_rippling_pump_shakes_the_supply_at_its_frequency() {
    let states = run(&press(), &[named("~pump-ripple", 0.03)], 0.0, 5.0, 1000);
    let off: Vec<f64> = states.iter().map(|state| state.supply_pressure_pa / 7e6 - 1.0).collect();
    let crossings = off.windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count();
    assert!((38..=42).contains(&crossings), "{crossings}");
    assert!(off.iter().all(|share| share.abs() < 0.04));
}

#[test]
fn a_hung_mass_shakes_the_rod_at_its_frequency_until_it_moves_along() {
    let speed = |state: &PlantState| state.velocity_m_per_s;
    let alone = run(&free_rod(), &[], 1000.0, 0.0, 1000);
    let shaken = run(&free_rod(), &[named("~hung-mass", 5.0)], 1000.0, 0.0, 1000);
    let off: Vec<f64> = alone.iter().zip(&shaken).map(|(alone, shaken)| speed(shaken) - speed(alone)).collect();
    // 15 Hz for half a second.
    let crossings = off[100..600].windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count();
    assert!((7..=8).contains(&crossings), "{crossings}");
    assert!(off[100..200].iter().any(|off| off.abs() > 1e-3) && off[999].abs() < 1e-4, "{}", off[999]);
}

#[test]
fn a_load_holding_valve_lets_oil_in_and_holds_it_until_the_other_side_is_pressed() {
    let machine = press();
    let effect = named("counterbalance", 2.2e7);
    let last = |volts: f64| [&[effect][..], &[]].map(|effects| run(&machine, effects, 0.0, volts, 600)[599]);
    // Extending fills A: nothing is in the way.
    let [with, without] = last(6.0);
    assert!((with.velocity_m_per_s / without.velocity_m_per_s - 1.0).abs() < 0.02, "{with:?} {without:?}");
    // Retracting empties it: both pressures rise until their weighted sum is beyond the setting.
    let [with, without] = last(-6.0);
    assert!(with.pressure_a_pa + 3.0 * with.pressure_b_pa > 2.2e7, "{with:?}");
    assert!(with.pressure_b_pa > without.pressure_b_pa + 3e5, "{with:?} {without:?}");
    assert!(with.velocity_m_per_s.abs() < without.velocity_m_per_s.abs());
}
