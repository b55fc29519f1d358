//! Where a recording drives the model.

use recording::Signal;

/// Where a recording drives the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum InputPoint {
    /// Command at the valve.
    Command,
    /// Measured spool.
    Spool,
    /// Speed of the pump and direction of its valve.
    Pump,
    /// Measured flow into A; the flow out of B is what the valve's other edge passes at the same opening, or for a pump drive the share by area
    /// ratio.
    Flow,
    /// Measured force of the oil, or the force computed from both recorded pressures.
    Force,
}

impl InputPoint {
    /// The signal that drives the model there.
    #[must_use]
    pub fn driving(self) -> Signal {
        match self {
            InputPoint::Command => Signal::Command,
            InputPoint::Spool => Signal::Spool,
            InputPoint::Pump => Signal::PumpSpeed,
            InputPoint::Flow => Signal::Flow,
            InputPoint::Force => Signal::Force,
        }
    }

    /// Whether this signal is set, as a command and a pump's speed are, and not measured by a sensor.
    #[must_use]
    pub fn is_set(self) -> bool {
        matches!(self, InputPoint::Command | InputPoint::Pump)
    }
}
