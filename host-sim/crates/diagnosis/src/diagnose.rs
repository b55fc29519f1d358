//! The whole way: recordings in, diagnosis out.
//!
//! recording → prepare → refit → locate → hypothesis → fit → verdict. Training recordings make the choice; the held-out
//! ones are opened after it, and may only take away from it.

use identification::compare::CompareError;
use identification::effort::Effort;
use identification::experiment::{JudgedSignal, Prepared, share_range_ends};
use identification::fit::{Estimate, Fit, FitError, Free, StartState, level_at_rest};
use identification::yardstick::yardsticks;
use machine_file::MachineFile;
use model_core::machine::{Machine, MachineError, Parameter, Tick};
use recording::{Recording, Signal};
use simulation::sensor_fault::Failures;
use simulation::signal::noise::extent;
use simulation::simulate_f64;

use crate::agreement::far_values;
use crate::asked::{Asked, Found};
use crate::base_parameters::{base_parameters, with_zero_of_force};
use crate::before_after::show_all;
use crate::catalogue::{CATALOGUE, Hypothesis, Scene, Subsystem};
use crate::decision::{Decision, decide};
use crate::ending::{Ending, missed_in};
use crate::finding::Finding;
use crate::localisation::{Miss, misses};
use crate::options::Options;
use crate::outcome::{Diagnosis, Verdict};
use crate::place::{Place, Seen};
use crate::selection::decision_rule::{BELOW_VACUUM_PA, NEAR_TANK_PA};
use crate::selection::excerpt::Excerpt;
use crate::settled_valve::SettledValve;
use crate::since::{Moves, held, may_be_found, other_oil};
use crate::structure::structure;

/// Why there is no diagnosis.
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// A recording cannot be used.
    #[error(transparent)]
    Recording(#[from] CompareError),
    /// A fit is not possible.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The machine does not become a drive.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// There is nothing to train on.
    #[error("no training recording; expected at least one")]
    NoTraining,
    /// The training recordings do not drive the model at the same place.
    #[error(
        "{first} drives the model at its {input_point}, {other} at its {other_input_point}; expected all training and held-out recordings to have the same inputs"
    )]
    MixedEntries {
        /// A recording.
        first: String,
        /// Its drive input.
        input_point: String,
        /// Another one.
        other: String,
        /// Its drive input.
        other_input_point: String,
    },
}

/// Progress of a diagnosis: `done` of about `of` steps, and what was just finished.
pub type Progress<'a> = &'a (dyn Fn(&str) + Sync);

/// How many progress steps a diagnosis of this machine takes at least.
#[must_use]
pub fn steps(file: &MachineFile) -> u64 {
    1 + (CATALOGUE.len() - held(file, &base_parameters(file)).len()) as u64
}

/// Diagnoses a drive from training recordings, and confirms on held-out ones.
///
/// ```
/// use std::path::Path;
///
/// use diagnosis::{Verdict, diagnose};
/// use recording::{ChannelMap, Recording};
///
/// let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../examples/press-63-40");
/// let drive = machine_file::read(&example.join("machine.toml"))?;
/// let read = |names: &[&str]| -> Result<Vec<Recording>, _> {
///     names.iter().map(|name| recording::read(&example.join(name), &ChannelMap::default())).collect()
/// };
/// let training = read(&["train-1.csv", "train-2.csv"])?;
/// let held_out = read(&["holdout-1.csv"])?;
///
/// let diagnosis = diagnose(&drive, &training, &held_out, None, &|_| {})?;
/// assert_eq!(diagnosis.verdict, Verdict::MissingPhysics);
/// assert_eq!(diagnosis.findings[0].effect.name, "internal-leakage");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn diagnose(
    file: &MachineFile,
    training: &[Recording],
    held_out: &[Recording],
    tick: Option<Tick>,
    progress: Progress<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    diagnose_with(file, (training, held_out), Options { tick, ..Options::default() }, progress)
}

/// Diagnoses what has changed since a machine file was written: the effects that it holds may have become more or less, and each that has is a finding.
pub fn diagnose_since(
    file: &MachineFile,
    training: &[Recording],
    held_out: &[Recording],
    tick: Option<Tick>,
    progress: Progress<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    diagnose_with(file, (training, held_out), Options { tick, asks_since: true, ..Options::default() }, progress)
}

