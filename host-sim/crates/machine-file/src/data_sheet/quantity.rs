//! Numbers as a data sheet gives them: `63mm`, `40 l/min`, `17.5 %`.

use std::fmt;

use recording::{Dimension, Unit};

/// A number with its unit, as it was typed.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// In SI units (a current in mA).
    pub si: f64,
    /// The unit that was typed.
    pub unit: Unit,
    /// The number that was typed.
    number: String,
}

/// Why a text is not a quantity of this kind.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum QuantityError {
    /// It does not begin with a number.
    #[error("`{text}` does not begin with a finite number; expected such as `{example}`, with a decimal point")]
    NoNumber {
        /// The text.
        text: String,
        /// A valid example.
        example: &'static str,
    },
    /// No unit follows the number.
    #[error("`{text}` has no unit; expected one of {known}, such as `{example}`")]
    NoUnit {
        /// The text.
        text: String,
        /// Units that are allowed.
        known: String,
        /// A valid example.
        example: &'static str,
    },
    /// The text after the number is not a unit, or is a unit of another quantity.
    #[error("`{found}` is not a unit of this quantity; expected one of {known}, such as `{example}`")]
    WrongUnit {
        /// What was found.
        found: String,
        /// Units that are allowed.
        known: String,
        /// A valid example.
        example: &'static str,
    },
    /// A number outside the range of this quantity.
    #[error("`{text}` is out of range; expected {expected}, such as `{example}`")]
    OutOfRange {
        /// The text.
        text: String,
        /// The allowed range, in words.
        expected: &'static str,
        /// A valid example.
        example: &'static str,
    },
}

impl Quantity {
    /// Reads a number with a unit of one of these dimensions. A decimal comma is read as a point, and `±10V` as `10V`.
    ///
    /// # Errors
    /// If there is no finite number, no unit, or a unit of another dimension.
    pub fn parse(text: &str, dimensions: &[Dimension], example: &'static str) -> Result<Self, QuantityError> {
        let typed = text.trim().trim_start_matches(['±', ' ']);
        let text = &if typed.contains('.') { typed.to_owned() } else { typed.replacen(',', ".", 1) };
        // The longest beginning that is a number: `1e5N`, and not `1` with the unit `e5N`.
        let ends = text.char_indices().map(|(at, _)| at).chain([text.len()]).rev();
        let number = |end: usize| text[..end].trim_end().parse().ok().filter(|value: &f64| value.is_finite());
        let is_digit =
            |end: &usize| text[..*end].trim_end().ends_with(|last: char| last.is_ascii_digit() || last == '.');
        let found = ends.filter(is_digit).find_map(|end| Some((number(end)?, end)));
        let Some((value, end)) = found else {
            return Err(QuantityError::NoNumber { text: text.to_owned(), example });
        };
        let known = || {
            let symbols: Vec<_> = dimensions.iter().flat_map(|of| Unit::of(*of)).map(Unit::symbol).collect();
            symbols.join(", ")
        };
        let symbol = text[end..].trim();
        if symbol.is_empty() {
            return Err(QuantityError::NoUnit { text: text.to_owned(), known: known(), example });
        }
        match Unit::parse(symbol).filter(|unit| dimensions.contains(&unit.dimension())) {
            Some(unit) => Ok(Self { si: unit.to_si(value), unit, number: text[..end].trim_end().to_owned() }),
            None => Err(QuantityError::WrongUnit { found: symbol.to_owned(), known: known(), example }),
        }
    }
}

/// As it was typed, with one space before the unit.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.number, self.unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str, dimension: Dimension) -> Result<Quantity, QuantityError> {
        Quantity::parse(text, &[dimension], "63mm")
    }

    #[test]
    fn number_and_unit_need_no_space_and_may_have_one() {
        for (text, dimension, si, shown) in [
            ("63mm", Dimension::Length, 0.063, "63 mm"),
            (" 0.3 m ", Dimension::Length, 0.3, "0.3 m"),
            ("40l/min", Dimension::Flow, 40.0 / 6e4, "40 l/min"),
            ("1e5N", Dimension::Force, 1e5, "1e5 N"),
            ("17.5 %", Dimension::Ratio, 0.175, "17.5 %"),
            ("16cm3/rev", Dimension::Displacement, 16e-6, "16 cm3/rev"),
            ("-2.5kN", Dimension::Force, -2500.0, "-2.5 kN"),
            ("63,5mm", Dimension::Length, 0.0635, "63.5 mm"),
            ("±10V", Dimension::Voltage, 10.0, "10 V"),
        ] {
            let quantity = parsed(text, dimension).unwrap();
            assert!((quantity.si / si - 1.0).abs() < 1e-12, "{text}: {}", quantity.si);
            assert_eq!(quantity.to_string(), shown);
        }
    }

    #[test]
    fn what_is_no_length_says_what_would_be() {
        let message = |text| parsed(text, Dimension::Length).unwrap_err().to_string();
        assert_eq!(message("63bar"), "`bar` is not a unit of this quantity; expected one of m, mm, such as `63mm`");
        assert!(message("63").contains("has no unit; expected one of m, mm"));
        assert!(message("1.006,3mm").contains("`,3mm` is not a unit"));
        for text in ["", "mm", "inf mm", "NaN mm", "1e999mm"] {
            assert!(parsed(text, Dimension::Length).is_err(), "{text}");
        }
        assert!(message("wide").contains("does not begin with a finite number"));
    }
}
