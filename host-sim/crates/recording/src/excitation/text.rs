//! Excitations as text: `step:4V`, `sweep:6.5V,0.4Hz,5Hz,4s`.
//!
//! ```text
//! excitation = name [ ":" item { "," item } ]
//! item       = number unit | "seed=" integer
//! unit       = "V" | "mV" | "mA" | "s" | "ms" | "Hz"
//! ```
//!
//! The unit of an item shows what the item is; items with the same unit are distinguished by their order. An item that is left out
//! has the default in brackets. A height or an amplitude is in the unit of the machine's command, V or mA; those by default are in V.
//!
//! | name | items |
//! |---|---|
//! | `zero` | length \[1 s\] |
//! | `step` | height, time it is held \[0.5 s\] |
//! | `steps` | height: the paper's sequence |
//! | `sweep` | amplitude \[6.5 V\], first and last frequency \[0.4 Hz, 5 Hz\], length \[4 s\] |
//! | `random` | largest height \[10 V\], shortest, longest step \[0.08 s, 0.5 s\], length \[4 s\], seed \[0\] |
//! | `triangle` | amplitude, frequency \[0.5 Hz\], length \[4 s\] |

use std::str::FromStr;

use thiserror::Error;

use super::signals::Excitation;
use crate::unit::{Dimension, Unit};

const NAMES: [&str; 6] = ["zero", "step", "steps", "sweep", "random", "triangle"];

const VOLT: &str = "V";
const MILLIAMPERE: &str = "mA";
/// Largest height in mA: that of a large proportional solenoid.
const MOST_MA: f64 = 5000.0;

/// Why a text is not an excitation.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ExcitationError {
    /// The name is not a known one.
    #[error("input \"{found}\" is not known; expected one of {}", NAMES.join(", "))]
    Name {
        /// The name found.
        found: String,
    },
    /// An item is not a number with a unit.
    #[error(
        "input {name}: \"{item}\" is not known; expected a number with unit V, mV, mA, s, ms or Hz, or seed=integer"
    )]
    Item {
        /// The excitation's name.
        name: &'static str,
        /// The item found.
        item: String,
    },
    /// A number without a unit.
    #[error("input {name}: \"{item}\" has no unit; expected one behind the number, as in {item}V, {item}s or {item}Hz")]
    NoUnit {
        /// The excitation's name.
        name: &'static str,
        /// The number found.
        item: String,
    },
    /// A height in another unit than the machine's command.
    #[error("input {name}: the amplitude is in {found}; expected {expected}, the unit of the command")]
    Unit {
        /// The excitation's name.
        name: &'static str,
        /// The unit found.
        found: &'static str,
        /// The command's.
        expected: &'static str,
    },
    /// More items of one unit than the excitation takes.
    #[error("input {name}: {found} values in {unit}; expected at most {most}")]
    TooMany {
        /// The excitation's name.
        name: &'static str,
        /// The unit, after conversion of mV and ms.
        unit: &'static str,
        /// How many were found.
        found: usize,
        /// How many the excitation takes.
        most: usize,
    },
    /// An item without a default is missing.
    #[error("input {name}: {what} is missing; expected a value in {unit}")]
    Missing {
        /// The excitation's name.
        name: &'static str,
        /// What the value would mean.
        what: &'static str,
        /// Its unit.
        unit: &'static str,
    },
    /// A value outside the admissible range.
    #[error("input {name}: {what} is {found} {unit}; expected {least} to {most} {unit}")]
    Range {
        /// The excitation's name.
        name: &'static str,
        /// What the value is.
        what: &'static str,
        /// The value.
        found: f64,
        /// Its unit.
        unit: &'static str,
        /// Smallest admissible.
        least: f64,
        /// Largest admissible.
        most: f64,
    },
}

impl ExcitationError {
    /// The part of the text that the error is about; `None` for the whole text.
    #[must_use]
    pub fn part(&self) -> Option<&str> {
        match self {
            ExcitationError::Name { found } => Some(found),
            ExcitationError::Item { item, .. } | ExcitationError::NoUnit { item, .. } => Some(item),
            ExcitationError::Unit { .. }
            | ExcitationError::TooMany { .. }
            | ExcitationError::Missing { .. }
            | ExcitationError::Range { .. } => None,
        }
    }
}

/// The items, sorted by unit.
struct Items {
    name: &'static str,
    /// In the unit of the command.
    heights: Vec<f64>,
    /// That unit: V or mA.
    unit: &'static str,
    seconds: Vec<f64>,
    hertz: Vec<f64>,
    seeds: Vec<u64>,
}

impl Items {
    fn none(name: &'static str, unit: &'static str) -> Self {
        Self { name, heights: Vec::new(), unit, seconds: Vec::new(), hertz: Vec::new(), seeds: Vec::new() }
    }

