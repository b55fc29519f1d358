//! Changes of every sensor by every direction in one excitation, as products of whitened changes: these can be summed over excitations.

use identification::parallel;
use nalgebra::{DMatrix, DVector};

use model_core::machine::{Machine, MachineError};
use simulation::{StartOffset, Stimulus, rows_f64};

use super::directions::Direction;
use crate::sensor::Sensor;

/// Largest number of rows that are kept; of longer excitations every n-th row is kept and stands for those left out.
const MOST_ROWS: usize = 20_000;

/// One simulation over the noise of each sensor: one vector per sensor.
pub(crate) type Seen = Vec<DVector<f64>>;

/// An excitation, ready to be simulated and judged.
#[derive(Debug)]
pub(crate) struct View<'a> {
    pub(crate) stimulus: &'a Stimulus,
    pub(crate) sensors: &'a [Sensor],
}

impl View<'_> {
    fn stride(&self) -> usize {
        self.stimulus.rows().div_ceil(MOST_ROWS).max(1)
    }

    /// A machine's signals over the noise; every kept row stands for those left out.
    pub(crate) fn of(&self, machine: &Machine<f64>, offset: StartOffset) -> Result<Seen, MachineError> {
        let stride = self.stride();
        let weight = (stride as f64).sqrt();
        let mut series = vec![Vec::new(); self.sensors.len()];
        rows_f64(machine, self.stimulus, offset, &mut |row, signal| {
            if row.is_multiple_of(stride) {
                for (sensor, series) in self.sensors.iter().zip(&mut series) {
                    series.push(signal(sensor.signal).map_or(0.0, |value| weight * value / sensor.noise));
                }
            }
        })?;
        Ok(series.into_iter().map(DVector::from_vec).collect())
    }

    /// Simulates the original machine and every direction.
    pub(crate) fn changes(&self, machine: &Machine<f64>, directions: &[Direction]) -> Result<Changes, MachineError> {
        let base = self.of(machine, StartOffset::none())?;
        let each = parallel::each(directions, |direction| {
            let there = self.of(&direction.machine, direction.offset).ok()?;
            let change = there.into_iter().zip(&base).map(|(there, base)| (there - base) * direction.times);
            Some(change.collect())
        });
        Ok(Changes { base, each })
    }
}

/// The changes by every direction.
#[derive(Debug)]
pub(crate) struct Changes {
    /// The original machine.
    pub(crate) base: Seen,
    /// The change by each direction; one that does not become a drive changes nothing.
    each: Vec<Option<Seen>>,
}

impl Changes {
    /// The changes by some directions in one sensor, one column each.
    pub(crate) fn columns(&self, directions: std::ops::Range<usize>, sensor: usize) -> DMatrix<f64> {
        let each = &self.each[directions];
        let mut columns = DMatrix::zeros(self.base[sensor].len(), each.len());
        for (mut column, change) in columns.column_iter_mut().zip(each) {
            if let Some(change) = change {
                column.copy_from(&change[sensor]);
            }
        }
        columns
    }
}

/// Products of all directions, one matrix per sensor.
#[derive(Clone, Debug)]
pub(crate) struct Products {
    pub(crate) by_sensor: Vec<DMatrix<f64>>,
    /// Samples of one sensor.
    pub(crate) rows: f64,
}

impl Products {
    /// From the changes by every direction in an excitation of this many rows.
    pub(crate) fn of(changes: &Changes, rows: usize) -> Self {
        let by_sensor = parallel::each(0..changes.base.len(), |sensor| {
            let columns = changes.columns(0..changes.each.len(), sensor);
            columns.tr_mul(&columns)
        });
        Self { by_sensor, rows: rows as f64 }
    }

    /// The sum over several excitations.
    pub(crate) fn sum<'a>(all: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        all.into_iter().cloned().reduce(|mut sum, one| {
            for (sum, one) in sum.by_sensor.iter_mut().zip(&one.by_sensor) {
                *sum += one;
            }
            Self { rows: sum.rows + one.rows, ..sum }
        })
    }

    /// Products over some of the sensors, and their samples.
    pub(crate) fn over(&self, sensors: &[usize]) -> (DMatrix<f64>, f64) {
        let size = self.by_sensor.first().map_or(0, DMatrix::nrows);
        let mut sum = DMatrix::zeros(size, size);
        for &sensor in sensors {
            sum += &self.by_sensor[sensor];
        }
        (sum, self.rows * sensors.len() as f64)
    }
}
