//! # Internal leakage
//!
//! ## What it adds
//! Oil passes the piston from the chamber at higher pressure to the other, laminar: Q = G·(pa − pb), into B and out of A.
//!
//! ## How it shows
//! Chamber B has too much of the oil that A lacks, at every spool position and also at rest: with the valve closed the two pressures run together.
//!
//! ## What looks alike
//! External leakage concerns one chamber. Valve leakage acts near the valve's centre only. Pump slip stops with the pump.
//!
//! ## Parameters
//! G in m³/s/Pa, not negative; 1e-14 (new seal) to 1e-11 (worn).
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, §6-1; M. Jelali and A. Kroll, *Hydraulic Servo-systems*, Springer 2003, §3.

use model_core::machine::Parameter;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "internal-leakage",
    subsystem: Subsystem::Chambers,
    equation: "Q_leak = G·(pa − pb)",
    forms: &[&[EffectParameter {
        parameter: Parameter::InternalLeakage,
        kind: Kind::Amount(|scene| {
            // 0.02 to 10 % of the full flow at full pressure.
            let full = scene.full_flow_m3_per_s() / scene.machine.get(Parameter::SupplyPressure);
            (2e-4 * full, 0.1 * full)
        }),
    }]],
    look_alikes: &[
        LookAlike { effect: "pump-slip", told_apart_by: "closed-valve hold under load: slip rests with the pump" },
        LookAlike {
            effect: "external-leakage",
            told_apart_by: "both pressures: what leaks inside, one chamber loses and the other gains",
        },
        LookAlike {
            effect: "valve-leakage",
            told_apart_by: "closed-valve hold and strokes at two loads: the piston leaks at every opening",
        },
        LookAlike {
            effect: "laminar-transition",
            told_apart_by: "closed-valve hold under load: only leakage lets it creep",
        },
        LookAlike {
            effect: "hose-compliance",
            told_apart_by: "closed-valve hold under load: leakage goes on, compliance rests",
        },
        LookAlike {
            effect: "oil-temperature",
            told_apart_by: "long run for warming up: with wear the leakage rises and the friction stays",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "closed-valve hold under load, both pressures recorded",
    source: "Merritt, Hydraulic Control Systems, 1967, §6-1",
    shows_in: |scene| scene.input_point != simulation::InputPoint::Force,
};
