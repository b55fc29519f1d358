//! The sensing link: counts → spool, and encoder counts ↔ cylinder length through the linkage triangle. §2, §3 of the paper.
//!
//! The cylinder is the third side of a triangle with the joint at one corner: L² = a² + b² − 2ab·cos θ. Cosine and its
//! inverse are evaluated once, when the linkage is built, at Chebyshev nodes over the stroke; a step sums the series by
//! Clenshaw's recurrence. No trigonometry and no float runs on the controller, and the same code runs on every number type.

#![expect(
    clippy::float_arithmetic,
    reason = "series are built once, before a run; the evaluations use the number type only"
)]

use core::f64::consts::PI;

use crate::machine::{Machine, MachineError, Parameter as P};
use crate::number::{Field, Number, Real, Scalar};

/// Terms of a series.
const TERMS: usize = 10;

/// Largest error of the series over the stroke, in strokes (position) or turns (angle).
pub const SERIES_TOLERANCE: f64 = 1e-5;

/// The spool's LVDT.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lvdt<N: Number> {
    scale: N::Steep,
}

impl<N: Number<Real = f64>> Lvdt<N> {
    /// From `sensing.lvdt_counts_per_unit`.
    ///
    /// # Errors
    /// The scale does not fit.
    pub fn new(machine: &Machine<f64>) -> Result<Self, MachineError> {
        let counts = machine.get(P::LvdtCounts);
        Ok(Self { scale: count_scale::<N>(P::LvdtCounts, counts, 1.0 / counts)? })
    }

    /// Spool position from counts; 1 is full travel.
    #[must_use]
    pub fn spool(&self, counts: i32) -> N {
        N::counted(counts).amplified(self.scale)
    }
}

/// Encoder on the joint and the triangle around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linkage<N: Number> {
    /// Counts to −1..1 over the stroke.
    scale: N::Steep,
    /// Count at the middle.
    middle: i32,
    /// Position in strokes over the scaled angle.
    position: [N; TERMS],
    /// Scaled angle over the position scaled to −1..1.
    angle: [N; TERMS],
    /// Counts at scaled angle 1, from the middle.
    half_range_counts: f64,
}

/// Why there is no linkage.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LinkageError {
    /// The three sides do not close over the whole stroke.
    #[error(
        "linkage: sides {base_m} m, {arm_m} m and {length_m} m make no triangle; expected each shorter than the other two together"
    )]
    NoTriangle {
        /// Joint to the cylinder's foot.
        base_m: f64,
        /// Joint to the rod's eye.
        arm_m: f64,
        /// Length of the cylinder at one end of its stroke.
        length_m: f64,
    },
    /// Near a stretched triangle the angle gives little information about the length.
    #[error(
        "linkage: the series misses by {error:.2e} of the stroke; expected at most {SERIES_TOLERANCE:e}: the triangle is nearly stretched"
    )]
    NearlyStretched {
        /// Largest error, in strokes.
        error: f64,
    },
    /// A scale does not fit.
    #[error(transparent)]
    Machine(#[from] MachineError),
}

