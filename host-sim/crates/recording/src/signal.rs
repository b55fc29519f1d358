//! The signals that a recording may hold.

use std::fmt;

use crate::unit::{Dimension, Unit};

macro_rules! signals {
    ($($variant:ident $name:literal [$($dimension:ident)+] $meaning:literal;)*) => {
        /// A measured or commanded quantity of a drive.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Signal { $(#[doc = $meaning] $variant,)* }

        impl Signal {
            /// Every signal, in the usual order of a list.
            pub const ALL: &'static [Signal] = &[$(Signal::$variant,)*];

            /// The name that stands in a recording's header.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Signal::$variant => $name,)* }
            }

            /// The quantities that its unit may measure; where there are several, the first is the usual one.
            #[must_use]
            pub const fn dimensions(self) -> &'static [Dimension] {
                match self { $(Signal::$variant => &[$(Dimension::$dimension,)+],)* }
            }
        }
    };
}

signals! {
    Time "time" [Time] "Time, s; starts anywhere.";
    Command "command" [Voltage Current] "Command to the valve, V or mA; positive extends.";
    Spool "spool" [Ratio] "Spool position as a part of full travel, 1; positive extends.";
    Flow "flow" [Flow] "Flow into chamber A, m³/s; positive extends.";
    PumpSpeed "pump_speed" [Rotation] "Speed of the pump, rev/s.";
    ValveDirection "valve_direction" [Ratio] "Directional valve: 1 leads the pump to A, -1 to B, 0 is closed.";
    PressureA "pressure_a" [Pressure] "Pressure in chamber A, Pa; it extends.";
    PressureB "pressure_b" [Pressure] "Pressure in chamber B, Pa; it retracts.";
    SupplyPressure "supply_pressure" [Pressure] "Supply pressure at the valve, Pa.";
    TankPressure "tank_pressure" [Pressure] "Pressure of the return line, Pa.";
    OtherFlow "other_flow" [Flow] "Flow that another consumer takes from the same supply, m³/s; its size counts, not its sign.";
    OtherFlow2 "other_flow_2" [Flow] "The same of a second one, m³/s.";
    OtherFlow3 "other_flow_3" [Flow] "The same of a third one, m³/s.";
    LoadForce "load_force" [Force] "External force on the rod, N; positive extends.";
    Force "force" [Force] "Force measured at the rod, N; positive extends.";
    Position "position" [Length] "Position of the rod, m; 0 is fully in, positive is out.";
    Velocity "velocity" [Speed] "Velocity of the rod, m/s; positive extends.";
    Angle "angle" [Angle] "Angle of the joint, rad.";
    OilTemperature "oil_temperature" [Temperature] "Temperature of the oil, °C.";
    Reference "reference" [Length Angle] "Set value of the position control, m (or rad of the joint).";
}

impl Signal {
    /// What other consumers take from the same supply.
    pub const OTHER_FLOWS: [Signal; 3] = [Signal::OtherFlow, Signal::OtherFlow2, Signal::OtherFlow3];

    /// The signal of this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|signal| signal.name() == name).copied()
    }

    /// Its usual unit inside the program.
    #[must_use]
    pub fn si_unit(self) -> Unit {
        Unit::si(self.dimensions()[0])
    }

    /// Whether a header may leave the unit out: only pure numbers may.
    #[must_use]
    pub fn is_dimensionless(self) -> bool {
        self.dimensions() == [Dimension::Ratio]
    }

    /// Whether it is a pressure.
    #[must_use]
    pub fn is_pressure(self) -> bool {
        self.dimensions() == [Dimension::Pressure]
    }

    /// The known units in which it may be recorded, for messages: `V mV mA`.
    #[must_use]
    pub fn units(self) -> String {
        let symbols: Vec<_> = self.dimensions().iter().flat_map(|&d| Unit::of(d)).map(Unit::symbol).collect();
        symbols.join(" ")
    }
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Splits a column header: `Kolbenweg [mm]` is the name `Kolbenweg` with the unit `mm`.
///
/// The unit stands in the last pair of brackets, where the header ends with it. A known unit of a signal may also stand as in `Kolbenweg (mm)`,
/// `Kolbenweg in mm` or, after the standard on quantities and units, `Kolbenweg/mm`.
#[must_use]
pub(crate) fn split_header(header: &str) -> (&str, Option<&str>) {
    let header = header.trim();
    match header.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        Some((name, unit)) if !unit.trim().is_empty() => (name.trim(), Some(unit.trim())),
        Some((name, _)) => (name.trim(), None),
        None => split_other(header).map_or((header, None), |(name, unit)| (name, Some(unit))),
    }
}

