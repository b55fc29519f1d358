//! A simulation with the derivatives of its signals with respect to some parameters, by dual numbers through the core's own equations.

use model_core::machine::{Machine, MachineError, Parameter};
use recording::Signal;

use crate::initial_state::{Offset, StartOffset};
use crate::number::dual::{BLOCK, Dual, single};
use crate::run::run;
use crate::stimulus::Stimulus;
use crate::whitening::Gaining;

/// Number of derivatives in the largest dual number: for every parameter, and for the level and the shift of a start.
const MOST_SLOTS: usize = 64;
/// Derivatives of a start: by its level and by its shift, behind those of the parameters.
pub const OF_START: usize = 2;

/// Largest number of parameters for which one run computes derivatives.
pub const MOST_PARAMETERS: usize = MOST_SLOTS - OF_START;

/// A parameter with respect to which derivatives are computed, through a coordinate of the caller's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct By {
    /// Which.
    pub parameter: Parameter,
    /// Its value, SI.
    pub value: f64,
    /// Derivative of the value with respect to the coordinate.
    pub slope: f64,
}

/// What is simulated with derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Derivatives<'a> {
    /// Every value without a derivative.
    pub machine: &'a Machine<f64>,
    /// The parameters of the derivatives, at most [`MOST_PARAMETERS`].
    pub by: &'a [By],
    /// Where the run starts.
    pub offset: StartOffset,
    /// Derivative of the start's level with respect to its coordinate; 0 where the start's pressures are recorded.
    pub level_slope: f64,
    /// Derivative of the start's shift with respect to its coordinate, m; 0 where no position is recorded.
    pub shift_slope_m: f64,
    /// What drives it.
    pub stimulus: &'a Stimulus,
    /// The signals that are wanted.
    pub signals: &'a [Signal],
}

/// A signal at one row: its value, SI, and its derivatives with respect to every coordinate and to those of the start's level and shift.
pub type Derived<'a> = Option<(f64, &'a [f32])>;

impl Derivatives<'_> {
    /// Runs once and hands every wanted signal to `sink`, row by row, with its index among the wanted signals; `None` where
    /// the model does not compute it. The values equal those of an f64 run to the last bit.
    ///
    /// Where the stimulus is whitened, it gets what they gain in place of what they are: the index of the gain in place of the row.
    pub fn run(&self, sink: &mut dyn FnMut(usize, usize, Derived<'_>)) -> Result<(), MachineError> {
        let Some(whitening) = &self.stimulus.whitening else { return self.row_by_row(sink) };
        let width = self.by.len() + OF_START;
        let of = |&signal: &Signal| Gaining::of_signal(whitening, signal, width + 1);
        let mut gaining: Vec<Gaining<'_>> = self.signals.iter().map(of).collect();
        let mut derivatives = vec![0.0_f32; width];
        self.row_by_row(&mut |row, place, derived| {
            let Some((value, partials)) = derived else { return sink(row, place, None) };
            let together = [value].into_iter().chain(partials.iter().copied().map(f64::from));
            if let Some((gain, [value, slopes @ ..])) = gaining[place].take(together) {
                derivatives.iter_mut().zip(slopes).for_each(|(to, slope)| *to = single(*slope));
                sink(gain, place, Some((*value, &derivatives)));
            }
        })
    }

    fn row_by_row(&self, sink: &mut dyn FnMut(usize, usize, Derived<'_>)) -> Result<(), MachineError> {
        match self.by.len() {
            0..=14 => self.in_vectors::<2>(sink),
            15..=22 => self.in_vectors::<3>(sink),
            23..=38 => self.in_vectors::<5>(sink),
            _ => self.in_vectors::<{ MOST_SLOTS / BLOCK }>(sink),
        }
    }

    fn in_vectors<const B: usize>(&self, sink: &mut dyn FnMut(usize, usize, Derived<'_>)) -> Result<(), MachineError> {
        let slots = self.by.len() + OF_START;
        let [level, shift] = [slots - 2, slots - 1];
        let offset = Offset {
            level: self.offset.level.map(|value| Dual::<B>::variable(value, level, self.level_slope)),
            shift_m: Dual::<B>::variable(self.offset.shift_m, shift, self.shift_slope_m),
        };
        run::<Dual<B>>(&self.lifted(), self.stimulus, offset, &mut |row, sample| {
            for (place, &signal) in self.signals.iter().enumerate() {
                let found = sample.signal(signal);
                sink(row, place, found.as_ref().map(|found| (found.value, &found.partials()[..slots])));
            }
        })
    }

    /// The machine whose parameters carry their derivatives.
    fn lifted<const B: usize>(&self) -> Machine<Dual<B>> {
        let mut machine = self.machine.map(Dual::constant_of);
        for (index, by) in self.by.iter().enumerate() {
            machine.set(by.parameter, Dual::<B>::variable(by.value, index, by.slope));
        }
        machine
    }
}
