//! Dry friction: how strongly the rod is held at rest, and braked in motion.
//!
//! Without bristles, friction is set-valued: at rest any force below the break-away is held exactly, in motion the friction acts
//! against the motion. With bristles it acts as `lugre` describes. All laws add up:
//!
//! ```text
//! constant            coulomb-friction, presliding, the force of stribeck-friction, friction-asymmetry by direction
//! excess/(1 + 0.0905·(v/vs)²)⁸   stribeck-friction, what breaking away takes more; evaluated at the velocity of each stage
//! max(0, f + a·s + b·s²)  position-dependent-friction, s = 2y/stroke − 1, at the tick's start
//! area·(pa⁺ + pb⁺)    pressure-dependent-friction, at the tick's start
//! ```
//!
//! Viscous friction is D·v with the mass's own coefficients. It is D·u·max(0.05, 1 + d·s + e·s²)·v where the oil warms to a
//! viscosity u or where position-dependent-friction lets it change along the stroke.
//!
//! The falling branch over the velocity is explicit: it drives the velocity away from its present value, but makes no oscillation.
//! Source: Armstrong-Hélouvry, Dupont, Canudas de Wit, *A survey of models, analysis tools and compensation methods for the
//! control of machines with friction*, Automatica 30, 1994.

use crate::number::{Mask, Number};

/// √(2^⅛ − 1): with it in t, half of the excess is gone at the Stribeck velocity. The eighth power is as near to the usual exponential curve,
/// 2^(−(v/vs)²), as is cheap: of the excess 1.7 % or less is left too much, at 1.5 times that velocity, and 2.2 % at twice it.
pub(crate) const STRIBECK_WIDTH: f64 = 0.300_845_030_979_834_67;

/// How dry friction acts during one tick. Where all are false, none acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contact<M> {
    /// The rod sticks.
    pub sticks: M,
    /// It slides; friction points against extending.
    pub extends: M,
    /// It slides; friction points against retracting.
    pub retracts: M,
}

impl<M: Mask> Contact<M> {
    /// No friction.
    pub(crate) const FREE: Self = Self { sticks: M::NONE, extends: M::NONE, retracts: M::NONE };
}

/// Coefficients of all dry friction, per unit of force, or in shares of the bristles' reference. 0 is neutral.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct DryFriction<N: Number> {
    /// Against extending, the constant part.
    pub extending: N,
    /// Against retracting, the constant part.
    pub retracting: N,
    pub stribeck: Option<Stribeck<N>>,
    pub placed: Option<Placed<N>>,
    /// Friction per sum of both pressures.
    pub seals: Option<N>,
}

/// Break-away above the friction at speed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Stribeck<N: Number> {
    /// At rest.
    pub excess: N,
    /// Velocity base over the velocity at which half of it has disappeared, times [`STRIBECK_WIDTH`].
    pub per_velocity: N::Steep,
    /// 1
    pub unity: N::Steep,
}

/// Friction that depends on the rod's position.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[doc(hidden)]
pub struct Placed<N> {
    /// At mid-stroke.
    pub level: N,
    /// Additional friction with the rod fully out.
    pub slope: N,
    /// Additional friction at both ends.
    pub bow: N,
}

/// Viscous friction that depends on the rod's position, as a share of the machine's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[doc(hidden)]
pub struct PlacedDrag<N> {
    /// In the oil that the machine's values are for.
    pub share: Placed<N>,
    /// Least value over the stroke that slope and bow may leave.
    pub slipperiest: N,
    /// Least of the oil's viscosity.
    pub thinnest: N,
    /// Least of both together, which the rod's own coefficients contain.
    pub least: N,
}

impl<N: Number> PlacedDrag<N> {
    /// Viscous friction above the least, where the oil's viscosity is this much above its own least; held at the end of the format, 8.
    #[inline]
    pub(crate) fn excess(&self, from_middle: N, viscosity: N) -> N {
        (self.thinnest + viscosity).times(self.share.along(from_middle).max(self.slipperiest)) - self.least
    }
}

