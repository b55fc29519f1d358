//! Dual numbers: a value and its derivatives with respect to as many parameters as `B` vectors of the processor can hold.
//!
//! The value equals an f64 run to the last bit; the derivatives are in single precision, which is always enough for a
//! search and halves their cost.
//!
//! On them the core's own equations give the sensitivities that identification needs (forward mode), so these cannot
//! deviate from what the controller computes. Comparisons use the value only.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use model_core::number::{Field, Real};
use wide::f32x8;

/// Derivatives in one vector.
pub const BLOCK: usize = 8;

/// A value with `B` vectors of partial derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Dual<const B: usize> {
    /// The value.
    pub value: f64,
    partials: [f32x8; B],
}

impl<const B: usize> Dual<B> {
    /// A parameter's value with coordinate `index`: `slope` = ∂value/∂θᵢ.
    ///
    /// # Panics
    /// Without a slot for it.
    #[must_use]
    pub fn variable(value: f64, index: usize, slope: f64) -> Self {
        let mut variable = Self::constant_of(value);
        bytemuck::must_cast_slice_mut(&mut variable.partials)[index] = single(slope);
        variable
    }

    /// Every ∂value/∂θᵢ.
    #[must_use]
    pub fn partials(&self) -> &[f32] {
        bytemuck::must_cast_slice(&self.partials)
    }

    /// A value that depends on no parameter.
    #[must_use]
    pub const fn constant_of(value: f64) -> Self {
        Self { value, partials: [f32x8::ZERO; B] }
    }

    /// f(self), from its value and derivative.
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        let slope = f32x8::splat(single(slope));
        Self { value, partials: self.partials.map(|partial| partial * slope) }
    }

    /// Weighted sum of the partial derivatives of two duals.
    #[inline(always)]
    fn combine(value: f64, a: &Self, weight_a: f64, b: &Self, weight_b: f64) -> Self {
        let (weight_a, weight_b) = (f32x8::splat(single(weight_a)), f32x8::splat(single(weight_b)));
        Self { value, partials: std::array::from_fn(|i| a.partials[i] * weight_a + b.partials[i] * weight_b) }
    }
}

/// A derivative below this is set to 0.
///
/// Once nothing moves, the derivative of a state decays for ever. Below 1.2e-38 it would be subnormal, and processors
/// take a hundred cycles for each product of such numbers.
const NONE_BELOW: f32 = 1e-30;

/// A derivative in single precision.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "derivatives are single precision")]
pub fn single(slope: f64) -> f32 {
    slope as f32
}

impl<const B: usize> PartialEq for Dual<B> {
    #[inline(always)]
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<const B: usize> PartialOrd for Dual<B> {
    #[inline(always)]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl<const B: usize> Add for Dual<B> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            partials: std::array::from_fn(|i| self.partials[i] + other.partials[i]),
        }
    }
}

impl<const B: usize> Sub for Dual<B> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            partials: std::array::from_fn(|i| self.partials[i] - other.partials[i]),
        }
    }
}

impl<const B: usize> Mul for Dual<B> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::combine(self.value * other.value, &self, other.value, &other, self.value)
    }
}

impl<const B: usize> Div for Dual<B> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // Not by the inverse: the value must equal an f64 run to the last bit.
        let value = self.value / other.value;
        let inverse = 1.0 / other.value;
        Self::combine(value, &self, inverse, &other, -value * inverse)
    }
}

impl<const B: usize> Neg for Dual<B> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const B: usize> Field for Dual<B> {
    type Real = Self;

    const ZERO: Self = Self::constant_of(0.0);
    const ONE: Self = Self::constant_of(1.0);

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::constant_of(value)
    }
    #[inline(always)]
    fn coefficient(value: Self) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }
    #[inline(always)]
    fn vanishes(self) -> bool {
        self.is_nil()
    }
    #[inline(always)]
    fn noted(self) -> Self {
        let noted = |slope: f32x8| !slope.abs().simd_lt(f32x8::splat(NONE_BELOW)) & slope;
        Self { partials: self.partials.map(noted), ..self }
    }
}

impl<const B: usize> Real for Dual<B> {
    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
    fn is_nil(self) -> bool {
        self.value == 0.0 && self.partials.iter().all(|partials| partials.simd_eq(f32x8::ZERO).all())
    }
    fn exp(self) -> Self {
        let value = Real::exp(self.value);
        self.chain(value, value)
    }
    fn cos(self) -> Self {
        self.chain(Real::cos(self.value), -libm::sin(self.value))
    }
    fn acos(self) -> Self {
        self.chain(Real::acos(self.value), -1.0 / (1.0 - self.value * self.value).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use model_core::number::Number;

    use super::*;

    #[test]
    fn a_derivative_that_fades_is_none_before_it_is_subnormal() {
        let decay = Dual::<1>::constant_of(0.5);
        let mut fading = Dual::<1>::variable(1.0, 0, 1.0);
        for _ in 0..200 {
            fading = fading.part(decay);
            assert!(fading.partials().iter().all(|slope| *slope == 0.0 || slope.is_normal()), "{fading:?}");
        }
        assert!(fading.value > 0.0 && fading.partials().iter().all(|slope| *slope == 0.0), "{fading:?}");
    }

    #[test]
    fn derivative_of_a_quotient_of_roots_and_exponentials() {
        let f = |x: Dual<1>| x.sqrt() / (x.exp() + x * x) - x;
        let (at, h) = (0.7, 1e-6);
        let plain = |x: f64| x.sqrt() / (x.exp() + x * x) - x;
        let expected = (plain(at + h) - plain(at - h)) / (2.0 * h);
        let dual = f(Dual::variable(at, 0, 1.0));
        assert!((dual.value - plain(at)).abs() < 1e-15);
        assert!((f64::from(dual.partials()[0]) - expected).abs() < 1e-6, "{} {expected}", dual.partials()[0]);
    }
}
