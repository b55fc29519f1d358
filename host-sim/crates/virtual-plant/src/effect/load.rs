//! Forces on the rod that depend on its position or its motion: springs, linkages, stops, a bore that narrows, a mass that hangs on it.

use crate::tangent::Real;
use crate::terms::{State, Terms};

/// A force that depends on the position or the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadEffect {
    /// A spring that touches from a certain position on and becomes stiffer: k·depth^1.5 against extending.
    ProgressiveSpring {
        /// The position from which it touches, m.
        from_m: f64,
        /// k, N/m^1.5.
        stiffness: f64,
    },
    /// A weight on a linkage: F·sin((y − y0)/r) against extending.
    Linkage {
        /// F, N.
        force_n: f64,
        /// y0, the position at which the weight hangs straight down, m.
        neutral_m: f64,
        /// r, metres of travel per radian.
        reach_m: f64,
    },
    /// A stop (Hunt and Crossley): k·depth^1.5·(1 + c·speed into it), pushing only.
    EndStop {
        /// Where it is, m.
        at_m: f64,
        /// True if it stops the extending rod; false if it stops the retracting one.
        extending: bool,
        /// k, N/m^1.5.
        stiffness: f64,
        /// c, s/m.
        damping_s_per_m: f64,
    },
    /// A film of oil, sheared more strongly away from the position where bore and rod fit: D·u²/(1 + u²) times the velocity, u = (y − y0)/w.
    NarrowBore {
        /// D, N s/m.
        most_n_s_per_m: f64,
        /// y0, m.
        fits_at_m: f64,
        /// w, m.
        width_m: f64,
    },
    /// A further mass on a spring on the load: a structure that rings (not in the vocabulary).
    HungMass {
        /// The further mass, kg.
        mass_kg: f64,
        /// Natural frequency of that mass while the rod stands still, Hz.
        frequency_hz: f64,
        /// Damping ratio of the same.
        damping: f64,
    },
}

/// One unit of the state that is the spring's extension, m.
const EXTENSION_M: f64 = 1e-3;

/// depth^1.5, and 0 for a negative depth.
fn pressed<R: Real>(depth: R) -> R {
    if depth.value() > 1e-12 { depth * depth.sqrt() } else { 0.0.into() }
}

impl LoadEffect {
    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::ProgressiveSpring { .. } | Self::Linkage { .. } => "position-dependent-load",
            Self::EndStop { .. } => "end-stop",
            Self::NarrowBore { .. } => "position-dependent-friction",
            Self::HungMass { .. } => "~hung-mass",
        }
    }

    /// Number of its own states: of a further mass the spring's extension and its own speed.
    pub(crate) const fn states(&self) -> usize {
        match self {
            Self::HungMass { .. } => 2,
            _ => 0,
        }
    }

    pub(crate) fn apply<R: Real>(&self, state: &State<R>, (own, rates): (&[R], &mut [R]), terms: &mut Terms<R>) {
        let force: R = match *self {
            Self::ProgressiveSpring { from_m, stiffness } => pressed(state.position - from_m) * -stiffness,
            Self::Linkage { force_n, neutral_m, reach_m } => ((state.position - neutral_m) / reach_m).sin() * -force_n,
            Self::EndStop { at_m, extending, stiffness, damping_s_per_m } => {
                let sign = if extending { 1.0 } else { -1.0 };
                let depth = (state.position - at_m) * sign;
                let push = (state.velocity * (sign * damping_s_per_m) + 1.0).at_least(0.0);
                pressed(depth) * push * (-sign * stiffness)
            }
            Self::NarrowBore { most_n_s_per_m, fits_at_m, width_m } => {
                let off = (state.position - fits_at_m) / width_m;
                let square = off * off;
                state.velocity * (square / (square + 1.0)) * -most_n_s_per_m
            }
            Self::HungMass { mass_kg, frequency_hz, damping } => {
                let ([extension, speed], [extends, gains]) = (own, rates) else { return };
                let per_s = std::f64::consts::TAU * frequency_hz;
                let apart = *speed - state.velocity;
                let pull = (*extension * (EXTENSION_M * per_s) + apart * (2.0 * damping)) * per_s;
                *extends = apart / EXTENSION_M;
                *gains = -pull;
                pull * mass_kg
            }
        };
        terms.force = terms.force + force;
    }
}