/// Diagnoses a drive, or where that is asked what has changed of it since, within a limit: a search that does not come to its own end claims nothing.
pub fn diagnose_with(
    file: &MachineFile,
    (training, held_out): (&[Recording], &[Recording]),
    Options { tick, asks_since, limit_s }: Options,
    progress: Progress<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    let effort = limit_s.map_or_else(Effort::default, Effort::within);
    let (trained, held) = prepared(file, (training, held_out), tick, &effort)?;
    let first = trained.first().ok_or(DiagnoseError::NoTraining)?;
    check_entries(&trained, &held)?;

    let sheet = with_zero_of_force(base_parameters(file), file, training);
    let on = self::held(file, &sheet);
    let moves = Moves::of(file, &sheet, asks_since.then_some(on.as_slice()), &trained);
    let valve = SettledValve::of(&file.machine, &moves.free, &moves.changeable, &trained)?;
    let machine = valve.as_ref().map_or(&file.machine, |valve| &valve.machine);
    let free = valve.as_ref().map_or(moves.free.as_slice(), |valve| &valve.free);
    let judged: Vec<Signal> = first.channels.iter().map(|channel| channel.signal).collect();
    let scene = Scene {
        asks_since,
        held: &moves.held,
        changeable: &moves.changeable,
        ..scene(file, machine, &judged, &trained)?
    };
    let (hypotheses, not_testable) = hypotheses(&scene, &on, valve.is_some(), &moves);
    let mut excerpt = Excerpt::of(training, &trained, &file.machine, file.load_source).map_err(CompareError::from)?;
    let asked = Asked { scene: &scene, base_parameters: free, hypotheses: &hypotheses };
    let Found { mut selection, decided, plain, outside, trained, held } =
        asked.found((trained, held), excerpt.as_mut(), progress)?;

    let references: Vec<&Prepared> = trained.iter().collect();
    let opened: Vec<&Prepared> = held.iter().collect();
    let decided = decided.map_or_else(|| decide(&asked.of(&references), &mut selection, &opened), Ok)?;
    // Where and how the misfit looks is told of the model without a force from outside.
    let (plain_base, without, held_without) = plain.as_ref().map_or_else(
        || (&selection.base, references.clone(), opened.clone()),
        |plain| (&plain.base, plain.trained.iter().collect(), plain.held.iter().collect()),
    );
    let is_impossible =
        far_values(&decided.after.fit.machine, &moves.free, &decided.estimates).iter().any(|far| far.is_impossible);
    let Ending { verdict, training_is_too_narrow } = match decided.findings.as_slice() {
        [] if !selection.searched.is_finished() => Ending::UNFINISHED,
        [] => Ending::of_base(asked, plain_base, is_impossible, (&without, &held_without))?,
        _ => Ending::FOUND,
    };
    let suspected = if verdict == Verdict::NothingMissing { selection.suspected() } else { None };
    let looked_at = match &excerpt {
        Some(excerpt) => (excerpt.recordings.as_slice(), excerpt.cases.iter().collect()),
        None => (training, without.clone()),
    };
    let seen = Seen { asked, recordings: looked_at.0, cases: &looked_at.1, is_excerpt: excerpt.is_some() };
    // Sparse rows that a model follows only with a value that no such drive has tell no table either.
    let tells_tables = outside.is_none() && !(is_impossible && scene.is_sparse);
    let tables_in = tells_tables.then_some(opened.as_slice());
    let Place { located, tabled } =
        seen.place(plain_base, (verdict, &decided, suspected), tables_in, &mut selection.searched)?;
    let Decision { findings, not_confirmed, otherwise, confirmation, after, estimates } = decided;
    let (estimates, after, unnamed) = match tabled {
        Some((tabled, estimates, unnamed)) => (estimates, tabled, Some(unnamed)),
        None => (estimates, after, None),
    };
    let [left, left_held_out] = left_by(&after.fit, &references, &opened)?;
    let level_at_rest = level_at_rest(&after.fit.machine, &references, &after.fit.starts);
    let linear = yardsticks(&without, &held_without);
    let plain: Vec<&Prepared> = plain.iter().flat_map(|plain| plain.trained.iter().chain(&plain.held)).collect();
    let shown = show_all(trained, held, &plain, &plain_base.fit, &after.fit)?;
    let of_spool = valve.into_iter().flat_map(|valve| valve.estimates);
    let refitted = of_base(&moves.free, &findings, of_spool.chain(estimates));
    let structure = structure(linear, &shown, &file.machine, &recorded_supply(training.iter().chain(held_out)));
    let structure = if selection.searched.is_finished() { structure } else { structure.unclaimed() };
    Ok(Diagnosis {
        machine: file.name.clone(),
        since: asks_since.then(|| on.clone()),
        then: None,
        untested: moves.untested(&hypotheses, &refitted),
        other_oil: other_oil(file, &shown, &after.fit.machine).filter(|_| asks_since),
        doubts: Vec::new(),
        verdict,
        located,
        suspected,
        findings,
        outside,
        left,
        left_held_out,
        structure,
        training_is_too_narrow,
        unsettled: after.unsettled(),
        not_confirmed,
        otherwise,
        unnamed,
        confirmation,
        refitted,
        base_parameters: moves.free,
        correlated: after.correlations(),
        shown,
        machine_after: after.fit.machine,
        level_at_rest,
        not_testable,
        selection,
    })
}