    /// `unit` is the command's; without it the first height has it.
    fn read(name: &'static str, text: &str, unit: Option<&'static str>) -> Result<Self, ExcitationError> {
        let (mut items, mut expected) = (Self::none(name, unit.unwrap_or(VOLT)), unit);
        for item in text.split(',').map(str::trim).filter(|item| !item.is_empty()) {
            if item.parse::<f64>().is_ok_and(f64::is_finite) {
                return Err(ExcitationError::NoUnit { name, item: item.to_owned() });
            }
            let wrong = || ExcitationError::Item { name, item: item.to_owned() };
            if let Some(seed) = item.strip_prefix("seed=") {
                items.seeds.push(seed.parse().map_err(|_| wrong())?);
                continue;
            }
            let unit_at = item.find(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E')).ok_or_else(wrong)?;
            let (number, unit) = item.split_at(unit_at);
            let number: f64 = number.trim().parse().map_err(|_| wrong())?;
            match unit {
                "V" | "mV" | "mA" => {
                    let found = if unit == MILLIAMPERE { MILLIAMPERE } else { VOLT };
                    items.unit = *expected.get_or_insert(found);
                    if found != items.unit {
                        return Err(ExcitationError::Unit { name, found, expected: items.unit });
                    }
                    items.heights.push(if unit == "mV" { number * 1e-3 } else { number });
                }
                "s" => items.seconds.push(number),
                "ms" => items.seconds.push(number * 1e-3),
                "Hz" => items.hertz.push(number),
                _ => return Err(wrong()),
            }
        }
        Ok(items)
    }

    /// Checks that there are at most so many heights, values in seconds, hertz and seeds.
    fn at_most(&self, most: [usize; 4]) -> Result<(), ExcitationError> {
        let found = [self.heights.len(), self.seconds.len(), self.hertz.len(), self.seeds.len()];
        for ((found, most), unit) in found.into_iter().zip(most).zip([self.unit, "s", "Hz", "seed"]) {
            if found > most {
                return Err(ExcitationError::TooMany { name: self.name, unit, found, most });
            }
        }
        Ok(())
    }

    /// A height; its default is in V.
    fn height(&self, default_v: Option<f64>) -> Result<f64, ExcitationError> {
        let (what, unit) = ("the amplitude", self.unit);
        let default = default_v.filter(|_| unit == VOLT);
        let value = self.heights.first().copied().or(default).ok_or(ExcitationError::Missing {
            name: self.name,
            what,
            unit,
        })?;
        let most = if unit == VOLT { 10.0 } else { MOST_MA };
        self.within(what, value, unit, (-most, most))
    }

    fn seconds(&self, index: usize, what: &'static str, default: f64) -> Result<f64, ExcitationError> {
        let value = self.seconds.get(index).copied().unwrap_or(default);
        self.within(what, value, "s", (1e-3, 3600.0))
    }

    fn hertz(&self, index: usize, what: &'static str, default: f64) -> Result<f64, ExcitationError> {
        let value = self.hertz.get(index).copied().unwrap_or(default);
        self.within(what, value, "Hz", (1e-3, 1e3))
    }

    fn within(
        &self,
        what: &'static str,
        found: f64,
        unit: &'static str,
        (least, most): (f64, f64),
    ) -> Result<f64, ExcitationError> {
        if (least..=most).contains(&found) {
            Ok(found)
        } else {
            Err(ExcitationError::Range { name: self.name, what, found, unit, least, most })
        }
    }
}

impl FromStr for Excitation {
    type Err = ExcitationError;

    /// One in V.
    fn from_str(text: &str) -> Result<Self, ExcitationError> {
        Ok(Self::read(text, Some(Unit::si(Dimension::Voltage)))?.0)
    }
}

impl Excitation {
    /// An excitation for a machine whose command is in `unit`, V or mA, and the unit of its heights: that one, or else the text's own.
    ///
    /// # Errors
    /// It is none, or it is in another unit.
    pub fn read(text: &str, unit: Option<Unit>) -> Result<(Self, Unit), ExcitationError> {
        let (found, rest) = text.split_once(':').unwrap_or((text, ""));
        let found = found.trim();
        let name = *NAMES
            .iter()
            .find(|name| **name == found)
            .ok_or_else(|| ExcitationError::Name { found: found.to_owned() })?;
        let is_current = |unit: Unit| unit.dimension() == Dimension::Current;
        let items = Items::read(name, rest, unit.map(|unit| if is_current(unit) { MILLIAMPERE } else { VOLT }))?;
        let dimension = if items.unit == MILLIAMPERE { Dimension::Current } else { Dimension::Voltage };
        Ok((Self::of(&items)?, Unit::si(dimension)))
    }

