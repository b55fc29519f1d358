//! Cavitation: oil cannot pull. A chamber that more is drawn from than it gives by its pressure's fall keeps its pressure at a floor, that
//! of its vapour or of the air that comes out of it, while a void grows; the pressure rises again once the void is filled.
//!
//! ```text
//! net oil n of a tick:   Δw = m − n,   Δp = c·m,   w ≥ 0,   p ≥ floor,   w·(p − floor) = 0
//! ```
//!
//! with w the void, in ticks of flow 1, and m what of the oil raises the pressure. Nothing of w is rounded: with the rest of a pressure's
//! rounding, oil is conserved to the bit.
//!
//! A tick of the chain starts with the chambers full or empty, and an empty one has no stiffness: its pressure stays, whatever flows. Only the
//! tick's end shows whether one emptied or filled in it. Such a tick is taken back and stepped once more, with the share of the stiffness
//! by which the chamber pushes the rod as much as it does in truth: its pressure moves over a part τ of the tick only. One that falls to the
//! floor after τ has the mean (1 − τ/2)·τ of what it would fall by, twice the share of which is 1 − (1 − τ)²; one that rises in the last τ has the
//! mean τ²/2, and the share τ². A chamber takes in what then flows by the law above, at its whole stiffness.
//!
//! The rod's mass is matched to the springs of the oil (`coefficients`), and an empty chamber is none. Whatever else is on the mass's diagonal
//! (a stop, bristles, thickened oil) grows with it in such a tick, by 5 % at most.
//!
//! Source: Merritt, *Hydraulic Control Systems*, 1967, 5.5 (a valve's cavity under an overrunning load).

use crate::capacity::ATMOSPHERE_PA;
use crate::chain::Chain;
use crate::chambers::ChamberState;
use crate::drive::{Drive, DriveState, Interfaces, Load};
use crate::feed::Feed;
use crate::flow::Flows;
use crate::number::{Compared, Mask, Number};
use crate::vocabulary::Effects;

/// Lowest floor there is, Pa: the vacuum, where pressures are over the atmosphere's. A floor below means that there is none.
pub(crate) const LOWEST_FLOOR_PA: f64 = -ATMOSPHERE_PA;

/// Coefficients of cavitation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cavitation<N: Number> {
    /// Pressure that a chamber does not fall below.
    pub(crate) floor: N,
    /// 1, as a slope.
    pub(crate) unity: N::Steep,
    pub(crate) unsprung: Unsprung<N>,
}

/// What a force does less on the mass that is matched to fewer springs of the oil, as a share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unsprung<N: Number> {
    /// Without that of A.
    pub(crate) a: N::Gain,
    /// Without that of B.
    pub(crate) b: N::Gain,
    /// Without both, beside these two.
    pub(crate) together: N::Gain,
}

/// Voids of both chambers, in units of [`Bases::void_m3`](crate::machine::Bases::void_m3).
pub type Voids<N> = ChamberState<<N as Number>::Travel>;

/// How far a chamber was full in a tick, and whether it emptied or filled in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing<N: Number> {
    crosses: N::Mask,
    /// Share of its stiffness.
    share: N,
}

/// Pressure of a chamber, what rounding left of it, and its void.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Content<N: Number> {
    pub(crate) pressure: N,
    pub(crate) rest: N,
    pub(crate) void: N::Travel,
}

impl<N: Number> Unsprung<N> {
    /// What a force does on the mass that is matched to chambers full by these shares, over what it does where both are full.
    fn share(&self, full: &Flows<N>) -> N {
        let (a, b) = (N::ONE - full.a, N::ONE - full.b);
        (N::ONE - N::dot([self.a, self.b, self.together], [a, b, a.times(b)])).min(N::ONE)
    }
}

impl<N: Number> Cavitation<N> {
    /// How far both chambers are full as a tick begins, 0 or 1; `None` where they are.
    fn full(voids: &Voids<N>) -> Option<Flows<N>> {
        let nothing = N::ZERO.as_travel();
        let (a, b) = (voids.a.above(nothing), voids.b.above(nothing));
        let full = |empty| N::pick(empty, N::ZERO, N::ONE);
        (a | b).any().then(|| Flows { a: full(a), b: full(b) })
    }

    /// Takes `net` oil into a chamber whose pressure it raises by `stiffness`.
    pub(crate) fn take(&self, stiffness: N::Gain, content: &mut Content<N>, net: N) -> Crossing<N> {
        let nothing = N::ZERO.as_travel();
        let empty = content.void.above(nothing);
        let start = content.pressure.max(self.floor);
        let raised = |by: N| start.accumulated(content.rest, [stiffness], [by]);
        let gap = N::pick(empty, N::of_sum(content.void), N::ZERO);
        let over = (net - gap).max(N::ZERO);
        let fills = empty & over.above(N::ZERO);
        let mut raising = N::pick(empty, over, net);
        let (mut pressure, mut rest) = raised(raising);
        let mut share = N::pick(empty, N::ZERO, N::ONE);
        if fills.any() {
            let part = N::share(over, [gap], [self.unity]);
            share = N::pick(fills, part.of(part), share);
        }
        let empties = self.floor.above(pressure);
        if empties.any() {
            let part = N::share(start - self.floor, [self.floor - pressure], [self.unity]);
            let left = N::ONE - part;
            share = N::pick(empties, N::ONE - left.of(left), share);
            // Less by the share's error: what rounds stays above the floor.
            let given = (part - N::ONE.over_power(25)).max(N::ZERO).of(net);
            let (at_floor, rest_there) = raised(given);
            pressure = N::pick(empties, at_floor, pressure);
            rest = N::pick(empties, rest_there, rest);
            raising = N::pick(empties, given, raising);
        }
        let void = N::summed(content.void, raising - net).larger(nothing);
        *content = Content { pressure, rest, void: N::Travel::pick(fills, nothing, void) };
        Crossing { crosses: fills | empties, share }
    }
}

impl<N: Number> Drive<N> {
    /// A tick of the links below the valve where chambers may cavitate.
    #[cold]
    #[inline(never)]
    pub(crate) fn step_cavitating<const DELAY: usize>(
        &self,
        cavitation: &Cavitation<N>,
        state: &mut DriveState<N, DELAY>,
        feed: &impl Feed<N>,
        load: Load<N>,
    ) -> Interfaces<N> {
        let &mut DriveState { chambers, rest, voids, motion, supply, .. } = state;
        let mut full = Cavitation::<N>::full(&voids);
        let mut again = true;
        loop {
            let left = full.as_ref().map(|full| {
                let share = cavitation.unsprung.share(full);
                (self.chambers.softened(*full), self.mechanics.heavier(share), share)
            });
            let chain = match &left {
                Some((chambers, mechanics, _)) => Chain { chambers, mechanics, ..self.chain() },
                None => self.chain(),
            };
            let mut seen = chain.step::<Effects, DELAY>(state, feed, load);
            seen.forces.around.sprung = left.map_or(N::ONE, |(_, _, share)| share);
            (state.chambers, state.rest, state.voids) = (chambers, rest, voids);
            let (pressures, rests) = (&mut state.chambers, &mut state.rest);
            let crossing = self.chambers.take(
                cavitation,
                pressures,
                rests,
                &mut state.voids,
                (seen.flows, seen.velocity, seen.position),
            );
            if !again || !(crossing.a.crosses | crossing.b.crosses).any() {
                return seen;
            }
            again = false;
            full = Some(Flows { a: crossing.a.share, b: crossing.b.share });
            (state.chambers, state.rest, state.voids) = (chambers, rest, voids);
            (state.motion, state.supply) = (motion, supply);
        }
    }
}
