//! Limits of a rig: what is too far, too fast or too long. Configuration, per unit.

use model_core::fixed_point::PerUnit;
use model_core::number::Number;

use crate::measured::Signal;
use crate::still::Patience;

/// Limits of a rig. Times are in periods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// How often a device is asked in a period before it is silent; at least once.
    pub attempts: u8,
    /// Periods without a fault before the rod follows.
    pub settling: u16,
    /// Least set point, of the stroke.
    pub least_position: PerUnit,
    /// Greatest set point.
    pub most_position: PerUnit,
    /// Greatest velocity of a set point, both signs, of its base.
    pub most_velocity: PerUnit,
    /// Greatest jump of a set point in a period, of the stroke.
    pub most_jump: PerUnit,
    /// The command, in 10 V, at which the valve passes nothing: the middle of its dead zone, −offset/gain.
    pub neutral: PerUnit,
    /// Greatest command, both signs, in 10 V.
    pub most_command: PerUnit,
    /// Greatest change of the command in a period while the rod is controlled.
    pub slew: PerUnit,
    /// Change of the command in a period while it ramps down.
    pub ramp: PerUnit,
    /// How long the position may stand still; `None` for ever.
    pub still_position: Option<Patience>,
    /// How long each signal may stand still, in the order of [`Signal::ALL`]. The model knows no oil temperature.
    pub still: [Option<Patience>; Signal::COUNT],
    /// How far the voltage at the valve may be from the one put out, in 10 V, and for how long it may be farther; where it is read back.
    pub read_back: Option<Patience>,
}

/// Why limits are none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LimitsError {
    /// The least set point is not below the greatest.
    #[error("set point from {least:?} to {most:?}; expected the first below the second")]
    Positions {
        /// Least.
        least: PerUnit,
        /// Greatest.
        most: PerUnit,
    },
    /// A limit that must be above 0 is not.
    #[error("{name} = {value:?}; expected above 0")]
    NotPositive {
        /// Which.
        name: &'static str,
        /// Its value.
        value: PerUnit,
    },
    /// The neutral command is beyond the greatest.
    #[error("neutral = {neutral:?}; expected within {most:?}, both signs")]
    Neutral {
        /// Neutral command.
        neutral: PerUnit,
        /// Greatest command.
        most: PerUnit,
    },
}

impl Limits {
    /// Checks what the period relies on.
    ///
    /// # Errors
    /// The first limit that is none.
    pub fn check(&self) -> Result<(), LimitsError> {
        let (least, most) = (self.least_position, self.most_position);
        if least >= most {
            return Err(LimitsError::Positions { least, most });
        }
        let positive = [
            ("most_velocity", self.most_velocity),
            ("most_jump", self.most_jump),
            ("most_command", self.most_command),
            ("slew", self.slew),
            ("ramp", self.ramp),
        ];
        if let Some(&(name, value)) = positive.iter().find(|(_, value)| *value <= PerUnit::ZERO) {
            return Err(LimitsError::NotPositive { name, value });
        }
        let (neutral, most) = (self.neutral, self.most_command);
        if neutral.magnitude() > most { Err(LimitsError::Neutral { neutral, most }) } else { Ok(()) }
    }

    /// Periods after which a ramp from any command has arrived at neutral.
    #[must_use]
    pub fn periods_to_neutral(&self) -> u32 {
        let farthest = self.most_command + self.neutral.magnitude();
        farthest.to_bits().unsigned_abs().div_ceil(self.ramp.to_bits().unsigned_abs().max(1))
    }
}
