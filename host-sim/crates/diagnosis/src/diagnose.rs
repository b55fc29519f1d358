//! The whole way: recordings in, diagnosis out.
//!
//! recording → prepare → refit → locate → hypothesis → fit → verdict. Training recordings make the choice; the held-out
//! ones are opened after it, and may only take away from it.

use std::collections::BTreeMap;
use std::mem;

use identification::compare::CompareError;
use identification::experiment::{JudgedSignal, Prepared, share_range_ends};
use identification::fit::{Estimate, Fit, FitError, Free, Freedom, StartState, level_at_rest};
use identification::yardstick::yardsticks;
use machine_file::MachineFile;
use model_core::machine::{Machine, MachineError, Parameter, Tick};
use recording::{Recording, Signal};
use simulation::sensor_fault::Failures;
use simulation::signal::noise::extent;
use simulation::{is_driven_by_pressures, simulate_f64};

use crate::agreement::far_values;
use crate::asked::{Asked, Beside};
use crate::before_after::show_all;
use crate::catalogue::{CATALOGUE, Hypothesis, Scene, Subsystem};
use crate::correction_table::improved;
use crate::decision::{Decision, decide};
use crate::ending::{Ending, missed_in};
use crate::finding::Finding;
use crate::gains;
use crate::localisation::locate::locate;
use crate::localisation::{Case, Location, Miss, Sought, misses};
use crate::outcome::{Diagnosis, Verdict};
use crate::selection::candidate::Reference;
use crate::selection::decision_rule::{BELOW_VACUUM_PA, NEAR_TANK_PA};
use crate::selection::excerpt::Excerpt;
use crate::selection::screen::Lead;
use crate::selection::{Candidate, Question, Selection};
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
    diagnosed(file, false, (training, held_out), tick, progress)
}

/// Diagnoses what has changed since a machine file was written: the effects that it holds may have become more or less, and each that has is a finding.
pub fn diagnose_since(
    file: &MachineFile,
    training: &[Recording],
    held_out: &[Recording],
    tick: Option<Tick>,
    progress: Progress<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    diagnosed(file, true, (training, held_out), tick, progress)
}

