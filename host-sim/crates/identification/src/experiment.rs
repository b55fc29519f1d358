//! From a recording to what a fit and a verdict need of it: the stimulus, the judged signals, and the noise in each.

use machine_file::LoadSource;
use model_core::machine::{Machine, MachineError, Parameter, Source, Tick};
use recording::{Recording, Signal};
use simulation::sensor_fault::{Failures, Mended, RangeEnd, Stretch, bridged};
use simulation::signal::noise::{extent, noise, resolution};
use simulation::{
    InputPoint, Shown, SimulateError, Start, Stimulus, Whitening, first_input_point, is_sparse, tick_for,
};

use crate::compare::judged;
use crate::effort::Effort;
use crate::error::CompareError;
use crate::input_noise::{at_most_by_noise_of_input, at_most_in_gains};

/// One measured signal that a simulation is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedSignal {
    /// The signal.
    pub signal: Signal,
    /// What was recorded, SI.
    pub recorded: Vec<f64>,
    /// Ratio of the refitted model's residual to the noise, at least 1: residuals far beyond that do not steer a fit.
    pub tolerance: f64,
    /// Rows where the sensor failed, or before the drive's state is known. They are not judged.
    pub failed: Vec<bool>,
    /// Where it failed for longer than a moment.
    pub stretches: Vec<Stretch>,
    /// The ends of its range that it reached.
    pub ends: Vec<RangeEnd>,
    /// Standard deviation of the sensor's noise and quantisation, including the input noise, SI.
    pub noise: f64,
    /// The part of this noise that the noise of the recorded signal driving the model causes, SI.
    pub input_noise: f64,
}

impl JudgedSignal {
    /// A signal as recorded, with its noise and the rows where its sensor failed.
    #[must_use]
    pub fn of(signal: Signal, time_s: &[f64], recorded: &[f64]) -> Self {
        Self::with(signal, recorded, Failures::of(signal, time_s, recorded))
    }

    /// A signal as recorded, with its noise, where the failures of its sensor are known.
    fn with(signal: Signal, recorded: &[f64], failures: Failures) -> Self {
        Self {
            signal,
            failed: failures.rows(),
            noise: failures.noise(recorded),
            stretches: failures.stretches,
            ends: failures.ends,
            tolerance: 1.0,
            input_noise: 0.0,
            recorded: recorded.to_vec(),
        }
    }

    /// No longer judges the rows at an end of the sensor's range that another recording showed.
    fn ends_at(&mut self, end: &RangeEnd) {
        if self.ends.iter().any(|known| known.side == end.side) {
            return;
        }
        let Some(end) = end.in_other(&self.recorded) else { return };
        self.failed.iter_mut().zip(&end.rows).for_each(|(failed, at_end)| *failed |= at_end);
        self.ends.push(end);
    }

    /// Standard deviation of the sensor's own noise and quantisation, SI.
    #[must_use]
    pub fn own_noise(&self) -> f64 {
        if self.input_noise > 0.0 {
            (self.noise.powi(2) - self.input_noise.powi(2)).max(0.0).sqrt()
        } else {
            self.noise
        }
    }

    /// Adds the error that the noise of the driving signal causes in a simulation.
    pub fn add_input_noise(&mut self, off_by: f64) {
        self.noise = libm::hypot(self.noise, off_by);
        self.input_noise = libm::hypot(self.input_noise, off_by);
    }

    /// The NRMSE fit, %, that a perfect model would reach: only the noise remains.
    #[must_use]
    pub fn noise_floor_percent(&self) -> f64 {
        self.fit_of_square(self.kept().count() as f64)
    }

    /// What was recorded, with the failed rows bridged by a straight line.
    #[must_use]
    pub fn bridged(&self) -> Vec<f64> {
        bridged(&self.recorded, &self.failed)
    }

