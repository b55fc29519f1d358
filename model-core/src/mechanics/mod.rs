//! ```text
//! m·d²y/dt² + Dw·dy/dt = F + A·(pa − α·pb)                               (8)
//! d²y/dt² = (F + A·pa − α·A·pb − Dw·dy/dt)/m                             (12)
//! Fa = A·pa                          Fb = α·A·pb                         (13)
//! d²y/dt² = (F + Fa − Fb − Dw·dy/dt)/m                                   (14)
//! ```
//!
//! The mechanics link: forces → velocity and position. The tick is the two-stage L-stable linearly implicit step of `drive::step`; stepped alone,
//! this link takes the forces f1 and f2 of the two stages. As computed over a tick h, with γ = 1 − 1/√2 and the diagonal d = 1 + γ·h·Dw/m:
//!
//! ```text
//! v1 = h/(m·d)·f1 − h·Dw/(m·d)·v     what the first stage gains
//! v2 = h/(m·d)·f2 + (1 − γ)/d·v1     what the second adds
//! v' = v + γ·v1 + v2
//! y' = y + h·(v + γ·v1 + γ·v2)       the mean velocity of the tick, which makes room for the oil
//! ```
//!
//! Formats: forces are signals, 1 being Aa·(pressure base); the velocity is a signal, 1 being [`Bases::velocity_m_per_s`]; the position has 56
//! fractional bits of a stroke. Signs: a positive force, velocity or position extends the rod.
//!
//! [`Bases::velocity_m_per_s`]: crate::machine::Bases::velocity_m_per_s

pub(crate) mod end_stop;
mod equation;
pub(crate) mod friction;
pub(crate) mod lugre;
pub(crate) mod position_load;

use end_stop::Stops;
use friction::{DryFriction, PlacedDrag};
use lugre::Bristles;
use position_load::PositionLoad;

use crate::correction_table::Push;
use crate::effects::{AnyEffect, Keeps, Knows, LinkEffects};
use crate::number::{Mask, Number};
use crate::ports::{Forces, MotionState, Surroundings};

pub use friction::Contact;

/// γ = 1 − 1/√2, at which the two-stage step is L-stable.
pub const GAMMA: f64 = 1.0 - core::f64::consts::FRAC_1_SQRT_2;

/// Coefficients of the mass at one tick, with those of its effects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(bound = "N: crate::number::Written, E: serde::Serialize")
)]
pub struct Mechanics<N: Number, E = MechanicalEffects<N>> {
    /// The row with the least viscous friction.
    #[doc(hidden)]
    pub row: Row<N>,
    /// That friction: force per velocity. 0 where it does not fit the format, because the mass is `hard`.
    #[doc(hidden)]
    pub viscous: N::Gain,
    /// Whether viscous friction is so strong that full force moves the rod at a quarter of the velocity base at most.
    #[doc(hidden)]
    pub hard: bool,
    /// γ
    #[doc(hidden)]
    pub gamma: N::Gain,
    /// Strokes per tick at velocity 1.
    #[doc(hidden)]
    pub travel: N::Gain,
    /// Velocity that the constant parts of dry friction, of both directions together, take in a tick.
    #[doc(hidden)]
    pub turn: N,
    /// Constant external force, positive extends.
    #[doc(hidden)]
    pub load: N,
    #[doc(hidden)]
    pub effects: E,
}

/// Coefficients of the mass's effects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
pub struct MechanicalEffects<N: Number> {
    /// Dry friction.
    #[doc(hidden)]
    pub dry: DryFriction<N>,
    /// Effects that add to the mass's own diagonal.
    #[doc(hidden)]
    pub resistance: Option<Resistance<N>>,
    /// Correction table of forces.
    #[doc(hidden)]
    pub push: Option<Push<N>>,
}

/// The equation of the velocity. All are divided by the whole diagonal: the mass's own, 1 + γ·h·D/m, and what effects add to it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Row<N: Number> {
    /// Velocity gained in a tick per force.
    pub mobility: N::Gain,
    /// γ times `mobility`, for the oil springs in the eliminated equation.
    pub pull: N::Gain,
    /// Velocity lost in a tick to viscous friction, per velocity.
    pub drag: N::Gain,
    /// (1 − γ)/(1 + γ·h·D/m): the share of the first stage that the second continues with.
    pub back: N::Gain,
    /// The mass's own diagonal over this one, where effects add to it.
    pub share: Option<N>,
}

