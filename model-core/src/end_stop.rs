//! End stops: beyond them a stiff spring with damping pushes the rod back, and never pulls.
//!
//! F = −k·depth − c·v into the stop. A stop of 1e8 N/m turns 20 kg within a tick or two, so it is part of the implicit step: stage for
//! stage the rod is held by the stop or free of it, whichever moves it less into the stop, so that neither a stage nor the tick
//! is ever pulled. A rod that meets a stop within a tick is set down on its face: a spring that started with depth already
//! in it would throw the rod back faster than it came. The oil that its way beyond the face would have made room for stays where
//! it is, so that the pressures know when within the tick the rod was stopped.

use crate::number::Number;

/// Both stops, where they are within reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stops<N: Number> {
    pub(crate) retracted: Option<Face<N>>,
    pub(crate) extended: Option<Face<N>>,
    /// Force per depth in strokes.
    pub(crate) stiffness: N::Steep,
    /// γ·h/m·(c + γ·h·k) over the mass's own diagonal: what a stop adds to it.
    pub(crate) weight: N::Steep,
    /// Velocity that moves the rod by a stroke in a tick.
    pub(crate) per_stroke: N::Steep,
}

/// A rod that was free at the start of the tick and met a stop in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SetDown<N: Number> {
    /// The stop's face.
    pub(crate) place: N::Travel,
    /// What of the tick's mean velocity was beyond it.
    pub(crate) beyond: N,
}

/// Where a stop begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face<N: Number> {
    /// As a position.
    pub(crate) place: N::Travel,
}

/// The side of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Retracted,
    Extended,
}

impl<N: Number> Stops<N> {
    /// The stop that the rod touches, and how far beyond its face the rod is, in strokes.
    #[inline]
    pub(crate) fn touched(&self, position: N::Travel) -> Option<(Side, N)> {
        let at = N::of_travel(position);
        let beyond = |face: &Option<Face<N>>, depth: fn(N, N) -> N| {
            face.map(|face| depth(at, N::of_travel(face.place))).filter(|depth| *depth >= N::ZERO)
        };
        beyond(&self.extended, |at, face| at - face)
            .map(|depth| (Side::Extended, depth))
            .or_else(|| beyond(&self.retracted, |at, face| face - at).map(|depth| (Side::Retracted, depth)))
    }

    /// What becomes of a rod that was free before it moved here; `None` where it still is.
    #[inline]
    pub(crate) fn set_down(&self, position: N::Travel) -> Option<SetDown<N>> {
        let (side, depth) = self.touched(position)?;
        let face = match side {
            Side::Extended => self.extended,
            Side::Retracted => self.retracted,
        }?;
        Some(SetDown { place: face.place, beyond: side.push(-depth.amplified(self.per_stroke)) })
    }
}

impl Side {
    /// A force into the stop's face becomes one on the rod.
    #[inline]
    pub(crate) fn push<N: Number>(self, force: N) -> N {
        match self {
            Side::Retracted => force,
            Side::Extended => -force,
        }
    }

    /// Of a free and a held motion the one less into the stop: a stop does not pull.
    #[inline]
    pub(crate) fn hold<N: Number>(self, free: N, held: N) -> N {
        match self {
            Side::Retracted => free.max(held),
            Side::Extended => free.min(held),
        }
    }
}
