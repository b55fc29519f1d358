//! Cavitation: oil cannot pull. When more oil is drawn from a chamber than the fall of its pressure gives, the pressure stays at a floor, that
//! of the oil's vapour or of the air that comes out of it, while a void grows; the pressure rises again once the void is filled.
//!
//! ```text
//! net oil n of a tick:   Δw = m − n,   Δp = c·m,   w ≥ 0,   p ≥ floor,   w·(p − floor) = 0
//! ```
//!
//! with w the void, in ticks of flow 1, and m the part of the oil that raises the pressure. Nothing of w is rounded: together with the rounding
//! remainder of the pressure, oil is conserved to the bit.
//!
//! How a tick in which a chamber empties or fills is stepped: `drive/cavitating.rs`.
//!
//! The rod's mass is matched to the springs of the oil (`coefficients`), and an empty chamber is no spring. Everything else on the mass's diagonal
//! (a stop, bristles, thickened oil) grows with the mass in such a tick, by 5 % at most.
//!
//! Source: Merritt, *Hydraulic Control Systems*, 1967, 5.5 (a valve's cavity under an overrunning load).

use crate::number::{Compared, Mask, Number};
use crate::ports::{ChamberState, Flows};

/// Coefficients of cavitation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Cavitation<N: Number> {
    /// Lowest pressure of a chamber.
    pub floor: N,
    /// 1, as a slope.
    pub unity: N::Steep,
    pub unsprung: Unsprung<N>,
}

/// By which share a force has less effect on the mass that is matched to fewer oil springs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Unsprung<N: Number> {
    /// Without the spring of A.
    pub a: N::Gain,
    /// Without the spring of B.
    pub b: N::Gain,
    /// Without both, in addition to these two.
    pub together: N::Gain,
}

/// Voids of both chambers, in units of [`Bases::void_m3`](crate::machine::Bases::void_m3).
pub type Voids<N> = ChamberState<<N as Number>::Travel>;

/// How far a chamber was full in a tick, and whether it emptied or filled in that tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing<N: Number> {
    pub(crate) crosses: N::Mask,
    /// Share of its stiffness.
    pub(crate) share: N,
}

/// Pressure of a chamber, its rounding remainder, and its void.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Content<N: Number> {
    pub(crate) pressure: N,
    pub(crate) rest: N,
    pub(crate) void: N::Travel,
}

impl<N: Number> Unsprung<N> {
    /// Effect of a force on the mass that is matched to chambers full by these shares, over its effect where both are full.
    pub(crate) fn share(&self, full: &Flows<N>) -> N {
        let (a, b) = (N::ONE - full.a, N::ONE - full.b);
        (N::ONE - N::dot([self.a, self.b, self.together], [a, b, a.times(b)])).min(N::ONE)
    }
}

impl<N: Number> Cavitation<N> {
    /// How far both chambers are full as a tick begins, 0 or 1; `None` where both are full.
    pub(crate) fn full(voids: &Voids<N>) -> Option<Flows<N>> {
        let nothing = N::ZERO.as_travel();
        let (a, b) = (voids.a.above(nothing), voids.b.above(nothing));
        let full = |empty| N::pick(empty, N::ZERO, N::ONE);
        (a | b).any().then(|| Flows { a: full(a), b: full(b) })
    }

