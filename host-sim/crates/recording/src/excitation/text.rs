//! Excitations as text: `step:4V`, `sweep:6.5V,0.4Hz,5Hz,4s`.
//!
//! ```text
//! excitation = name [ ":" item { "," item } ]
//! item       = number unit | "seed=" integer
//! unit       = "V" | "mV" | "s" | "ms" | "Hz"
//! ```
//!
//! The unit of an item shows what the item is; items with the same unit are distinguished by their order. An item that is left out
//! has the default in brackets.
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

const NAMES: [&str; 6] = ["zero", "step", "steps", "sweep", "random", "triangle"];

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
    #[error("input {name}: \"{item}\" is not known; expected a number with unit V, mV, s, ms or Hz, or seed=integer")]
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
            ExcitationError::TooMany { .. } | ExcitationError::Missing { .. } | ExcitationError::Range { .. } => None,
        }
    }
}

/// The items, sorted by unit.
struct Items {
    name: &'static str,
    volts: Vec<f64>,
    seconds: Vec<f64>,
    hertz: Vec<f64>,
    seeds: Vec<u64>,
}

impl Items {
    fn read(name: &'static str, text: &str) -> Result<Self, ExcitationError> {
        let mut items = Self { name, volts: Vec::new(), seconds: Vec::new(), hertz: Vec::new(), seeds: Vec::new() };
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
                "V" => items.volts.push(number),
                "mV" => items.volts.push(number * 1e-3),
                "s" => items.seconds.push(number),
                "ms" => items.seconds.push(number * 1e-3),
                "Hz" => items.hertz.push(number),
                _ => return Err(wrong()),
            }
        }
        Ok(items)
    }

    /// Checks that there are at most so many values in volts, seconds, hertz and seeds.
    fn at_most(&self, most: [usize; 4]) -> Result<(), ExcitationError> {
        let found = [self.volts.len(), self.seconds.len(), self.hertz.len(), self.seeds.len()];
        for ((found, most), unit) in found.into_iter().zip(most).zip(["V", "s", "Hz", "seed"]) {
            if found > most {
                return Err(ExcitationError::TooMany { name: self.name, unit, found, most });
            }
        }
        Ok(())
    }

    fn volts(&self, default: Option<f64>) -> Result<f64, ExcitationError> {
        let (what, unit) = ("the amplitude", "V");
        let value =
            self.volts.first().copied().or(default).ok_or(ExcitationError::Missing { name: self.name, what, unit })?;
        self.within(what, value, unit, (-10.0, 10.0))
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

    fn from_str(text: &str) -> Result<Self, ExcitationError> {
        let (found, rest) = text.split_once(':').unwrap_or((text, ""));
        let found = found.trim();
        let name = *NAMES
            .iter()
            .find(|name| **name == found)
            .ok_or_else(|| ExcitationError::Name { found: found.to_owned() })?;
        let items = Items::read(name, rest)?;
        match name {
            "zero" => {
                items.at_most([0, 1, 0, 0])?;
                Ok(Self::Zero { duration_s: items.seconds(0, "the length", 1.0)? })
            }
            "step" => {
                items.at_most([1, 1, 0, 0])?;
                let hold_s = items.seconds(0, "the time it is held", 0.5)?;
                Ok(Self::Step { amplitude_v: items.volts(None)?, hold_s })
            }
            "steps" => {
                items.at_most([1, 0, 0, 0])?;
                Ok(Self::Steps { amplitude_v: items.volts(None)? })
            }
            "sweep" => {
                items.at_most([1, 1, 2, 0])?;
                Ok(Self::Sweep {
                    amplitude_v: items.volts(Some(6.5))?,
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
                    amplitude_v: items.volts(Some(10.0))?,
                    shortest_s,
                    longest_s,
                    duration_s: items.seconds(2, "the length", 4.0)?,
                    seed: items.seeds.first().copied().unwrap_or(0),
                })
            }
            _ => {
                items.at_most([1, 1, 1, 0])?;
                Ok(Self::Triangle {
                    amplitude_v: items.volts(None)?,
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
