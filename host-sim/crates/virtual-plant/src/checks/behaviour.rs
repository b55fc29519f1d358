//! What each effect and the pump drive must do, by hand calculation, and the exactness of the Jacobian.

use model_core::machine::Parameter::*;
use model_core::machine::{Machine, Source};
use recording::seeded_noise::Noise;

use super::validation::{heavy, press};
use crate::physics::Physics;
use crate::tangent::Tangent;
use crate::*;

const SIMPLE: f64 = 1e-9;

fn ticks(count: usize) -> Vec<f64> {
    (0..count).map(|k| k as f64 * 1e-3).collect()
}

/// A valve drive whose command keeps the spool inside its dead zone.
fn closed_valve(effects: &[PlantEffect], load: LoadProfile, initial: &InitialState, count: usize) -> Vec<PlantState> {
    let plant = Plant::new(&press(), SIMPLE).unwrap().with_effects(effects).with_load(load);
    plant.simulate(&Commands::Valve(vec![0.0; count]), initial, &ticks(count)).unwrap()
}

#[test]
fn the_tangent_jacobian_agrees_with_differences_with_every_effect_on() {
    let effects = [
        PlantEffect::hose_compliance(1e-13),
        PlantEffect::coulomb_friction(500.0),
        PlantEffect::internal_leakage(1e-12),
        PlantEffect::pump_slip(1e-12),
        PlantEffect::external_leakage([1e-12, 3e-13]),
        PlantEffect::entrained_air(0.01),
        PlantEffect::named("cavitation", 2.79e6).unwrap(),
        PlantEffect::PositionDependentVolume,
        PlantEffect::named("position-dependent-friction", 400.0).unwrap(),
        PlantEffect::named("stribeck-friction", 400.0).unwrap(),
        PlantEffect::named("pressure-dependent-friction", 1e-4).unwrap(),
        PlantEffect::named("position-dependent-load", 900.0).unwrap(),
        PlantEffect::named("end-stop", 0.149).unwrap(),
        PlantEffect::named("supply-droop", 3e9).unwrap(),
        PlantEffect::named("tank-back-pressure", 5e12).unwrap(),
        PlantEffect::named("valve-leakage", 0.01).unwrap(),
        PlantEffect::named("oil-temperature", 1.0).unwrap(),
        PlantEffect::named("~pump-ripple", 0.02).unwrap(),
    ];
    for (source, speed) in [(Source::Valve, 0.0), (Source::Pump, 20.0)] {
        let mut machine = heavy();
        machine.source = source;
        let physics = Physics::new(&machine, &effects);
        let pump = (source == Source::Pump).then_some(PumpCommand { speed_rev_per_s: speed, direction: -1 });
        for spool in [-0.3, 0.0, 0.2, 0.9] {
            let inputs = physics.inputs(0.0, spool, pump, 100.0);
            let at = [0.4, 0.7, -0.05, 0.5, 0.6, 0.4, -0.3, 0.2, -0.1, 0.7];
            assert_eq!(at.len(), physics.states());
            for column in 0..at.len() {
                let (mut above, mut below) = (at, at);
                above[column] += 1e-6;
                below[column] -= 1e-6;
                let (mut rates_above, mut rates_below) = ([0.0; 10], [0.0; 10]);
                physics.rates(&inputs, &above, &mut rates_above);
                physics.rates(&inputs, &below, &mut rates_below);
                let variables: [Tangent; 10] =
                    std::array::from_fn(|i| Tangent::new(at[i], if i == column { 1.0 } else { 0.0 }));
                let mut rates = [Tangent::new(0.0, 0.0); 10];
                physics.rates(&inputs, &variables, &mut rates);
                for row in 0..at.len() {
                    let difference = (rates_above[row] - rates_below[row]) / 2e-6;
                    let slope = rates[row].slope;
                    assert!(
                        (slope - difference).abs() < 1e-4 * (1.0 + slope.abs()),
                        "{source:?} {spool} {row} {column}"
                    );
                }
            }
        }
    }
}