    /// What was recorded while the sensor worked.
    pub fn kept(&self) -> impl Iterator<Item = f64> + '_ {
        self.recorded.iter().zip(&self.failed).filter(|(_, failed)| !**failed).map(|(value, _)| *value)
    }

    /// Recorded minus simulated over noise, row by row; 0 where the sensor failed.
    #[must_use]
    pub fn over_noise(&self, simulated: &[f64]) -> Vec<f64> {
        let rows = self.recorded.iter().zip(simulated).zip(&self.failed);
        rows.map(|((recorded, simulated), failed)| if *failed { 0.0 } else { (recorded - simulated) / self.noise })
            .collect()
    }

    /// The NRMSE fit, %, from residuals over noise.
    #[must_use]
    pub fn fit_percent(&self, over_noise: &[f64]) -> f64 {
        self.fit_of_square(over_noise.iter().map(|value| value * value).sum())
    }

    fn fit_of_square(&self, over_noise: f64) -> f64 {
        let mean = self.kept().sum::<f64>() / self.kept().count() as f64;
        let spread: f64 = self.kept().map(|value| (value - mean).powi(2)).sum();
        100.0 * (1.0 - self.noise * (over_noise / spread).sqrt())
    }
}

/// A recording, ready for fitting and judging.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// The recording's name.
    pub name: String,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// What drives the model.
    pub stimulus: Stimulus,
    /// The tick at which the controller is to carry what is fitted: the stimulus' own, but of a copy for a first estimate.
    pub tick: Tick,
    /// The judged signals in the chain's order.
    pub channels: Vec<JudgedSignal>,
    /// Measured signals whose sensors failed, judged or not.
    pub failures: Vec<(Signal, Failures)>,
    /// Rows at the beginning that are not judged, as the recording does not begin at rest and not all of its state is measured.
    pub unsettled: usize,
    /// Standard deviation of the initial position, m: what its sensor leaves open, and where the start is not known, the travel meanwhile. A play
    /// leaves [more](Self::start_sigma_on) open.
    pub start_sigma_m: f64,
    /// Standard deviation of the noise of the recorded spool, flow or force that drives the model, SI; 0 where a command or a
    /// pump's speed drives it, as these are set.
    pub input_noise: f64,
    /// What its simulations have cost; copies share it.
    pub effort: Effort,
}

impl Prepared {
    /// Prepares a recording, driven as far upstream as it allows. If a sensor's signal drives the model, the noise of every judged
    /// signal includes what that sensor's noise causes in it: a rod that is moved by a measured flow integrates the meter's noise.
    pub fn new(
        recording: &Recording,
        machine: &Machine<f64>,
        load: LoadSource,
        tick: Option<Tick>,
    ) -> Result<Self, CompareError> {
        let input_point = first_input_point(machine.source, recording)?;
        let mut prepared = Self::entered_at(input_point, recording, machine, load, tick)?;
        let added = at_most_by_noise_of_input(&prepared, machine).map_err(SimulateError::from)?;
        for (channel, added) in prepared.channels.iter_mut().zip(added) {
            channel.add_input_noise(added);
        }
        Ok(prepared)
    }

