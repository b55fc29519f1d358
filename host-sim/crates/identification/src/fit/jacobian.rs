//! A recording simulated with the slopes of its judged signals by everything that is free.

use model_core::machine::{Machine, MachineError};
use recording::Signal;
use simulation::number::dual::{Dual, single};
use simulation::{StartOffset, run};

use super::Free;
use super::initial_state::{StartState, needs_level};
use crate::experiment::{Channel, Prepared};

/// Most slots of a dual number here: every free parameter and the level of a start.
pub(crate) const MOST_SLOTS: usize = 40;

/// The coordinates that slopes are taken at.
#[derive(Clone, Copy)]
pub(crate) struct At<'a> {
    /// What is not free.
    pub(crate) base: &'a Machine<f64>,
    /// What is free.
    pub(crate) free: &'a [Free],
    /// Coordinates of the free parameters, first of all; what follows is not looked at.
    pub(crate) coordinates: &'a [f64],
}

/// A judged signal at one row.
pub(crate) struct Judged<'a> {
    /// The row.
    pub(crate) row: usize,
    /// What it is held against.
    pub(crate) channel: &'a Channel,
    /// Simulated, SI; `None` where the chain does not compute it or its sensor failed.
    pub(crate) simulated: Option<f64>,
    /// Its derivative by the coordinate of every free parameter, then of the start's level; empty where nothing is simulated.
    pub(crate) slopes: &'a [f32],
    /// Its derivative by the coordinate of the start's shift.
    pub(crate) by_shift: f64,
}

impl At<'_> {
    /// Runs the recording once and hands every judged signal to `sink`, row by row.
    pub(crate) fn each(
        &self,
        start: StartState,
        case: &Prepared,
        sink: &mut dyn FnMut(&Judged<'_>),
    ) -> Result<(), MachineError> {
        macro_rules! with_slots {
            ($($slots:literal)*) => {
                match self.free.len() + 1 {
                    $(0..=$slots => self.run::<$slots>(start, case, sink),)*
                    _ => self.run::<MOST_SLOTS>(start, case, sink),
                }
            };
        }
        with_slots!(4 8 12 16 20 24 28 32)
    }

    fn run<const P: usize>(
        &self,
        start: StartState,
        case: &Prepared,
        sink: &mut dyn FnMut(&Judged<'_>),
    ) -> Result<(), MachineError> {
        let slots = self.free.len() + 1;
        let machine = self.machine::<P>();
        let mut level = Dual::<P>::constant_of(start.level_on(&machine));
        if needs_level(case) {
            level.partials[slots - 1] = single(start.level_slope(&machine));
        }
        let offset = StartOffset { level: Some(level), shift_m: Dual::constant_of(start.shift * case.start_sigma_m) };
        run::<Dual<P>>(&machine, &case.stimulus, offset, |row, sample| {
            for channel in &case.channels {
                let simulated = if channel.failed[row] { None } else { sample.signal(channel.signal) };
                sink(&Judged {
                    row,
                    channel,
                    simulated: simulated.map(|simulated| simulated.value),
                    slopes: simulated.as_ref().map_or(&[], |simulated| &simulated.partials[..slots]),
                    by_shift: if channel.signal == Signal::Position { case.start_sigma_m } else { 0.0 },
                });
            }
        })
    }

    /// The machine whose free parameters carry their slopes.
    fn machine<const P: usize>(&self) -> Machine<Dual<P>> {
        let mut machine = self.base.map(Dual::constant_of);
        for (index, (free, &coordinate)) in self.free.iter().zip(self.coordinates).enumerate() {
            let mut value = Dual::<P>::constant_of(free.value(coordinate));
            value.partials[index] = single(free.slope(coordinate));
            machine.set(free.parameter, value);
        }
        machine
    }
}
