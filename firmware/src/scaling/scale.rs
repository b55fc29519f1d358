//! Common parts of all scales: bands of voltages and counts, the word for 1, and the errors.

use crate::measured::AnalogSignal;

/// The word for 1.
pub(super) const ONE: f64 = (1_u32 << 28) as f64;

/// A band of voltages, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Lower end, V.
    pub from_v: f64,
    /// Upper end, V.
    pub to_v: f64,
}

/// Why a calibration table is not valid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CalibrationError {
    /// Two points of a line coincide, or its slope does not fit.
    #[error("{signal:?}: {per_count:e} per unit a count; expected a magnitude of about 4e-9 to 1")]
    Slope {
        /// Which sensor.
        signal: AnalogSignal,
        /// Slope, per unit per count.
        per_count: f64,
    },
    /// A band ends before it starts, or lies beyond all counts.
    #[error("{signal:?}: band from {from_v} V to {to_v} V; expected two voltages in rising order")]
    Band {
        /// Which sensor.
        signal: AnalogSignal,
        /// Lower end, V.
        from_v: f64,
        /// Upper end, V.
        to_v: f64,
    },
    /// An open wire cannot be distinguished from a working sensor.
    #[error(
        "{signal:?}: an open wire reads {from_v} V to {to_v} V, where a working sensor does too; expected them apart"
    )]
    OpenWithinWorking {
        /// Which sensor.
        signal: AnalogSignal,
        /// Lower end of the open wire's band, V.
        from_v: f64,
        /// Its upper end, V.
        to_v: f64,
    },
    /// The position's scale does not fit.
    #[error(
        "position: {per_m} counts a metre, {reference_m} m at the reference; expected about 1e2 to 1e9 counts a metre"
    )]
    Position {
        /// Counts per metre.
        per_m: f64,
        /// Position at the reference, m.
        reference_m: f64,
    },
    /// The output's scale does not fit.
    #[error("output: {zero_v} V to {full_v} V for the command 0 to full, held within {lowest_v} V to {highest_v} V")]
    Output {
        /// Voltage at command 0.
        zero_v: f64,
        /// Voltage at the largest command.
        full_v: f64,
        /// Lowest voltage.
        lowest_v: f64,
        /// Highest voltage.
        highest_v: f64,
    },
}

/// A range of counts, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) lowest: i32,
    pub(super) highest: i32,
}

impl Counts {
    pub(super) fn of(band: Band, signal: AnalogSignal, span_uv: u32) -> Result<Self, CalibrationError> {
        let Band { from_v, to_v } = band;
        let count = |volts: f64| {
            let count = libm::round(volts * counts_per_volt(span_uv));
            #[expect(clippy::cast_possible_truncation, reason = "within the limits just checked")]
            let whole = (count.abs() <= f64::from(i32::MAX)).then_some(count as i32);
            whole
        };
        match (count(from_v), count(to_v)) {
            (Some(lowest), Some(highest)) if lowest < highest => Ok(Self { lowest, highest }),
            _ => Err(CalibrationError::Band { signal, from_v, to_v }),
        }
    }

    pub(super) fn hold(self, count: i32) -> bool {
        self.lowest <= count && count <= self.highest
    }
}

pub(super) fn counts_per_volt(span_uv: u32) -> f64 {
    65_536.0 * 1e6 / f64::from(span_uv)
}