#[test]
fn dry_friction_holds_a_load_below_its_force_and_lets_go_above() {
    let effects = [PlantEffect::coulomb_friction(1000.0)];
    // Chambers so soft that they cannot hold the rod; only the friction can.
    let mut machine = press();
    machine.set(VolumeA, 10.0);
    machine.set(VolumeB, 10.0);
    machine.set(ViscousFriction, 1.0e4);
    let plant = Plant::new(&machine, SIMPLE).unwrap().with_effects(&effects);
    let load = LoadProfile::through(vec![(0.0, 0.0), (0.1, 900.0), (0.6, 900.0), (0.7, 1500.0)]).unwrap();
    let initial = InitialState::at_rest(&machine, 0.15);
    let states = plant.with_load(load).simulate(&Commands::Valve(vec![0.0; 1001]), &initial, &ticks(1001)).unwrap();
    let held = states[600].position_m - states[150].position_m;
    assert!(held.abs() < 1e-8, "it creeps by {held:.2e} m");
    // Bristles give by Fc/stiffness · ln(1/(1 − F/Fc)): 76.8 µm, less a small part because the oil carries some of the load.
    let give_m = 1000.0 / 3e7 * 10.0_f64.ln();
    assert!((states[150].position_m - 0.15 - give_m).abs() < 0.01 * give_m);
    // (1500 − 1000) N / 1e4 N s/m = 50 mm/s once it slides, less the effect of the oil spring.
    let spring_n_per_m = 1.2e8 * (3.117e-3_f64.powi(2) + 1.861e-3_f64.powi(2));
    let expected = (500.0 - spring_n_per_m * (states[1000].position_m - 0.15)) / 1e4;
    assert!((states[1000].velocity_m_per_s - expected).abs() < 3e-4, "{}", states[1000].velocity_m_per_s);
}

#[test]
fn leakage_past_the_piston_conserves_oil_and_evens_the_pressures() {
    let machine = press();
    let initial = InitialState { pressure_a_pa: 4.0e6, pressure_b_pa: 1.0e6, ..InitialState::at_rest(&machine, 0.15) };
    let states = closed_valve(&[PlantEffect::internal_leakage(2e-11)], LoadProfile::none(), &initial, 3000);
    let oil =
        |s: &PlantState| s.pressure_a_pa / 2.3e12 + s.pressure_b_pa / 3.6e12 + (3.117e-3 - 1.861e-3) * s.position_m;
    assert!((oil(&states[2999]) - oil(&states[0])).abs() < 1e-12);
    let gap = (states[2999].pressure_a_pa - states[2999].pressure_b_pa).abs();
    assert!(gap < 2e5, "{gap}");
    let still = closed_valve(&[], LoadProfile::none(), &InitialState::at_rest(&machine, 0.15), 1000);
    assert!((still[999].position_m - 0.15).abs() < 1e-12);
}

#[test]
fn a_hose_makes_the_oil_spring_softer_by_its_share_of_the_capacity() {
    let machine = press();
    let initial = InitialState::at_rest(&machine, 0.15);
    let load = || LoadProfile::through(vec![(0.0, 0.0), (0.1, 0.0), (0.2, 2000.0)]).unwrap();
    let give = |effects: &[PlantEffect]| {
        let states = closed_valve(effects, load(), &initial, 2000);
        states[1999].position_m - 0.15
    };
    let stiffness =
        |extra: f64| 3.117e-3_f64.powi(2) / (1.0 / 2.3e12 + extra) + 1.861e-3_f64.powi(2) / (1.0 / 3.6e12 + extra);
    assert!((give(&[]) * stiffness(0.0) / 2000.0 - 1.0).abs() < 1e-6);
    // At about 3 MPa, compared with 60 MPa, the hose has become stiffer by a tenth.
    let found = give(&[PlantEffect::hose_compliance(4e-13)]) * stiffness(4e-13) / 2000.0;
    assert!((0.88..0.97).contains(&found), "{found}");
}

fn pump_drive() -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Pump);
    for (parameter, value) in [(AreaA, 1.9635e-3), (AreaB, 1.6493e-3), (Stroke, 0.075), (ViscousFriction, 2.0e3)] {
        machine.set(parameter, value);
    }
    machine
}

