//! How the spool moves within a tick: by both lags of (16), or as a second-order system.
//!
//! ```text
//! l' = d + decay_1·(l − d) + back·(x − d)
//! x' = d + decay_2·(x − d) + cross·(l − d)
//! ```
//!
//! with d the set value that the tick holds. Lags: l is the output of the first, each decay is e^(−h/T), cross is T1/(T1 − T2) times their
//! difference, and back is 0. A second-order system, x″ = ω²·(d − x) − 2·ζ·ω·x′, has l = x + x′/ω, so that ζ = 1 is two equal lags of 1/ω. Then, with k = ω·h,
//! q = k²·(ζ² − 1), C = cosh √q and S = (sinh √q)/√q, both of which are smooth through q = 0:
//!
//! ```text
//! decay_1, decay_2 = e^(−ζk)·(C ± S·k·(1 − ζ))        cross = e^(−ζk)·S·k        back = −2·(1 − ζ)·cross
//! ```
//!
//! Both are exact for a held set value, whatever the tick. A delay of no whole number of ticks has an older set value for the first share ρ of a tick: lags
//! answer the mean. A second-order system, whose speed may then be limited, answers each when it is there: of G, the answer to a step at the tick's start, the
//! older value has the share 1 − G((1 − ρ)·h)/G(h), of l and of x.

use core::f64::consts::PI;

use super::Builder;
use crate::machine::Parameter as P;
use crate::number::Real;

/// The spool's motion over a tick.
pub(super) struct Lags<R> {
    /// l by l.
    pub(super) decay_1: R,
    /// x by x.
    pub(super) decay_2: R,
    /// x by l.
    pub(super) cross: R,
    /// `None` for lags.
    pub(super) swing: Option<Swing<R>>,
}

/// What a second-order system has besides.
pub(super) struct Swing<R> {
    /// l by x.
    pub(super) back: R,
    /// Of an older set value, which the tick begins with: its share in l and in x.
    pub(super) older: [R; 2],
}

impl<R: Real> Lags<R> {
    /// The part of a set value that arrives at the spool in a tick.
    pub(super) fn share(&self) -> R {
        R::ONE - self.decay_2 - self.cross
    }
}

impl<R: Real> Builder<'_, R> {
    /// The lags; `rest` is the share of a tick that begins with an older set value.
    pub(super) fn lags(&self, rest: R) -> Lags<R> {
        if self.get(P::NaturalFrequency).is_nil() {
            return self.two_lags();
        }
        let (whole, later) = (self.swung(R::ONE), self.swung(R::ONE - rest));
        let share = |whole: R, later: R| {
            let share = R::ONE - later / whole;
            // Within a tick as long as half a turn, G may already have come back.
            if share.value() < 0.0 { R::ZERO } else { share }
        };
        let [[l, x], [later_l, later_x]] = [whole.answers(), later.answers()];
        let older = [share(l, later_l), share(x, later_x)];
        let Swung { decay_1, decay_2, cross, back } = whole;
        Lags { decay_1, decay_2, cross, swing: Some(Swing { back, older }) }
    }

    /// ω·h
    pub(super) fn turn(&self) -> R {
        R::constant(2.0 * PI * self.tick_s) * self.get(P::NaturalFrequency)
    }

    fn two_lags(&self) -> Lags<R> {
        let (t1, t2) = (self.get(P::TimeConstant1), self.get(P::TimeConstant2));
        let (decay_1, decay_2) = (self.decay(t1), self.decay(t2));
        let apart = t1 - t2;
        let cross = if apart.value().abs() > 1e-6 * t1.value().max(t2.value()) {
            t1 * (decay_1 - decay_2) / apart
        } else if t1.value() > 0.0 {
            R::constant(self.tick_s) / t1 * decay_1
        } else {
            R::ZERO
        };
        Lags { decay_1, decay_2, cross, swing: None }
    }

    /// The second-order system after this part of a tick.
    fn swung(&self, part: R) -> Swung<R> {
        let (turn, damping) = (part * self.turn(), self.get(P::SpoolDamping));
        let fades = R::ONE - damping;
        let (c, s) = faded(damping * turn, turn * turn * (damping * damping - R::ONE));
        let cross = s * turn;
        Swung { decay_1: c + cross * fades, decay_2: c - cross * fades, cross, back: R::constant(-2.0) * fades * cross }
    }
}

/// A second-order system after some time.
struct Swung<R> {
    decay_1: R,
    decay_2: R,
    cross: R,
    back: R,
}

impl<R: Real> Swung<R> {
    /// l and x after a step.
    fn answers(&self) -> [R; 2] {
        [R::ONE - self.decay_1 - self.back, R::ONE - self.decay_2 - self.cross]
    }
}

/// Beyond this |q| the closed forms are used: below it they lose digits, and the series needs few terms.
const SERIES_WITHIN: f64 = 1.0;

/// e^(−a)·cosh √q and e^(−a)·(sinh √q)/√q, for q ≤ a² of either sign.
fn faded<R: Real>(a: R, q: R) -> (R, R) {
    let half = R::constant(0.5);
    if q.value() > SERIES_WITHIN {
        let root = q.sqrt();
        let (slow, fast) = ((root - a).exp(), (-(root + a)).exp());
        return (half * (slow + fast), half * (slow - fast) / root);
    }
    let fades = (-a).exp();
    if q.value() < -SERIES_WITHIN {
        let root = (-q).sqrt();
        let sine = (root - R::constant(0.5 * PI)).cos();
        return (fades * root.cos(), fades * sine / root);
    }
    // Σ qⁿ/(2n)! and Σ qⁿ/(2n + 1)!, by Horner; the next term is below 1e-14.
    let mut even = R::ONE;
    let mut odd = R::ONE;
    for n in (1..=8_u32).rev() {
        let twice = f64::from(2 * n);
        even = R::ONE + q * even / R::constant((twice - 1.0) * twice);
        odd = R::ONE + q * odd / R::constant(twice * (twice + 1.0));
    }
    (fades * even, fades * odd)
}
