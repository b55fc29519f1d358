//! # End stop
//!
//! ## What it adds
//! A stop, a cushion or the cylinder's own end that pushes back once the rod is past a position: F = −k·s − d·ds/dt at
//! depth s, and it never pulls. One at the extended end, or one at the retracted end.
//!
//! ## How it shows
//! The position ends flat at one value though the valve is open, and the pressures go to supply and tank; force is
//! missing within a millimetre of that position only.
//!
//! ## What looks alike
//! A load spring pushes along the whole stroke; one that begins inside the stroke yields by more than a few hundredths of it. Friction that
//! rises towards an end flips with the direction.
//!
//! ## Parameters
//! Position of the stop in m, where the recording turns or ends flat. Stiffness k in N/m, not negative: the full force compresses it
//! by a hundredth of the stroke (rubber) to a ten-thousandth (steel), which is 1e7–1e9 N/m for 25 kN and 0.25 m. Damping d in N·s/m,
//! not negative: around the critical damping of the moving mass on the stop; a cushion has far more. A stop
//! that yields by more than three hundredths is a load that begins inside the stroke, and is never accepted as a stop.
//!
//! ## Source
//! K. H. Hunt and F. R. E. Crossley, *Coefficient of restitution interpreted as damping in vibroimpact*, J. Applied
//! Mechanics 42, 1975; M. Jelali and A. Kroll, *Hydraulic Servo-systems*, Springer 2003, chapter 4.

use machine_file::LoadSource;
use model_core::machine::Parameter;
use recording::Signal;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Scene, Subsystem};

const STIFFNESS: EffectParameter = EffectParameter {
    parameter: Parameter::StopStiffness,
    kind: Kind::Firm(|scene| (giving(scene, 1e-2), giving(scene, 1e-4))),
};
const DAMPING: EffectParameter = EffectParameter {
    parameter: Parameter::StopDamping,
    kind: Kind::Amount(|scene| {
        // 2·√(k·m) on a stop of middling stiffness.
        let critical = 2.0 * (giving(scene, 1e-3) * scene.machine.get(Parameter::MovingMass)).sqrt();
        (0.02 * critical, 20.0 * critical)
    }),
};
// No rod moves further than a stop permits: the recorded travel ends at a hard stop; a soft stop begins a little before that end.
const EXTENDED_AT: EffectParameter = EffectParameter {
    parameter: Parameter::StopExtended,
    kind: Kind::Place(|scene| (from_lowest_m(scene, 0.7), scene.travel_m.1), &[0.4, 0.8, 0.95, 1.0]),
};
const RETRACTED_AT: EffectParameter = EffectParameter {
    parameter: Parameter::StopRetracted,
    kind: Kind::Place(|scene| (scene.travel_m.0, from_lowest_m(scene, 0.3)), &[0.0, 0.05, 0.2, 0.6]),
};

/// The stiffness that yields by this share of the stroke under the full force, N/m.
fn giving(scene: &Scene<'_>, share: f64) -> f64 {
    scene.full_force_n() / (share * scene.machine.get(Parameter::Stroke))
}

/// The position at this share of the recorded travel.
fn from_lowest_m(scene: &Scene<'_>, share: f64) -> f64 {
    let (lowest, highest) = scene.travel_m;
    lowest + share * (highest - lowest)
}

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "end-stop",
    subsystem: Subsystem::Mechanics,
    equation: "F = −(k·s + d·ds/dt) at depth s > 0, never pulling",
    forms: &[&[STIFFNESS, EXTENDED_AT, DAMPING], &[STIFFNESS, RETRACTED_AT, DAMPING]],
    look_alikes: &[
        LookAlike {
            effect: "position-dependent-load",
            told_apart_by: "strokes over the whole stroke: a spring pushes everywhere",
        },
        LookAlike {
            effect: "position-dependent-friction",
            told_apart_by: "strokes over the whole stroke, both ways: leaving a stop the rod is not held",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "strokes over the whole stroke, slowly into the end, both pressures recorded",
    source: "Hunt & Crossley, J. Applied Mechanics 42, 1975",
    // Where the load is taken from the pressures, the force balance is an input; a rod that never moved met no stop.
    shows_in: |scene| {
        scene.load == LoadSource::Constant && scene.judges(Signal::Position) && scene.travel_m.0 < scene.travel_m.1
    },
};
