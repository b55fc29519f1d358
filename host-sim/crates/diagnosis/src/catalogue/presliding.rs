//! # Presliding
//!
//! ## What it adds
//! Coulomb friction on bristles that are soft: before the rod slides, a spring of stiffness σ holds it up to the force Fc, and
//! the deflection Fc/σ has to be taken back at each reversal.
//!
//! ## How it shows
//! The rod yields by up to Fc/σ while it sticks, and springs back. Force over velocity is a loop at reversals, wider
//! at higher frequency.
//!
//! ## What looks alike
//! Coulomb friction yields less than the oil does, and steps. Stribeck friction has a hump, but no loop. Play in the linkage hides small
//! motion from the sensor, while the pressures show none of it.
//!
//! ## Parameters
//! Fc in N, not negative: 1–5 % of full force. σ in N/m: a thousandth to a tenth of the stiffness of the oil columns. Bristles that
//! are stiffer than about a third of it yield less than the oil does anyway: the pressures then show a rod that sticks, which
//! is Coulomb friction.
//!
//! ## Source
//! C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, *A new model for control of systems with friction*, IEEE
//! Trans. Automatic Control 40, 1995 (`LuGre`); H. Yanada and Y. Sekikawa, *Modeling of dynamic behaviors of friction*,
//! Mechatronics 18, 2008 (hydraulic cylinders).

use machine_file::LoadSource;
use model_core::machine::Parameter;

use super::{EffectParameter, Extension, Hypothesis, Kind, LookAlike, Subsystem, softest_bristles};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "presliding",
    subsystem: Subsystem::Mechanics,
    equation: "F = −σ·z, dz/dt = v − σ·|v|·z/Fc",
    forms: &[&[
        EffectParameter {
            parameter: Parameter::PreslidingForce,
            kind: Kind::Amount(|scene| (2e-3 * scene.full_force_n(), 0.1 * scene.full_force_n())),
        },
        EffectParameter {
            parameter: Parameter::PreslidingStiffness,
            kind: Kind::Shape(
                |scene| (1e-3 * softest_bristles(scene.machine), 0.1 * softest_bristles(scene.machine)),
                3,
            ),
        },
    ]],
    look_alikes: &[
        LookAlike {
            effect: "coulomb-friction",
            told_apart_by: "sine sweep of small amplitude, both pressures recorded: Coulomb friction has no loop",
        },
        LookAlike {
            effect: "stribeck-friction",
            told_apart_by: "sine sweep of small amplitude, both pressures recorded: the loop grows with the frequency",
        },
        LookAlike {
            effect: "linkage-backlash",
            told_apart_by: "sine sweep of small amplitude, both pressures recorded: play leaves no force",
        },
    ],
    refined: &[],
    extends: Some(Extension {
        plain: "coulomb-friction",
        given: Parameter::CoulombFriction,
        taken: &[Parameter::PreslidingForce],
    }),
    separated_by: "sine sweep of small amplitude, both pressures recorded",
    source: "Canudas de Wit, Olsson, Åström, Lischinsky, IEEE Trans. Automatic Control 40, 1995",
    // Where the load is taken from the pressures, the force balance is an input.
    shows_in: |scene| scene.load == LoadSource::Constant,
};
