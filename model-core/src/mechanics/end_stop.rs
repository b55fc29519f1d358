//! End stops: beyond them a stiff spring with damping pushes the rod back, and never pulls.
//!
//! F = −k·depth − c·v into the stop. A stop of 1e8 N/m reverses 20 kg within a tick or two, so it is part of the implicit step: each stage is
//! computed with the rod held by the stop and free of it, and the result that moves the rod less into the stop is taken, so that neither
//! a stage nor the tick is ever pulled. A rod that meets a stop within a tick is set on the stop's face: a spring that started with a depth
//! would throw the rod back faster than it came. The oil for the rod's way beyond the face stays where
//! it is, so that the pressures depend on when within the tick the rod was stopped.

use crate::number::{Compared, Mask, Number};

/// Both stops, where they are within reach.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Stops<N: Number> {
    pub retracted: Option<Face<N>>,
    pub extended: Option<Face<N>>,
    /// Force per depth in strokes.
    pub stiffness: N::Steep,
    /// γ·h/m·(c + γ·h·k) over the mass's own diagonal: what a stop adds to it.
    pub weight: N::Steep,
    /// Velocity that moves the rod by a stroke in a tick.
    pub per_stroke: N::Steep,
}

/// Where a stop begins.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Face<N: Number> {
    /// As a position.
    pub place: N::Travel,
}

/// Whether a rod touches a stop, and which.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touch<N: Number> {
    /// The retracted one.
    retracted: N::Mask,
    /// The extended one.
    extended: N::Mask,
    /// How far beyond its face, in strokes; only where it touches.
    pub(crate) depth: N,
}

impl<N: Number> Stops<N> {
    /// The stop that the rod touches.
    #[inline]
    pub(crate) fn touched(&self, position: N::Travel) -> Touch<N> {
        let at = N::of_travel(position);
        let touch = |face: &Option<Face<N>>, depth: fn(N, N) -> N| match face {
            Some(face) => {
                let depth = depth(at, N::of_travel(face.place));
                (!N::ZERO.above(depth), depth)
            }
            None => (N::Mask::NONE, N::ZERO),
        };
        let (extended, beyond) = touch(&self.extended, |at, face| at - face);
        if extended.all() {
            return Touch { retracted: N::Mask::NONE, extended, depth: beyond };
        }
        let (retracted, before) = touch(&self.retracted, |at, face| face - at);
        Touch { retracted: retracted & !extended, extended, depth: N::pick(extended, beyond, before) }
    }

    /// Sets a rod that was free before on the face that it has met. Returns the tick's mean velocity beyond the face, 0 where the rod is still
    /// free; `None` where no rod met a stop.
    #[inline]
    pub(crate) fn set_down(&self, position: &mut N::Travel, was_free: N::Mask) -> Option<N> {
        let touch = self.touched(*position).only(was_free);
        if !touch.any().any() {
            return None;
        }
        for (met, face) in [(touch.extended, &self.extended), (touch.retracted, &self.retracted)] {
            if let Some(face) = face {
                *position = N::Travel::pick(met, face.place, *position);
            }
        }
        Some(N::pick(touch.any(), touch.push(-touch.depth.amplified(self.per_stroke)), N::ZERO))
    }
}

impl<N: Number> Touch<N> {
    /// Whether the rod touches either stop.
    #[inline]
    pub(crate) fn any(&self) -> N::Mask {
        self.retracted | self.extended
    }

    /// Only the touches of these lanes.
    #[inline]
    fn only(self, these: N::Mask) -> Self {
        Self { retracted: self.retracted & these, extended: self.extended & these, ..self }
    }

    /// A force of the stop, positive out of its face, as a force on the rod.
    #[inline]
    pub(crate) fn push(&self, force: N) -> N {
        N::pick(self.extended, -force, force)
    }

    /// Of a free and a held motion, the one that goes less into the stop that the rod touches: a stop does not pull.
    #[inline]
    pub(crate) fn hold(&self, free: N, held: N) -> N {
        N::pick(self.extended, free.min(held), N::pick(self.retracted, free.max(held), free))
    }
}
