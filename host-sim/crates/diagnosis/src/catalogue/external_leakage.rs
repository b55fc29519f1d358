//! # External leakage
//!
//! ## What it adds
//! Oil leaves a chamber to the outside, past the rod seal, a fitting or a relief valve, laminar:
//! `Q = G·(p − p_T)`, from A, from B or from both.
//!
//! ## How it shows
//! One chamber lacks oil in proportion to its pressure, at every spool position and at rest; the other does not gain
//! it.
//!
//! ## What looks alike
//! With leakage past the piston, one chamber gains what the other loses. A pressure sensor that reads wrong shows in the force as
//! well, and does not drain a chamber at rest.
//!
//! ## Parameters
//! G of each chamber in m³/s/Pa, not negative: up to 1e-11; 0.02–10 % of the full flow at full pressure.
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, chapter 6; M. Jelali and A. Kroll, *Hydraulic
//! Servo-systems*, Springer 2003, chapter 4.

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Scene, Subsystem};

/// 0.02 to 10 % of the full flow at full pressure.
fn conductance(scene: &Scene<'_>) -> (f64, f64) {
    let full = scene.full_flow_m3_per_s() / scene.machine.get(Parameter::SupplyPressure);
    (2e-4 * full, 0.1 * full)
}

const FROM_A: EffectParameter =
    EffectParameter { parameter: Parameter::ExternalLeakageA, kind: Kind::Amount(conductance) };
const FROM_B: EffectParameter =
    EffectParameter { parameter: Parameter::ExternalLeakageB, kind: Kind::Amount(conductance) };

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "external-leakage",
    subsystem: Subsystem::Chambers,
    equation: "Q_out = G·(p − p_T), each chamber its own",
    forms: &[&[FROM_A], &[FROM_B], &[FROM_A, FROM_B]],
    look_alikes: &[
        LookAlike {
            effect: "internal-leakage",
            told_apart_by: "both pressures: what leaks inside, one chamber loses and the other gains",
        },
        LookAlike {
            effect: "sensor-offset",
            told_apart_by: "closed-valve hold under load: a sensor's offset stays, a leaking chamber empties",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "closed-valve hold under load, both pressures recorded",
    source: "Merritt, Hydraulic Control Systems, 1967, ch. 6",
    shows_in: |scene| scene.input_point != InputPoint::Force,
};
