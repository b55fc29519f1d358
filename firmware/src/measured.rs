//! What the sensors measure in one period: the counterpart of [`Predicted`](crate::control::Predicted).

use model_core::control::Observed;
use model_core::number::PerUnit;
use model_core::ports::ChamberState;

/// What the sensors measure in this period, per unit of the model's [`Bases`](model_core::machine::Bases), `I4F28`.
///
/// `None` where there is no such sensor, or where it does not answer as a working sensor does: then a fault states the cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Measured {
    /// Position, as a share of the stroke; 0 is fully in. Where the counter does not answer, the last position that it gave.
    pub position: PerUnit,
    /// Spool position; 1 is full travel, positive extends.
    pub spool: Option<PerUnit>,
    /// Pressure in A, relative to supply.
    pub pressure_a: Option<PerUnit>,
    /// Pressure in B, relative to supply.
    pub pressure_b: Option<PerUnit>,
    /// Temperature of the oil; 0 is 0 °C.
    pub oil_temperature: Option<PerUnit>,
}

impl Measured {
    /// What control and monitor use: pressures only where both are measured.
    #[must_use]
    pub fn observed(&self) -> Observed {
        let pressures = self.pressure_a.zip(self.pressure_b).map(|(a, b)| ChamberState { a, b });
        Observed { position: self.position, spool: self.spool, pressures }
    }
}

/// A signal that comes in as a voltage. Each is a row of the calibration table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnalogSignal {
    /// The output's own voltage, read back at the valve's end of its wire.
    Command,
    /// Spool position.
    Spool,
    /// Pressure in A.
    PressureA,
    /// Pressure in B.
    PressureB,
    /// Temperature of the oil.
    OilTemperature,
}

impl AnalogSignal {
    /// Every signal, in the order of the calibration table.
    pub const ALL: [AnalogSignal; 5] = [
        AnalogSignal::Command,
        AnalogSignal::Spool,
        AnalogSignal::PressureA,
        AnalogSignal::PressureB,
        AnalogSignal::OilTemperature,
    ];

    /// How many there are.
    pub const COUNT: usize = Self::ALL.len();
}
