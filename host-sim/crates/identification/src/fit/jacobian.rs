//! A recording simulated with the derivatives of its judged signals with respect to everything that is free.

use model_core::machine::{Machine, MachineError};
use recording::Signal;
use simulation::{By, Derivatives};

use super::Free;
use super::initial_state::{StartState, needs_level};
use crate::experiment::{JudgedSignal, Prepared};

/// The coordinates at which derivatives are computed.
#[derive(Clone, Copy)]
pub(crate) struct At<'a> {
    /// What is not free.
    pub(crate) base: &'a Machine<f64>,
    /// What is free.
    pub(crate) free: &'a [Free],
    /// Coordinates, those of the free parameters first; what follows is not used.
    pub(crate) coordinates: &'a [f64],
}

/// A judged signal at one row.
pub(crate) struct Judged<'a> {
    /// The row.
    pub(crate) row: usize,
    /// The channel that it is compared with.
    pub(crate) channel: &'a JudgedSignal,
    /// Simulated, SI; `None` where the model does not compute it or its sensor failed.
    pub(crate) simulated: Option<f64>,
    /// Its derivative with respect to the coordinate of every free parameter, then of the start's level and shift; empty where nothing is simulated.
    pub(crate) jacobian: &'a [f32],
}

impl At<'_> {
    /// The machine with the values of these coordinates.
    pub(crate) fn machine(&self) -> Machine<f64> {
        let mut machine = *self.base;
        for (free, &coordinate) in self.free.iter().zip(self.coordinates) {
            machine.set(free.parameter, free.value(coordinate));
        }
        machine
    }

    /// Runs the recording once and hands every judged signal to `sink`, row by row.
    pub(crate) fn each(
        &self,
        start: StartState,
        case: &Prepared,
        sink: &mut dyn FnMut(&Judged<'_>),
    ) -> Result<(), MachineError> {
        case.effort.derived(case.stimulus.ticks(), self.free.len());
        let machine = self.machine();
        let by: Vec<By> =
            self.free.iter().zip(self.coordinates).map(|(free, &coordinate)| by(free, coordinate)).collect();
        let signals: Vec<Signal> = case.channels.iter().map(|channel| channel.signal).collect();
        let run = Derivatives {
            machine: self.base,
            by: &by,
            offset: start.offset(&machine, case),
            level_slope: if needs_level(case) { start.level_slope(&machine) } else { 0.0 },
            shift_slope_m: case.start_sigma_on(&machine),
            stimulus: &case.stimulus,
            signals: &signals,
        };
        run.run(&mut |row, place, derived| {
            let channel = &case.channels[place];
            let derived = derived.filter(|_| !channel.failed[row]);
            sink(&Judged {
                row,
                channel,
                simulated: derived.map(|(simulated, _)| simulated),
                jacobian: derived.map_or(&[], |(_, jacobian)| jacobian),
            });
        })
    }
}

/// A free parameter at a coordinate.
fn by(free: &Free, coordinate: f64) -> By {
    By { parameter: free.parameter, value: free.value(coordinate), slope: free.slope(coordinate) }
}
