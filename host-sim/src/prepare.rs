//! Recording → what a fit and a verdict need to know of it: the stimulus, the judged signals, and the noise in each.

use model_core::machine::{Machine, Tick};

use crate::compare::{CompareError, judged};
use crate::machine_file::LoadSource;
use crate::noise::{noise, resolution};
use crate::recording::{Recording, Signal};
use crate::simulate::{EntryPoint, Stimulus, first_entry, natural_tick};

/// One measured signal that a simulation is held against.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The signal.
    pub signal: Signal,
    /// What was recorded, SI.
    pub recorded: Vec<f64>,
    /// Standard deviation of the sensor's noise and quantisation, SI.
    pub noise: f64,
}

impl Channel {
    /// The NRMSE fit, %, that a perfect model would reach: only the noise is left.
    #[must_use]
    pub fn noise_floor_percent(&self) -> f64 {
        self.fit_of_square(self.recorded.len() as f64)
    }

    /// The NRMSE fit, %, of residuals over noise.
    #[must_use]
    pub fn fit_percent(&self, over_noise: &[f64]) -> f64 {
        self.fit_of_square(over_noise.iter().map(|value| value * value).sum())
    }

    fn fit_of_square(&self, over_noise: f64) -> f64 {
        let mean = self.recorded.iter().sum::<f64>() / self.recorded.len() as f64;
        let spread: f64 = self.recorded.iter().map(|value| (value - mean).powi(2)).sum();
        100.0 * (1.0 - self.noise * (over_noise / spread).sqrt())
    }
}

/// A recording, ready to be fitted to and judged by.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// The recording's name.
    pub name: String,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// What drives the chain.
    pub stimulus: Stimulus,
    /// The judged signals in the chain's order.
    pub channels: Vec<Channel>,
}

impl Prepared {
    /// Prepares a recording, entered as far upstream as it allows.
    pub fn new(
        recording: &Recording,
        machine: &Machine<f64>,
        load: LoadSource,
        tick: Option<Tick>,
    ) -> Result<Self, CompareError> {
        Self::entered_at(first_entry(machine.source, recording)?, recording, machine, load, tick)
    }

    /// Prepares a recording, entered at a given signal.
    pub fn entered_at(
        entry: EntryPoint,
        recording: &Recording,
        machine: &Machine<f64>,
        load: LoadSource,
        tick: Option<Tick>,
    ) -> Result<Self, CompareError> {
        let tick = tick.unwrap_or_else(|| natural_tick(recording));
        let stimulus = Stimulus::new(recording, machine, entry, load, tick)?;
        let signals = judged(recording, entry, load);
        if signals.is_empty() {
            return Err(CompareError::NothingMeasured { recording: recording.name().to_owned() });
        }
        let channels = signals
            .into_iter()
            .map(|signal| {
                recording.check_varies(signal)?;
                let recorded = recording.require(signal)?.to_vec();
                Ok(Channel { signal, noise: noise(&recorded, resolution(&recorded)), recorded })
            })
            .collect::<Result<_, CompareError>>()?;
        Ok(Self { name: recording.name().to_owned(), time_s: recording.time_s().to_vec(), stimulus, channels })
    }
}
