//! Refused excitations, with their values.

use thiserror::Error;

/// Why an excitation cannot be played from where the rod is.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ExcitationError {
    /// It would leave the bounds, or its amplitude is not a number or 0.
    #[error("an amplitude of {amplitude_m} m, expected above 0 and, from here, at most {most_m} m")]
    Amplitude {
        /// What was stated.
        amplitude_m: f64,
        /// Room to the bound.
        most_m: f64,
    },
    /// A frequency that cannot be played.
    #[error("a frequency of {found_hz} Hz, expected {least_hz} to {most_hz} Hz")]
    Frequency {
        /// What was stated.
        found_hz: f64,
        /// The least possible; at the end of a sweep twice that at its start.
        least_hz: f64,
        /// The highest possible: ten ticks a period.
        most_hz: f64,
    },
    /// A sine that is faster than the bounds permit.
    #[error("a sine reaches {velocity_m_per_s} m/s, expected at most {most_m_per_s} m/s")]
    Velocity {
        /// Its largest velocity.
        velocity_m_per_s: f64,
        /// Four fifths of what the bounds permit.
        most_m_per_s: f64,
    },
    /// A sine that accelerates more than the bounds permit.
    #[error("a sine reaches {acceleration_m_per_s2} m/s², expected at most {most_m_per_s2} m/s²")]
    Acceleration {
        /// Its largest acceleration.
        acceleration_m_per_s2: f64,
        /// Four fifths of what the bounds permit.
        most_m_per_s2: f64,
    },
    /// Too short for its frequencies, too long, or not a number.
    #[error("a time of {duration_s} s, expected {least_s} to {most_s} s")]
    Duration {
        /// What was stated or follows.
        duration_s: f64,
        /// The least possible.
        least_s: f64,
        /// The longest possible.
        most_s: f64,
    },
}
