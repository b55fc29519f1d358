//! Refused set points, with their values.

use thiserror::Error;

use super::Bounds;

/// Why legs do not make a course, or a set point is refused.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SetPointError {
    /// There are more legs than fit.
    #[error("{found} legs, at most {room} fit")]
    TooMany {
        /// How many there are.
        found: usize,
        /// How many fit.
        room: usize,
    },
    /// A position is out of bounds, or not a number.
    #[error("leg {leg} leads to {to_m} m, expected {from_m} to {most_m} m")]
    Position {
        /// Which leg.
        leg: usize,
        /// Its end.
        to_m: f64,
        /// Smallest permitted position.
        from_m: f64,
        /// Largest permitted position.
        most_m: f64,
    },
    /// A duration is not a number, shorter than a tick, or longer than an hour.
    #[error("leg {leg} takes {duration_s} s, expected a tick to an hour")]
    Duration {
        /// Which leg.
        leg: usize,
        /// Its duration.
        duration_s: f64,
    },
    /// A leg is faster than the bounds permit.
    #[error("leg {leg} reaches {velocity_m_per_s} m/s, expected at most {most_m_per_s} m/s")]
    Velocity {
        /// Which leg.
        leg: usize,
        /// Its largest velocity.
        velocity_m_per_s: f64,
        /// Largest permitted velocity.
        most_m_per_s: f64,
    },
    /// A leg accelerates more than the bounds permit.
    #[error("leg {leg} reaches {acceleration_m_per_s2} m/s², expected at most {most_m_per_s2} m/s²")]
    Acceleration {
        /// Which leg.
        leg: usize,
        /// Its largest acceleration.
        acceleration_m_per_s2: f64,
        /// Largest permitted acceleration.
        most_m_per_s2: f64,
    },
    /// The resolution of set points is not a number, negative, or more than the stroke.
    #[error("set points in steps of {step_m} m, expected 0 to {most_m} m")]
    Resolution {
        /// The resolution that was stated.
        step_m: f64,
        /// The largest possible.
        most_m: f64,
    },
    /// Bounds that are not valid: not numbers, or in the wrong order.
    #[error("bounds {0:?}, expected a stretch of the stroke, and a velocity and an acceleration above 0")]
    Bounds(Bounds),
}
