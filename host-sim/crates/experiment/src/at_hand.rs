//! An excitation at hand, which a plan judges beside the best one.

use identification::compare::CompareError;
use identification::experiment::Prepared;
use machine_file::{LoadSource, MachineFile};
use model_core::machine::Tick;
use recording::excitation::signals::Excitation;
use recording::{Recording, Signal};
use simulation::{InputPoint, Stimulus};

use crate::sensor::Sensor;
use crate::standard_tests::StandardTest;

/// The excitation at hand.
#[derive(Debug)]
pub struct AtHand {
    /// What drives the model.
    pub stimulus: Stimulus,
    /// Its largest command, V.
    pub largest_v: f64,
    /// The sensors that it was recorded with, and their noise; none for a signal.
    pub sensors: Vec<Sensor>,
}

impl AtHand {
    /// That of a recording.
    pub fn of_recording(recording: &Recording, file: &MachineFile) -> Result<Self, CompareError> {
        let prepared = Prepared::entered_at(InputPoint::Command, recording, &file.machine, LoadSource::Constant, None)?;
        let sensors = prepared.channels.iter().map(|channel| Sensor { signal: channel.signal, noise: channel.noise });
        Ok(Self {
            sensors: sensors.collect(),
            largest_v: largest(recording.signal(Signal::Command).unwrap_or_default()),
            stimulus: prepared.stimulus,
        })
    }

    /// A signal at the command; `text` is how it was given.
    pub fn of_input(signal: &Excitation, text: &str, file: &MachineFile) -> Result<Self, CompareError> {
        let tick = Tick::OneMillisecond;
        let test = StandardTest::of_input(signal, text, tick);
        let largest_v = largest(&test.command_v);
        let recording = test.recording(&file.machine)?;
        let stimulus = Stimulus::new(&recording, &file.machine, InputPoint::Command, LoadSource::Constant, tick)?;
        Ok(Self { stimulus, largest_v, sensors: Vec::new() })
    }
}

/// Largest command, V.
fn largest(command_v: &[f64]) -> f64 {
    command_v.iter().fold(0.0, |largest, volts| largest.max(volts.abs()))
}
