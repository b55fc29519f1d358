//! Numbers as people read them: mm, bar, per cent of spool travel, and only as many digits as are significant.

use comfy_table::{ContentArrangement, LineStyle, Table, TableStyle};

use crate::recording::Column;
use crate::signal::Signal;
use crate::unit::{Dimension, Unit};

/// Tables with a line above, below, and under the header.
pub const TABLE: TableStyle = TableStyle::new()
    .top_border(LineStyle::none().fill('─').junction('─'))
    .header_separator(LineStyle::none().fill('─').junction('─'))
    .bottom_border(LineStyle::none().fill('─').junction('─'));

/// Sets a table's width in characters, or lets it follow from its cells. The terminal of this process is not queried.
pub fn arrange(table: &mut Table, width: Option<u16>) {
    #[cfg(not(target_family = "wasm"))]
    table.force_no_tty();
    match width {
        Some(width) => table.set_content_arrangement(ContentArrangement::Dynamic).set_width(width),
        None => table.set_content_arrangement(ContentArrangement::Disabled),
    };
}

/// The unit in which tables and plots show a signal: mm, mm/s, bar, l/min, %, kN …, in whatever unit it was recorded.
#[must_use]
pub fn unit_for_people(signal: Signal) -> Unit {
    let si = signal.si_unit();
    let symbol = match si.dimension() {
        Dimension::Length => "mm",
        Dimension::Speed => "mm/s",
        Dimension::Pressure => "bar",
        Dimension::Flow => "l/min",
        Dimension::Angle => "deg",
        Dimension::Rotation => "rpm",
        Dimension::Ratio if signal == Signal::Spool => "%",
        _ => return si,
    };
    Unit::parse(symbol).unwrap_or(si)
}

/// The same for a column: a current in mA is not shown as a voltage.
#[must_use]
pub fn unit_of(column: &Column) -> Unit {
    let (usual, own) = (unit_for_people(column.signal), Unit::si(column.unit.dimension()));
    if usual.dimension() == own.dimension() { usual } else { own }
}

/// The unit in which people read a state of the drive that has this SI unit, and what to multiply by.
#[must_use]
pub fn state_unit(si: &'static str) -> (&'static str, f64) {
    match si {
        "1" => ("% of travel", 100.0),
        "m" => ("mm", 1e3),
        "m/s" => ("mm/s", 1e3),
        "Pa" => ("bar", 1e-5),
        other => (other, 1.0),
    }
}

/// A difference of two values of `signal` with its unit: `0.0312 mm`; of the spool `0.41 % of travel`.
#[must_use]
pub fn difference(signal: Signal, si: f64) -> String {
    let unit = unit_for_people(signal);
    let number = significant(unit.from_si(si) - unit.from_si(0.0), 3);
    if signal == Signal::Spool { format!("{number} % of travel") } else { format!("{number} {unit}") }
}

/// A number with so many significant digits, without powers of ten: `1234`, `0.00123`; zero is `0`.
#[must_use]
pub fn significant(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    // Smaller than any sensor resolves, in any of these units.
    if value.abs() < 1e-9 {
        return "0".into();
    }
    // The exponent after rounding: 0.09999 with three digits is 0.100.
    let precision = usize::try_from(digits - 1).unwrap_or(0);
    let scientific = format!("{value:.precision$e}");
    let exponent = scientific.rsplit_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0_i32);
    let decimals = usize::try_from((digits - 1 - exponent).clamp(0, 12)).unwrap_or(0);
    format!("{value:.decimals$}")
}

/// A value in SI units with this many significant digits: plain where people write it so, with a power of ten where it has many zeros.
#[must_use]
pub fn in_si(value: f64, digits: i32) -> String {
    let plain = 1e-3..f64::powi(10.0, digits.max(4));
    if value == 0.0 || plain.contains(&value.abs()) || !value.is_finite() {
        return significant(value, digits);
    }
    let precision = usize::try_from(digits - 1).unwrap_or(0);
    format!("{value:.precision$e}")
}

/// A percentage that never hides a small difference from 100: `99.9987` and not `100.00`.
#[must_use]
pub fn percent(value: f64) -> String {
    let missing = (100.0 - value).abs();
    let decimals = if missing >= 0.05 || missing == 0.0 { 2 } else { 4 };
    let text = format!("{value:.decimals$}");
    // A fit just below zero is shown as zero.
    if text == "-0.00" { "0.00".to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_in_units_people_read() {
        assert_eq!(difference(Signal::Position, 3.12e-5), "0.0312 mm");
        assert_eq!(difference(Signal::PressureA, 123_456.0), "1.23 bar");
        assert_eq!(difference(Signal::Spool, 0.0041), "0.410 % of travel");
        assert_eq!(difference(Signal::OilTemperature, 2.0), "2.00 °C");
    }

    #[test]
    fn significant_digits_have_no_powers_of_ten() {
        assert_eq!(significant(1234.5, 3), "1234");
        assert_eq!(significant(-0.001_234_5, 3), "-0.00123");
        assert_eq!(significant(0.099_99, 3), "0.100");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(f64::INFINITY, 3), "inf");
    }

    #[test]
    fn a_value_in_si_units_has_a_power_of_ten_only_where_it_has_many_zeros() {
        assert_eq!(in_si(0.132_649, 5), "0.13265");
        assert_eq!(in_si(-7.0e6, 5), "-7.0000e6");
        assert_eq!(in_si(2.966e-12, 3), "2.97e-12");
        assert_eq!((in_si(98_765.4, 5), in_si(98_765.4, 2)), ("98765".into(), "9.9e4".into()));
        assert_eq!((in_si(0.0, 5), in_si(f64::NAN, 2)), ("0".into(), "NaN".into()));
    }

    #[test]
    fn a_small_miss_is_not_rounded_away() {
        assert_eq!(
            (percent(99.9987), percent(98.456), percent(100.0)),
            ("99.9987".into(), "98.46".into(), "100.00".into())
        );
        assert_eq!(percent(-1e-4), "0.00");
    }
}
