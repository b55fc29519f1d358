//! Dry friction on elastic bristles (`LuGre`), with the level of sliding friction in several forms.

use crate::tangent::Real;
use crate::terms::{State, Terms};

/// How far plain dry friction yields elastically before it slides, m.
const PLAIN_GIVES_M: f64 = 2e-6;
const PLAIN_DAMPING_N_S_PER_M: f64 = 1e4;

/// The force in steady sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrictionLevel {
    /// The same everywhere, N.
    Constant(f64),
    /// Falls from the break-away force as exp(−(v/vs)²).
    Stribeck {
        /// At high speed, N.
        sliding_n: f64,
        /// At rest, N.
        break_away_n: f64,
        /// vs, m/s.
        velocity_m_per_s: f64,
    },
    /// One force for each direction.
    Asymmetric {
        /// N.
        extending_n: f64,
        /// N.
        retracting_n: f64,
    },
    /// A tight place: a Gaussian bump over the position.
    Bump {
        /// Away from the tight place, N.
        force_n: f64,
        /// Additional force at its middle, N.
        rise_n: f64,
        /// Position of its middle, m.
        at_m: f64,
        /// Distance from there at which it has fallen to 1/e, m.
        width_m: f64,
    },
    /// A bore that narrows: linear over the position.
    Slope {
        /// With the rod fully in, N.
        retracted_n: f64,
        /// With the rod fully out, N.
        extended_n: f64,
        /// Length of travel, m.
        stroke_m: f64,
    },
    /// Seals press harder as the pressure rises: mainly by the higher one of the two pressures.
    Pressure {
        /// Force per pressure, m².
        area_m2: f64,
        /// Share of the higher pressure; the remaining share depends on the lower one.
        share_of_higher: f64,
        /// Force that remains at zero pressure, N.
        least_n: f64,
    },
    /// Soft bristles with a small excess at rest.
    Presliding {
        /// At high speed, N.
        sliding_n: f64,
        /// At rest, N.
        break_away_n: f64,
    },
}

/// Dry friction: a level and the bristles that carry it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DryFriction {
    /// The force in steady sliding.
    pub level: FrictionLevel,
    /// Bristle stiffness σ0, N/m.
    pub stiffness_n_per_m: f64,
    /// Bristle damping σ1, N·s/m.
    pub damping_n_s_per_m: f64,
}

impl DryFriction {
    /// With bristles that yield by `give_m` before they slide, damped as in plain dry friction usually.
    #[must_use]
    pub fn stiff(level: FrictionLevel, give_m: f64) -> Self {
        Self::giving(level, give_m, PLAIN_DAMPING_N_S_PER_M)
    }

    /// With bristles that yield by `give_m` before they slide.
    #[must_use]
    pub fn giving(level: FrictionLevel, give_m: f64, damping_n_s_per_m: f64) -> Self {
        Self { level, stiffness_n_per_m: level.usual_n() / give_m, damping_n_s_per_m }
    }

    /// The same usual force everywhere times a factor, on bristles as stiff as in plain dry friction usually.
    pub(crate) fn plainer(&self, factor: f64) -> Option<Self> {
        let level = FrictionLevel::Constant(factor * self.level.usual_n());
        (self.name() != "coulomb-friction").then(|| Self::stiff(level, PLAIN_GIVES_M))
    }

    pub(crate) const fn name(&self) -> &'static str {
        match self.level {
            FrictionLevel::Constant(_) => "coulomb-friction",
            FrictionLevel::Stribeck { .. } => "stribeck-friction",
            FrictionLevel::Asymmetric { .. } => "friction-asymmetry",
            FrictionLevel::Bump { .. } | FrictionLevel::Slope { .. } => "position-dependent-friction",
            FrictionLevel::Pressure { .. } => "pressure-dependent-friction",
            FrictionLevel::Presliding { .. } => "presliding",
        }
    }

    /// `bristle` is the deflection, in units of usual force over stiffness; the result is its rate of change.
    pub(crate) fn apply<R: Real>(&self, bristle: R, state: &State<R>, terms: &mut Terms<R>) -> R {
        let usual_n = self.level.usual_n();
        if usual_n <= 0.0 {
            return 0.0.into();
        }
        let share = R::from(usual_n) / self.level.at(state);
        let deflection_speed = state.velocity - state.velocity.abs() * bristle * share;
        terms.force = terms.force - bristle * usual_n - deflection_speed * self.damping_n_s_per_m;
        deflection_speed * (self.stiffness_n_per_m / usual_n)
    }
}

impl FrictionLevel {
    /// The scale of the bristle's state: a typical force of this level, N.
    fn usual_n(&self) -> f64 {
        match *self {
            Self::Constant(force_n) | Self::Bump { force_n, .. } => force_n,
            Self::Stribeck { sliding_n, .. } | Self::Presliding { sliding_n, .. } => sliding_n,
            Self::Asymmetric { extending_n, retracting_n } => 0.5 * (extending_n + retracting_n),
            Self::Slope { retracted_n, extended_n, .. } => 0.5 * (retracted_n + extended_n),
            Self::Pressure { area_m2, least_n, .. } => least_n + area_m2 * 5.0e6,
        }
    }

    fn at<R: Real>(&self, state: &State<R>) -> R {
        let falling = |from_n: f64, to_n: f64, over: f64| {
            let relative = state.velocity / over;
            (-(relative * relative)).exp() * (from_n - to_n) + to_n
        };
        let level: R = match *self {
            Self::Constant(force_n) => force_n.into(),
            Self::Stribeck { sliding_n, break_away_n, velocity_m_per_s } => {
                falling(break_away_n, sliding_n, velocity_m_per_s)
            }
            Self::Presliding { sliding_n, break_away_n } => falling(break_away_n, sliding_n, 0.01),
            Self::Asymmetric { extending_n, retracting_n } => {
                if state.velocity.value() < 0.0 {
                    retracting_n.into()
                } else {
                    extending_n.into()
                }
            }
            Self::Bump { force_n, rise_n, at_m, width_m } => {
                let off = (state.position - at_m) / width_m;
                (-(off * off)).exp() * rise_n + force_n
            }
            Self::Slope { retracted_n, extended_n, stroke_m } => {
                state.position * ((extended_n - retracted_n) / stroke_m) + retracted_n
            }
            Self::Pressure { area_m2, share_of_higher, least_n } => {
                let (a, b) = (state.pressure_a, state.pressure_b);
                let (higher, lower) = if a.value() > b.value() { (a, b) } else { (b, a) };
                (higher * share_of_higher + lower * (1.0 - share_of_higher)) * area_m2 + least_n
            }
        };
        level.at_least(0.02 * self.usual_n())
    }
}
