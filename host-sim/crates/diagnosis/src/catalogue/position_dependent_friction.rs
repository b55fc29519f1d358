//! # Position-dependent friction
//!
//! ## What it adds
//! Friction that changes along the stroke, by side load, a bent rod or a worn bore, with the position η from −1 (fully
//! in) to +1 (fully out): dry, F = −(F0 + F1·η + F2·η²)·sgn v, which includes Coulomb friction; or of the oil in the
//! gap, F = −D·(1 + d1·η + d2·η²)·v, which grows with the speed.
//!
//! ## How it shows
//! The missing force flips with the direction and its size varies with the position; the gap between Δp of slow strokes
//! in the two directions varies along the stroke.
//!
//! ## What looks alike
//! A spring or a linkage's geometry also varies with the position, but does not flip. Friction of pressed seals follows
//! the pressure.
//!
//! ## Parameters
//! F0 at mid-stroke in N, not negative, 1–5 % of full force; slope F1 and curvature F2 in N, either sign: 10–300 % of F0,
//! up to 10 % of full force within the recorded travel. Stiffness of the bristles as with Coulomb friction. Slope d1 and curvature d2 of
//! the viscous friction as shares of D, either sign: up to D itself within the recorded travel.
//!
//! ## Source
//! B. Armstrong-Hélouvry, *Control of Machines with Friction*, Kluwer 1991 (friction as a function of position).

use machine_file::LoadSource;
use model_core::machine::Parameter;
use recording::Signal;

use super::{EffectParameter, Extension, Hypothesis, Kind, LUGRE, LookAlike, Scene, Subsystem};

const FORCE: EffectParameter = EffectParameter {
    parameter: Parameter::PositionFriction,
    kind: Kind::Amount(|scene| (2e-3 * scene.full_force_n(), 0.1 * scene.full_force_n())),
};
const SLOPE: EffectParameter = EffectParameter {
    parameter: Parameter::PositionFrictionSlope,
    kind: Kind::Signed(|scene| 0.1 * scene.full_force_n() / reached(scene)),
};
const BOW: EffectParameter = EffectParameter {
    parameter: Parameter::PositionFrictionBow,
    kind: Kind::Signed(|scene| 0.1 * scene.full_force_n() / reached(scene).powi(2)),
};

const DRAG_SLOPE: EffectParameter = EffectParameter {
    parameter: Parameter::PositionDragSlope,
    kind: Kind::Signed(|scene| (1.0 / reached(scene)).min(STEEPEST)),
};
const DRAG_BOW: EffectParameter = EffectParameter {
    parameter: Parameter::PositionDragBow,
    kind: Kind::Signed(|scene| (1.0 / reached(scene).powi(2)).min(STEEPEST)),
};

/// Largest usual value of a coefficient, chosen so that three times this is within the parameter's range.
const STEEPEST: f64 = 2.4;

/// How far η goes from the middle in the recordings, which do not show the friction beyond.
fn reached(scene: &Scene<'_>) -> f64 {
    let stroke = scene.machine.get(Parameter::Stroke);
    let from_middle = |position_m: f64| (2.0 * position_m / stroke - 1.0).abs();
    from_middle(scene.travel_m.0).max(from_middle(scene.travel_m.1)).clamp(0.1, 1.0)
}

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "position-dependent-friction",
    subsystem: Subsystem::Mechanics,
    equation: "F = −(F0 + F1·η + F2·η²)·sgn v or −D·(1 + d1·η + d2·η²)·v, η = −1 fully in, +1 fully out",
    forms: &[
        &[FORCE, SLOPE],
        &[DRAG_SLOPE],
        &[FORCE, SLOPE, BOW],
        &[DRAG_SLOPE, DRAG_BOW],
        &[FORCE, SLOPE, LUGRE],
        &[FORCE, SLOPE, BOW, LUGRE],
    ],
    look_alikes: &[
        LookAlike {
            effect: "position-dependent-load",
            told_apart_by: "strokes over the whole stroke, both ways: a load does not flip with the direction",
        },
        LookAlike {
            effect: "coulomb-friction",
            told_apart_by: "strokes over the whole stroke at constant speed: Coulomb friction is the same everywhere",
        },
        LookAlike {
            effect: "pressure-dependent-friction",
            told_apart_by: "strokes at two loads over the whole stroke: pressed seals follow the load, not the place",
        },
        LookAlike {
            effect: "end-stop",
            told_apart_by: "strokes over the whole stroke, both ways: leaving a stop the rod is not held",
        },
    ],
    refined: &[],
    extends: Some(Extension {
        plain: "coulomb-friction",
        given: Parameter::CoulombFriction,
        taken: &[Parameter::PositionFriction],
    }),
    separated_by: "constant-speed strokes over the whole stroke both ways, both pressures recorded",
    source: "Armstrong-Hélouvry, Control of Machines with Friction, 1991",
    // Where the load is taken from the pressures, the force balance is an input; without motion no place is known.
    shows_in: |scene| {
        scene.load == LoadSource::Constant && (scene.judges(Signal::Position) || scene.judges(Signal::Velocity))
    },
};
