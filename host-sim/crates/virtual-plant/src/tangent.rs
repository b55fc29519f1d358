//! A number that carries its derivative along one direction: it gives the plant's exact Jacobian without further code.
//!
//! The plant's equations are written once over [`Real`]. Evaluated with `f64` they give the
//! derivatives of the state; evaluated with [`Tangent`] they give, beside them, the product of the
//! Jacobian with a direction, which the implicit solver needs.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The operations that the plant's equations need.
pub(crate) trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + From<f64>
{
    /// The number without its derivative: for decisions (which side, which branch).
    fn value(self) -> f64;
    /// Square root; the argument is positive.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Absolute value; its derivative at zero is taken as +1.
    #[must_use]
    fn abs(self) -> Self;
    /// The exponential.
    #[must_use]
    fn exp(self) -> Self;
    /// The natural logarithm; the argument is positive.
    #[must_use]
    fn ln(self) -> Self;
    /// The sine, of radians.
    #[must_use]
    fn sin(self) -> Self;
    /// A power; the base is positive.
    #[must_use]
    fn powf(self, exponent: f64) -> Self {
        (self.ln() * exponent).exp()
    }
    /// The larger of the number and a bound.
    #[must_use]
    fn at_least(self, bound: f64) -> Self {
        if self.value() < bound { bound.into() } else { self }
    }
    /// The smaller of the number and a bound.
    #[must_use]
    fn at_most(self, bound: f64) -> Self {
        if self.value() > bound { bound.into() } else { self }
    }
}

impl Real for f64 {
    fn value(self) -> f64 {
        self
    }
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    fn abs(self) -> Self {
        f64::abs(self)
    }
    fn exp(self) -> Self {
        libm::exp(self)
    }
    fn ln(self) -> Self {
        libm::log(self)
    }
    fn sin(self) -> Self {
        libm::sin(self)
    }
}

/// A value and its derivative along the chosen direction (forward-mode dual number).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tangent {
    /// The value, as `f64` arithmetic would give it.
    pub(crate) value: f64,
    /// The derivative of the value along the direction.
    pub(crate) slope: f64,
}

impl Tangent {
    /// A variable with its component in the direction.
    #[must_use]
    pub(crate) const fn new(value: f64, slope: f64) -> Self {
        Self { value, slope }
    }
}

impl From<f64> for Tangent {
    fn from(value: f64) -> Self {
        Self::new(value, 0.0)
    }
}

impl Real for Tangent {
    fn value(self) -> f64 {
        self.value
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        Self::new(root, 0.5 * self.slope / root)
    }
    fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }
    fn exp(self) -> Self {
        let value = libm::exp(self.value);
        Self::new(value, value * self.slope)
    }
    fn ln(self) -> Self {
        Self::new(libm::log(self.value), self.slope / self.value)
    }
    fn sin(self) -> Self {
        Self::new(libm::sin(self.value), self.slope * libm::cos(self.value))
    }
}

impl Neg for Tangent {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.value, -self.slope)
    }
}

impl Add for Tangent {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.slope + other.slope)
    }
}

impl Sub for Tangent {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.value - other.value, self.slope - other.slope)
    }
}

impl Mul for Tangent {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::new(self.value * other.value, self.slope * other.value + self.value * other.slope)
    }
}

impl Div for Tangent {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self::new(value, (self.slope - value * other.slope) / other.value)
    }
}

impl Add<f64> for Tangent {
    type Output = Self;
    fn add(self, other: f64) -> Self {
        Self::new(self.value + other, self.slope)
    }
}

impl Sub<f64> for Tangent {
    type Output = Self;
    fn sub(self, other: f64) -> Self {
        Self::new(self.value - other, self.slope)
    }
}

impl Mul<f64> for Tangent {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        Self::new(self.value * other, self.slope * other)
    }
}

impl Div<f64> for Tangent {
    type Output = Self;
    fn div(self, other: f64) -> Self {
        Self::new(self.value / other, self.slope / other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formula<R: Real>(x: R) -> R {
        (x * x + 3.0).sqrt() / (x - 0.5) - (-x).abs() * 2.0
            + (x * x + 1.0).powf(0.7)
            + (x * x).at_least(0.1)
            + (x * 2.0).sin()
    }

    #[test]
    fn slope_agrees_with_a_central_difference() {
        for x in [-2.0, 0.1, 1.7] {
            let step = 1e-6;
            let difference = (formula(x + step) - formula(x - step)) / (2.0 * step);
            let tangent = formula(Tangent::new(x, 1.0));
            assert!((tangent.value - formula(x)).abs() < 1e-15);
            assert!((tangent.slope - difference).abs() < 1e-7 * (1.0 + difference.abs()), "{x}");
        }
    }
}