impl<N: Scalar<Real = f64>> Linkage<N> {
    /// From `[linkage]`, `sensing.encoder_counts_per_rev` and the stroke.
    ///
    /// # Errors
    /// The sides make no triangle, or one too flat to measure with.
    pub fn new(machine: &Machine<f64>) -> Result<Self, LinkageError> {
        let triangle = Triangle::of(machine);
        let (first, last) = (triangle.angle_rad(0.0)?, triangle.angle_rad(1.0)?);
        let per_rad = machine.get(P::EncoderCounts) / (2.0 * PI);
        let middle_rad = f64::midpoint(first, last);
        let middle = libm::round((middle_rad - triangle.angle_at_zero_rad) * per_rad);
        let middle_rad = middle / per_rad + triangle.angle_at_zero_rad;
        // A little wider than the stroke, so that a count beyond either end is still measured.
        let half_range_rad = 0.505 * libm::fabs(last - first) + 1.0 / per_rad;
        let position = |scaled: f64| triangle.position(middle_rad + scaled * half_range_rad);
        let angle = |scaled: f64| {
            triangle.angle_rad(f64::midpoint(1.0, scaled)).map(|angle| (angle - middle_rad) / half_range_rad)
        };
        let mut angles = [0.0; TERMS];
        for (index, value) in angles.iter_mut().enumerate() {
            *value = angle(node(index))?;
        }
        let linkage = Self {
            scale: count_scale::<N>(P::EncoderCounts, per_rad, 1.0 / (half_range_rad * per_rad))?,
            #[expect(clippy::cast_possible_truncation, reason = "a few turns of an encoder")]
            middle: middle as i32,
            position: series(core::array::from_fn(|index| position(node(index)))).map(N::saturated),
            angle: series(angles).map(N::saturated),
            half_range_counts: half_range_rad * per_rad,
        };
        let error = (0..=64).map(|step| {
            let scaled = f64::from(step) / 32.0 - 1.0;
            let there = libm::fabs(clenshaw(&linkage.position, N::saturated(scaled)).to_f64() - position(scaled));
            let back = angle(scaled)
                .map_or(0.0, |angle| libm::fabs(clenshaw(&linkage.angle, N::saturated(scaled)).to_f64() - angle));
            there.max(back)
        });
        let error = error.fold(0.0, f64::max);
        if error <= SERIES_TOLERANCE { Ok(linkage) } else { Err(LinkageError::NearlyStretched { error }) }
    }

    /// Position in strokes from the encoder's count.
    #[must_use]
    pub fn position(&self, counts: i32) -> N {
        let scaled = N::counted(counts.saturating_sub(self.middle)).amplified(self.scale);
        clenshaw(&self.position, scaled.limited(N::ONE))
    }

    /// The encoder's count, not yet rounded to whole counts, from a position in strokes.
    #[must_use]
    pub fn counts(&self, position: N) -> f64 {
        let scaled = clenshaw(&self.angle, (position + position - N::ONE).limited(N::ONE));
        scaled.to_f64() * self.half_range_counts + f64::from(self.middle)
    }
}

/// Scale from `N::counted` (in units of 65536 counts) to a unit of which a count is `per_count`.
fn count_scale<N: Number<Real = f64>>(parameter: P, value: f64, per_count: f64) -> Result<N::Steep, MachineError> {
    let scaled = 65536.0 * per_count;
    N::steep(scaled).ok_or(MachineError::DoesNotFit { parameter, value, coefficient: "counts", scaled, limit: 65536.0 })
}

struct Triangle {
    base_m: f64,
    arm_m: f64,
    retracted_m: f64,
    stroke_m: f64,
    angle_at_zero_rad: f64,
}

impl Triangle {
    fn of(machine: &Machine<f64>) -> Self {
        Self {
            base_m: machine.get(P::LinkageBase),
            arm_m: machine.get(P::LinkageArm),
            retracted_m: machine.get(P::LinkageLengthRetracted),
            stroke_m: machine.get(P::Stroke),
            angle_at_zero_rad: machine.get(P::LinkageAngleAtZero),
        }
    }

    /// Angle at the joint for a position in strokes, by the law of cosines.
    fn angle_rad(&self, strokes: f64) -> Result<f64, LinkageError> {
        let length_m = self.retracted_m + strokes * self.stroke_m;
        let (base_m, arm_m) = (self.base_m, self.arm_m);
        let cosine = (base_m * base_m + arm_m * arm_m - length_m * length_m) / (2.0 * base_m * arm_m);
        if cosine > -1.0 && cosine < 1.0 {
            Ok(Real::acos(cosine))
        } else {
            Err(LinkageError::NoTriangle { base_m, arm_m, length_m })
        }
    }