/// The training and the held-out recordings, of which each sensor is the same in all. They share a meter.
fn prepared(
    file: &MachineFile,
    (training, held_out): (&[Recording], &[Recording]),
    tick: Option<Tick>,
    effort: &Effort,
) -> Result<(Vec<Prepared>, Vec<Prepared>), CompareError> {
    let prepare = |recording: &Recording| {
        let case = Prepared::new(recording, &file.machine, file.load_source, tick)?;
        Ok::<_, CompareError>(Prepared { effort: effort.clone(), ..case })
    };
    let mut trained: Vec<Prepared> = training.iter().map(prepare).collect::<Result<_, _>>()?;
    let mut held: Vec<Prepared> = held_out.iter().map(prepare).collect::<Result<_, _>>()?;
    share_range_ends(&mut trained.iter_mut().chain(&mut held).collect::<Vec<_>>());
    Ok((trained, held))
}

/// What is known of a drive beforehand, and what these recordings say of where it works.
fn scene<'a>(
    file: &MachineFile,
    machine: &'a Machine<f64>,
    judged: &'a [Signal],
    trained: &[Prepared],
) -> Result<Scene<'a>, DiagnoseError> {
    let first = trained.first().ok_or(DiagnoseError::NoTraining)?;
    Ok(Scene {
        machine,
        input_point: first.stimulus.input_point,
        load: file.load_source,
        judged,
        travel_m: travelled(machine, trained),
        duration_s: trained.iter().map(Prepared::duration_s).fold(0.0, f64::max),
        is_sparse: trained.iter().all(Prepared::is_sparse),
        lowest_pa: lowest_pressure(machine, trained)?,
        held: &[],
        asks_since: false,
        changeable: &[],
    })
}

/// The effects that these recordings may show, and those that they cannot: `on` are those of the machine file. Of a valve that is settled
/// only those are asked that may have changed.
fn hypotheses(
    scene: &Scene<'_>,
    on: &[&Hypothesis],
    is_settled: bool,
    moves: &Moves,
) -> (Vec<&'static Hypothesis>, Vec<&'static Hypothesis>) {
    let is_held = |effect: &Hypothesis| scene.held.iter().any(|held| held.name == effect.name);
    CATALOGUE
        .iter()
        .copied()
        .filter(|effect| may_be_found(effect, on, scene.held, scene.changeable) && effect.is_reached(scene))
        .filter(|effect| !moves.has_in_model(effect))
        .filter(|effect| !is_settled || effect.subsystem != Subsystem::Valve || is_held(effect))
        .partition(|effect| effect.is_testable(scene))
}

