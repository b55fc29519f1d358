//! The paper's experiment, repeated on the virtual test bed.
//!
//! Steps of 2, 4, 6, 8 and 10 V on a drive that differs a little from the reference model, measured with the paper's sensors (16-bit
//! LVDT, joint encoder of 3600 impulses, dither on the command). The model is driven by the command and by the measured
//! spool, as in Figs. 3 and 6, and the static characteristic (15) is determined again by regression on the spool after 0.3 s.

use rayon::prelude::*;

use machine_file::{LoadSource, MachineFileError};
use model_core::machine::{Machine, Parameter, Tick};
use recording::excitation::signals::{Dither, Excitation};
use recording::{Recording, RecordingError, Signal};
use simulation::figures_of_merit::SignalFit;
use simulation::{Arithmetic, InputPoint, SimulateError, StartOffset, Stimulus};
use virtual_plant::{Bench, Drive, InitialState, LinkageError, Plant, PlantEffect, PlantError, Sensors};

/// The preset that the experiment is about.
pub const PRESET: &str = include_str!("../../presets/paper-as-printed.toml");

/// The commands of the paper's steps, V.
pub const COMMANDS_V: [f64; 5] = [2.0, 4.0, 6.0, 8.0, 10.0];

/// Similarity of the position in the paper's Table 2, %, for each of [`COMMANDS_V`]. Its Table 1 is missing in the text.
pub const TABLE_2_PERCENT: [f64; 5] = [94.20, 97.18, 98.88, 97.78, 99.42];

/// Slope, 1/V, and offset, 1, of the paper's static characteristic (15).
pub const CHARACTERISTIC: (f64, f64) = (0.0559, 0.0345);

/// When a step begins and how long it is held, s.
const STEP_S: (f64, f64) = (0.1, 2.5);

/// Where the rod starts, as a share of the stroke: low, since every step extends the rod.
const START: f64 = 0.1;

/// Time after a step when the spool has settled, s.
pub const SETTLED_S: f64 = 0.3;

/// How the drive on the test bed differs from the model: parameter, factor.
pub const DEVIATIONS: [(Parameter, f64); 6] = [
    (Parameter::ValveGain, 1.004),
    (Parameter::TimeConstant1, 1.15),
    (Parameter::TimeConstant2, 0.9),
    (Parameter::DeadZone, 1.005),
    (Parameter::FlowCoefficient, 0.99),
    (Parameter::ViscousFriction, 1.02),
];

/// Dry friction of the drive on the test bed, N.
pub const FRICTION_N: f64 = 150.0;

/// Leakage past the piston of the drive on the test bed, m³/s/Pa.
pub const LEAKAGE_M3_PER_S_PA: f64 = 3.0e-14;

/// Dither on the command.
pub const DITHER: Dither = Dither { amplitude_v: 0.5, frequency_hz: 50.0 };

/// One step of the experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Height, V.
    pub command_v: f64,
    /// Spool, simulated from the command (Table 1).
    pub spool: SignalFit,
    /// Position, simulated from the command (Table 2).
    pub position: SignalFit,
    /// Position, simulated from the measured spool (Fig. 3).
    pub position_from_spool: SignalFit,
    /// Mean of the measured spool from [`SETTLED_S`] after the step to its end, 1.
    pub settled_spool: f64,
}

/// The experiment's result.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// One for each of [`COMMANDS_V`].
    pub steps: Vec<Step>,
    /// Slope of the static characteristic found by regression, 1/V.
    pub slope_per_v: f64,
    /// Its offset, 1.
    pub offset: f64,
}

