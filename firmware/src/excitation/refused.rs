//! Refused excitations and plans, with their values.

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

/// Why a plan cannot be played from where the rod is.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PlanError {
    /// It was made for a machine with other values.
    #[error(
        "planned for a machine of the fingerprint {found:#010x}, expected {expected:#010x}: plan again for this one"
    )]
    Machine {
        /// Of the plan.
        found: u32,
        /// Of the machine.
        expected: u32,
    },
    /// Its rows do not fit the tick.
    #[error("rows of {row_us} µs, expected a multiple of the tick, {tick_us} µs")]
    Rows {
        /// Length of a row.
        row_us: u32,
        /// Length of a tick.
        tick_us: u32,
    },
    /// Its voltages are too large.
    #[error("voltages up to {largest_v} V, expected at most {most_v} V: plan with a smaller --largest")]
    Command {
        /// Largest of the plan.
        largest_v: f64,
        /// Largest permitted.
        most_v: f64,
    },
    /// The rod stands elsewhere.
    #[error("the rod stands at {rod_m} m, expected within {within_m} m of {start_m} m: go there first")]
    Start {
        /// Where it stands.
        rod_m: f64,
        /// Where the plan begins.
        start_m: f64,
        /// How far away it may stand.
        within_m: f64,
    },
    /// The rod would leave the bounds.
    #[error(
        "the rod would move, and come to rest, within {from_m} to {to_m} m, expected {least_m} to {most_m} m: plan with a smaller --largest"
    )]
    Range {
        /// Least position.
        from_m: f64,
        /// Largest position.
        to_m: f64,
        /// Least permitted.
        least_m: f64,
        /// Largest permitted.
        most_m: f64,
    },
    /// The rod would be too fast.
    #[error(
        "the rod reaches {fastest_m_per_s} m/s, expected at most {most_m_per_s} m/s: plan with a smaller --largest"
    )]
    Velocity {
        /// Largest velocity of the model.
        fastest_m_per_s: f64,
        /// Largest permitted.
        most_m_per_s: f64,
    },
}
