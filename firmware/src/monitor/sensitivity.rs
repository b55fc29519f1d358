//! The monitor's settings, as an engineer states them, and which of them are refused.

use thiserror::Error;

use super::MonitoredSignal;

/// How far a signal's innovation spreads while the model is right: the sensor's noise and what the model is known not to predict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Standard deviation, in the signal's SI unit.
    pub sigma: f64,
    /// Correlation time of the innovation (to e⁻¹), s; 0 for noise that is new in each tick.
    pub correlation_s: f64,
}

/// What the monitor must distinguish from chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// Spool, 1.
    pub spool: Spread,
    /// Either pressure, Pa.
    pub pressure: Spread,
    /// Position, m.
    pub position: Spread,
    /// Memory of the average, s: a deviation that is much shorter is not seen.
    pub memory_s: f64,
    /// At most one false alarm in this time, on average, s.
    pub between_false_alarms_s: f64,
}

/// Why such a monitor is not possible.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MonitorError {
    /// A spread that is not valid, or too small for the number format.
    #[error("{signal:?}: a spread of {sigma}, expected more than {least} and below a base")]
    Sigma {
        /// Of which signal.
        signal: MonitoredSignal,
        /// Its standard deviation, SI.
        sigma: f64,
        /// It must be larger than this, SI.
        least: f64,
    },
    /// A time that is not valid.
    #[error("{name} is {found_s} s, expected {least_s} to {most_s} s")]
    Time {
        /// Which.
        name: &'static str,
        /// Its value.
        found_s: f64,
        /// Smallest permitted value.
        least_s: f64,
        /// Largest permitted value.
        most_s: f64,
    },
    /// The memory is too short to distinguish so rare an event from chance.
    #[error(
        "{signal:?}: a limit of {limit}, expected below {most}: use a longer memory or allow false alarms more often"
    )]
    TooShort {
        /// Of which signal.
        signal: MonitoredSignal,
        /// The limit that would be needed.
        limit: f64,
        /// The largest possible limit.
        most: f64,
    },
}
