//! From a command to the counts of the output.

use model_core::number::PerUnit;

use super::line::StraightLine;
use super::scale::{Band, CalibrationError, Counts, ONE, counts_per_volt};
use crate::measured::AnalogSignal;

/// The output to the valve, as its amplifier's data state it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    /// Voltage that is put out for the command 0 V.
    pub zero_v: f64,
    /// Voltage that is put out for the command 10 V.
    pub full_v: f64,
    /// Lowest voltage that is put out.
    pub lowest_v: f64,
    /// Highest voltage that is put out.
    pub highest_v: f64,
}

/// The output in whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    line: StraightLine,
    within: Counts,
}

impl Output {
    /// From an actuator on an output whose 2¹⁶ counts are `span_uv` µV.
    ///
    /// # Errors
    /// The actuator's voltages do not define a line, or its limits are not valid.
    pub fn new(actuator: &Actuator, span_uv: u32) -> Result<Self, CalibrationError> {
        let Actuator { zero_v, full_v, lowest_v, highest_v } = *actuator;
        let refused = CalibrationError::Output { zero_v, full_v, lowest_v, highest_v };
        let per_volt = counts_per_volt(span_uv);
        let line = StraightLine::new((full_v - zero_v) * per_volt / ONE, zero_v * per_volt).ok_or(refused)?;
        let band = Band { from_v: lowest_v, to_v: highest_v };
        let within = Counts::of(band, AnalogSignal::Command, span_uv).map_err(|_| refused)?;
        Ok(Self { line, within })
    }

    /// The count for a command in units of 10 V, held within the limits.
    #[must_use]
    pub fn count(&self, command: PerUnit) -> i32 {
        // `clamp` would panic if these limits were in the wrong order.
        self.line.at(command.to_bits().into()).max(self.within.lowest).min(self.within.highest)
    }

    /// Lowest and highest count that is put out.
    #[must_use]
    pub fn limits(&self) -> [i32; 2] {
        [self.within.lowest, self.within.highest]
    }
}

#[cfg(test)]
mod tests {
    use model_core::number::Number;

    use super::*;

    #[test]
    fn ten_volts_are_full_scale_of_the_converter_and_what_is_more_is_held() {
        let actuator = Actuator { zero_v: 0.0, full_v: 10.0, lowest_v: -9.5, highest_v: 9.0 };
        let output = Output::new(&actuator, 20_000_000).unwrap();
        assert_eq!(output.count(PerUnit::saturated(0.5)), 16_384);
        assert_eq!(output.count(PerUnit::ONE), 29_491); // 9 V
        assert_eq!(output.count(PerUnit::saturated(-8.0)), -31_130); // -9.5 V
        let none = Actuator { lowest_v: 1.0, highest_v: -1.0, ..actuator };
        assert!(matches!(Output::new(&none, 20_000_000), Err(CalibrationError::Output { .. })));
    }
}
