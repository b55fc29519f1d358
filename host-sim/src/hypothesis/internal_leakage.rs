//! # Internal leakage
//!
//! ## What it adds
//! Oil passes the piston from the chamber at higher pressure to the other, laminar: Q = G·(pa − pb), into B and out of A.
//!
//! ## How it shows
//! What A lacks B has too much of, at every slider position, also at rest: a loaded rod drifts with the valve closed.
//!
//! ## What looks alike
//! External leakage concerns one chamber. Valve leakage acts near the valve's centre only. Pump slip rests with the pump.
//!
//! ## Parameters
//! G in m³/s/Pa, not negative; 1e-14 (new seal) to 1e-11 (worn).
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, §6-1; M. Jelali and A. Kroll, *Hydraulic Servo-systems*, Springer 2003, §3.

use model_core::parameter::Parameter;

use super::{Hypothesis, LookAlike, Strength, Subsystem};

pub(super) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "internal-leakage",
    subsystem: Subsystem::Chambers,
    equation: "Q_leak = G·(pa − pb)",
    strengths: &[Strength {
        name: "conductance_m3_per_s_pa",
        parameter: Parameter::InternalLeakage,
        typical: |machine| 0.01 * machine.get(Parameter::AreaA) * 0.1 / machine.get(Parameter::SupplyPressure),
    }],
    look_alikes: &[
        LookAlike { effect: "pump-slip", told_apart_by: "closed-valve hold under load: slip rests with the pump" },
        LookAlike {
            effect: "external-leakage",
            told_apart_by: "both pressures: what leaks inside, one chamber loses and the other gains",
        },
    ],
    separated_by: "closed-valve hold under load, both pressures recorded",
    source: "Merritt, Hydraulic Control Systems, 1967, §6-1",
    shows_in: |_, entry, _| !matches!(entry, crate::simulate::EntryPoint::Force),
};
