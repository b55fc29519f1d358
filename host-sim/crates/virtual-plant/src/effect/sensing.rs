//! What the sensors do beyond noise and rounding; the motion as the sensors see it is in [`crate::sensor::before_noise`].

/// Which channel reads wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasuredSignal {
    /// Spool position.
    Spool,
    /// Rod position.
    Position,
    /// Pressure in chamber A.
    PressureA,
    /// Pressure in chamber B.
    PressureB,
}

/// An effect between the true signals and the sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensingEffect {
    /// Play between rod and encoder, with slight elastic rounding near its flanks.
    Backlash {
        /// Travel between the two flanks, m.
        play_m: f64,
    },
    /// The position passes a filter of second order.
    PositionFilter {
        /// Natural frequency, Hz.
        frequency_hz: f64,
        /// Damping ratio.
        damping: f64,
    },
    /// The position is measured with a delay.
    PositionDelay {
        /// The delay, s.
        delay_s: f64,
    },
    /// A channel reads too high by a constant, in its SI unit.
    Offset {
        /// Which one.
        channel: MeasuredSignal,
        /// By how much.
        offset: f64,
    },
    /// A channel reads with a wrong scale factor.
    Factor {
        /// Which one.
        channel: MeasuredSignal,
        /// Factor less 1.
        excess: f64,
    },
    /// The encoder sits on a structure that rings as the rod accelerates (not in the vocabulary).
    Flexibility {
        /// Natural frequency, Hz.
        frequency_hz: f64,
        /// Damping ratio.
        damping: f64,
        /// Deflection for a given acceleration, relative to what the rod's own inertia would give.
        share: f64,
    },
}

impl SensingEffect {
    /// The name in the project's vocabulary; a leading ~ marks an effect outside the vocabulary.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Backlash { .. } => "linkage-backlash",
            Self::PositionFilter { .. } | Self::PositionDelay { .. } => "position-sensor-lag",
            Self::Offset { .. } | Self::Factor { .. } => "sensor-offset",
            Self::Flexibility { .. } => "~structural-flexibility",
        }
    }
}
