//! What the links hand to one another within a tick.
//!
//! ```text
//! valve ─ Spool ─ flow ─ Flows ─ chambers ─ Forces ─ mechanics ─ MotionState ─ sensing
//!   ▲ AcrossEdges ─┘  ▲ Filling, ChamberState ─┘  ▲ Surroundings, States of the drive
//! ```
//!
//! Every `N` is per unit ([`Bases`](crate::machine::Bases)): in fixed point ±8 in steps of 2⁻²⁸. Signs: spool > 0 opens P-A and B-T and extends
//! the rod; flow a > 0 goes into chamber A, flow b > 0 comes out of chamber B; a positive force, velocity or position extends.

use crate::number::Number;

/// The spool over one tick; between start and end it moves linearly.
///
/// A spool that sticks and jumps within the tick is handed on in the same way: the jump is equally likely at any time within the tick, and
/// the straight line has the mean opening of a jump in the middle. With the jump taken at the start or the end of the tick, every jump would
/// be half a tick early or late.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
pub struct Spool<N> {
    /// At the start of the tick.
    pub from: N,
    /// At its end.
    pub to: N,
}

/// Sum of the pressure differences over the two edges that the spool opens, without sign: flow forces depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcrossEdges<N> {
    /// P-A and B-T, open where the spool extends.
    pub extending: N,
    /// A-T and P-B, open where it retracts.
    pub retracting: N,
}

impl<N: Number> AcrossEdges<N> {
    /// No pressure: the spool moves as if no oil flowed.
    pub const NONE: Self = Self { extending: N::ZERO, retracting: N::ZERO };
}

/// Flow into A and out of B.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Flows<F> {
    /// Into chamber A.
    pub a: F,
    /// Out of chamber B.
    pub b: F,
}

/// One flow, and what the implicit step needs of its derivative by the chamber's pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearised<N: Number> {
    /// The flow, per unit.
    pub flow: N,
    /// Magnitude of the opening: the slope is −`opening`·`slope`, that of the chord to zero pressure difference; 0 where the flow does not
    /// depend on the pressure.
    pub opening: N,
    /// Slope of the orifice's root: of its chord to zero pressure difference.
    pub slope: N::Steep,
}

/// Spool travel from the centre that passes no oil, to either side; `dead-zone-asymmetry` lets the sides differ.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[doc(hidden)]
pub struct Overlap<N> {
    pub extending: N,
    pub retracting: N,
}

impl<N: Number> Overlap<N> {
    /// Travel beyond the overlap, signed like the spool; not renormalised.
    #[inline]
    pub(crate) fn beyond(&self, spool: N) -> N {
        (spool - self.extending).max(N::ZERO) + (spool + self.retracting).min(N::ZERO)
    }

    /// Travel from where each direction begins, positive beyond it: extending, retracting.
    #[inline]
    pub(crate) fn past_edges(&self, spool: N) -> [N; 2] {
        [spool - self.extending, -spool - self.retracting]
    }
}

/// Pressures of both chambers, per unit of supply pressure.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ChamberState<N> {
    /// Chamber A.
    pub a: N,
    /// Chamber B.
    pub b: N,
}

/// How a tick fills a chamber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Filling<N: Number> {
    /// Pressure rise over the tick at a flow of 1.
    pub(crate) stiffness: N::Gain,
    /// Flow that is taken up elsewhere, by the rod's movement and by leakage: into A, out of B.
    pub(crate) room: N,
}

impl<N: Number> Filling<N> {
    /// The same for a flow the other way.
    #[inline]
    pub(crate) fn reversed(self) -> Self {
        Self { room: -self.room, ..self }
    }

    /// The same with an additional flow in the other direction.
    #[inline]
    pub(crate) fn against(self, flow: N) -> Self {
        Self { room: self.room + flow, ..self }
    }
}

/// Velocity and position.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "N: serde::Serialize, N::Travel: serde::Serialize",
        deserialize = "N: serde::Deserialize<'de>, N::Travel: serde::Deserialize<'de>"
    ))
)]
pub struct MotionState<N: Number> {
    /// Velocity, per unit; positive extends.
    pub velocity: N,
    /// Position.
    pub position: N::Travel,
    /// Force of the bent bristles in shares of their reference; positive holds against extending. 0 where there are none.
    pub bristles: N,
}

impl<N: Number> MotionState<N> {
    /// No velocity, no bristle bent.
    #[must_use]
    pub fn at_rest(position: N::Travel) -> Self {
        Self { velocity: N::ZERO, position, bristles: N::ZERO }
    }
}

/// Net force on the rod in a tick, without friction and without what depends on the rod's own position.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
pub struct Forces<N> {
    /// At the start of the tick: what dry friction has to hold.
    pub start: N,
    /// First stage: the force at the start plus γ times the stage's change; `from` + γ·(`to` − `from`) for a force that changes linearly
    /// over the tick.
    pub first: N,
    /// Second stage: the change that is left, γ·(1 − γ)·(`to` − `from`) for a force that changes linearly; 0 for a constant one.
    pub second: N,
    /// Other quantities that friction depends on.
    pub around: Surroundings<N>,
}

/// What friction depends on beside the motion, at the start of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
pub struct Surroundings<N> {
    /// Sum of both chamber pressures above 0, on the seals.
    pub pressed: N,
    /// Viscosity of the oil above its least possible value, as a share of the viscosity that the machine's values are for.
    pub viscosity: N,
    /// States over which a table of forces is defined.
    pub states: States<N>,
    /// The mass matched to both oil springs, over the mass matched to the springs that cavitation leaves, 0..1.
    pub sprung: N,
}

impl<N: Number> Surroundings<N> {
    /// No pressures, and the thinnest oil.
    pub const NONE: Self = Self { pressed: N::ZERO, viscosity: N::ZERO, states: States::NONE, sprung: N::ONE };
}

/// States of a drive over which a table may be defined, per unit.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
pub struct States<N> {
    /// Velocity of the rod.
    pub velocity: N,
    /// Position, strokes.
    pub position: N,
    /// Spool; 0 where the drive input is below the spool.
    pub spool: N,
    /// Pressure in A.
    pub pressure_a: N,
    /// Pressure in B.
    pub pressure_b: N,
}

impl<N: Number> States<N> {
    /// All 0.
    pub const NONE: Self =
        Self { velocity: N::ZERO, position: N::ZERO, spool: N::ZERO, pressure_a: N::ZERO, pressure_b: N::ZERO };
}
