//! # Friction asymmetry
//!
//! ## What it adds
//! Dry friction of different size extending and retracting, as lip seals and differential cylinders have it: F = −F1
//! for v > 0, +F2 for v < 0; at rest any force between is held. It includes Coulomb friction.
//!
//! ## How it shows
//! The missing force steps at v = 0, by unequal amounts to both sides of zero.
//!
//! ## What looks alike
//! Coulomb friction with a constant load has the same two levels in motion: at rest and in a hold the load remains,
//! friction does not. A pressure sensor's offset acts like such a load. The friction of seals pressed by the pressure depends on the
//! load, not with the direction alone.
//!
//! ## Parameters
//! F1 and F2 in N, not negative: 1–5 % of full force, differing by 10–60 %. Stiffness of the bristles as with Coulomb friction.
//!
//! ## Source
//! A. Bonchis, P. I. Corke, D. C. Rye, *A pressure-based, velocity independent, friction model for asymmetric hydraulic
//! cylinders*, IEEE Int. Conf. on Robotics and Automation, 1999; Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica
//! 30, 1994.

use machine_file::LoadSource;
use model_core::machine::Parameter;

use super::{EffectParameter, Extension, Hypothesis, Kind, LUGRE, LookAlike, Scene, Subsystem};

fn force_n(scene: &Scene<'_>) -> (f64, f64) {
    (2e-3 * scene.full_force_n(), 0.1 * scene.full_force_n())
}

const EXTENDING: EffectParameter =
    EffectParameter { parameter: Parameter::AsymmetricExtending, kind: Kind::Amount(force_n) };
const RETRACTING: EffectParameter =
    EffectParameter { parameter: Parameter::AsymmetricRetracting, kind: Kind::Amount(force_n) };

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "friction-asymmetry",
    subsystem: Subsystem::Mechanics,
    equation: "F = −F1 at v > 0, +F2 at v < 0; at rest −F1 ≤ F ≤ F2",
    forms: &[&[EXTENDING, RETRACTING], &[EXTENDING, RETRACTING, LUGRE]],
    look_alikes: &[
        LookAlike {
            effect: "coulomb-friction",
            told_apart_by: "constant-speed strokes both ways, both pressures recorded: equal steps either way",
        },
        LookAlike {
            effect: "pressure-dependent-friction",
            told_apart_by: "strokes at two loads: friction of the direction alone does not change",
        },
        LookAlike {
            effect: "position-dependent-load",
            told_apart_by: "constant-speed strokes both ways: a load does not flip with the direction",
        },
        LookAlike {
            effect: "sensor-offset",
            told_apart_by: "closed-valve hold under load: a pressure sensor's offset is there at rest, too",
        },
    ],
    refined: &[],
    extends: Some(Extension {
        plain: "coulomb-friction",
        given: Parameter::CoulombFriction,
        taken: &[Parameter::AsymmetricExtending, Parameter::AsymmetricRetracting],
    }),
    separated_by: "constant-speed strokes both ways, both pressures recorded",
    source: "Bonchis, Corke, Rye, IEEE ICRA 1999",
    // Where the load is taken from the pressures, the force balance is an input.
    shows_in: |scene| scene.load == LoadSource::Constant,
};