    /// Takes `net` oil into a chamber whose pressure rises by `stiffness` per net oil.
    pub(crate) fn take(&self, stiffness: N::Gain, content: &mut Content<N>, net: N) -> Crossing<N> {
        let nothing = N::ZERO.as_travel();
        let empty = content.void.above(nothing);
        let start = content.pressure.max(self.floor);
        let raised = |by: N| start.accumulated(content.rest, [stiffness], [by]);
        if !empty.any() {
            let (pressure, rest) = raised(net);
            if !self.floor.above(pressure).any() {
                (content.pressure, content.rest) = (pressure, rest);
                return Crossing { crosses: N::Mask::NONE, share: N::ONE };
            }
        }
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
            // All times a quarter, as the whole may leave the format. Less by a few steps and the share's error, to stay above the floor.
            let would_fall = -N::dot([stiffness], [net.over_power(2)]);
            let falls = (start - self.floor - N::ONE.over_power(26)).max(N::ZERO).over_power(2);
            let part = N::share(falls, [would_fall - falls], [self.unity]);
            let left = N::ONE - part;
            share = N::pick(empties, N::ONE - left.of(left), share);
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

#[cfg(test)]
mod tests {
    use fixed::types::{I4F28, I8F56};
    use proptest::prelude::*;

    use super::*;
    use crate::number::{PerUnit, Single};

    fn law<N: Number<Real = f64>>(floor: f64) -> Cavitation<N> {
        let none = N::gain(0.0).unwrap();
        Cavitation {
            floor: N::saturated(floor),
            unity: N::steep(1.0).unwrap(),
            unsprung: Unsprung { a: none, b: none, together: none },
        }
    }

    /// A chamber at 0.1 over a floor of 0 that rises by 0.5 per net oil.
    #[test]
    fn a_chamber_gives_what_its_pressure_has_then_a_void_and_rises_once_that_is_filled() {
        fn check<N: crate::number::Scalar<Real = f64>>() {
            let law = law::<N>(0.0);
            let stiffness = N::gain(0.5).unwrap();
            let mut chamber = Content { pressure: N::saturated(0.1), rest: N::ZERO, void: N::ZERO.as_travel() };
            let mut take = |net: f64| {
                let crossing = law.take(stiffness, &mut chamber, N::saturated(net));
                (crossing.crosses, crossing.share.to_f64(), chamber.pressure.to_f64(), N::of_sum(chamber.void).to_f64())
            };
            // The pressure gives 0.2 of 1.0 in the first fifth of the tick, the void 0.8; then 0.3 leaves a void of 0.5; filled, the pressure is 0.1.
            for (net, crosses, share, pressure, void) in [
                (-1.0, true, 1.0 - 0.8 * 0.8, 0.0, 0.8),
                (0.3, false, 0.0, 0.0, 0.5),
                (-0.1, false, 0.0, 0.0, 0.6),
                (0.8, true, 0.25 * 0.25, 0.1, 0.0),
                (0.2, false, 1.0, 0.2, 0.0),
            ] {
                let found = take(net);
                assert_eq!(found.0, crosses, "{net}");
                for (found, expected) in [(found.1, share), (found.2, pressure), (found.3, void)] {
                    assert!((found - expected).abs() < 2e-7, "{net}: {found} {expected}");
                }
            }
        }
        check::<PerUnit>();
        check::<Single>();
        check::<f64>();
    }

    fn word() -> impl Strategy<Value = i32> {
        prop_oneof![4 => (any::<i32>(), 0_u32..31).prop_map(|(bits, less)| bits >> less), 1 => prop::sample::select(&[i32::MIN, i32::MAX][..])]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5000))]

        /// pressure·2²⁸ + rest changes by gain times the oil that raises it; this oil less the void's change is the oil taken in: to the last bit.
        #[test]
        fn no_oil_is_lost_and_no_pressure_is_below_the_floor(
            gain in 1_i32..1 << 30, less in 0_u32..28, floor in -(1_i32 << 28)..1_i32 << 28, above in 0_i32..1 << 28,
            nets in prop::collection::vec((any::<i32>(), 3_u32..31), 1..100),
        ) {
            let law = Cavitation { floor: PerUnit::from_bits(floor), ..law(0.0) };
            let gain = I4F28::from_bits((gain >> less).max(1));
            let start = PerUnit::from_bits(floor.saturating_add(above));
            let mut chamber = Content { pressure: start, rest: PerUnit::ZERO, void: I8F56::ZERO };
            let account = |chamber: &Content<PerUnit>| i128::from(chamber.pressure.to_bits()) << 28;
            for (bits, less) in nets {
                let net = PerUnit::from_bits(bits >> less);
                let before = chamber;
                let crossing = law.take(gain, &mut chamber, net);
                prop_assert!(chamber.pressure >= law.floor);
                prop_assert!(chamber.void >= I8F56::ZERO);
                prop_assert!(PerUnit::ZERO <= crossing.share && crossing.share <= PerUnit::ONE);
                let void = |content: &Content<PerUnit>| i128::from(content.void.to_bits() >> 14);
                let raising = i128::from(net.to_bits()) + void(&chamber) - void(&before);
                let oil = |content: &Content<PerUnit>| account(content) + i128::from(content.rest.to_bits());
                // A pressure that is held at the end of the format does not count.
                if !chamber.pressure.is_held() {
                    prop_assert_eq!(oil(&chamber) - oil(&before), i128::from(gain.to_bits()) * raising);
                }
                if before.void > I8F56::ZERO && chamber.void > I8F56::ZERO {
                    prop_assert_eq!((chamber.pressure, chamber.rest, crossing.crosses), (before.pressure, before.rest, false));
                }
            }
        }

        #[test]
        fn no_content_overflows(
            words in prop::array::uniform4(word()), void in 0..=i64::MAX, gain in 1_i32..1 << 30,
        ) {
            let [floor, pressure, rest, net] = words.map(PerUnit::from_bits);
            let rest = rest.over_power(4);
            let law = Cavitation { floor, ..law(0.0) };
            let mut chamber = Content { pressure, rest, void: I8F56::from_bits(void) };
            law.take(I4F28::from_bits(gain), &mut chamber, net);
            prop_assert!(chamber.pressure >= floor && chamber.void >= I8F56::ZERO);
        }
    }
}
