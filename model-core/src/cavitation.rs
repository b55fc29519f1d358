//! Cavitation: oil cannot pull. A chamber that more is drawn from than it gives by its pressure's fall keeps its pressure at a floor, that
//! of its vapour or of the air that comes out of it, while a void grows; the pressure rises again once the void is filled.
//!
//! ```text
//! net oil over a tick, n           dp = c·(n − m)      dw = m − n      0 ≤ w,   p ≥ floor,   w·(p − floor) = 0
//! ```
//!
//! with w the void, in the ticks of flow 1 that fill it, and m what of n the void takes or gives. Of w nothing is rounded: oil and void
//! together change by n to the bit.
//!
//! In the implicit step an empty chamber has no stiffness: its pressure stays whatever flows. One that empties or fills within the tick has
//! the chord's, the rise that its net oil makes over what it would make in a full one. Which of these a tick is shows only at its end, so it is
//! then taken back and stepped once more with the chord. Flows and forces see that chord; what the chambers hold goes by the law above.
//! Source: Merritt, *Hydraulic Control Systems*, 1967, 5.5; of the chord: as the slopes of `chain`.

use crate::capacity::ATMOSPHERE_PA;
use crate::chambers::ChamberState;
use crate::flow::Flows;
use crate::number::{Compared, Mask, Number};

/// Lowest floor there is, Pa: no oil below the vacuum. What is lower means that there is none.
pub(crate) const LOWEST_FLOOR_PA: f64 = -ATMOSPHERE_PA;

/// Coefficients of cavitation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cavitation<N: Number> {
    /// Pressure that a chamber does not fall below.
    pub(crate) floor: N,
    /// 1, as a slope.
    pub(crate) unity: N::Steep,
}

/// Voids of both chambers, in units of [`Bases::void_m3`](crate::machine::Bases::void_m3).
pub type Voids<N> = ChamberState<<N as Number>::Travel>;

/// Whether a chamber filled or emptied within a tick, and how far it was full: its pressure's change over that of a full one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing<N: Number> {
    crosses: N::Mask,
    share: N,
}

impl<N: Number> Flows<Crossing<N>> {
    /// Whether either chamber of any drive did.
    #[inline]
    pub(crate) fn any(&self) -> bool {
        (self.a.crosses | self.b.crosses).any()
    }

    /// How far each chamber is full in the tick.
    #[inline]
    pub(crate) fn shares(&self) -> Flows<N> {
        Flows { a: self.a.share, b: self.b.share }
    }
}

/// What a rod loses of the oil springs that its mass is matched to (`coefficients`), and so of what lightens that mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unsprung<N: Number> {
    /// Share of what a force does that is lost where A is empty.
    pub(crate) without_a: N::Gain,
    /// Where B is.
    pub(crate) without_b: N::Gain,
    /// Where both are, beside these two.
    pub(crate) together: N::Gain,
    /// γ − γ²: how much more of the first stage the second goes on with, per drag that is lost.
    pub(crate) back: N::Gain,
    /// 1, as a slope.
    pub(crate) unity: N::Steep,
}

impl<N: Number> Unsprung<N> {
    /// The mass matched to both springs over that matched to chambers full by these shares.
    #[inline]
    pub(crate) fn share(&self, full: &Flows<N>) -> N {
        let (a, b) = (N::ONE - full.a, N::ONE - full.b);
        (N::ONE - N::dot([self.without_a, self.without_b, self.together], [a, b, a.times(b)])).min(N::ONE)
    }

    /// The diagonal of a rod over that with brakes, with the mass so much heavier; `share` as it is without.
    #[inline]
    pub(crate) fn braked(&self, share: N, sprung: N) -> N {
        N::share(share, [(N::ONE - share).times(sprung)], [self.unity])
    }
}

impl<N: Number> Cavitation<N> {
    /// How far each chamber is full as a tick begins: 0 or 1; `None` where all are.
    #[inline]
    pub(crate) fn full(voids: &Voids<N>) -> Option<Flows<N>> {
        let nothing = N::ZERO.as_travel();
        let (a, b) = (voids.a.above(nothing), voids.b.above(nothing));
        let full = |empty| N::pick(empty, N::ZERO, N::ONE);
        (a | b).any().then(|| Flows { a: full(a), b: full(b) })
    }

    /// Lets a chamber that rises by `stiffness` per net oil take in `net`.
    #[inline]
    pub(crate) fn take(
        &self,
        stiffness: N::Gain,
        pressure: &mut N,
        rest: &mut N,
        void: &mut N::Travel,
        net: N,
    ) -> Crossing<N> {
        let nothing = N::ZERO.as_travel();
        let empty = void.above(nothing);
        let gap = N::pick(empty, N::of_sum(*void), N::ZERO);
        let start = pressure.max(self.floor);
        // What is left of the oil once the void is filled; a full chamber may have to give all.
        let surplus = N::pick(empty, (net - gap).max(N::ZERO), net);
        let (mut after, mut after_rest) = start.accumulated(*rest, [stiffness], [surplus]);
        let (mut taken, mut share) = (surplus, N::pick(empty, N::ZERO, N::ONE));
        let fills = empty & surplus.above(N::ZERO);
        if fills.any() {
            let filled = N::share(surplus, [gap], [self.unity]);
            share = N::pick(fills, filled.of(filled), share);
        }
        let empties = self.floor.above(after);
        if empties.any() {
            let chord = N::share(start - self.floor, [self.floor - after], [self.unity]);
            // Less by the share's own error: what is left stands above the floor by a few steps, not below.
            let given = (chord - N::ONE.over_power(25)).max(N::ZERO).of(net);
            let (full, full_rest) = start.accumulated(*rest, [stiffness], [given]);
            after = N::pick(empties, full, after);
            after_rest = N::pick(empties, full_rest, after_rest);
            taken = N::pick(empties, given, taken);
            let left = N::ONE - chord;
            share = N::pick(empties, N::ONE - left.of(left), share);
        }
        let left = N::Travel::pick(fills, nothing, N::summed(*void, taken - net).larger(nothing));
        (*pressure, *rest, *void) = (after, after_rest, left);
        Crossing { crosses: fills | empties, share }
    }
}
