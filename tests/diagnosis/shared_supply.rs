//! A supply that other consumers share: what they take is recorded, and belongs to the supply's balance.

use rayon::prelude::*;

use diagnosis::{Diagnosis, Verdict};
use model_core::machine::Parameter as P;
use recording::{Column, Recording, Signal};
use virtual_plant::{FlowEffect, LoadProfile, PlantEffect};

use super::bed::{Case, accepted, valve_case_loaded};

/// 3 bar at 0.1 l/s, of which other consumers take up to 0.3 l/s.
const RESISTANCE: f64 = 3e9;
const TAKEN_M3_PER_S: f64 = 3e-4;

/// A drive on a pump that gives way, with an accumulator, from which another consumer takes its strokes; `recorded` names what is recorded of those.
fn case(seed: u64, drooping: bool, recorded: &[(Signal, f64)]) -> Case {
    let droop =
        FlowEffect::SupplyDroop { resistance_pa_s_per_m3: RESISTANCE, gas_volume_m3: 2e-4, line_pa_s2_per_m6: 0.0 };
    let other = FlowEffect::OtherConsumer { flow_m3_per_s: TAKEN_M3_PER_S, period_s: 0.9 };
    let effects = [other, droop].map(PlantEffect::Flow);
    let effects = if drooping { &effects[..] } else { &effects[..1] };
    let load = |_| LoadProfile::none();
    valve_case_loaded(2e-3, seed, effects, load, |made, name| {
        let made = made.rounded();
        let of = |&(signal, share): &(Signal, f64)| {
            Column::si(signal, made.other_flow_m3_per_s.iter().map(|flow| share * flow).collect())
        };
        let others = recorded.iter().map(of);
        let mut alone = made.clone();
        alone.other_flow_m3_per_s.clear();
        let alone = alone.to_recording(name).unwrap();
        let kept = |&signal: &Signal| Some(Column::si(signal, alone.signal(signal)?.to_vec()));
        let time = Column::si(Signal::Time, alone.time_s().to_vec());
        let signals = Signal::ALL.iter().filter(|signal| **signal != Signal::Time).filter_map(kept);
        Recording::new(name, [time].into_iter().chain(signals).chain(others).collect()).unwrap()
    })
}

#[test]
fn what_others_take_is_not_taken_for_a_fault_of_this_drive() {
    // Of two consumers that move the other way, each takes its part.
    let recorded = [(Signal::OtherFlow, -0.6), (Signal::OtherFlow2, 0.4)];
    let whole = [(Signal::OtherFlow, 1.0)];
    [(11, &recorded[..]), (12, &whole[..])].par_iter().for_each(|&(seed, recorded)| {
        let known = case(seed, true, recorded).diagnose();
        assert_eq!(accepted(&known), "supply-droop", "{seed}");
        let found = known.machine_after.get(P::DroopResistance);
        assert!((found / RESISTANCE - 1.0).abs() < 0.1, "{seed}: {found:e}");
        let unknown = case(seed, true, &[]).diagnose();
        let missed = |diagnosis: &Diagnosis| 100.0 - diagnosis.mean_fits(true, true)["pressure_a"];
        assert!(missed(&unknown) > 2.0 * missed(&known), "{seed}: {} {}", missed(&unknown), missed(&known));
    });
}

#[test]
fn on_a_supply_that_does_not_give_way_others_change_nothing() {
    let known = case(13, false, &[(Signal::OtherFlow, 1.0)]).diagnose();
    assert_eq!((accepted(&known).as_str(), known.verdict), ("none", Verdict::NothingMissing));
}
