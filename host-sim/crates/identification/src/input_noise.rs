//! The error that the noise of recorded signals causes in a simulation that they drive.
//!
//! A position that is computed from recorded pressures integrates their noise: its error is a random walk, however right
//! the model is. Therefore noise is added to the recorded signals once more and the simulation is repeated: the
//! difference has the same distribution as the error that the recorded noise has already caused.

use model_core::machine::{Machine, MachineError};
use recording::seeded_noise::Noise;
use recording::{Recording, Signal};
use simulation::sensor_fault::{MEASURED, Mended};
use simulation::signal::noise::{noise, resolution};
use simulation::{Run, SimulateError, StartOffset, Stimulus, Trajectory, run_in_lanes, simulate_f64};

use crate::experiment::Prepared;

/// Fewest rows that are simulated again, where a recording is short: a single random walk may be anywhere.
const ROWS_AGAIN: usize = 400_000;
/// Largest number of repetitions.
const MOST: usize = 16;
/// Smallest number of repetitions, for a long recording.
const LEAST: usize = 2;

/// Number of times that noise is added to a recording of this many rows.
pub(crate) fn realisations(rows: usize) -> usize {
    (ROWS_AGAIN / rows.max(1)).clamp(LEAST, MOST)
}

/// RMS error of each of the `signals` of a simulation caused by the noise of the recording's sensors, SI.
pub(crate) fn input_noise(
    mended: &Mended<'_>,
    trajectory: &Trajectory,
    signals: &[Signal],
    simulated: impl Fn(&Mended<'_>) -> Result<Trajectory, SimulateError>,
) -> Result<Vec<f64>, SimulateError> {
    let noisy = noisy(&mended.recording);
    let again = |seed| simulated(&disturbed(mended, &noisy, seed));
    off_by(trajectory, signals, realisations(mended.recording.rows()), again)
}

/// RMS difference of each of the `signals` between a simulation and several others, SI; each of these gets its own seed for the noise.
pub(crate) fn off_by<E>(
    trajectory: &Trajectory,
    signals: &[Signal],
    times: usize,
    again: impl Fn(u64) -> Result<Trajectory, E>,
) -> Result<Vec<f64>, E> {
    let mut squares = vec![0.0; signals.len()];
    for seed in 0..times {
        let again = again(seed as u64)?;
        for (square, &signal) in squares.iter_mut().zip(signals) {
            if let Some((quiet, loud)) = trajectory.signal(signal).zip(again.signal(signal)) {
                let sum: f64 = quiet.iter().zip(loud).map(|(quiet, loud)| (loud - quiet).powi(2)).sum();
                *square += sum / (quiet.len() * times) as f64;
            }
        }
    }
    Ok(squares.into_iter().map(f64::sqrt).collect())
}

/// RMS error of each judged signal of a recording, SI, caused by noise of this standard deviation in the recorded spool,
/// flow or force that drives it; the mean of several draws.
pub fn by_noise_of_input(
    case: &Prepared,
    machine: &Machine<f64>,
    deviation: f64,
    draws: usize,
) -> Result<Vec<f64>, MachineError> {
    off_by(&driven(machine, &case.stimulus)?, &signals(case), draws, |seed| {
        disturbed_input(case, machine, deviation, seed)
    })
}

/// The same for the noise that was estimated there, but with the largest of the draws for each signal. The root mean square of integrated noise lies
/// anywhere from a third to twice its mean; with as many draws as for a short recording, the largest is a value that nineteen of twenty stay below.
pub(crate) fn at_most_by_noise_of_input(case: &Prepared, machine: &Machine<f64>) -> Result<Vec<f64>, MachineError> {
    let signals = signals(case);
    let mut most = vec![0.0_f64; signals.len()];
    if case.input_noise > 0.0 {
        let quiet = driven(machine, &case.stimulus)?;
        for seed in 0..realisations(case.rows()) as u64 {
            let off = off_by(&quiet, &signals, 1, |_| disturbed_input(case, machine, case.input_noise, seed))?;
            most.iter_mut().zip(off).for_each(|(most, off)| *most = most.max(off));
        }
    }
    Ok(most)
}

/// The same for a whitened recording, in what its signals gain.
pub(crate) fn at_most_in_gains(case: &Prepared, machine: &Machine<f64>) -> Result<Vec<f64>, MachineError> {
    let draws = realisations(case.stimulus.rows()) as u64;
    let disturbed = |seed| {
        let mut noise = Noise::new(1, seed);
        case.stimulus.disturbed(|| noise.gaussian(case.input_noise))
    };
    let stimuli: Vec<Stimulus> = [case.stimulus.clone()].into_iter().chain((0..draws).map(disturbed)).collect();
    let run = |stimulus| Run { stimulus, offset: StartOffset::none(), signals: signals(case) };
    let runs: Vec<Run<'_>> = stimuli.iter().map(run).collect();
    let mut gained = vec![Vec::new(); runs.len()];
    run_in_lanes(machine, &runs, &mut |run, _, values| gained[run].extend_from_slice(values))?;
    let channels = case.channels.len();
    let Some((quiet, loud)) = gained.split_first() else { return Ok(vec![0.0; channels]) };
    let off_by = |channel: usize, loud: &Vec<f64>| {
        let errors = loud.iter().zip(quiet).skip(channel).step_by(channels).map(|(loud, quiet)| (loud - quiet).powi(2));
        (errors.sum::<f64>() / case.rows() as f64).sqrt()
    };
    Ok((0..channels).map(|channel| loud.iter().map(|loud| off_by(channel, loud)).fold(0.0, f64::max)).collect())
}

fn signals(case: &Prepared) -> Vec<Signal> {
    case.channels.iter().map(|channel| channel.signal).collect()
}

fn driven(machine: &Machine<f64>, stimulus: &Stimulus) -> Result<Trajectory, MachineError> {
    simulate_f64(machine, stimulus, StartOffset::none())
}

fn disturbed_input(
    case: &Prepared,
    machine: &Machine<f64>,
    deviation: f64,
    seed: u64,
) -> Result<Trajectory, MachineError> {
    let mut noise = Noise::new(1, seed);
    driven(machine, &case.stimulus.disturbed(|| noise.gaussian(deviation)))
}

/// A signal that a sensor measured, and the standard deviation of its noise, SI.
type Noisy<'a> = (Signal, &'a [f64], f64);

