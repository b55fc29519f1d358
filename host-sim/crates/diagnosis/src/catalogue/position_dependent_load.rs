//! # Position-dependent load
//!
//! ## What it adds
//! A load that is a function of the position alone: spring, weight on a linkage, counterbalance. With z = y −
//! mid-stroke, F = −(F0 + K·z + B·z²).
//!
//! ## How it shows
//! The missing force varies with the position, is the same in both directions and remains at rest.
//!
//! ## What looks alike
//! Position-dependent friction flips with the direction. A stop acts within a millimetre. Wrong readings of a pressure are
//! the same at every position.
//!
//! ## Parameters
//! K in N/m, F0 in N, B in N/m², each of either sign, positive against extending; together they rarely take more than
//! half of the full force.
//!
//! ## Source
//! M. Jelali and A. Kroll, *Hydraulic Servo-systems*, Springer 2003, chapter 4 (load models); H. E. Merritt, *Hydraulic
//! Control Systems*, Wiley 1967, chapter 6 (spring load).

use machine_file::LoadSource;
use model_core::machine::Parameter;
use recording::Signal;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

const STIFFNESS: EffectParameter = EffectParameter {
    parameter: Parameter::LoadSpring,
    // A quarter of the full force at either end.
    kind: Kind::Signed(|scene| 0.5 * scene.full_force_n() / scene.machine.get(Parameter::Stroke)),
};
const FORCE: EffectParameter =
    EffectParameter { parameter: Parameter::LoadSpringForce, kind: Kind::Signed(|scene| 0.3 * scene.full_force_n()) };
const BOW: EffectParameter = EffectParameter {
    parameter: Parameter::LoadSpringBow,
    // A quarter of the full force at both ends.
    kind: Kind::Signed(|scene| scene.full_force_n() / scene.machine.get(Parameter::Stroke).powi(2)),
};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "position-dependent-load",
    subsystem: Subsystem::Mechanics,
    equation: "F = −(F0 + K·z + B·z²), z = y − y_mid",
    forms: &[&[STIFFNESS, FORCE], &[STIFFNESS, FORCE, BOW]],
    look_alikes: &[
        LookAlike {
            effect: "position-dependent-friction",
            told_apart_by: "strokes over the whole stroke, both ways: friction flips with the direction",
        },
        LookAlike {
            effect: "friction-asymmetry",
            told_apart_by: "closed-valve hold under load at several positions: a load goes on at rest",
        },
        LookAlike {
            effect: "end-stop",
            told_apart_by: "strokes over the whole stroke: a stop pushes within a millimetre of one position only",
        },
        LookAlike {
            effect: "sensor-offset",
            told_apart_by: "strokes over the whole stroke: a pressure sensor's offset is the same at every position",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "constant-speed strokes over the whole stroke both ways, both pressures recorded",
    source: "Jelali & Kroll, Hydraulic Servo-systems, 2003, ch. 4",
    // Where the load is taken from the pressures, the force balance is an input; without a position the place is unknown.
    shows_in: |scene| scene.load == LoadSource::Constant && scene.judges(Signal::Position),
};