#[test]
fn a_pump_moves_the_rod_at_flow_over_area_both_ways_and_a_closed_valve_holds_it() {
    let machine = pump_drive();
    let command = |k: usize| match k {
        0..500 => PumpCommand { speed_rev_per_s: 20.0, direction: 1 },
        500..1000 => PumpCommand { speed_rev_per_s: 20.0, direction: -1 },
        _ => PumpCommand { speed_rev_per_s: 20.0, direction: 0 },
    };
    let commands = Commands::Pump((0..1500).map(command).collect());
    let initial = InitialState::at_rest_with_level(&machine, 0.03, 5e5);
    let run = |effects: &[PlantEffect]| {
        let plant = Plant::new(&machine, SIMPLE).unwrap().with_effects(effects);
        plant.simulate(&commands, &initial, &ticks(1500)).unwrap()
    };
    let states = run(&[]);
    assert!((states[450].velocity_m_per_s - 1.6e-6 * 20.0 / 1.9635e-3).abs() < 1e-6);
    assert!((states[950].velocity_m_per_s + 1.6e-6 * 20.0 / 1.6493e-3).abs() < 1e-6);
    assert!(states[1499].velocity_m_per_s.abs() < 1e-6);
    let slipping = run(&[PlantEffect::pump_slip(1e-11)]);
    assert!(slipping[450].velocity_m_per_s < states[450].velocity_m_per_s);
    assert!(slipping[950].velocity_m_per_s > states[950].velocity_m_per_s);
}

#[test]
fn a_plant_can_be_handed_to_another_thread() {
    fn shared<T: Send + Sync>(_: &T) {}
    shared(&Plant::new(&press(), 1e-7).unwrap());
}

#[test]
fn what_cannot_be_simulated_is_said_with_its_values() {
    let machine = press();
    let initial = InitialState::at_rest(&machine, 0.15);
    let plant = Plant::new(&machine, 1e-7).unwrap();
    let error = |commands: Commands, times: &[f64]| plant.simulate(&commands, &initial, times).unwrap_err().to_string();
    assert_eq!(
        error(Commands::Valve(vec![0.0; 3]), &[0.0, 1.0]),
        "3 commands for 2 times; expected one command per time"
    );
    assert_eq!(error(Commands::Valve(vec![0.0; 2]), &[1.0, 1.0]), "time 1 s at tick 1 does not follow 1 s");
    assert!(error(Commands::Pump(vec![PumpCommand::default()]), &[0.0]).contains("Valve"));
    assert_eq!(
        error(Commands::Valve(vec![0.0, f64::NAN]), &[0.0, 1e-3]),
        "command at tick 1 is NaN, expected a finite number"
    );
    let mut broken = machine;
    broken.set(MovingMass, -1.0);
    assert_eq!(
        Plant::new(&broken, 1e-7).unwrap_err().to_string(),
        "cylinder.moving_mass_kg is -1, expected a number within its range"
    );
    assert!(Plant::new(&machine, 1e-20).is_err());
}

/// Also far from the validation drives: over three decades of mass, damping and volume, with every effect.
#[test]
fn no_plausible_drive_makes_the_integrator_fail() {
    let mut noise = Noise::new(99, 0);
    for case in 0..12 {
        let mut machine = press();
        let mut spread = |from: f64, to: f64| noise.uniform(from.ln(), to.ln()).exp();
        for (parameter, from, to) in [
            (MovingMass, 1.0, 2000.0),
            (ViscousFriction, 100.0, 3e5),
            (VolumeA, 5e-5, 5e-3),
            (VolumeB, 5e-5, 5e-3),
            (FlowCoefficient, 1e-8, 3e-6),
            (LaminarTransition, 10.0, 1e5),
            (TimeConstant1, 1e-4, 0.1),
            (DeadZone, 1e-3, 0.3),
            (TransportDelay, 1e-4, 0.05),
        ] {
            machine.set(parameter, spread(from, to));
        }
        let effects = [
            PlantEffect::coulomb_friction(spread(10.0, 4000.0)),
            PlantEffect::internal_leakage(spread(1e-14, 1e-11)),
            PlantEffect::hose_compliance(spread(1e-15, 1e-11)),
        ];
        let volts = Excitation::random_steps(case).sample(1e-3);
        let initial = InitialState::at_rest(&machine, 0.15);
        let run = |tolerance: f64| {
            let plant = Plant::new(&machine, tolerance).unwrap().with_effects(&effects);
            plant.simulate(&Commands::Valve(volts.clone()), &initial, &ticks(volts.len())).unwrap()
        };
        for (coarse, fine) in run(1e-7).iter().zip(run(1e-9)) {
            assert!((coarse.pressure_a_pa - fine.pressure_a_pa).abs() < 1e-4 * 7e6, "case {case}");
            assert!((coarse.position_m - fine.position_m).abs() < 1e-6 * 0.3, "case {case}");
        }
    }
}