impl<N: Number> Stribeck<N> {
    /// excess/(1 + t²)⁸, t = √(2^⅛ − 1)·|v|/vs. Error 3e-7 of the excess, and 1.5e-5 of (velocity base)/vs in t.
    ///
    /// Computed from r = 1/(1 + t), which fits the format for every t: 1/(1 + t²) = 2r²/(1 + (1 − 2r)²).
    #[inline]
    fn at(&self, velocity: N) -> N {
        let r = N::inverse_one_plus([velocity.magnitude()], [self.per_velocity]);
        let odd = N::ONE - r - r;
        let square = r.times(r);
        let share = (square + square).times(N::inverse_one_plus([odd.times(odd)], [self.unity]));
        let fourth = share.times(share).times(share.times(share));
        self.excess.times(fourth).times(fourth)
    }
}

impl<N: Number> Placed<N> {
    #[inline]
    fn along(&self, from_middle: N) -> N {
        let s = from_middle + from_middle;
        self.level + s.times(self.slope) + s.times(s).times(self.bow)
    }

    #[inline]
    fn at(&self, from_middle: N) -> N {
        self.along(from_middle).max(N::ZERO)
    }
}

impl<N: Number> DryFriction<N> {
    /// The levels of a tick, `from_middle` strokes from mid-stroke, with the sum of both pressures on the seals.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn level(&self, from_middle: N, pressed: N) -> Level<N> {
        let mut level = Level { extending: self.extending, retracting: self.retracting, stribeck: self.stribeck };
        if let Some(placed) = &self.placed {
            level = level.raised(placed.at(from_middle));
        }
        if let Some(seals) = self.seals {
            level = level.raised(seals.times(pressed));
        }
        level
    }

    /// Whether there is no dry friction.
    pub(crate) fn is_off(&self) -> bool {
        self.extending == N::ZERO && self.retracting == N::ZERO && !self.varies()
    }

    /// Whether the levels differ from tick to tick.
    #[inline]
    pub(crate) fn varies(&self) -> bool {
        self.stribeck.is_some() || self.placed.is_some() || self.seals.is_some()
    }
}

/// Dry friction in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Level<N: Number> {
    extending: N,
    retracting: N,
    stribeck: Option<Stribeck<N>>,
}

impl<N: Number> Level<N> {
    /// No friction.
    pub(crate) const NONE: Self = Self::constant(N::ZERO, N::ZERO);

    /// The same without the part that falls with velocity.
    #[inline]
    pub(crate) fn without_stribeck(self) -> Self {
        Self { stribeck: None, ..self }
    }

    /// Friction that does not depend on velocity.
    pub(crate) const fn constant(extending: N, retracting: N) -> Self {
        Self { extending, retracting, stribeck: None }
    }

    #[inline]
    fn raised(self, by: N) -> Self {
        Self { extending: self.extending + by, retracting: self.retracting + by, ..self }
    }

    #[inline]
    fn excess(&self) -> N {
        self.stribeck.map_or(N::ZERO, |stribeck| stribeck.excess)
    }

    /// Whether the rod sticks, or in which direction it slides. Set-valued: at rest, any force below the friction is held exactly.
    #[inline]
    pub(crate) fn contact(&self, velocity: N, force: N) -> Contact<N::Mask> {
        let (out, back) = (velocity.above(N::ZERO), N::ZERO.above(velocity));
        let rests = !(out | back);
        if !rests.any() {
            return Contact { extends: out, retracts: back, ..Contact::FREE };
        }
        let excess = self.excess();
        let sticks = rests & (self.extending + excess).above(force) & (self.retracting + excess).above(-force);
        let yields = rests & !sticks;
        Contact {
            sticks,
            extends: out | (yields & force.above(N::ZERO)),
            retracts: back | (yields & N::ZERO.above(force)),
        }
    }

    /// The friction force at a stage's velocity; a velocity that has reversed within the tick counts as rest.
    #[inline]
    pub(crate) fn force(&self, contact: Contact<N::Mask>, velocity: N) -> N {
        let falling = |along: N| self.stribeck.map(|stribeck| stribeck.at(along.max(N::ZERO)));
        let level = |constant: N, along: N| falling(along).map_or(constant, |excess| constant + excess);
        let retracts = || N::choose(contact.retracts, || level(self.retracting, -velocity), || N::ZERO);
        N::choose(contact.extends, || -level(self.extending, velocity), retracts)
    }

