//! The linkage between rod and joint: rod position to joint angle and back.
//!
//! Joint, cylinder foot and rod eye form a triangle. Its two sides at the joint are fixed (base and arm);
//! the third side is the cylinder, `length_retracted + y`. The angle at the joint follows from the law of
//! cosines and grows as the rod extends.

use thiserror::Error;

use model_core::machine::{Machine, Parameter};

/// The triangle, and the angle at which the encoder counts zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linkage {
    base_m: f64,
    arm_m: f64,
    length_retracted_m: f64,
    angle_at_zero_rad: f64,
}

/// A triangle that does not close within the stroke.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("linkage: cylinder length {length_m} m within the stroke, expected between {shortest_m} and {longest_m} m")]
pub struct LinkageError {
    /// The length that does not fit, m.
    pub length_m: f64,
    /// Difference of base and arm, m.
    pub shortest_m: f64,
    /// Sum of base and arm, m.
    pub longest_m: f64,
}

impl Linkage {
    /// The linkage of a machine, checked to close over its stroke.
    pub fn of(machine: &Machine<f64>) -> Result<Self, LinkageError> {
        let linkage = Self {
            base_m: machine.get(Parameter::LinkageBase),
            arm_m: machine.get(Parameter::LinkageArm),
            length_retracted_m: machine.get(Parameter::LinkageLengthRetracted),
            angle_at_zero_rad: machine.get(Parameter::LinkageAngleAtZero),
        };
        let (shortest_m, longest_m) = ((linkage.base_m - linkage.arm_m).abs(), linkage.base_m + linkage.arm_m);
        for position_m in [0.0, machine.get(Parameter::Stroke)] {
            let length_m = linkage.length_retracted_m + position_m;
            if !(shortest_m..=longest_m).contains(&length_m) {
                return Err(LinkageError { length_m, shortest_m, longest_m });
            }
        }
        Ok(linkage)
    }

    /// Joint angle from the encoder's zero, rad. Outside the triangle's limits it keeps the limit value.
    #[must_use]
    pub fn angle_rad(&self, position_m: f64) -> f64 {
        let length_m = self.length_retracted_m + position_m;
        let sides = self.base_m * self.base_m + self.arm_m * self.arm_m;
        let cosine = (sides - length_m * length_m) / (2.0 * self.base_m * self.arm_m);
        libm::acos(cosine.clamp(-1.0, 1.0)) - self.angle_at_zero_rad
    }

    /// Rod position, m, for an angle from the encoder's zero.
    #[must_use]
    pub fn position_m(&self, angle_rad: f64) -> f64 {
        let sides = self.base_m * self.base_m + self.arm_m * self.arm_m;
        let cosine = libm::cos(angle_rad + self.angle_at_zero_rad);
        (sides - 2.0 * self.base_m * self.arm_m * cosine).max(0.0).sqrt() - self.length_retracted_m
    }
}

#[cfg(test)]
mod tests {
    use model_core::machine::Source;

    use super::*;

    #[test]
    fn angle_and_position_are_inverse_over_the_stroke() {
        let linkage = Linkage::of(&Machine::with_defaults(Source::Valve)).unwrap();
        for k in 0..=30 {
            let position = f64::from(k) * 0.01;
            assert!((linkage.position_m(linkage.angle_rad(position)) - position).abs() < 1e-14);
        }
    }

    #[test]
    fn a_right_angle_is_found_by_pythagoras() {
        let mut machine = Machine::with_defaults(Source::Valve);
        machine.set(Parameter::LinkageBase, 0.4);
        machine.set(Parameter::LinkageArm, 0.3);
        machine.set(Parameter::LinkageLengthRetracted, 0.3);
        let angle = Linkage::of(&machine).unwrap().angle_rad(0.2);
        assert!((angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn a_triangle_that_does_not_close_is_refused_with_the_length() {
        let mut machine = Machine::with_defaults(Source::Valve);
        machine.set(Parameter::LinkageArm, 0.1);
        let found = Linkage::of(&machine).unwrap_err();
        assert!((found.length_m - 0.45).abs() < 1e-12 && (found.shortest_m - 0.5).abs() < 1e-12);
    }
}
