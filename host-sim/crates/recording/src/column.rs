//! A known column of a recording, and how its values follow from what the file holds.

use std::sync::Arc;

use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::linkage::Linkage;
use crate::signal::{Signal, split_header};
use crate::unit::Unit;

/// One known column of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The header as in the file, with its unit: `Kolbenweg [mm]`.
    pub header: String,
    /// What it holds.
    pub signal: Signal,
    /// The unit that the file uses.
    pub unit: Unit,
    /// The values in SI units, one for each row.
    pub values: Vec<f64>,
    /// Where the file does not hold them but the angle of the joint: how they follow from it.
    pub from_angle: Option<FromAngle>,
}

/// How positions follow from the column of a joint's angle.
#[derive(Clone, Debug, PartialEq)]
pub struct FromAngle {
    /// The unit in which the file holds the angle.
    pub unit: Unit,
    /// What turns angles into positions.
    pub linkage: Arc<Linkage>,
}

impl Column {
    /// A column of the file, still without values.
    pub(crate) fn of_file(header: String, signal: Signal, unit: Unit) -> Self {
        Self { header, signal, unit, values: Vec::new(), from_angle: None }
    }

    /// The positions that follow from a column of angles, still without values.
    pub(crate) fn position_from(angle: &Self, linkage: &Arc<Linkage>) -> Self {
        let from_angle = Some(FromAngle { unit: angle.unit, linkage: Arc::clone(linkage) });
        Self { from_angle, ..Self::si(Signal::Position, Vec::new()) }
    }

    /// Whether this column of times, called `name` in the file, is an index: it is called so and counts rows one by one.
    pub(crate) fn is_index(&self, name: &str) -> bool {
        const NAMES: [&str; 10] =
            ["index", "idx", "unnamed: 0", "level_0", "__index_level_0__", "row", "row number", "#", "no", "nr"];
        let name = split_header(name).0.trim_end_matches('.').to_lowercase();
        let counts = |pair: &[f64]| (self.unit.from_si(pair[1]) - self.unit.from_si(pair[0]) - 1.0).abs() < 1e-9;
        NAMES.contains(&name.as_str()) && self.values.windows(2).all(counts)
    }

    /// The value in SI units of what the file holds; `None` for an angle that the linkage does not reach.
    pub(crate) fn read(&self, value: f64) -> Option<f64> {
        match &self.from_angle {
            None => Some(self.unit.to_si(value)),
            Some(FromAngle { unit, linkage }) => linkage.position_m(unit.to_si(value)),
        }
    }

    /// The error of an angle, as the file holds it, that the linkage does not reach.
    pub(crate) fn out_of_reach(&self, place: Place, found: f64) -> RecordingError {
        let unit = self.from_angle.as_ref().map_or(self.unit, |from| from.unit);
        let (low, high) = self.from_angle.as_ref().map_or((f64::NAN, f64::NAN), |from| from.linkage.reach_rad());
        let (low, high) = (unit.from_si(low), unit.from_si(high));
        RecordingError::AngleOutOfReach { place, found, from: low.min(high), to: low.max(high), unit: unit.symbol() }
    }

    /// A column under the signal's own name and in its SI unit.
    #[must_use]
    pub fn si(signal: Signal, values: Vec<f64>) -> Self {
        let unit = signal.si_unit();
        Self { header: format!("{signal} [{unit}]"), signal, unit, values, from_angle: None }
    }
}