    /// Position in strokes for an angle at the joint.
    fn position(&self, angle_rad: f64) -> f64 {
        let (base_m, arm_m) = (self.base_m, self.arm_m);
        let square = base_m * base_m + arm_m * arm_m - 2.0 * base_m * arm_m * Real::cos(angle_rad);
        (Field::sqrt(square.max(0.0)) - self.retracted_m) / self.stroke_m
    }
}

/// Chebyshev node.
fn node(index: usize) -> f64 {
    Real::cos(PI * (index as f64 + 0.5) / TERMS as f64)
}

/// Coefficients of the Chebyshev series through values at the nodes; the first is halved already.
fn series(values: [f64; TERMS]) -> [f64; TERMS] {
    core::array::from_fn(|order| {
        let sum = values
            .iter()
            .enumerate()
            .map(|(index, value)| value * Real::cos(PI * order as f64 * (index as f64 + 0.5) / TERMS as f64));
        let share = if order == 0 { 1.0 } else { 2.0 };
        sum.sum::<f64>() * share / TERMS as f64
    })
}

/// The series at `at` in −1..1.
fn clenshaw<N: Number>(series: &[N; TERMS], at: N) -> N {
    let [first, rest @ ..] = series;
    let (mut next, mut after) = (N::ZERO, N::ZERO);
    for &term in rest.iter().rev() {
        let product = at.times(next);
        (next, after) = (term + product + product - after, next);
    }
    *first + at.times(next) - after
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::machine::Source;
    use crate::number::PerUnit;

    fn machine() -> Machine<f64> {
        Machine::with_defaults(Source::Valve)
    }

    /// Law of cosines, written again for the test.
    fn length_m(machine: &Machine<f64>, counts: f64) -> f64 {
        let angle = machine.get(P::LinkageAngleAtZero) + counts * 2.0 * PI / machine.get(P::EncoderCounts);
        let (a, b) = (machine.get(P::LinkageBase), machine.get(P::LinkageArm));
        (a * a + b * b - 2.0 * a * b * libm::cos(angle)).sqrt()
    }

    #[test]
    fn lvdt_at_half_its_counts_reads_a_half() {
        let lvdt = Lvdt::<PerUnit>::new(&machine()).unwrap();
        assert_eq!(lvdt.spool(16384), PerUnit::saturated(0.5));
        assert_eq!(lvdt.spool(-16384), PerUnit::saturated(-0.5));
    }

    #[test]
    fn sides_that_do_not_close_are_refused() {
        let mut machine = machine();
        machine.set(P::LinkageArm, 0.05);
        assert!(matches!(Linkage::<f64>::new(&machine), Err(LinkageError::NoTriangle { .. })));
    }

    proptest! {
        #[test]
        fn counts_become_cylinder_length_and_back(strokes in 0.0..=1.0, base in 0.55..0.8, arm in 0.45..0.6, zero in -3.0..3.0) {
            let mut machine = machine();
            machine.set(P::LinkageBase, base);
            machine.set(P::LinkageArm, arm);
            machine.set(P::LinkageAngleAtZero, zero);
            let linkage = Linkage::<PerUnit>::new(&machine).unwrap();
            let exact = Linkage::<f64>::new(&machine).unwrap();
            let counts = linkage.counts(PerUnit::saturated(strokes));
            prop_assert!((counts - exact.counts(strokes)).abs() < 1e-3);
            let length = machine.get(P::LinkageLengthRetracted) + strokes * machine.get(P::Stroke);
            prop_assert!((length_m(&machine, counts) - length).abs() < 3e-6, "{counts}");
            #[expect(clippy::cast_possible_truncation, reason = "a count")]
            let whole = counts.round() as i32;
            let position = linkage.position(whole).to_f64();
            let wanted = (length_m(&machine, f64::from(whole)) - machine.get(P::LinkageLengthRetracted)) / machine.get(P::Stroke);
            prop_assert!((position - wanted).abs() < SERIES_TOLERANCE, "{position} {wanted}");
        }
    }
}