    fn of(items: &Items) -> Result<Self, ExcitationError> {
        match items.name {
            "zero" => {
                items.at_most([0, 1, 0, 0])?;
                Ok(Self::Zero { duration_s: items.seconds(0, "the length", 1.0)? })
            }
            "step" => {
                items.at_most([1, 1, 0, 0])?;
                let hold_s = items.seconds(0, "the time it is held", 0.5)?;
                Ok(Self::Step { amplitude_v: items.height(None)?, hold_s })
            }
            "steps" => {
                items.at_most([1, 0, 0, 0])?;
                Ok(Self::Steps { amplitude_v: items.height(None)? })
            }
            "sweep" => {
                items.at_most([1, 1, 2, 0])?;
                Ok(Self::Sweep {
                    amplitude_v: items.height(Some(6.5))?,
                    from_hz: items.hertz(0, "the first frequency", 0.4)?,
                    to_hz: items.hertz(1, "the last frequency", 5.0)?,
                    duration_s: items.seconds(0, "the length", 4.0)?,
                })
            }
            "random" => {
                items.at_most([1, 3, 0, 1])?;
                let shortest_s = items.seconds(0, "the shortest step", 0.08)?;
                let longest_s = items.seconds(1, "the longest step", 0.5_f64.max(shortest_s))?;
                let longest_s = items.within("the longest step", longest_s, "s", (shortest_s, 3600.0))?;
                Ok(Self::Random {
                    amplitude_v: items.height(Some(10.0))?,
                    shortest_s,
                    longest_s,
                    duration_s: items.seconds(2, "the length", 4.0)?,
                    seed: items.seeds.first().copied().unwrap_or(0),
                })
            }
            _ => {
                items.at_most([1, 1, 1, 0])?;
                Ok(Self::Triangle {
                    amplitude_v: items.height(None)?,
                    frequency_hz: items.hertz(0, "the frequency", 0.5)?,
                    duration_s: items.seconds(0, "the length", 4.0)?,
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_contract_examples_are_read() {
        assert_eq!("step:4V".parse(), Ok(Excitation::Step { amplitude_v: 4.0, hold_s: 0.5 }));
        assert_eq!("step: -4e3 mV, 250ms".parse(), Ok(Excitation::Step { amplitude_v: -4.0, hold_s: 0.25 }));
        assert_eq!("sweep".parse(), Ok(Excitation::paper_sweep()));
        assert_eq!("sweep:6.5V,0.4Hz,5Hz,4s".parse(), Ok(Excitation::paper_sweep()));
        assert_eq!("random:seed=7".parse(), Ok(Excitation::random_steps(7)));
        assert_eq!("steps:2V".parse(), Ok(Excitation::paper_steps(2.0)));
        assert_eq!("zero".parse(), Ok(Excitation::Zero { duration_s: 1.0 }));
    }

    #[test]
    fn a_command_in_milliamperes_is_read_for_a_machine_that_counts_in_them() {
        let (volt, milliampere) = (Unit::parse("V").unwrap(), Unit::parse("mA").unwrap());
        let step = (Excitation::Step { amplitude_v: 4.0, hold_s: 0.5 }, milliampere);
        assert_eq!(Excitation::read("step:4mA", Some(milliampere)), Ok(step));
        assert_eq!(Excitation::read("step:4mA", None), Ok(step));
        assert_eq!(Excitation::read("step:4V", None), Ok((step.0, volt)));
        let message = |text: &str, unit| Excitation::read(text, Some(unit)).unwrap_err().to_string();
        let wrong = "input step: the amplitude is in V; expected mA, the unit of the command";
        assert_eq!(message("step:4V", milliampere), wrong);
        assert!(message("step:4mA", volt).ends_with("is in mA; expected V, the unit of the command"));
        assert!(message("sweep", milliampere).ends_with("the amplitude is missing; expected a value in mA"));
    }

    #[test]
    fn what_is_wrong_is_named_with_what_was_expected() {
        let message = |text: &str| text.parse::<Excitation>().unwrap_err().to_string();
        assert_eq!(
            message("stp:4V"),
            "input \"stp\" is not known; expected one of zero, step, steps, sweep, random, triangle"
        );
        assert_eq!(message("step"), "input step: the amplitude is missing; expected a value in V");
        assert_eq!(message("step:40V"), "input step: the amplitude is 40 V; expected -10 to 10 V");
        assert_eq!(message("step:4V,1Hz"), "input step: 1 values in Hz; expected at most 0");
        assert_eq!(
            message("step:4"),
            "input step: \"4\" has no unit; expected one behind the number, as in 4V, 4s or 4Hz"
        );
        assert!(message("step:4V,3X").contains("\"3X\" is not known; expected a number with unit"));
        assert!(message("step:NaNV").contains("\"NaNV\""));
        assert!(message("random:10V,0.5s,0.1s").contains("the longest step is 0.1 s; expected 0.5 to 3600 s"));
    }
}