/// Effects on the mass's own diagonal. Weights are γ·h/m·s over the diagonal without them; 0 for those that are off.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Resistance<N: Number> {
    /// Weight of the machine's whole viscous friction.
    pub viscosity: N::Steep,
    pub drag: Option<PlacedDrag<N>>,
    pub load: Option<PositionLoad<N>>,
    /// Weight of the load's stiffness.
    pub load_weight: N::Steep,
    pub bristles: Option<Bristles<N>>,
    pub stops: Option<Stops<N>>,
    /// 1/γ
    pub per_gamma: N::Gain,
    /// 1 − 2γ: the share of the first stage's travel that is left in a spring's second stage.
    pub second: N::Gain,
    /// 0
    pub none: N::Steep,
}

impl<N: Number, E: Keeps<MechanicalEffects<N>>> Mechanics<N, E> {
    /// Velocity at which the rod makes room for oil over a tick that starts in this state: 0 where a stop has caught the rod by the end.
    #[inline]
    pub(crate) fn making_room<V: Knows<MechanicalEffects<N>>>(&self, motion: &MotionState<N>) -> N {
        let resistance = V::of(self.effects.kept()).and_then(|effects| effects.resistance.as_ref());
        let Some(stops) = resistance.and_then(|resistance| resistance.stops.as_ref()) else { return motion.velocity };
        let ahead = N::travelled(motion.position, [self.travel], [motion.velocity]);
        N::pick(stops.touched(ahead).any(), N::ZERO, motion.velocity)
    }
}

impl<N: Number, E> Mechanics<N, E> {
    /// The same mass with these effects.
    #[inline]
    pub(crate) fn with<F>(&self, effects: F) -> Mechanics<N, F> {
        let &Self { row, viscous, hard, gamma, travel, turn, load, .. } = self;
        Mechanics { row, viscous, hard, gamma, travel, turn, load, effects }
    }
}

impl<N: Number> LinkEffects for MechanicalEffects<N> {}

impl<N: Number> MechanicalEffects<N> {
    /// Whether no effect is on.
    pub(crate) fn are_off(&self) -> bool {
        self.resistance.is_none() && self.push.is_none() && self.dry.is_off()
    }
}

impl<N: Number> Mechanics<N> {
    /// The same with a heavier mass: a force has this share, 0..1, of its effect here. What effects add to the mass's diagonal grows with it.
    pub(crate) fn heavier(&self, share: N) -> Self {
        let shrunk = |gain: N::Gain| N::scaled(gain, share);
        // 1 − γ of the mass over its diagonal, as the mass's part of the diagonal grows.
        let lost = N::of_gain(N::scaled(self.row.drag, N::ONE - share)).small_part(self.gamma);
        let back = N::of_gain(self.row.back) + (lost - lost.small_part(self.gamma));
        let row = Row {
            mobility: shrunk(self.row.mobility),
            pull: shrunk(self.row.pull),
            drag: shrunk(self.row.drag),
            back: back.as_gain(),
            share: self.row.share,
        };
        Self { row, turn: self.turn.times(share), ..*self }
    }

    /// One tick under the given forces. Returns the mean velocity of the tick.
    #[inline]
    pub fn step(&self, state: &mut MotionState<N>, forces: Forces<N>) -> N {
        if N::ONE.above(forces.around.sprung).any() {
            let around = Surroundings { sprung: N::ONE, ..forces.around };
            return self.heavier(forces.around.sprung).step(state, Forces { around, ..forces });
        }
        self.step_with::<AnyEffect>(state, forces)
    }

    /// The same with the mass as it is.
    #[inline]
    pub(crate) fn step_with<V: Knows<MechanicalEffects<N>>>(&self, state: &mut MotionState<N>, forces: Forces<N>) -> N {
        let equation = self.equation::<V>(state, forces.around);
        let contact = equation.contact(state.velocity, forces.start);
        let stage = equation.first_stage(contact, state.velocity);
        let first = equation.first(&stage, forces.first);
        let stage = equation.second_stage(contact, &stage, first.velocity);
        let gained = [first.velocity, equation.second(&stage, &first, forces.second)];
        let moved = equation.finish(contact, state, gained, gained.map(|gained| gained.small_part(self.gamma)));
        moved.beyond.map_or(moved.solved, |beyond| moved.solved - beyond)
    }
}
