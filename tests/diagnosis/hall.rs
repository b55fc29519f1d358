//! Drives as they stand in a hall: known by their data sheets alone, with the tolerances that every installed drive has.

use diagnosis::{Verdict, base_parameters};
use identification::experiment::Prepared;
use identification::fit::{Free, first_search, with_channel_tolerances};
use machine_file::data_sheet::{Answers, Edges, Item, derived, toml};
use machine_file::{MachineFile, read_text};
use model_core::machine::Parameter as P;
use recording::Recording;
use recording::excitation::signals::Excitation;
use virtual_plant::sensor::sensors::PositionSensor;
use virtual_plant::{Bench, Drive, FlowEffect, InitialState, Plant, PlantEffect, Sensors, ValveEffect};

use super::bed::{Case, accepted};

/// What the catalogues say of a 63/36 × 300 mm cylinder on a proportional valve.
fn data_sheet() -> MachineFile {
    let mut answers = Answers::default();
    for (item, text) in [
        (Item::Bore, "63mm"),
        (Item::Rod, "36mm"),
        (Item::Stroke, "300mm"),
        (Item::Mass, "160kg"),
        (Item::Supply, "100bar"),
        (Item::RatedFlow, "10l/min"),
        (Item::RatedDrop, "5bar"),
        (Item::RatedSignal, "10V"),
        (Item::ValveResponse, "22ms"),
        (Item::ValveStrokeTime, "40ms"),
        (Item::Overlap, "10%"),
        (Item::HoseLength, "1m"),
        (Item::HoseDiameter, "10mm"),
    ] {
        answers.insert(item, item.parse(text).unwrap());
    }
    read_text("machine.toml", &toml("hall", &derived(&answers, Edges::Edge).unwrap())).unwrap()
}

/// Recordings of the drive as it is: oil in the tank line at 3.2 bar, a spool that overshoots, volumes that follow the piston, seals with a
/// friction of 1.2 % of full force, hoses that yield; and what is broken.
pub(super) fn case(broken: &[PlantEffect]) -> Case {
    case_of(broken, &[random(1), random(2), Excitation::paper_steps(4.0), random(3)])
}

/// The same with these commands, the last of them held out.
fn case_of(broken: &[PlantEffect], signals: &[Excitation]) -> Case {
    let file = data_sheet();
    let of_file = |parameter| file.machine.get(parameter);
    let factors = [
        (P::SupplyPressure, 1.005),
        (P::TankPressure, 1.6),
        (P::NaturalFrequency, 0.85),
        (P::SpoolDamping, 0.75),
        (P::SpoolSpeedLimit, 0.95),
        (P::TransportDelay, 1.4),
        (P::FlowCoefficient, 1.06),
        (P::DeadZone, 1.04),
        (P::BulkModulus, 1.1),
        (P::MovingMass, 0.95),
        (P::ViscousFriction, 0.4),
    ];
    let truth = file.machine.with(&factors.map(|(parameter, factor)| (parameter, factor * of_file(parameter))));
    let truth = truth.with(&[(P::SpeedOverdrive, 30.0)]);
    let full_n = of_file(P::AreaA) * of_file(P::SupplyPressure);
    let seals = PlantEffect::CoulombFriction {
        force_n: 0.012 * full_n,
        stiffness_n_per_m: 0.012 * full_n / 3e-5,
        damping_n_s_per_m: 2e3,
    };
    let hoses = PlantEffect::HoseCompliance { compliance_m3_per_pa: 1e-13, stiffening_pressure_pa: 1e8 };
    let effects = [&[seals, hoses], broken].concat();
    let recorded = |(index, signal): (usize, &Excitation)| {
        let plant = Plant::new(&truth, 1e-7).unwrap().with_effects(&effects);
        let mut sensors = Sensors::with_position(&truth, PositionSensor::Linear { resolution_m: 2e-5 });
        sensors.spool.noise_std = 5e-4;
        let bench = Bench { tick_s: 2e-3, seed: 10 + index as u64, ..Bench::new(plant, sensors) };
        let initial = InitialState::at_rest(&truth, 0.5 * truth.get(P::Stroke));
        let made = bench.record(&Drive::Commands(signal.sample(bench.tick_s)), &initial).unwrap();
        assert!(made.truth.iter().all(|state| (0.0..=truth.get(P::Stroke)).contains(&state.position_m)), "{signal:?}");
        made.rounded().to_recording(&format!("{index}.csv")).unwrap()
    };
    let mut training: Vec<Recording> = signals.iter().enumerate().map(recorded).collect();
    let held_out = training.split_off(signals.len() - 1);
    Case { file, training, held_out }
}

const fn random(seed: u64) -> Excitation {
    Excitation::Random { amplitude_v: 6.0, shortest_s: 0.15, longest_s: 0.4, duration_s: 2.0, seed }
}

#[test]
fn a_healthy_drive_misses_nothing_though_its_data_sheet_knows_none_of_its_tolerances() {
    let found = case(&[]).diagnose();
    assert_eq!((accepted(&found).as_str(), found.verdict), ("none", Verdict::NothingMissing), "{:?}", found.left);
}

