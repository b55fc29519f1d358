//! Flow through the valve's edges.

use crate::tangent::Real;

/// The signed root of a pressure difference, with a finite slope at zero: `Δ/(Δ² + p_t²)^¼`, √Pa.
///
/// For |Δ| ≫ `p_t` it is sgn(Δ)·√|Δ| (3), (4); below `p_t` it is linear (laminar).
#[must_use]
pub(crate) fn signed_root<R: Real>(difference_pa: R, transition_pa: f64) -> R {
    difference_pa / (difference_pa * difference_pa + transition_pa * transition_pa).sqrt().sqrt()
}

/// A flow held within ± the limit, m³/s.
#[must_use]
pub(crate) fn limited<R: Real>(flow: R, limit_m3_per_s: f64) -> R {
    if flow.value() > limit_m3_per_s {
        limit_m3_per_s.into()
    } else if flow.value() < -limit_m3_per_s {
        (-limit_m3_per_s).into()
    } else {
        flow
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_odd_linear_at_zero_and_a_root_far_away() {
        assert!((signed_root(4.0e6, 2.0e3) - 2000.0).abs() < 1e-3);
        assert!((signed_root(-4.0e6, 2.0e3) + signed_root(4.0e6, 2.0e3)).abs() < 1e-12);
        assert!((signed_root(1.0, 2.0e3) - 1.0 / 2.0e3_f64.sqrt()).abs() < 1e-8);
    }
}
