//! Units of measure of recorded signals, and their conversion to SI and back.

use std::fmt;

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// Time, s.
    Time,
    /// Voltage, V.
    Voltage,
    /// Current of a current-driven valve, mA; it is not converted to V.
    Current,
    /// A pure number, 1.
    Ratio,
    /// Length, m.
    Length,
    /// Angle, rad.
    Angle,
    /// Speed, m/s.
    Speed,
    /// Turns per time, rev/s.
    Rotation,
    /// Pressure, Pa.
    Pressure,
    /// Force, N.
    Force,
    /// Volume flow, m³/s.
    Flow,
    /// Temperature, °C.
    Temperature,
    /// Volume, m³; only in data sheets, not a signal.
    Volume,
    /// Mass, kg; only in data sheets, not a signal.
    Mass,
    /// Oil per turn of a pump, m³/rev; only in data sheets, not a signal.
    Displacement,
    /// Frequency, Hz; only in data sheets, not a signal.
    Frequency,
}

/// A unit of measure: `si = value · multiply / divide + add`.
///
/// Factors are split into multiplier and divisor so that every conversion by a power of ten is correctly rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    symbol: &'static str,
    dimension: Dimension,
    multiply: f64,
    divide: f64,
    add: f64,
}

const fn unit(symbol: &'static str, dimension: Dimension, multiply: f64, divide: f64, add: f64) -> Unit {
    Unit { symbol, dimension, multiply, divide, add }
}

/// Adding it changes no number, not even -0.0; adding +0.0 would turn -0.0 into 0.0.
const NO_OFFSET: f64 = -0.0;

/// Pressure of the air, Pa: what an absolute sensor reads more than one whose zero is the air. Source: the standard atmosphere.
pub const ATMOSPHERE_PA: f64 = 101_325.0;

const PSI_PA: f64 = 6_894.757_293_168_361;

/// Every known unit; the first unit of a dimension is the one used inside the program.
const UNITS: &[Unit] = &[
    unit("s", Dimension::Time, 1.0, 1.0, NO_OFFSET),
    unit("ms", Dimension::Time, 1.0, 1e3, NO_OFFSET),
    unit("µs", Dimension::Time, 1.0, 1e6, NO_OFFSET),
    unit("V", Dimension::Voltage, 1.0, 1.0, NO_OFFSET),
    unit("mV", Dimension::Voltage, 1.0, 1e3, NO_OFFSET),
    unit("mA", Dimension::Current, 1.0, 1.0, NO_OFFSET),
    unit("1", Dimension::Ratio, 1.0, 1.0, NO_OFFSET),
    unit("%", Dimension::Ratio, 1.0, 1e2, NO_OFFSET),
    unit("m", Dimension::Length, 1.0, 1.0, NO_OFFSET),
    unit("mm", Dimension::Length, 1.0, 1e3, NO_OFFSET),
    unit("rad", Dimension::Angle, 1.0, 1.0, NO_OFFSET),
    unit("deg", Dimension::Angle, std::f64::consts::PI, 180.0, NO_OFFSET),
    unit("m/s", Dimension::Speed, 1.0, 1.0, NO_OFFSET),
    unit("mm/s", Dimension::Speed, 1.0, 1e3, NO_OFFSET),
    unit("rev/s", Dimension::Rotation, 1.0, 1.0, NO_OFFSET),
    unit("rpm", Dimension::Rotation, 1.0, 60.0, NO_OFFSET),
    unit("rad/s", Dimension::Rotation, 1.0, std::f64::consts::TAU, NO_OFFSET),
    unit("Pa", Dimension::Pressure, 1.0, 1.0, NO_OFFSET),
    unit("kPa", Dimension::Pressure, 1e3, 1.0, NO_OFFSET),
    unit("MPa", Dimension::Pressure, 1e6, 1.0, NO_OFFSET),
    unit("bar", Dimension::Pressure, 1e5, 1.0, NO_OFFSET),
    unit("psi", Dimension::Pressure, PSI_PA, 1.0, NO_OFFSET),
    unit("N", Dimension::Force, 1.0, 1.0, NO_OFFSET),
    unit("kN", Dimension::Force, 1e3, 1.0, NO_OFFSET),
    unit("m3/s", Dimension::Flow, 1.0, 1.0, NO_OFFSET),
    unit("l/min", Dimension::Flow, 1.0, 6e4, NO_OFFSET),
    unit("°C", Dimension::Temperature, 1.0, 1.0, NO_OFFSET),
    unit("K", Dimension::Temperature, 1.0, 1.0, -273.15),
    unit("m3", Dimension::Volume, 1.0, 1.0, NO_OFFSET),
    unit("l", Dimension::Volume, 1.0, 1e3, NO_OFFSET),
    unit("cm3", Dimension::Volume, 1.0, 1e6, NO_OFFSET),
    unit("kg", Dimension::Mass, 1.0, 1.0, NO_OFFSET),
    unit("t", Dimension::Mass, 1e3, 1.0, NO_OFFSET),
    unit("m3/rev", Dimension::Displacement, 1.0, 1.0, NO_OFFSET),
    unit("Hz", Dimension::Frequency, 1.0, 1.0, NO_OFFSET),
    unit("cm3/rev", Dimension::Displacement, 1.0, 1e6, NO_OFFSET),
];