fn noisy(recording: &Recording) -> Vec<Noisy<'_>> {
    let measured = MEASURED.into_iter().filter(|signal| *signal != Signal::OilTemperature);
    measured
        .filter_map(|signal| Some((signal, recording.signal(signal)?)))
        .map(|(signal, values)| (signal, values, noise(values, resolution(values))))
        .collect()
}

/// The recording with the same noise once more on every signal that its sensors measured.
fn disturbed<'a>(mended: &Mended<'a>, noisy: &[Noisy<'_>], seed: u64) -> Mended<'a> {
    let mut disturbed = mended.clone();
    for (stream, &(signal, values, deviation)) in (0..).zip(noisy) {
        let mut source = Noise::new(seed, stream);
        let values: Vec<f64> = values.iter().map(|value| value + source.gaussian(deviation)).collect();
        disturbed.recording.to_mut().replace(signal, &values);
    }
    disturbed
}

#[cfg(test)]
mod tests {
    use recording::Column;

    use super::*;

    /// The sum of the recorded values, as an integrator gives it.
    fn summed(mended: &Mended<'_>) -> Trajectory {
        let mut sum = 0.0;
        let force = mended.recording.signal(Signal::Force).unwrap();
        let position = force.iter().map(|force| {
            sum += force;
            sum
        });
        Trajectory { series: vec![(Signal::Position, position.collect())] }
    }

    #[test]
    fn a_sum_of_noise_is_off_as_a_random_walk_is() {
        const ROWS: u32 = 4000;
        let mut source = Noise::new(7, 0);
        let force: Vec<f64> = (0..ROWS).map(|row| (f64::from(row) * 0.01).sin() + source.gaussian(0.02)).collect();
        let columns = vec![
            Column::si(Signal::Time, (0..ROWS).map(|row| f64::from(row) * 1e-3).collect()),
            Column::si(Signal::Force, force),
        ];
        let recording = Recording::new("r", columns).unwrap();
        let mended = Mended::of(&recording);
        let found = input_noise(&mended, &summed(&mended), &[Signal::Position], |mended| Ok(summed(mended))).unwrap();
        // The mean square of a random walk over n steps is n/2 of a single step's.
        let expected = 0.02 * (f64::from(ROWS) / 2.0).sqrt();
        assert!((found[0] / expected - 1.0).abs() < 0.4, "{} {expected}", found[0]);
    }
}
