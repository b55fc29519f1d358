//! # Pressure-dependent friction
//!
//! ## What it adds
//! Seals press harder against bore and rod as the pressure rises: F = −a·(pa + pb)·sgn v, at rest any force up to that
//! is held. a is the friction coefficient times the area that the pressure loads.
//!
//! ## How it shows
//! The missing force flips with the direction and grows with the level of the pressures at equal velocity.
//!
//! ## What looks alike
//! Coulomb friction is the same at every load. Position-dependent friction repeats with the position at any load.
//! Friction that depends on the direction alone is the same at every load, too.
//!
//! ## Parameters
//! a in m², not negative: 0.2–10 % of the piston area, usually 0.5–5 %. Stiffness of the bristles as with Coulomb friction.
//!
//! ## Source
//! A. Bonchis, P. I. Corke, D. C. Rye, *A pressure-based, velocity independent, friction model for asymmetric hydraulic
//! cylinders*, IEEE Int. Conf. on Robotics and Automation, 1999.

use machine_file::LoadSource;
use model_core::machine::Parameter;

use super::{EffectParameter, Hypothesis, Kind, LUGRE, LookAlike, Subsystem};

const AREA: EffectParameter = EffectParameter {
    parameter: Parameter::PressureFriction,
    kind: Kind::Amount(|scene| {
        let area_m2 = scene.machine.get(Parameter::AreaA);
        (2e-3 * area_m2, 0.1 * area_m2)
    }),
};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "pressure-dependent-friction",
    subsystem: Subsystem::Mechanics,
    equation: "F = −a·(pa + pb)·sgn v; at rest |F| ≤ a·(pa + pb)",
    forms: &[&[AREA], &[AREA, LUGRE]],
    look_alikes: &[
        LookAlike {
            effect: "coulomb-friction",
            told_apart_by: "strokes at two loads at the same speed: Coulomb friction does not change",
        },
        LookAlike {
            effect: "friction-asymmetry",
            told_apart_by: "strokes at two loads at the same speed: friction of the direction alone does not change",
        },
        LookAlike {
            effect: "position-dependent-friction",
            told_apart_by: "strokes at two loads over the whole stroke: friction of the place does not follow the load",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "strokes at two loads at the same constant speed, both pressures recorded",
    source: "Bonchis, Corke, Rye, IEEE ICRA 1999",
    // Where the load is taken from the pressures, the force balance is an input.
    // A model that is driven by the force has no pressures.
    shows_in: |scene| scene.load == LoadSource::Constant && scene.input_point != simulation::InputPoint::Force,
};
