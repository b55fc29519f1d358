//! Whether the pressures of a drive were read by absolute sensors, asked before any physics is searched for.
//!
//! A sensor whose zero is the vacuum reads the pressure of the air more than one whose zero is the air. The model balances forces and meters flow by
//! pressures above the air: one offset that all pressures share looks like a load, and like unequal edges.

use identification::experiment::Prepared;
use identification::fit::{Fit, Residuals};
use machine_file::MachineFile;
use model_core::machine::{Machine, Tick};
use recording::{PressureZero, Recording, Signal};

use crate::base_parameters::base_parameters;
use crate::catalogue::Scene;
use crate::diagnose::{DiagnoseError, travelled};
use crate::selection::decision_rule::{ABSOLUTE_EXPLAINS, ABSOLUTE_GAINS};
use crate::selection::excerpt::Excerpt;
use crate::selection::likelihood::{gained, misfit_above_noise, straightened};
use crate::selection::{Candidate, Question};

/// Both pressures: the offset is theirs together, and one of them alone is a sensor's own.
const BOTH: [Signal; 2] = [Signal::PressureA, Signal::PressureB];

/// Whether training recordings fit the refitted model far better with the pressure of the air taken off all pressures: without it, nearly nothing of the
/// misfit above noise is left, and each of both pressures gains.
pub fn read_absolute(file: &MachineFile, training: &[Recording], tick: Option<Tick>) -> Result<bool, DiagnoseError> {
    let has_both = |recording: &Recording| BOTH.iter().all(|&signal| recording.has(signal));
    if file.channels.pressure == PressureZero::Absolute || training.is_empty() || !training.iter().all(has_both) {
        return Ok(false);
    }
    let taken: Vec<Recording> = training
        .iter()
        .map(|recording| {
            let mut taken = recording.clone();
            taken.take_as_absolute();
            taken
        })
        .collect();
    let (mut gauge, mut absolute) = (cases(file, training, tick)?, cases(file, &taken, tick)?);
    let is_judged =
        |case: &Prepared| BOTH.iter().all(|both| case.channels.iter().any(|channel| channel.signal == *both));
    if !gauge.iter().chain(&absolute).all(is_judged) {
        return Ok(false);
    }
    let judged: Vec<Signal> = gauge[0].channels.iter().map(|channel| channel.signal).collect();
    let scene = Scene {
        machine: &file.machine,
        input_point: gauge[0].stimulus.input_point,
        load: file.load_source,
        judged: &judged,
        travel_m: travelled(&file.machine, &gauge),
        duration_s: gauge.iter().map(Prepared::duration_s).fold(0.0, f64::max),
        is_sparse: gauge.iter().all(Prepared::is_sparse),
        lowest_pa: f64::INFINITY,
        held: &[],
        asks_since: false,
        changeable: &[],
    };
    let base = base_parameters(file);
    let near = Candidate::tolerated(&scene, &base, &mut gauge)?;
    // Both are compared by the same loss.
    for (case, other) in absolute.iter_mut().zip(&gauge) {
        for (channel, other) in case.channels.iter_mut().zip(&other.channels) {
            channel.tolerance = other.tolerance;
        }
    }
    let gauge: Vec<&Prepared> = gauge.iter().collect();
    let absolute: Vec<&Prepared> = absolute.iter().collect();
    let refitted = |training: &[&Prepared], near: &Fit| {
        Candidate::rough(&Question { scene: &scene, base_parameters: &base, hypotheses: &[], training }, Some(near))
    };
    let (before, after) = (refitted(&gauge, &near)?, refitted(&absolute, &near)?);
    let explained = 1.0 - misfit_above_noise(&after.residuals) / misfit_above_noise(&before.residuals);
    let question = Question { scene: &scene, base_parameters: &base, hypotheses: &[], training: &gauge };
    let of = |signals: &[Signal]| gain(&question, &before.residuals, &after.residuals, signals);
    let each = BOTH.iter().all(|signal| of(&[*signal]) > ABSOLUTE_GAINS);
    Ok(each && explained > ABSOLUTE_EXPLAINS && of(&judged) + straightened(&question, &before, &after) > ABSOLUTE_GAINS)
}

/// The recordings as a search looks at them.
/// Where training recordings say that the pressures count from a vacuum ([`read_absolute`]), takes them so in all recordings, and has the machine file say so.
pub fn settle_pressure_zero(
    file: &mut MachineFile,
    training: &mut [Recording],
    held_out: &mut [Recording],
    tick: Option<Tick>,
) -> Result<(), DiagnoseError> {
    if read_absolute(file, training, tick)? {
        training.iter_mut().chain(held_out).for_each(Recording::take_as_absolute);
        file.channels.pressure = PressureZero::Absolute;
    }
    Ok(())
}

fn cases(file: &MachineFile, training: &[Recording], tick: Option<Tick>) -> Result<Vec<Prepared>, DiagnoseError> {
    let prepare = |recording: &Recording| Prepared::new(recording, &file.machine, file.load_source, tick);
    let whole: Vec<Prepared> = training.iter().map(prepare).collect::<Result<_, _>>()?;
    let machine: &Machine<f64> = &file.machine;
    let excerpt = Excerpt::of(training, &whole, machine, file.load_source)
        .map_err(identification::compare::CompareError::from)?;
    Ok(excerpt.map_or(whole, |excerpt| excerpt.cases))
}

/// Log-likelihood gained on some of the signals.
fn gain(question: &Question<'_>, before: &Residuals, after: &Residuals, signals: &[Signal]) -> f64 {
    let counts = question.counts();
    let mut gain = 0.0;
    for (case, (before, after)) in question.training.iter().zip(before.iter().zip(after)) {
        for (channel, (before, after)) in case.channels.iter().zip(before.iter().zip(after)) {
            if signals.contains(&channel.signal) {
                gain += gained(before, after, counts);
            }
        }
    }
    gain
}
