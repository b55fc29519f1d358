//! End stops: beyond them a stiff spring with damping pushes the rod back, and never pulls.
//!
//! F = −k·depth − c·v into the stop. A stop of 1e8 N/m turns 20 kg within a tick or two, so it is part of the implicit step: stage for
//! stage the rod is held by the stop or free of it, whichever moves it less into the stop, so that neither a stage nor the tick
//! is ever pulled. A rod that meets a stop within a tick is set down on its face: a spring that started with depth already
//! in it would throw the rod back faster than it came. That costs less than a tick's travel of position.

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

    /// Where the rod is put that was free before it moved here.
    #[inline]
    pub(crate) fn set_down(&self, position: N::Travel) -> N::Travel {
        match self.touched(position) {
            Some((Side::Extended, _)) => self.extended.map_or(position, |face| face.place),
            Some((Side::Retracted, _)) => self.retracted.map_or(position, |face| face.place),
            None => position,
        }
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
