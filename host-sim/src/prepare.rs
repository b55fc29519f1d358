//! Recording → what a fit and a verdict need to know of it: the stimulus, the judged signals, and the noise in each.

use model_core::machine::{Machine, Tick};

use crate::compare::{CompareError, judged};
use crate::machine_file::LoadSource;
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
    /// Smallest step between recorded values: the sensor's resolution, SI; 0 if none shows.
    pub resolution: f64,
}

impl Channel {
    /// The NRMSE fit, %, that a perfect model would reach: only the noise is left.
    #[must_use]
    pub fn noise_floor_percent(&self) -> f64 {
        let mean = self.recorded.iter().sum::<f64>() / self.recorded.len() as f64;
        let spread: f64 = self.recorded.iter().map(|value| (value - mean).powi(2)).sum();
        100.0 * (1.0 - self.noise * (self.recorded.len() as f64 / spread).sqrt())
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
                let resolution = resolution(&recorded);
                Ok(Channel { signal, noise: noise(&recorded, resolution), recorded, resolution })
            })
            .collect::<Result<_, CompareError>>()?;
        Ok(Self { name: recording.name().to_owned(), time_s: recording.time_s().to_vec(), stimulus, channels })
    }
}

/// Rows of one segment that the noise is estimated from.
const SEGMENT: usize = 64;

/// Standard deviation of white noise in a smooth signal: root mean square of its third differences over √20 (Gasser, Sroka,
/// Jennen-Steinmetz 1986) in short segments, of which the median counts, so that steps and spikes do not; at least what
/// rounding to the resolution makes.
fn noise(values: &[f64], resolution: f64) -> f64 {
    let squares: Vec<f64> = values.windows(4).map(|w| ((w[3] - w[0]) - 3.0 * (w[2] - w[1])).powi(2) / 20.0).collect();
    let mut segments: Vec<f64> =
        squares.chunks(SEGMENT).map(|segment| segment.iter().sum::<f64>() / segment.len() as f64).collect();
    let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    median(&mut segments).sqrt().max(resolution / 12.0_f64.sqrt()).max(1e-12 * largest).max(f64::MIN_POSITIVE)
}

/// The step that most neighbouring values differ by, where a sensor shows one: the smallest difference that is not nil
/// and occurs more than rarely.
fn resolution(values: &[f64]) -> f64 {
    let mut steps: Vec<f64> =
        values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let rank = steps.len() / 20;
    let (_, step, _) = steps.select_nth_unstable_by(rank, f64::total_cmp);
    let step = *step;
    // A resolution shows in that steps are multiples of it; noise of many digits has none.
    let multiples = values
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs() / step)
        .filter(|ratio| (ratio - ratio.round()).abs() < 0.02)
        .count();
    if multiples * 10 >= values.len() * 9 { step } else { 0.0 }
}

/// The median; 0 for nothing.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_of_a_quantised_ramp_is_that_of_its_rounding() {
        let ramp: Vec<f64> = (0..4000).map(|k| (f64::from(k) * 0.013).floor() * 0.5).collect();
        let step = resolution(&ramp);
        assert!((step - 0.5).abs() < 1e-12);
        assert!((noise(&ramp, step) - 0.5 / 12.0_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn noise_on_a_sine_is_found_within_a_tenth() {
        let mut seed = 1_u32;
        let mut uniform = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let values: Vec<f64> =
            (0..5000).map(|k| (f64::from(k) * 0.01).sin() + 0.02 * (uniform() + uniform() + uniform())).collect();
        let found = noise(&values, resolution(&values));
        assert!((found / 0.01 - 1.0).abs() < 0.1, "{found}");
    }
}