    /// A force of the bristles, limited to what holds a rod at rest.
    #[inline]
    pub(crate) fn held(&self, force: N) -> N {
        let excess = self.excess();
        force.min(self.extending + excess).max(-(self.retracting + excess))
    }

    /// The friction against this velocity; at rest that of the direction with more friction.
    #[inline]
    pub(crate) fn against(&self, velocity: N) -> N {
        let still = || self.extending.max(self.retracting);
        let back = || N::choose(N::ZERO.above(velocity), || self.retracting, still);
        let constant = N::choose(velocity.above(N::ZERO), || self.extending, back);
        self.stribeck.map_or(constant, |stribeck| constant + stribeck.at(velocity))
    }

    /// Change of the friction in the direction of `from` when the velocity becomes `to`; a velocity that has reversed counts as rest.
    #[inline]
    pub(crate) fn change(&self, from: N, to: N) -> N {
        let Some(stribeck) = &self.stribeck else { return N::ZERO };
        let back = N::ZERO.above(from);
        let along = N::pick(back, -to, to);
        let change = stribeck.at(along.max(N::ZERO)) - stribeck.at(from);
        N::pick(back, -change, change)
    }

    /// Sum of the frictions of both directions, break-away included.
    #[inline]
    pub(crate) fn both(&self) -> N {
        let excess = self.excess();
        self.extending + self.retracting + excess + excess
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::number::PerUnit;

    fn stribeck<N: Number<Real = f64>>(excess: f64, per_velocity: f64) -> Stribeck<N> {
        Stribeck {
            excess: N::saturated(excess),
            per_velocity: N::steep(per_velocity).unwrap(),
            unity: N::steep(1.0).unwrap(),
        }
    }

    #[test]
    fn half_of_the_excess_is_gone_at_the_stribeck_velocity_and_eleven_twelfths_at_twice_it() {
        let law = stribeck::<PerUnit>(0.5, STRIBECK_WIDTH * 10.0);
        assert!((law.at(PerUnit::saturated(0.1)).to_f64() - 0.25).abs() < 2e-6);
        assert!((law.at(PerUnit::saturated(-0.2)).to_f64() - 0.0422).abs() < 1e-4);
        assert!((law.at(PerUnit::ZERO).to_f64() - 0.5).abs() < 1e-7);
    }

    #[test]
    fn a_bent_rod_is_held_harder_at_its_ends_and_never_pushed() {
        let placed = |s: f64| {
            let [level, slope, bow] = [0.1, 0.05, -0.2].map(PerUnit::saturated);
            Placed { level, slope, bow }.at(PerUnit::saturated(0.5 * s)).to_f64()
        };
        assert!((placed(0.5) - (0.1 + 0.025 - 0.05)).abs() < 1e-8);
        assert!(placed(-1.0).abs() < 1e-12, "0.1 − 0.05 − 0.2 is less than nothing");
    }

    #[test]
    fn unequal_friction_holds_between_its_two_forces() {
        let [extending, retracting] = [0.3, 0.1].map(PerUnit::saturated);
        let level = Level::constant(extending, retracting);
        let at_rest = |force: f64| level.contact(PerUnit::ZERO, PerUnit::saturated(force));
        let (sticks, extends) = (Contact { sticks: true, ..Contact::FREE }, Contact { extends: true, ..Contact::FREE });
        assert_eq!([0.29, -0.09].map(at_rest), [sticks; 2]);
        assert_eq!([0.31, -0.11].map(at_rest), [extends, Contact { retracts: true, ..Contact::FREE }]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5000))]

        #[test]
        fn the_excess_falls_as_its_formula(v in -8.0..8.0_f64, k in 1e-2..6e4_f64, excess in 0.0..4.0_f64) {
            let fixed = stribeck::<PerUnit>(excess, k);
            let t = PerUnit::saturated(v).to_f64() * fixed.per_velocity.to_num::<f64>();
            let exact = fixed.excess.to_f64() / (1.0 + t * t).powi(8);
            prop_assert!((fixed.at(PerUnit::saturated(v)).to_f64() - exact).abs() < 2e-7 * (1.0 + excess));
            let real = stribeck::<f64>(excess, k).at(v);
            prop_assert!((real - excess / (1.0 + (k * v).powi(2)).powi(8)).abs() < 1e-9);
        }
    }
}
