//! The valve's overlap and how a loop steps over it.
//!
//! A loop uses a coordinate w for the spool, in which the overlap is only `kept` wide. The map to the spool is monotone and
//! piecewise linear, and its inverse is exact except for rounding:
//!
//! ```text
//! x = w·overlap/kept            |w| ≤ kept      the overlap, crossed fast
//! x = w ± (overlap − kept)      beyond          open: one for one
//! ```
//!
//! So the spool jumps over nearly all of its overlap, as in I. Lee, D. Oh, S. Ji, S. Yun: *Control of an overlap-type proportional
//! directional control valve using input shaping filter*, Mechatronics 29 (2015), and within the kept part small corrections of
//! either sign pass no oil at all, instead of chattering from edge to edge.

use crate::number::Scalar;

/// Half of the overlap, to either side of its middle, and what is kept of it; spool travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Overlap<N: Scalar> {
    pub(super) whole: N,
    pub(super) kept: N,
    /// overlap / kept; 1 without overlap.
    pub(super) spread: N::Steep,
    /// kept / overlap; 1 without overlap.
    pub(super) shrunk: N::Steep,
}

impl<N: Scalar> Overlap<N> {
    /// From the loop's coordinate to the spool, from the overlap's middle.
    #[inline]
    pub(super) fn spool(&self, w: N) -> N {
        let inside = w.limited(self.kept);
        if inside == w { w.amplified(self.spread).limited(self.whole) } else { w - inside + signed(self.whole, w) }
    }

    /// From the spool to the loop's coordinate.
    #[inline]
    pub(super) fn coordinate(&self, spool: N) -> N {
        let inside = spool.limited(self.whole);
        if inside == spool { spool.amplified(self.shrunk) } else { spool - inside + signed(self.kept, spool) }
    }

    /// Opening at a coordinate.
    #[inline]
    pub(super) fn opening(&self, w: N) -> N {
        w - w.limited(self.kept)
    }

    /// Coordinate of an opening: the kept part of the overlap is crossed while the opening grows by the same amount.
    #[inline]
    pub(super) fn opened(&self, opening: N) -> N {
        opening + opening.limited(self.kept)
    }
}

/// `magnitude` with the sign of `of`.
#[inline]
pub(super) fn signed<N: Scalar>(magnitude: N, of: N) -> N {
    of.select_positive(magnitude, -magnitude)
}

#[cfg(test)]
mod tests {
    use fixed::types::U16F16;
    use proptest::prelude::*;

    use super::*;
    use crate::number::{Number, PerUnit};

    fn overlap() -> Overlap<PerUnit> {
        Overlap {
            whole: PerUnit::saturated(0.1),
            kept: PerUnit::saturated(0.01),
            spread: U16F16::from_num(10),
            shrunk: U16F16::from_num(0.1),
        }
    }

    #[test]
    fn the_edge_of_what_is_kept_is_the_edge_of_the_overlap() {
        let found = overlap().spool(PerUnit::saturated(0.01)).to_f64();
        assert!((found - 0.1).abs() < 1e-6);
        assert!((overlap().spool(PerUnit::saturated(-0.03)).to_f64() + 0.12).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn the_way_back_leads_where_it_came_from(bits in -(1_i32 << 29)..1 << 29, small in 0_u32..20) {
            let w = PerUnit::from_bits(bits >> small);
            let back = overlap().coordinate(overlap().spool(w));
            // A step of 1.5e-5 in the ratio, of a coordinate of at most 0.01.
            prop_assert!((back - w).magnitude().to_f64() < 3e-6, "{w:?} {back:?}");
        }

        #[test]
        fn the_spool_never_falls_as_the_coordinate_rises(bits in -(1_i32 << 27)..1 << 27, more in 0_i32..1 << 20) {
            let (w, beyond) = (PerUnit::from_bits(bits), PerUnit::from_bits(bits + more));
            prop_assert!(overlap().spool(beyond) >= overlap().spool(w));
        }
    }
}