/// Diagnoses a drive, or where that is asked what has changed of it since.
#[expect(clippy::too_many_lines, reason = "the whole way, a stage a line")]
fn diagnosed(
    file: &MachineFile,
    asks_since: bool,
    (training, held_out): (&[Recording], &[Recording]),
    tick: Option<Tick>,
    progress: Progress<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    let (mut trained, mut held) = prepared(file, training, held_out, tick)?;
    let first = trained.first().ok_or(DiagnoseError::NoTraining)?;
    check_entries(&trained, &held)?;

    let sheet = with_zero_of_force(base_parameters(file), file, training);
    let on = self::held(file, &sheet);
    let moves = Moves::of(file, &sheet, asks_since.then_some(on.as_slice()), &trained);
    let valve = SettledValve::of(&file.machine, &moves.free, &moves.changeable, &trained)?;
    let machine = valve.as_ref().map_or(&file.machine, |valve| &valve.machine);
    let base_parameters = valve.as_ref().map_or(moves.free.as_slice(), |valve| &valve.free);
    let judged: Vec<Signal> = first.channels.iter().map(|channel| channel.signal).collect();
    let scene = Scene { held: &moves.held, changeable: &moves.changeable, ..scene(file, machine, &judged, &trained)? };
    let (hypotheses, not_testable) = hypotheses(&scene, &on, valve.is_some(), &moves);
    let mut excerpt = Excerpt::of(training, &trained, &file.machine, file.load_source).map_err(CompareError::from)?;
    let asked = Asked { scene: &scene, base_parameters, hypotheses: &hypotheses };
    let (mut selection, decided, beside) = searched(asked, (&mut trained, &held), excerpt.as_mut(), progress)?;
    let (plain, outside) = beside
        .map(|beside| {
            let trained = mem::replace(&mut trained, beside.trained);
            let held = mem::replace(&mut held, beside.held);
            let base = mem::replace(&mut selection, beside.selection).base;
            (Plain { trained, held, base }, beside.told)
        })
        .unzip();

    let references: Vec<&Prepared> = trained.iter().collect();
    let opened: Vec<&Prepared> = held.iter().collect();
    let decided = decided.map_or_else(|| decide(&asked.of(&references), &mut selection, &opened), Ok)?;
    let Decision { findings, not_confirmed, confirmation, after, estimates } = decided;
    // Where and how the misfit looks is told of the model without a force from outside.
    let (plain_base, without, held_without) = plain.as_ref().map_or_else(
        || (&selection.base, references.clone(), opened.clone()),
        |plain| (&plain.base, plain.trained.iter().collect(), plain.held.iter().collect()),
    );
    let is_impossible = far_values(&after.fit.machine, &moves.free, &estimates).iter().any(|far| far.is_impossible);
    let Ending { verdict, training_is_too_narrow } = match findings.as_slice() {
        [] => Ending::of_base(asked, plain_base, is_impossible, (&without, &held_without))?,
        _ => Ending::FOUND,
    };
    // Where and how it looks is told by what was searched.
    let (recordings, searched) = match &excerpt {
        Some(excerpt) => (excerpt.recordings.as_slice(), excerpt.cases.iter().collect()),
        None => (training, without.clone()),
    };
    let question = asked.of(&searched);
    let seen = if excerpt.is_some() { plain_base.finished(&question)? } else { plain_base.clone() };
    let cases = cases(recordings, &searched, &seen.fit.starts);
    let suspected = if verdict == Verdict::NothingMissing { selection.suspected() } else { None };
    // What was named tells the link better than what it looks like from outside; within the noise, only what was all but named.
    let effects: Vec<&Hypothesis> = match verdict {
        Verdict::MissingPhysics => findings.iter().map(|finding| finding.effect).collect(),
        Verdict::NothingMissing => suspected.into_iter().chain(not_confirmed.iter().copied()).collect(),
        Verdict::Unexplained => Vec::new(),
    };
    let named: Vec<Subsystem> = effects.iter().map(|effect| effect.subsystem).collect();
    let located = if verdict == Verdict::NothingMissing && named.is_empty() {
        None
    } else {
        Some(place(&question, &seen, &cases, &named)?)
    };
    let tabled = match &located {
        Some(location) if verdict == Verdict::Unexplained && outside.is_none() => {
            improved(&question, &seen, location, &cases, &opened)?
        }
        _ => None,
    };
    let (estimates, after, unnamed) = match tabled {
        Some((tabled, unnamed)) => (tabled.estimates(&question)?, tabled, Some(unnamed)),
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

/// What free runs choose, and what they choose beside a cause from outside; or what the gains of a drive that is entered at a measured force say, which is
/// decided already.
fn searched(
    asked: Asked<'_>,
    (trained, held): (&mut [Prepared], &[Prepared]),
    mut excerpt: Option<&mut Excerpt>,
    progress: Progress<'_>,
) -> Result<(Selection, Option<Decision>, Option<Beside>), FitError> {
    let selection = asked.selected(trained, excerpt.as_deref_mut(), progress)?;
    let beside = if excerpt.is_none() { asked.outside(&selection, trained, held, progress)? } else { None };
    if beside.is_some() {
        return Ok((selection, None, beside));
    }
    Ok(match gains::found(asked, &selection, (trained, held), excerpt.as_deref(), progress)? {
        Some((selection, decision)) => (selection, Some(decision), None),
        None => (selection, None, None),
    })
}

/// The training and the held-out recordings, of which each sensor is the same in all.
fn prepared(
    file: &MachineFile,
    training: &[Recording],
    held_out: &[Recording],
    tick: Option<Tick>,
) -> Result<(Vec<Prepared>, Vec<Prepared>), CompareError> {
    let prepare = |recording: &Recording| Prepared::new(recording, &file.machine, file.load_source, tick);
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
        lowest_pa: lowest_pressure(machine, trained)?,
        held: &[],
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

/// What there was before a force from outside became an input.
struct Plain {
    trained: Vec<Prepared>,
    held: Vec<Prepared>,
    base: Candidate,
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

/// Where the misfit of a model is, by what was named of it, or else by what the best hypothesis of each subsystem would gain.
fn place(
    question: &Question<'_>,
    seen: &Candidate,
    cases: &[Case<'_>],
    named: &[Subsystem],
) -> Result<Location, FitError> {
    let predicted_gains = if named.is_empty() {
        predicted_gains(&Reference::new(question, seen)?.leads(question.hypotheses)?)
    } else {
        Vec::new()
    };
    let (machine, load) = (&seen.fit.machine, question.scene.load);
    Ok(locate(&Sought { machine, load, cases, named, predicted_gains: &predicted_gains })?)
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

/// Recordings with how they were prepared and where each starts.
fn cases<'a>(recordings: &'a [Recording], prepared: &[&'a Prepared], starts: &[StartState]) -> Vec<Case<'a>> {
    let together = recordings.iter().zip(prepared).zip(starts);
    together.map(|((recording, prepared), &start)| Case { recording, prepared, start }).collect()
}

/// What the best hypothesis of each subsystem would gain.
fn predicted_gains(leads: &[Lead]) -> Vec<(Subsystem, f64)> {
    let mut best: BTreeMap<Subsystem, f64> = BTreeMap::new();
    for lead in leads {
        let gain = best.entry(lead.effect.subsystem).or_default();
        *gain = gain.max(lead.gain);
    }
    best.into_iter().collect()
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

/// Base parameters that may move: those of `[fit.sigma]`, else every one that the file gives and that is usually
/// uncertain, by a tenth of its value; and what is within its tolerance by `[fit.tolerance]`.
#[must_use]
pub fn base_parameters(file: &MachineFile) -> Vec<Free> {
    const USUALLY_UNCERTAIN: &[Parameter] = &[
        Parameter::ValveGain,
        Parameter::DeadZone,
        Parameter::RateLimit,
        Parameter::TimeConstant1,
        Parameter::TimeConstant2,
        Parameter::TransportDelay,
        Parameter::FlowCoefficient,
        Parameter::BulkModulus,
        Parameter::ViscousFriction,
        Parameter::PumpDisplacement,
    ];
    let value = |parameter| file.machine.get(parameter);
    let around = |parameter: Parameter, sigma: f64| {
        // A chamber that follows its piston has oil left when the piston is at its end.
        let displaced = match parameter {
            Parameter::VolumeA => Parameter::AreaA,
            Parameter::VolumeB => Parameter::AreaB,
            _ => return Free::around(parameter, value(parameter), sigma),
        };
        let swept_m3 = 0.5 * value(displaced) * value(Parameter::Stroke);
        if value(Parameter::VolumeFollows) > 0.0 && swept_m3 < value(parameter) {
            Free::above(swept_m3, parameter, value(parameter), sigma)
        } else {
            Free::around(parameter, value(parameter), sigma)
        }
    };
    let mut free: Vec<Free> = if file.has_sigma_table {
        file.sigma.iter().map(|(&parameter, &sigma)| around(parameter, sigma)).collect()
    } else {
        let sigma = |parameter: Parameter| 0.1 * value(parameter).abs();
        let given = USUALLY_UNCERTAIN.iter().copied().filter(|parameter| file.given.contains(parameter));
        given
            .filter(|&parameter| sigma(parameter) > 0.0 && sigma(parameter).is_finite())
            .map(|parameter| around(parameter, sigma(parameter)))
            .collect()
    };
    free.extend(file.tolerance.iter().map(|(&parameter, &most)| Free {
        parameter,
        freedom: Freedom::Within { most, is_signed: parameter.description().min < 0.0 },
    }));
    free
}

/// The base parameters, and what the zeros of two pressure sensors make of a force that is computed from both: a bar on the larger area. It moves the rod as a
/// constant load does.
fn with_zero_of_force(mut free: Vec<Free>, file: &MachineFile, recordings: &[Recording]) -> Vec<Free> {
    /// 0.3 % of 250 bar, and what warms up.
    const ZERO_PA: f64 = 1e5;
    let is_free = free.iter().any(|free| free.parameter == Parameter::LoadForce);
    if !is_free && recordings.iter().any(|recording| is_driven_by_pressures(file.machine.source, recording)) {
        let area = file.machine.get(Parameter::AreaA).max(file.machine.get(Parameter::AreaB));
        free.push(Free::around(Parameter::LoadForce, file.machine.get(Parameter::LoadForce), ZERO_PA * area));
    }
    free
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