/// A value that may move besides, or a tolerance, lets a fit come closer or leaves it where it is.
#[test]
fn a_base_fit_with_more_free_values_is_never_worse() {
    let case = case(&[]);
    let mut prepared = case.prepared(&case.training);
    let all = base_parameters(&case.file);
    let fitted = |free: &[Free], cases: &[&Prepared]| first_search(&case.file.machine, free, cases, 1e-5).unwrap();
    let machine =
        with_channel_tolerances(&case.file.machine, &mut prepared, |cases| Ok(fitted(&all, cases))).unwrap().machine;
    let cases: Vec<&Prepared> = prepared.iter().collect();
    let whole = fitted(&all, &cases).loss;
    assert!(machine.get(P::MovingMass) > 100.0);
    for left_out in
        [P::TankPressure, P::BulkModulus, P::SpoolSpeedLimit, P::FlowCoefficient, P::MeteringRatio, P::StribeckForce]
    {
        let fewer: Vec<Free> = all.iter().filter(|free| free.parameter != left_out).copied().collect();
        assert!(fewer.len() < all.len(), "{left_out:?}");
        let loss = fitted(&fewer, &cases).loss;
        assert!(whole <= 1.001 * loss, "without {left_out:?} {loss}, with it {whole}");
    }
}

/// Edges that differ by less than their tolerance are told as that; worn ones are named.
#[test]
fn what_is_within_its_tolerance_becomes_a_finding_only_beyond() {
    let edges = |wider: f64| {
        PlantEffect::Flow(FlowEffect::Metering { sizes: [1.0 + wider, 1.0 - wider, 1.0 + wider, 1.0 - wider] })
    };
    let within = case(&[edges(0.02)]).diagnose();
    assert_eq!((accepted(&within).as_str(), within.verdict), ("none", Verdict::NothingMissing));
    assert!(within.tolerances().iter().any(|one| one.parameter == P::MeteringRatio && one.value.abs() > 0.02));
    assert_eq!(accepted(&case(&[edges(0.15)]).diagnose()), "metering-asymmetry");
}

#[test]
fn a_leak_is_named_alone_and_in_its_size() {
    let leak = 6e-12;
    let found = case(&[PlantEffect::InternalLeakage {
        conductance_m3_per_s_pa: leak,
        turbulent_share: 0.0,
        transition_pa: 3e6,
    }])
    .diagnose();
    assert_eq!(accepted(&found), "internal-leakage");
    let value = found.findings[0].parameters[0].value;
    assert!((value / leak - 1.0).abs() < 0.1, "{value}");
    // What the leak does below the spool bends no value of the valve: those are known from the spool alone.
    let spool = found.refitted.iter().find(|one| one.parameter == P::NaturalFrequency).unwrap();
    assert!((spool.value / (0.85 * spool.before) - 1.0).abs() < 0.03, "{spool:?}");
    assert!(found.selection.base.fit.free.iter().all(|free| free.parameter != P::NaturalFrequency));
}

/// A model without stiction makes a slow spool of it, from which no search comes back.
#[test]
fn a_spool_with_mass_that_sticks_is_named_alone_and_in_its_size() {
    let break_away = 0.045;
    let sticks = PlantEffect::Valve(ValveEffect::Stiction { break_away, kinetic_share: 0.15, jump_s: 0.0 });
    let sweep = |to_hz| Excitation::Sweep { amplitude_v: 5.0, from_hz: 0.6, to_hz, duration_s: 2.0 };
    let triangle = Excitation::Triangle { amplitude_v: 4.0, frequency_hz: 0.6, duration_s: 2.0 };
    let found = case_of(&[sticks], &[sweep(4.0), triangle, random(1), sweep(2.5)]).diagnose();
    assert_eq!(accepted(&found), "spool-stiction");
    let [band, kept] = [0, 1].map(|index| found.findings[0].parameters[index].value);
    assert!((band / break_away - 1.0).abs() < 0.1, "{band}");
    assert!((kept / 0.15 - 1.0).abs() < 0.25, "{kept}");
}

/// Beside a wide hysteresis the valve without it looks like one whose pull is limited: that it is its speed is found again with the hysteresis.
#[test]
fn a_hysteresis_is_fitted_beside_the_structure_that_the_valve_has() {
    let width = 0.08;
    let found = case(&[PlantEffect::Valve(ValveEffect::WeightedPlays { width })]).diagnose();
    assert_eq!(accepted(&found), "valve-hysteresis");
    assert!((found.findings[0].parameters[0].value / width - 1.0).abs() < 0.1, "{:?}", found.findings[0].parameters);
    assert!(found.machine_after.get(P::SpeedOverdrive) > 2.0, "{}", found.machine_after.get(P::SpeedOverdrive));
    assert!(found.left.iter().all(|miss| miss.signal != recording::Signal::Spool), "{:?}", found.left);
}
