//! A sensor that records a signal, and how much noise it adds.

use strsim::jaro_winkler as alike;

use machine_file::data_sheet::Quantity;
use model_core::machine::{Machine, Parameter};
use recording::Signal;
use simulation::{InputPoint, computed_below};

/// A sensor at hand, or one that could be bought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// What it records.
    pub signal: Signal,
    /// Standard deviation of its noise and quantisation, in the signal's SI unit.
    pub noise: f64,
}

/// Why a text does not describe a sensor.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SensorError {
    /// No signal has this name.
    #[error("unknown signal `{name}` (did you mean `{nearest}`?); expected one of: {}", known())]
    Unknown {
        /// The name.
        name: String,
        /// The one that was perhaps intended.
        nearest: &'static str,
    },
    /// The noise is not a positive number with a unit of the signal.
    #[error("noise `{text}` of {signal}; expected a positive number with a unit of it, one of: {}", .signal.units())]
    Noise {
        /// The signal with this noise.
        signal: Signal,
        /// The given text.
        text: String,
    },
}

fn known() -> String {
    let names: Vec<&str> = sensed().map(Signal::name).collect();
    names.join(", ")
}

/// Signals that the model computes and a sensor may record.
fn sensed() -> impl Iterator<Item = Signal> {
    computed_below(InputPoint::Command).iter().copied()
}

impl Sensor {
    /// A usual sensor of this signal: spool 0.1 % of its travel, pressures and force 0.2 % of the supply's, flow and speed
    /// 0.5 % of those at full opening, position 0.01 % of the stroke.
    #[must_use]
    pub fn usual(signal: Signal, machine: &Machine<f64>) -> Self {
        let get = |parameter| machine.get(parameter);
        let supply = get(Parameter::SupplyPressure);
        let flow = (get(Parameter::FlowCoefficient) * supply.sqrt()).min(get(Parameter::FlowLimit));
        let noise = match signal {
            Signal::Spool => 1e-3,
            Signal::Position => 1e-4 * get(Parameter::Stroke),
            Signal::Force => 2e-3 * supply * get(Parameter::AreaA),
            Signal::Flow => 5e-3 * flow,
            Signal::Velocity => 5e-3 * flow / get(Parameter::AreaA),
            _ => 2e-3 * supply,
        };
        Self { signal, noise }
    }

    /// Reads `position` (with usual noise) or `position:0.05mm`.
    pub fn parse(text: &str, machine: &Machine<f64>) -> Result<Self, SensorError> {
        let (name, noise) = text.split_once(':').map_or((text, None), |(name, noise)| (name, Some(noise.trim())));
        let name = name.trim();
        let signal = sensed().find(|signal| signal.name() == name).ok_or_else(|| SensorError::Unknown {
            name: name.to_owned(),
            nearest: sensed().map(Signal::name).max_by(|a, b| alike(name, a).total_cmp(&alike(name, b))).unwrap_or(""),
        })?;
        let usual = Self::usual(signal, machine);
        let Some(text) = noise else { return Ok(usual) };
        let wrong = || SensorError::Noise { signal, text: text.to_owned() };
        let dimension = signal.si_unit().dimension();
        let given = Quantity::parse(text, &[dimension], "0.05mm").map_err(|_| wrong())?;
        let noise = given.si - given.unit.to_si(0.0);
        if noise.is_finite() && noise > 0.0 { Ok(Self { signal, noise }) } else { Err(wrong()) }
    }
}

#[cfg(test)]
mod tests {
    use test_press::press;

    use super::*;

    #[test]
    fn a_sensor_is_a_signal_with_its_noise_in_any_unit_of_it() {
        let machine = press(&[]);
        let read = |text: &str| Sensor::parse(text, &machine);
        assert_eq!(read("position:0.05mm").unwrap(), Sensor { signal: Signal::Position, noise: 5e-5 });
        assert_eq!(read(" pressure_a : 0.2 bar").unwrap(), Sensor { signal: Signal::PressureA, noise: 2e4 });
        assert_eq!(read("spool:0.1%").unwrap(), Sensor { signal: Signal::Spool, noise: 1e-3 });
        assert_eq!(read("spool").unwrap(), Sensor::usual(Signal::Spool, &machine));
    }

    #[test]
    fn what_is_no_sensor_is_refused_with_what_was_expected() {
        let machine = press(&[]);
        let message = |text: &str| Sensor::parse(text, &machine).unwrap_err().to_string();
        assert!(message("positon").contains("did you mean `position`?"), "{}", message("positon"));
        assert!(message("command").contains("unknown signal"));
        for wrong in ["position:0.05bar", "position:mm", "position:0.05", "position:-1mm", "position:0mm"] {
            assert!(message(wrong).contains("expected a positive number with a unit"), "{wrong}");
        }
    }
}