    /// Prepares a recording, driven at a given input point.
    pub fn entered_at(
        input_point: InputPoint,
        recording: &Recording,
        machine: &Machine<f64>,
        load: LoadSource,
        tick: Option<Tick>,
    ) -> Result<Self, CompareError> {
        let tick = tick.unwrap_or_else(|| tick_for(recording, machine));
        let mut mended = Mended::of(recording);
        let stimulus = Stimulus::of_mended(&mended, machine, input_point, load, tick)?;
        let mut signals = judged(recording, input_point, load);
        let fed = machine.source == Source::Valve && matches!(input_point, InputPoint::Command | InputPoint::Spool);
        if fed && recording.check_varies(Signal::SupplyPressure).is_ok() && recording.has(Signal::SupplyPressure) {
            signals.push(Signal::SupplyPressure);
        }
        if signals.is_empty() {
            return Err(CompareError::NothingMeasured { recording: recording.name().to_owned() });
        }
        let unsettled = unsettled_rows(recording.time_s(), &stimulus.start);
        let mut channels = signals
            .into_iter()
            .map(|signal| {
                recording.check_varies(signal)?;
                let values = recording.require(signal)?;
                let known = mended.failures.iter().find(|(of, _)| *of == signal).map(|(_, failures)| failures.clone());
                Ok(match known {
                    Some(failures) => JudgedSignal::with(signal, values, failures),
                    None => JudgedSignal::of(signal, recording.time_s(), values),
                })
            })
            .collect::<Result<Vec<_>, CompareError>>()?;
        for channel in &mut channels {
            channel.failed[..unsettled].fill(true);
        }
        let input_noise = input_noise(&mended.recording, input_point, machine);
        mended.failures.retain(|(_, failures)| failures.are_any());
        let start_sigma_m = recording.signal(Signal::Position).map_or(0.0, |position| {
            let step = resolution(position);
            let noise = noise(position, step);
            // A run that is taken up takes its position from a few rows.
            let taken_up = stimulus.start.taken_up.is_some_and(|taken_up| taken_up.position_m.is_some());
            let unknown_m = if taken_up {
                noise
            } else {
                let (low, high) = extent(&position[..unsettled.max(1)]);
                high - low
            };
            (step * step / 12.0 + noise.powi(2) / ROWS_AT_REST + unknown_m.powi(2)).sqrt()
        });
        Ok(Self {
            name: recording.name().to_owned(),
            time_s: recording.time_s().to_vec(),
            stimulus,
            tick,
            channels,
            failures: mended.failures,
            unsettled,
            start_sigma_m,
            input_noise,
            effort: Effort::default(),
        })
    }

    /// The number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// From the first row to the last, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.time_s.last().zip(self.time_s.first()).map_or(0.0, |(last, first)| last - first)
    }

    /// Whether so few rows were recorded that the fast half of a drive does not show.
    #[must_use]
    pub fn is_sparse(&self) -> bool {
        is_sparse(&self.time_s)
    }

    /// Standard deviation of the rod's initial position on a machine, m: where in a play it stands, no sensor shows. A rod that is driven by its measured
    /// force starts in the middle: its position integrates twice what that sensor reads wrong, which hides the place.
    #[must_use]
    pub fn start_sigma_on(&self, machine: &Machine<f64>) -> f64 {
        /// Chosen: half of a usual play. It is the same for every width, so that no derivative depends on it.
        const WITHIN_PLAY_M: f64 = 5e-4;
        let is_told = self.start_sigma_m > 0.0 && self.stimulus.input_point != InputPoint::Force;
        if is_told && machine.get(Parameter::BacklashPlay) > 0.0 {
            libm::hypot(self.start_sigma_m, WITHIN_PLAY_M)
        } else {
            self.start_sigma_m
        }
    }

    /// The same with the recorded spool metering the oil, where the command drives the valve and the spool is judged: the
    /// valve is then judged by its spool alone, and everything below it by the flow that the real spool let through.
    #[must_use]
    pub fn following(&self) -> Option<Self> {
        let is_judged = self.channels.iter().any(|channel| channel.signal == Signal::Spool);
        let stimulus = self.stimulus.following().filter(|_| is_judged)?;
        Some(Self { stimulus, ..self.clone() })
    }

    /// The same with its runs held near the recording, which lead a search there from afar, so many `times` more seldom than the rows allow; `None` where it does
    /// not show both pressures and the motion.
    #[must_use]
    pub fn held(&self, times: u32) -> Option<Self> {
        // Gains are no signals as recorded.
        if self.stimulus.is_whitened() {
            return None;
        }
        let channels = self.channels.iter();
        let shown: Vec<Shown<'_>> =
            channels.map(|one| Shown { signal: one.signal, values: &one.recorded, lost: &one.failed }).collect();
        let stimulus = self.stimulus.held(&self.time_s, &shown, times)?;
        Some(Self { stimulus, ..self.clone() })
    }

    /// The same recording, entered at a measured force, judged by what velocity and position gain over each of so many seconds (see [`Whitening`]), while a
    /// wrong velocity decays with the time constant `memory_s`; `None` where neither is judged or the recording is too short. Its rows are the gains.
    pub fn whitened(&self, machine: &Machine<f64>, block_s: f64, memory_s: f64) -> Result<Option<Self>, MachineError> {
        /// Below this, two dozen values that each say something are not to be had.
        const FEWEST: usize = 24;
        let whitening = Whitening::new(&self.time_s, block_s, memory_s);
        let case = self.judged_by(|signal| matches!(signal, Signal::Position | Signal::Velocity));
        if case.channels.is_empty() || whitening.gains() < FEWEST {
            return Ok(None);
        }
        let gains = |channel: &JudgedSignal| JudgedSignal {
            signal: channel.signal,
            recorded: whitening.gains_of(channel.signal, &channel.bridged()),
            tolerance: 1.0,
            failed: whitening.spoilt(&channel.failed),
            stretches: Vec::new(),
            ends: Vec::new(),
            noise: channel.own_noise() * whitening.noise_of(channel.signal),
            input_noise: 0.0,
        };
        let mut whitened = Self {
            time_s: whitening.at_ends(&self.time_s),
            channels: case.channels.iter().map(gains).collect(),
            failures: Vec::new(),
            unsettled: 0,
            stimulus: self.stimulus.whitened(whitening),
            ..case
        };
        let added = at_most_in_gains(&whitened, machine)?;
        for (channel, added) in whitened.channels.iter_mut().zip(added) {
            channel.add_input_noise(added);
        }
        Ok(Some(whitened))
    }

    /// The same recording judged by some of its signals only.
    #[must_use]
    pub fn judged_by(&self, wanted: impl Fn(Signal) -> bool) -> Self {
        let channels = self.channels.iter().filter(|channel| wanted(channel.signal)).cloned().collect();
        Self { channels, ..self.clone() }
    }
}