impl Unit {
    /// The unit with this symbol, if it is a known one.
    ///
    /// Besides the symbols of the file format it accepts other spellings of the same unit:
    /// both Unicode micro signs and `us`, `m³/s`, `L/min`, `1/min`, `sec`, `degC`, `Bar` and their like, and `-` for a pure number.
    #[must_use]
    pub fn parse(symbol: &str) -> Option<Self> {
        let plain = match symbol.trim() {
            "us" | "μs" | "usec" => "µs",
            "sec" | "Sec" | "second" | "seconds" | "Seconds" => "s",
            "msec" | "milliseconds" => "ms",
            "m³/s" => "m3/s",
            "L/min" | "lpm" => "l/min",
            "1/min" | "min-1" | "min⁻¹" | "U/min" | "RPM" => "rpm",
            "mm/sec" => "mm/s",
            "m/sec" => "m/s",
            "°" | "degree" | "degrees" => "deg",
            "degC" | "℃" => "°C",
            "Bar" => "bar",
            "Volt" => "V",
            "-" => "1",
            other => other,
        };
        UNITS.iter().find(|unit| unit.symbol == plain).copied()
    }

    /// The unit of a dimension in which the program computes.
    #[must_use]
    #[expect(clippy::missing_panics_doc, reason = "the table has a unit for every dimension")]
    pub fn si(dimension: Dimension) -> Self {
        *UNITS.iter().find(|unit| unit.dimension == dimension).expect("the table has a unit for every dimension")
    }

    /// The unit of a sensor that measures another quantity: its readings become values of `dimension` by (reading − zero)/full.
    pub(crate) fn of_sensor(readings_in: Option<Self>, dimension: Dimension, zero: f64, full: f64) -> Self {
        let symbol = readings_in.map_or("reading", Self::symbol);
        Self { symbol, dimension, multiply: 1.0, divide: full, add: -zero / full }
    }

    /// This unit of a pressure, read by a sensor whose zero is the vacuum.
    pub(crate) fn absolute(self) -> Self {
        Self { add: self.add - ATMOSPHERE_PA, ..self }
    }

    /// Every known unit.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        UNITS.iter().copied()
    }

    /// Every known unit of a dimension, SI first.
    pub fn of(dimension: Dimension) -> impl Iterator<Item = Self> {
        UNITS.iter().filter(move |unit| unit.dimension == dimension).copied()
    }

    /// The symbol as it stands in a header.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        self.symbol
    }

    /// What it measures.
    #[must_use]
    pub fn dimension(self) -> Dimension {
        self.dimension
    }

    /// Converts a value in this unit to SI.
    #[must_use]
    pub fn to_si(self, value: f64) -> f64 {
        value * self.multiply / self.divide + self.add
    }

    /// Converts an SI value to this unit.
    #[must_use]
    pub fn from_si(self, si: f64) -> f64 {
        (si - self.add) * self.divide / self.multiply
    }

    /// The decimal text of an SI value in this unit.
    ///
    /// An SI unit gives the shortest text that reads back to the same bits; other units give 15
    /// significant digits, which hides the rounding of the conversion.
    #[must_use]
    pub fn print(self, si: f64) -> String {
        if self == Self::si(self.dimension) {
            return shortest(si);
        }
        let value = self.from_si(si);
        // A sensor's zero reading has no sign of its own.
        let value = if value == 0.0 && si != 0.0 { 0.0 } else { value };
        shortest(format!("{value:.14e}").parse().unwrap_or(value))
    }
}

/// Shortest text that reads back to the same bits; powers of ten only where there would be many zeros.
fn shortest(value: f64) -> String {
    format!("{value:?}").trim_end_matches(".0").to_owned()
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn si(symbol: &str, value: f64) -> f64 {
        Unit::parse(symbol).unwrap().to_si(value)
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "conversions by powers of ten are correctly rounded")]
    fn every_unit_converts_as_a_table_of_units_says() {
        assert_eq!(si("bar", 70.0), 7.0e6);
        assert_eq!(si("MPa", 7.0), 7.0e6);
        assert_eq!(si("kPa", 7.0), 7.0e3);
        assert_eq!(si("mm", 0.1), 1e-4);
        assert_eq!(si("ms", 1.0), 1e-3);
        assert_eq!(si("us", 3.0), 3e-6);
        assert_eq!(si("mV", 4000.0), 4.0);
        assert_eq!(si("mA", 12.0), 12.0);
        assert_eq!(si("%", 50.0), 0.5);
        assert_eq!(si("rpm", 1500.0), 25.0);
        assert_eq!(si("l/min", 60.0), 1e-3);
        assert_eq!(si("kN", 2.0), 2e3);
        assert_eq!(si("mm/s", 250.0), 0.25);
        assert_eq!(si("deg", 180.0), std::f64::consts::PI);
        assert_eq!(si("rad/s", std::f64::consts::TAU), 1.0);
        assert_eq!(si("K", 300.0), 300.0 - 273.15);
        assert!((si("psi", 14.503_773_773) - 1e5).abs() < 1e-4);
    }

    #[test]
    fn what_was_typed_in_any_unit_is_printed_again() {
        for unit in UNITS {
            for typed in ["0.1", "123.456", "-7.25", "0.000123", "5.1250"] {
                let value: f64 = typed.parse().unwrap();
                let printed: f64 = unit.print(unit.to_si(value)).parse().unwrap();
                // The offset of a temperature causes an absolute rounding error, not a relative one.
                assert!((printed - value).abs() <= 1e-13, "{typed} {unit}: {printed}");
            }
        }
        assert_eq!(Unit::parse("mm").unwrap().print(1e-4), "0.1");
        let spelt =
            ["sec", "L/min", "1/min", "mm/sec", "°", "degC", "Bar"].map(|text| Unit::parse(text).unwrap().symbol());
        assert_eq!(spelt, ["s", "l/min", "rpm", "mm/s", "deg", "°C", "bar"]);
    }

    #[test]
    fn unknown_symbols_are_not_guessed() {
        for symbol in ["", "MM", "Mpa", "mbar", "V ]", "inch"] {
            assert_eq!(Unit::parse(symbol), None, "{symbol}");
        }
    }
}
