//! One column: what it holds, how noisy it is, where its sensor failed.

use recording::display_unit::unit_of;
use recording::{Column, Signal, Unit};
use simulation::sensor_fault::Failures;
use simulation::signal::noise::{extent, resolution};

use super::marks::{Mark, marks};

/// What was found in one column.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectedColumn {
    /// The signal that it contains.
    pub signal: Signal,
    /// Its header in the file; of a position that follows from the joint's angle, the words for that.
    pub header: String,
    /// The unit in which people read it.
    pub unit: Unit,
    /// Lowest value, SI.
    pub low: f64,
    /// Highest value, SI.
    pub high: f64,
    /// Standard deviation of noise and quantisation, SI; `None` where nothing changes, and for signals that are set and not measured.
    pub noise: Option<f64>,
    /// Resolution of its sensor, SI, where it can be seen.
    pub step: Option<f64>,
    /// Rows where its sensor failed.
    pub failed: usize,
    /// What its sensor reads at the ends of its range that it reached, SI, and in which share of the rows.
    pub ends: Vec<(f64, f64)>,
    /// Where it is suspicious.
    pub marks: Vec<Mark>,
}

impl InspectedColumn {
    pub(crate) fn of(time_s: &[f64], column: &Column) -> Self {
        let values = &column.values;
        let (low, high) = extent(values);
        let is_set =
            matches!(column.signal, Signal::Command | Signal::Reference | Signal::ValveDirection | Signal::PumpSpeed);
        let step = resolution(values);
        let measured = low < high && !is_set;
        let failures = if measured { Failures::of(column.signal, time_s, values) } else { Failures::default() };
        let ends = failures.ends.iter().map(|end| (end.reading, end.count() as f64 / values.len() as f64));
        Self {
            signal: column.signal,
            header: if column.from_angle.is_some() { "from the angle".to_owned() } else { column.header.clone() },
            unit: unit_of(column),
            low,
            high,
            noise: measured.then(|| failures.noise(values)),
            step: (measured && step > 0.0).then_some(step),
            failed: failures.rows().into_iter().filter(|failed| *failed).count(),
            ends: ends.collect(),
            marks: marks(time_s, values, &failures),
        }
    }

    /// Whether it holds one value in every row.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.low >= self.high
    }
}