/// Standard deviation of the noise of the recorded signal that drives the model, SI; of a force from both pressures, of their noise together.
fn input_noise(recording: &Recording, input_point: InputPoint, machine: &Machine<f64>) -> f64 {
    let of = |signal| recording.signal(signal).map(|values| noise(values, resolution(values)));
    let from = |pressure, area| machine.get(area) * of(pressure).unwrap_or(0.0);
    match (input_point.is_set(), of(input_point.driving())) {
        (true, _) => 0.0,
        (false, Some(noise)) => noise,
        (false, None) => {
            libm::hypot(from(Signal::PressureA, Parameter::AreaA), from(Signal::PressureB, Parameter::AreaB))
        }
    }
}

/// Takes an end of a sensor's range that one recording shows as its end in all of them: it is the same sensor, and a short visit alone shows no end.
pub fn share_range_ends(cases: &mut [&mut Prepared]) {
    let channels = cases.iter().flat_map(|case| &case.channels);
    let found: Vec<(Signal, RangeEnd)> =
        channels.flat_map(|channel| channel.ends.iter().map(|end| (channel.signal, end.clone()))).collect();
    for channel in cases.iter_mut().flat_map(|case| &mut case.channels) {
        for (signal, end) in &found {
            if *signal == channel.signal {
                channel.ends_at(end);
            }
        }
    }
}

/// Rows at the beginning of a recording before a state that is not measured has settled.
#[must_use]
pub fn unsettled_rows(time_s: &[f64], start: &Start) -> usize {
    if start.unknown_for_s > 0.0 { time_s.partition_point(|time| time - time_s[0] < start.unknown_for_s) } else { 0 }
}

/// Fewest rows that the initial state is averaged over.
const ROWS_AT_REST: f64 = 20.0;