/// The supply pressure of each recording, where it is recorded.
fn recorded_supply<'a>(recordings: impl Iterator<Item = &'a Recording>) -> Vec<Option<&'a [f64]>> {
    let works = |recording: &Recording, values: &[f64]| {
        !Failures::of(Signal::SupplyPressure, recording.time_s(), values).are_any()
    };
    let of =
        |recording: &'a Recording| recording.signal(Signal::SupplyPressure).filter(|values| works(recording, values));
    recordings.map(of).collect()
}

/// The estimates of base parameters, in their order. An amount that has changed is the finding's.
fn of_base(free: &[Free], findings: &[Finding], estimates: impl Iterator<Item = Estimate>) -> Vec<Estimate> {
    let mut estimates: Vec<Estimate> = estimates.collect();
    let has_changed = |one: &Estimate| {
        findings.iter().flat_map(|finding| &finding.before).any(|(parameter, _)| *parameter == one.parameter)
    };
    estimates.retain(|one| !has_changed(one));
    let of = |free: &Free| estimates.iter().find(|estimate| estimate.parameter == free.parameter).copied();
    free.iter().filter_map(of).collect()
}

/// What a model misses of the training recordings that it was fitted to, and of the held-out ones, where that is more than noise.
fn left_by(after: &Fit, training: &[&Prepared], held_out: &[&Prepared]) -> Result<[Vec<Miss>; 2], MachineError> {
    let started = training.iter().copied().zip(after.starts.iter().copied());
    Ok([above_noise(misses(&after.machine, started)?), above_noise(missed_in(&after.machine, held_out)?)])
}

/// Signals that are missed by more than noise.
fn above_noise(mut misses: Vec<Miss>) -> Vec<Miss> {
    misses.retain(Miss::is_above_noise);
    misses
}

/// Lowest and highest position judged, m; the whole stroke where none is.
pub(crate) fn travelled(machine: &Machine<f64>, cases: &[Prepared]) -> (f64, f64) {
    let channels = cases.iter().flat_map(|case| &case.channels);
    let positions = channels.filter(|channel| channel.signal == Signal::Position).flat_map(JudgedSignal::kept);
    let (low, high) = extent(positions);
    if low < high { (low, high) } else { (0.0, machine.get(Parameter::Stroke)) }
}

/// Lowest pressure that a chamber of the nominal model reaches in these recordings, Pa. Infinite where both pressures are measured and stay away from
/// the tank's, or where a sensor shows less than a vacuum: in that drive oil does pull.
fn lowest_pressure(machine: &Machine<f64>, cases: &[Prepared]) -> Result<f64, MachineError> {
    let mut lowest_pa = f64::INFINITY;
    for case in cases {
        let start = StartState::default().offset(machine, case);
        let simulated = simulate_f64(machine, &case.stimulus, start)?;
        for signal in [Signal::PressureA, Signal::PressureB] {
            let measured = case.channels.iter().find(|channel| channel.signal == signal);
            let shown = measured.map(|channel| extent(channel.kept()).0);
            if shown.is_some_and(|pa| pa < BELOW_VACUUM_PA) {
                return Ok(f64::INFINITY);
            }
            if shown.is_some_and(|pa| pa > machine.get(Parameter::TankPressure) + NEAR_TANK_PA) {
                continue;
            }
            let fallen = simulated.signal(signal).unwrap_or_default().iter().copied().fold(f64::INFINITY, f64::min);
            lowest_pa = lowest_pa.min(fallen);
        }
    }
    Ok(lowest_pa)
}

fn check_entries(training: &[Prepared], held: &[Prepared]) -> Result<(), DiagnoseError> {
    let Some(first) = training.first() else { return Err(DiagnoseError::NoTraining) };
    match training.iter().chain(held).find(|other| other.stimulus.input_point != first.stimulus.input_point) {
        None => Ok(()),
        Some(other) => Err(DiagnoseError::MixedEntries {
            first: first.name.clone(),
            input_point: format!("{:?}", first.stimulus.input_point).to_lowercase(),
            other: other.name.clone(),
            other_input_point: format!("{:?}", other.stimulus.input_point).to_lowercase(),
        }),
    }
}
