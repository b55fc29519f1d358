//! # Stribeck friction
//!
//! ## What it adds
//! Dry friction with a higher force to break away; half of the excess is gone at the Stribeck velocity vs, since the seal's
//! lubricating film has to form first. F falls from Fc + Fe at rest to Fc at speed (a twelfth of Fe is left at twice
//! vs); at rest any force up to Fc + Fe is held. It includes Coulomb friction.
//!
//! ## How it shows
//! A hump of the missing force at low speed: Δp builds up, the rod breaks away, and the pressures fall although it moves
//! faster. Slow strokes stick and slip.
//!
//! ## What looks alike
//! Coulomb friction has no hump. A dead zone leaves the pressures flat while the rod rests. Bristles open a loop of
//! force over velocity at reversals. A spool that jumps makes the rod jump without pressure building up.
//!
//! ## Parameters
//! Fc and Fe in N, not negative: Fc 1–5 % of full force, break-away 1.1–2.6 times Fc. vs in m/s: 1–50 mm/s.
//! Stiffness of the bristles as with Coulomb friction.
//!
//! ## Source
//! R. Stribeck, *Die wesentlichen Eigenschaften der Gleit- und Rollenlager*, Z. VDI 46, 1902; B. Armstrong-Hélouvry, P.
//! Dupont, C. Canudas de Wit, *A survey of models … for the control of machines with friction*, Automatica 30, 1994.

use machine_file::LoadSource;
use model_core::machine::Parameter;

use super::{EffectParameter, Extension, Hypothesis, Kind, LUGRE, LookAlike, Subsystem};

const FORCE: EffectParameter = EffectParameter {
    parameter: Parameter::StribeckForce,
    kind: Kind::Amount(|scene| (2e-3 * scene.full_force_n(), 0.1 * scene.full_force_n())),
};
const EXCESS: EffectParameter = EffectParameter {
    parameter: Parameter::StribeckExcess,
    kind: Kind::Amount(|scene| (1e-3 * scene.full_force_n(), 0.1 * scene.full_force_n())),
};
const VELOCITY: EffectParameter =
    EffectParameter { parameter: Parameter::StribeckVelocity, kind: Kind::Shape(|_| (1e-3, 0.05), 3) };

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "stribeck-friction",
    subsystem: Subsystem::Mechanics,
    equation: "F = −(Fc + Fe/(1 + 0.0905·(v/vs)²)⁸)·sgn v; at rest |F| ≤ Fc + Fe",
    forms: &[&[FORCE, EXCESS, VELOCITY], &[FORCE, EXCESS, VELOCITY, LUGRE]],
    look_alikes: &[
        LookAlike {
            effect: "coulomb-friction",
            told_apart_by: "constant-speed strokes below 10 mm/s: Coulomb friction has no hump",
        },
        LookAlike {
            effect: "presliding",
            told_apart_by: "constant-speed strokes below 10 mm/s: bristles alone have no hump",
        },
        LookAlike {
            effect: "spool-stiction",
            told_apart_by: "constant-speed strokes, pressures recorded: a spool that jumps leaves them flat before",
        },
    ],
    refined: &[],
    extends: Some(Extension {
        plain: "coulomb-friction",
        given: Parameter::CoulombFriction,
        taken: &[Parameter::StribeckForce],
    }),
    separated_by: "constant-speed strokes from 1 to 100 mm/s, both pressures recorded",
    source: "Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30, 1994",
    // Where the load is taken from the pressures, the force balance is an input.
    shows_in: |scene| scene.load == LoadSource::Constant,
};
