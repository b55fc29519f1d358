//! The units of an FMU's variables, in base units of SI and in the units that people read.
//!
//! Volt and degree Celsius have no base units here: `fmi-schema` writes the exponents of ampere and kelvin in lower case,
//! which the standard's schema does not allow.

use std::f64::consts::TAU;

use fmi_schema::fmi3::{BaseUnit, DisplayUnit, Float64Type, Fmi3Unit};

use recording::Dimension;

/// A physical quantity, its unit, and the unit in which people read it.
pub(crate) struct Quantity {
    /// Its name as a type in the description.
    pub(crate) name: &'static str,
    /// SI unit.
    pub(crate) unit: &'static str,
    /// Exponents of kg, m, s and rad, and the number of such base units in one of the unit.
    base: Option<([i32; 4], f64)>,
    /// A unit for people, and the number of them in one SI unit.
    shown: Option<(&'static str, f64)>,
}

/// The quantity of a dimension of recorded signals.
pub(crate) fn quantity(dimension: Dimension) -> Quantity {
    let (name, unit, base, shown) = match dimension {
        Dimension::Time => ("Time", "s", Some(([0, 0, 1, 0], 1.0)), None),
        Dimension::Voltage => ("Voltage", "V", None, None),
        Dimension::Current => ("Current", "mA", None, None),
        Dimension::Ratio => ("Ratio", "1", Some(([0; 4], 1.0)), None),
        Dimension::Length => ("Length", "m", Some(([0, 1, 0, 0], 1.0)), Some(("mm", 1e3))),
        Dimension::Angle => ("Angle", "rad", Some(([0, 0, 0, 1], 1.0)), None),
        Dimension::Speed => ("Velocity", "m/s", Some(([0, 1, -1, 0], 1.0)), Some(("mm/s", 1e3))),
        Dimension::Pressure => ("Pressure", "Pa", Some(([1, -1, -2, 0], 1.0)), Some(("bar", 1e-5))),
        Dimension::Force => ("Force", "N", Some(([1, 1, -2, 0], 1.0)), Some(("kN", 1e-3))),
        Dimension::Flow => ("VolumeFlowRate", "m3/s", Some(([0, 3, -1, 0], 1.0)), Some(("l/min", 6e4))),
        Dimension::Rotation => ("RotationalFrequency", "rev/s", Some(([0, 0, -1, 1], TAU)), Some(("rpm", 60.0))),
        Dimension::Temperature => ("Temperature", "degC", None, None),
        Dimension::Volume => ("Volume", "m3", Some(([0, 3, 0, 0], 1.0)), Some(("l", 1e3))),
        Dimension::Mass => ("Mass", "kg", Some(([1, 0, 0, 0], 1.0)), None),
        Dimension::Displacement => ("Displacement", "m3/rev", Some(([0, 3, 0, -1], 1.0 / TAU)), None),
        Dimension::Frequency => ("Frequency", "Hz", Some(([0, 0, -1, 0], 1.0)), None),
    };
    Quantity { name, unit, base, shown }
}

impl Quantity {
    /// The type that variables refer to.
    pub(crate) fn declared(&self) -> Float64Type {
        Float64Type {
            name: self.name.to_owned(),
            quantity: Some(self.name.to_owned()),
            unit: Some(self.unit.to_owned()),
            display_unit: self.shown.map(|(unit, _)| unit.to_owned()),
            ..Float64Type::default()
        }
    }

    /// The definition of its unit.
    pub(crate) fn defined(&self) -> Fmi3Unit {
        let exponent = |exponent: i32| (exponent != 0).then_some(exponent);
        let base_unit = self.base.map(|([kg, m, s, rad], factor)| BaseUnit {
            kg: exponent(kg),
            m: exponent(m),
            s: exponent(s),
            rad: exponent(rad),
            factor: (factor.to_bits() != 1.0_f64.to_bits()).then_some(factor),
            ..BaseUnit::default()
        });
        let shown = self.shown.map(|(name, factor)| DisplayUnit {
            name: name.to_owned(),
            factor: Some(factor),
            ..DisplayUnit::default()
        });
        Fmi3Unit {
            name: self.unit.to_owned(),
            base_unit,
            display_unit: shown.into_iter().collect(),
            ..Fmi3Unit::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use recording::Unit;

    use super::*;

    #[test]
    fn a_unit_is_called_as_in_a_recording_and_shown_by_the_same_factor() {
        let all = [
            Dimension::Time,
            Dimension::Voltage,
            Dimension::Ratio,
            Dimension::Length,
            Dimension::Speed,
            Dimension::Pressure,
            Dimension::Force,
            Dimension::Flow,
            Dimension::Rotation,
        ];
        for dimension in all {
            let quantity = quantity(dimension);
            assert_eq!(quantity.unit, Unit::si(dimension).symbol());
            if let Some((shown, factor)) = quantity.shown {
                let unit = Unit::of(dimension).find(|unit| unit.symbol() == shown).unwrap();
                assert!((unit.to_si(factor) - 1.0).abs() < 1e-12, "{shown}");
            }
        }
    }
}
