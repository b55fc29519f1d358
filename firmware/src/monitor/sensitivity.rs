//! What the monitor is told, as an engineer states it, and what is refused of it.

use thiserror::Error;

use super::Signal;

/// How far a signal's innovation spreads while the model is right: the sensor's noise and what the model is known not to tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Standard deviation, in the signal's SI unit.
    pub sigma: f64,
    /// Time over which an innovation is like the one before (e⁻¹), s; 0 for noise that is new in each tick.
    pub correlation_s: f64,
}

/// What the monitor is to tell from chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// Spool, 1.
    pub spool: Spread,
    /// Either pressure, Pa.
    pub pressure: Spread,
    /// Position, m.
    pub position: Spread,
    /// Memory of the average, s: what lasts much shorter is not seen.
    pub memory_s: f64,
    /// At most one false alarm in this time, on average, s.
    pub between_false_alarms_s: f64,
}

/// Why there is no such monitor.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MonitorError {
    /// A spread that is none, or too small for the number format.
    #[error("{signal:?}: a spread of {sigma}, expected more than {least} and below a base")]
    Sigma {
        /// Of which signal.
        signal: Signal,
        /// Its standard deviation, SI.
        sigma: f64,
        /// Must be more than this, SI.
        least: f64,
    },
    /// A time that is none.
    #[error("{name} is {found_s} s, expected {least_s} to {most_s} s")]
    Time {
        /// Which.
        name: &'static str,
        /// Its value.
        found_s: f64,
        /// Smallest there may be.
        least_s: f64,
        /// Largest there may be.
        most_s: f64,
    },
    /// The memory is too short to tell so rare an event from chance.
    #[error(
        "{signal:?}: a limit of {limit}, expected below {most}: use a longer memory or allow false alarms more often"
    )]
    TooShort {
        /// Of which signal.
        signal: Signal,
        /// The limit that were needed.
        limit: f64,
        /// What can be reached.
        most: f64,
    },
}
