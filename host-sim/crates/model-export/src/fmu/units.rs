//! The units of an FMU's variables, in base units of SI and in the units that people read.
//!
//! In FMI 3.0 volt and degree Celsius have no base units: there `fmi-schema` writes the exponents of ampere and kelvin in
//! lower case, which the standard's schema does not allow.

use std::f64::consts::TAU;

use fmi_schema::{fmi2, fmi3};

use recording::Dimension;

/// A physical quantity, its unit, and the unit in which people read it.
pub(crate) struct Quantity {
    /// Its name as a type in the description.
    pub(crate) name: &'static str,
    /// SI unit.
    pub(crate) unit: &'static str,
    /// What one of the unit is in base units.
    base: Base,
    /// A unit for people, and the number of them in one SI unit.
    shown: Option<(&'static str, f64)>,
}

/// A value in base units is the value in the unit times the factor, plus the offset.
struct Base {
    /// Exponents of kg, m, s, A, K and rad.
    exponents: [i32; 6],
    factor: f64,
    offset: f64,
}

/// A unit that is a product of base units.
const fn product(exponents: [i32; 6]) -> Base {
    Base { exponents, factor: 1.0, offset: 0.0 }
}

/// The quantity of a dimension of recorded signals.
pub(crate) fn quantity(dimension: Dimension) -> Quantity {
    let (name, unit, base, shown) = match dimension {
        Dimension::Time => ("Time", "s", product([0, 0, 1, 0, 0, 0]), None),
        Dimension::Voltage => ("Voltage", "V", product([1, 2, -3, -1, 0, 0]), None),
        Dimension::Current => ("Current", "mA", Base { factor: 1e-3, ..product([0, 0, 0, 1, 0, 0]) }, None),
        Dimension::Ratio => ("Ratio", "1", product([0; 6]), None),
        Dimension::Length => ("Length", "m", product([0, 1, 0, 0, 0, 0]), Some(("mm", 1e3))),
        Dimension::Angle => ("Angle", "rad", product([0, 0, 0, 0, 0, 1]), None),
        Dimension::Speed => ("Velocity", "m/s", product([0, 1, -1, 0, 0, 0]), Some(("mm/s", 1e3))),
        Dimension::Pressure => ("Pressure", "Pa", product([1, -1, -2, 0, 0, 0]), Some(("bar", 1e-5))),
        Dimension::Force => ("Force", "N", product([1, 1, -2, 0, 0, 0]), Some(("kN", 1e-3))),
        Dimension::Flow => ("VolumeFlowRate", "m3/s", product([0, 3, -1, 0, 0, 0]), Some(("l/min", 6e4))),
        Dimension::Rotation => {
            ("RotationalFrequency", "rev/s", Base { factor: TAU, ..product([0, 0, -1, 0, 0, 1]) }, Some(("rpm", 60.0)))
        }
        Dimension::Temperature => ("Temperature", "degC", Base { offset: 273.15, ..product([0, 0, 0, 0, 1, 0]) }, None),
        Dimension::Volume => ("Volume", "m3", product([0, 3, 0, 0, 0, 0]), Some(("l", 1e3))),
        Dimension::Mass => ("Mass", "kg", product([1, 0, 0, 0, 0, 0]), None),
        Dimension::Displacement => {
            ("Displacement", "m3/rev", Base { factor: 1.0 / TAU, ..product([0, 3, 0, 0, 0, -1]) }, None)
        }
        Dimension::Frequency => ("Frequency", "Hz", product([0, 0, -1, 0, 0, 0]), None),
    };
    Quantity { name, unit, base, shown }
}

impl Quantity {
    /// The type that variables refer to, by FMI 2.0.
    pub(crate) fn simple_type(&self) -> fmi2::SimpleType {
        let real = fmi2::RealAttributes {
            quantity: Some(self.name.to_owned()),
            unit: Some(self.unit.to_owned()),
            display_unit: self.shown.map(|(unit, _)| unit.to_owned()),
            ..fmi2::RealAttributes::default()
        };
        fmi2::SimpleType { name: self.name.to_owned(), description: None, elem: fmi2::SimpleTypeElement::Real(real) }
    }

    /// The type that variables refer to, by FMI 3.0.
    pub(crate) fn float64_type(&self) -> fmi3::Float64Type {
        fmi3::Float64Type {
            name: self.name.to_owned(),
            quantity: Some(self.name.to_owned()),
            unit: Some(self.unit.to_owned()),
            display_unit: self.shown.map(|(unit, _)| unit.to_owned()),
            ..fmi3::Float64Type::default()
        }
    }

    /// The definition of its unit, by FMI 2.0.
    pub(crate) fn fmi2_unit(&self) -> fmi2::Fmi2Unit {
        let Base { exponents, factor, offset } = self.base;
        let [kg, m, s, a, k, rad] = exponents.map(|exponent| (exponent != 0).then_some(exponent));
        let shown = self.shown.map(|(name, factor)| fmi2::DisplayUnit {
            name: name.to_owned(),
            factor: Some(factor),
            ..fmi2::DisplayUnit::default()
        });
        let unless = |value: f64, default: f64| (value.to_bits() != default.to_bits()).then_some(value);
        fmi2::Fmi2Unit {
            name: self.unit.to_owned(),
            base_unit: Some(fmi2::BaseUnit {
                kg,
                m,
                s,
                a,
                k,
                rad,
                factor: unless(factor, 1.0),
                offset: unless(offset, 0.0),
                ..fmi2::BaseUnit::default()
            }),
            display_unit: shown.into_iter().collect(),
        }
    }

    /// The definition of its unit, by FMI 3.0.
    pub(crate) fn fmi3_unit(&self) -> fmi3::Fmi3Unit {
        let fmi2::Fmi2Unit { name, base_unit, display_unit } = self.fmi2_unit();
        let written = base_unit.filter(|base| base.a.is_none() && base.k.is_none());
        let base_unit = written.map(|fmi2::BaseUnit { kg, m, s, rad, factor, offset, .. }| fmi3::BaseUnit {
            kg,
            m,
            s,
            rad,
            factor,
            offset,
            ..fmi3::BaseUnit::default()
        });
        let shown =
            |fmi2::DisplayUnit { name, factor, .. }| fmi3::DisplayUnit { name, factor, ..fmi3::DisplayUnit::default() };
        fmi3::Fmi3Unit {
            name,
            base_unit,
            display_unit: display_unit.into_iter().map(shown).collect(),
            ..fmi3::Fmi3Unit::default()
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
