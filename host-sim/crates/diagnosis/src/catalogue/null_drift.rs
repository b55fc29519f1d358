//! # Null drift
//!
//! ## What it adds
//! The neutral of the valve moves, with the temperature of magnet, electronics and pilot, or with the supply
//! pressure: x = g·U + x0 + Δx·(1 − e^(−t/T)), t from the start of the recording.
//!
//! ## How it shows
//! The valve link's residual of the spool is slow and of the same sign at every command; the command that holds the
//! rod still changes in the course of the recording.
//!
//! ## What looks alike
//! A wrong offset is there from the start. Unequal overlap depends on the side, not on time. Warm oil changes friction
//! and leakage, not the neutral.
//!
//! ## Parameters
//! Δx in parts of full travel, positive extends: up to 3 % (5 % in an extreme drive). T in s, from shorter than a
//! stroke to far longer than the recording, where the drift is a ramp.
//!
//! ## Source
//! ISO 10770-1 (null shift with temperature and pressure); H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967,
//! chapter 7.

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "null-drift",
    subsystem: Subsystem::Valve,
    equation: "x = g·U + x0 + Δx·(1 − e^(−t/T))",
    forms: &[&[
        EffectParameter { parameter: Parameter::NullDriftTravel, kind: Kind::Signed(|_| 0.05) },
        EffectParameter {
            parameter: Parameter::NullDriftTime,
            kind: Kind::Shape(|scene| (0.3, (2.0 * scene.duration_s).clamp(1.0, 1e5)), 3),
        },
    ]],
    look_alikes: &[
        LookAlike {
            effect: "sensor-offset",
            told_apart_by: "long run for warming up: a sensor's offset is the same from start to end",
        },
        LookAlike {
            effect: "dead-zone-asymmetry",
            told_apart_by: "slow triangle, repeated: unequal overlap is the same every time",
        },
        LookAlike {
            effect: "oil-temperature",
            told_apart_by: "long run for warming up: warm oil speeds both directions up, drift one only",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "long run for warming up, with the slow triangle repeated, spool recorded",
    source: "ISO 10770-1 (null shift); Merritt, Hydraulic Control Systems, 1967, ch. 7",
    shows_in: |scene| scene.input_point == InputPoint::Command,
};
