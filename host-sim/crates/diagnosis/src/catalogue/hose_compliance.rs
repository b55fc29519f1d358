//! # Hose compliance
//!
//! ## What it adds
//! Hoses (and a gas accumulator beside them) take up volume with pressure, in addition to the oil's own compression:
//! dp/dt = (Q − A·v) / (V/E0 + C). Equation (7) becomes softer in both chambers, at all pressures and positions.
//!
//! ## How it shows
//! The flow that the model lacks follows dp/dt: the rod lags while pressure builds, and creeps on when it falls. Under
//! load the position stays behind by C·Δp/A.
//!
//! ## What looks alike
//! A larger dead volume has the same form: one name for both, and the report says so. Entrained air acts below 30–50 bar
//! only. Leakage continues at constant pressure, flow into compliance does not.
//!
//! ## Parameters
//! C in m³/Pa, not negative; effective bulk moduli of `0.4–1 GPa` are usual with hoses.
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, §2-5 (effective bulk modulus with containers).

use model_core::machine::Parameter;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "hose-compliance",
    subsystem: Subsystem::Chambers,
    equation: "dp/dt = (Q − A·v) / (V/E0 + C)",
    forms: &[&[EffectParameter {
        parameter: Parameter::HoseCompliance,
        kind: Kind::Amount(|scene| {
            let volume = scene.machine.get(Parameter::VolumeA).max(scene.machine.get(Parameter::VolumeB));
            let own = volume / scene.machine.get(Parameter::BulkModulus);
            (0.05 * own, 10.0 * own)
        }),
    }]],
    look_alikes: &[
        LookAlike {
            effect: "entrained-air",
            told_apart_by: "pressure cycles above and below 50 bar: air is soft only below",
        },
        LookAlike {
            effect: "internal-leakage",
            told_apart_by: "closed-valve hold under load: leakage goes on, compliance rests",
        },
        LookAlike {
            effect: "position-dependent-volume",
            told_apart_by: "strokes over the whole stroke: hoses are as soft at both ends",
        },
        LookAlike {
            effect: "position-sensor-lag",
            told_apart_by: "constant-speed strokes: at constant pressure compliance rests, a lag stays",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "pressure steps against a blocked rod at two pressure levels",
    source: "Merritt, Hydraulic Control Systems, 1967, §2-5",
    shows_in: |scene| scene.input_point != simulation::InputPoint::Force,
};
