//! Load-holding valves between valve and cylinder: named where the circuit has one that the machine file does not know, and on its side.

use rayon::prelude::*;

use diagnosis::Verdict;
use model_core::machine::Parameter as P;
use virtual_plant::{FlowEffect, LoadHolding, PlantEffect};

use super::bed::{accepted, valve_case};

/// Opened by twice the supply pressure without a pilot.
const SETTING_PA: f64 = 1.6e7;

/// The plant's ports have a volume, which the hypothesis lacks: setting, pilot ratio and span are determined together, and none of them alone.
#[test]
fn a_load_holding_valve_is_named_with_its_side_and_a_drive_without_one_has_none() {
    let none = f64::INFINITY;
    let sides = [(21, [SETTING_PA, none], P::HoldingSetB), (22, [none, SETTING_PA], P::HoldingSetA)];
    sides.par_iter().for_each(|&(seed, settings_pa, other)| {
        let holding = LoadHolding { settings_pa, pilot_ratio: 3.0, span_pa: 1e7, time_constant_s: 0.015 };
        let effect = PlantEffect::Flow(FlowEffect::Counterbalance(holding));
        let found = valve_case(seed, Some(effect), true, None).diagnose();
        assert_eq!((accepted(&found).as_str(), found.verdict), ("counterbalance", Verdict::MissingPhysics), "{seed}");
        assert!(found.machine_after.get(other) < 0.0, "{seed}");
        let missed = |after: bool| 100.0 - found.mean_fits(true, after)["pressure_a"];
        assert!(missed(true) < 0.5 * missed(false), "{seed}: {} of {}", missed(true), missed(false));
    });
    let without = valve_case(21, None, true, None).diagnose();
    assert_eq!((accepted(&without).as_str(), without.verdict), ("none", Verdict::NothingMissing));
}