/// A header whose unit does not stand in brackets.
fn split_other(header: &str) -> Option<(&str, &str)> {
    let known = |(name, unit): (&'_ str, &'_ str)| {
        let written = unit.trim();
        // `Weg (1)` is the second of two columns, `Rig/1` an address, and `U(t)` a function; `spool/1` and `Schieber (-)` are pure numbers.
        let is_pure = written == "-"
            || Signal::parse(name.trim()).is_some_and(|signal| signal.is_dimensionless() || header.contains('/'));
        let unit = Unit::parse(written).filter(|unit| unit.symbol() != "1" || is_pure)?;
        let is_recorded = Signal::ALL.iter().any(|signal| signal.dimensions().contains(&unit.dimension()));
        (is_recorded && !name.trim().is_empty()).then_some(())
    };
    let in_parentheses = header.strip_suffix(')').and_then(|rest| rest.rsplit_once('('));
    // In `v/mm/s` the first stroke counts, in `Rig/v/s` the last one.
    let strokes = header.match_indices('/').map(|(at, _)| (&header[..at], &header[at + 1..]));
    let by_stroke = strokes.map(|(name, unit)| (name, unit.trim().trim_start_matches('(').trim_end_matches(')')));
    let mut all = in_parentheses.into_iter().chain(header.rsplit_once(" in ")).chain(by_stroke);
    let (name, unit) = all.find(|parts| known(*parts).is_some())?;
    Some((name.trim().trim_end_matches('/').trim(), unit.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_signal_is_found_by_its_name_and_has_an_si_unit() {
        for &signal in Signal::ALL {
            assert_eq!(Signal::parse(signal.name()), Some(signal));
            assert_eq!(signal.si_unit().dimension(), signal.dimensions()[0]);
        }
        assert_eq!(Signal::PumpSpeed.si_unit().symbol(), "rev/s");
        assert_eq!(Signal::Command.units(), "V mV mA");
    }

    #[test]
    fn a_header_is_a_name_and_a_unit_in_brackets() {
        assert_eq!(split_header(" Kolbenweg [mm] "), ("Kolbenweg", Some("mm")));
        assert_eq!(split_header("a[1].p [bar]"), ("a[1].p", Some("bar")));
        assert_eq!(split_header("valve_direction"), ("valve_direction", None));
        assert_eq!(split_header("position []"), ("position", None));
        assert_eq!(split_header("Kolbenweg (mm)"), ("Kolbenweg", Some("mm")));
        assert_eq!(split_header("pressure_a(bar)"), ("pressure_a", Some("bar")));
        assert_eq!(split_header("Zeit/s"), ("Zeit", Some("s")));
        assert_eq!(split_header("v/mm/s"), ("v", Some("mm/s")));
        assert_eq!(split_header("v / (mm/s)"), ("v", Some("mm/s")));
        assert_eq!(split_header("Kolbenweg in mm"), ("Kolbenweg", Some("mm")));
        for pure in ["spool (-)", "spool/1", "spool / -", "spool (1)", "Schieber (-)"] {
            let (name, unit) = split_header(pure);
            assert!(["spool", "Schieber"].contains(&name) && unit.and_then(Unit::parse) == Unit::parse("1"), "{pure}");
        }
        for plain in
            ["position (1)", "Rig/1", "Kolbenweg (1)", "U(t)", "x (raw)", "Model/Weg/Out1", "/s", "(mm)", "built in"]
        {
            assert_eq!(split_header(plain), (plain, None));
        }
    }
}
