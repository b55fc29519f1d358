//! The limit above which an average is no longer attributed to chance.
//!
//! The limit h follows from how often a false alarm may come. For independent normal innovations, E exp(θ·s) is the product of
//! 1/√(1 − 2θ·wᵢ) over the weights wᵢ = λ·(1 − λ)ⁱ, and with x = 2θλ Chernoff's bound gives for any 0 < x < 1
//!
//! ```text
//! P(s > h) ≤ exp(Λ − θ·h)     Λ = Li₂(x)/(2·|ln(1 − λ)|) − ½·ln(1 − x)     h = min over x of (Λ + ln 1/p)·2λ/x
//! ```
//!
//! An alarm in a tick needs s > h in that tick, so alarms come no more often than p per tick, on average; with four signals each gets
//! a quarter of that rate. The bound is conservative; the monitor's test shows the actual rate. Innovations that are correlated in time are
//! worth fewer independent ones: with ρ from tick to tick, and q = ρ²·(1 − λ), the memory holds (1 − q)/(1 + q) times as many, and λ in
//! the bound is larger by the inverse of that factor.

/// λ for independent innovations that is worth the same as `share` for innovations that are correlated over so many ticks.
pub(super) fn effective(share: f64, correlation_ticks: f64) -> f64 {
    let squared = if correlation_ticks > 0.0 { libm::exp(-2.0 / correlation_ticks) } else { 0.0 };
    let alike = squared * (1.0 - share);
    (share * (1.0 + alike) / (1.0 - alike)).min(0.99)
}

/// h, by Chernoff's bound.
pub(super) fn limit(share: f64, chance: f64) -> f64 {
    const STEPS: u32 = 400;
    let held = |x: f64| {
        let exponent = dilogarithm(x) / (-2.0 * libm::log1p(-share)) - 0.5 * libm::log1p(-x);
        (exponent - libm::log(chance)) * 2.0 * share / x
    };
    (1..STEPS).map(|k| held(f64::from(k) / f64::from(STEPS))).fold(f64::INFINITY, f64::min)
}

/// Li₂(x) for 0 < x < 1, to 1e-8: Σ xᵏ/k²; for x beyond a half, from 1 − x by Euler's reflection.
fn dilogarithm(x: f64) -> f64 {
    const AT_ONE: f64 = core::f64::consts::PI * core::f64::consts::PI / 6.0;
    if x > 0.5 {
        return AT_ONE - libm::log(x) * libm::log1p(-x) - dilogarithm(1.0 - x);
    }
    let (mut sum, mut power) = (0.0, 1.0);
    for k in 1..=24_u32 {
        power *= x;
        sum += power / f64::from(k * k);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dilogarithm_has_its_known_values() {
        let half = core::f64::consts::PI.powi(2) / 12.0 - 0.5 * core::f64::consts::LN_2.powi(2);
        assert!((dilogarithm(0.5) - half).abs() < 1e-8);
        assert!((dilogarithm(0.999_999) - core::f64::consts::PI.powi(2) / 6.0).abs() < 2e-5);
    }
}
