//! # Coulomb friction
//!
//! ## What it adds
//! Dry friction of constant size against the motion: F = −Fc·sgn v while sliding; at rest any force up to Fc is held, by
//! bristles that are stiff but give by some micrometres (`LuGre`).
//!
//! ## How it shows
//! The force that the model lacks steps at v = 0. After a stop the pressures differ by 2·Fc/A between the two directions; the
//! rod starts late and stops early.
//!
//! ## What looks alike
//! A constant load does not flip with the direction. Stribeck friction adds a hump at low speed. A valve's dead zone leaves
//! the pressures flat while the rod rests.
//!
//! ## Parameters
//! Fc in N, not negative; 1–5 % of the cylinder's full force. Stiffness of the bristles in N/m: one to thirty times that of the
//! oil columns; with less than about a third of it, the effect is presliding.
//!
//! ## Source
//! B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, *A survey of models … for the control of machines with friction*,
//! Automatica 30, 1994.

use model_core::machine::Parameter;

use super::{EffectParameter, Hypothesis, Kind, LUGRE, LookAlike, Subsystem};

const FORCE: EffectParameter = EffectParameter {
    parameter: Parameter::CoulombFriction,
    kind: Kind::Amount(|scene| (2e-3 * scene.full_force_n(), 0.1 * scene.full_force_n())),
};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "coulomb-friction",
    subsystem: Subsystem::Mechanics,
    equation: "F = −Fc·sgn v; at rest |F| ≤ Fc",
    forms: &[&[FORCE], &[FORCE, LUGRE]],
    look_alikes: &[
        LookAlike { effect: "stribeck-friction", told_apart_by: "constant-speed strokes below 10 mm/s" },
        LookAlike {
            effect: "friction-asymmetry",
            told_apart_by: "slow strokes both ways with both pressures recorded",
        },
        LookAlike {
            effect: "presliding",
            told_apart_by: "sine sweep of small amplitude, both pressures recorded: only bristles open a loop",
        },
        LookAlike {
            effect: "position-dependent-friction",
            told_apart_by: "constant-speed strokes over the whole stroke: Coulomb friction is the same everywhere",
        },
        LookAlike {
            effect: "pressure-dependent-friction",
            told_apart_by: "strokes at two loads at the same speed: Coulomb friction does not change",
        },
        LookAlike {
            effect: "linkage-backlash",
            told_apart_by: "slow triangle, both pressures recorded: they build up when friction holds the rod",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "constant-speed strokes below 10 mm/s",
    source: "Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30, 1994",
    // Where the load is taken from the pressures, the force balance is an input.
    shows_in: |scene| scene.load == machine_file::LoadSource::Constant,
};
