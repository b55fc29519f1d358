//! Oil temperature: the oil warms, its viscosity falls, viscous friction with it, and leakage rises.
//!
//! f(t) = 1 − loss·(1 − e^(−t/τ)) since the state's start multiplies D and divides the leakage conductances.
//! How much of the warming is done is kept with 56 fractional bits, so that it does not stall at time constants of a day; its rate is
//! exact to 2e-4 at 1e5 s. The coefficients of the links are those of the thinnest oil that there will be.

use crate::number::Number;

/// Coefficients of the warming at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Warming<N: Number> {
    /// (1 − e^(−h/τ))/`share`
    pub(crate) rate: N::Gain,
    /// A small power of two.
    pub(crate) share: N,
    /// Magnitude of the loss.
    pub(crate) change: N,
    /// Whether the oil thins: its thinnest is then at the end, else at the start.
    pub(crate) thins: bool,
    /// 1 over the least factor.
    pub(crate) per_thinnest: N::Steep,
}

/// The oil in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Oil<N> {
    /// Viscosity above that of the thinnest, in shares of the one that the machine's values are for.
    pub(crate) excess: N,
    /// Viscosity of the thinnest over this one's, 0..1.
    pub(crate) thinness: N,
}

impl<N: Number> Warming<N> {
    /// The oil when `done` of the warming is done.
    #[inline]
    pub(crate) fn oil(&self, done: N::Travel) -> Oil<N> {
        let done = N::of_travel(done).max(N::ZERO).min(N::ONE);
        let excess = self.change.times(if self.thins { N::ONE - done } else { done });
        Oil { excess, thinness: N::inverse_one_plus([excess], [self.per_thinnest]) }
    }

    /// One tick more.
    #[inline]
    pub(crate) fn step(&self, done: &mut N::Travel) {
        let left = N::ONE - N::of_travel(*done);
        *done = N::travelled(*done, [self.rate], [left.times(self.share)]);
    }
}