/// Why the experiment is not possible.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// The preset.
    #[error(transparent)]
    Preset(#[from] MachineFileError),
    /// The encoder's linkage.
    #[error(transparent)]
    Linkage(#[from] LinkageError),
    /// The drive on the test bed.
    #[error("step of {command_v} V: {cause}")]
    Plant {
        /// The step, V.
        command_v: f64,
        /// Why.
        cause: PlantError,
    },
    /// The recording of the test bed.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The model.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
}

/// Runs the experiment; `done` is called after each step.
pub fn experiment(arithmetic: Arithmetic, done: impl Fn() + Sync) -> Result<Experiment, PaperError> {
    let model = machine_file::read_text("paper-as-printed.toml", PRESET)?.machine;
    let steps = COMMANDS_V
        .par_iter()
        .enumerate()
        .map(|(index, &command_v)| {
            let recording = record(&model, command_v, index as u64)?;
            let step = judge(&model, &recording, command_v, arithmetic)?;
            done();
            Ok(step)
        })
        .collect::<Result<Vec<_>, PaperError>>()?;
    let points: Vec<(f64, f64)> = steps.iter().map(|step| (step.command_v, step.settled_spool)).collect();
    let (slope_per_v, offset) = regression(&points);
    Ok(Experiment { steps, slope_per_v, offset })
}

/// A step on the test bed: command, spool and position, as the paper measured them.
fn record(model: &Machine<f64>, command_v: f64, seed: u64) -> Result<Recording, PaperError> {
    let mut truth = *model;
    for (parameter, factor) in DEVIATIONS {
        truth.set(parameter, factor * model.get(parameter));
    }
    let effects = [PlantEffect::coulomb_friction(FRICTION_N), PlantEffect::internal_leakage(LEAKAGE_M3_PER_S_PA)];
    let failed = |cause| PaperError::Plant { command_v, cause };
    let plant = Plant::new(&truth, 1e-7).map_err(failed)?.with_effects(&effects);
    let mut sensors = Sensors::of(&truth)?;
    sensors.spool.noise_std = 5e-4;
    let mut bench = Bench::new(plant, sensors);
    bench.dither = Some(DITHER);
    bench.seed = seed;
    let drive = Drive::Open(Excitation::Step { amplitude_v: command_v, hold_s: STEP_S.1 });
    let initial = InitialState::at_rest(&truth, START * truth.get(Parameter::Stroke));
    let mut seen = bench.record(&drive, &initial).map_err(failed)?;
    // The paper's recordings hold no pressures.
    seen.pressure_a_pa.clear();
    seen.pressure_b_pa.clear();
    Ok(seen.to_recording(&format!("step of {command_v} V"))?)
}

fn judge(
    model: &Machine<f64>,
    recording: &Recording,
    command_v: f64,
    arithmetic: Arithmetic,
) -> Result<Step, PaperError> {
    let run = |input_point| {
        let stimulus = Stimulus::new(recording, model, input_point, LoadSource::Constant, Tick::OneMillisecond)?;
        arithmetic.simulate(model, &stimulus, StartOffset::none())
    };
    let (from_command, from_spool) = (run(InputPoint::Command)?, run(InputPoint::Spool)?);
    let time_s = recording.time_s();
    let spool = recording.require(Signal::Spool)?;
    let position = recording.require(Signal::Position)?;
    let fit = |signal, recorded, simulated: Option<&[f64]>| {
        SignalFit::of(signal, time_s, recorded, simulated.unwrap_or_default())
    };
    let held = STEP_S.0 + SETTLED_S..STEP_S.0 + STEP_S.1;
    let settled: Vec<f64> =
        time_s.iter().zip(spool).filter(|(time, _)| held.contains(*time)).map(|(_, spool)| *spool).collect();
    Ok(Step {
        command_v,
        spool: fit(Signal::Spool, spool, from_command.signal(Signal::Spool)),
        position: fit(Signal::Position, position, from_command.signal(Signal::Position)),
        position_from_spool: fit(Signal::Position, position, from_spool.signal(Signal::Position)),
        settled_spool: settled.iter().sum::<f64>() / settled.len() as f64,
    })
}

/// Slope and offset of the straight line through points by least squares.
fn regression(points: &[(f64, f64)]) -> (f64, f64) {
    let count = points.len() as f64;
    let mean_x = points.iter().map(|point| point.0).sum::<f64>() / count;
    let mean_y = points.iter().map(|point| point.1).sum::<f64>() / count;
    let both: f64 = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let square: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let slope = both / square;
    (slope, mean_y - slope * mean_x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_regression_finds_a_line() {
        let (slope, offset) = regression(&COMMANDS_V.map(|volts| (volts, 0.0559 * volts + 0.0345)));
        assert!((slope - 0.0559).abs() < 1e-15 && (offset - 0.0345).abs() < 1e-15);
    }

    #[test]
    fn the_experiment_finds_the_characteristic_again_and_similarities_like_the_papers() {
        let found = experiment(Arithmetic::Fixed, || {}).unwrap();
        let true_slope = 1.004 * CHARACTERISTIC.0;
        assert!((found.slope_per_v - true_slope).abs() < 2e-5, "{}", found.slope_per_v);
        assert!((found.offset - CHARACTERISTIC.1).abs() < 2e-4, "{}", found.offset);
        for step in &found.steps {
            for fit in [step.spool, step.position, step.position_from_spool] {
                assert!((88.0..99.9).contains(&fit.nrmse_percent), "{} V: {fit:?}", step.command_v);
            }
        }
    }
}
