//! Rough refits to recordings as they are and changed, and what their comparison says.

use identification::compare::CompareError;
use identification::experiment::{JudgedSignal, Prepared};
use identification::fit::residuals::standardised_all;
use identification::fit::{Fit, FitError, Free, From, StartState, fit, set_tolerances};
use identification::parallel;
use machine_file::MachineFile;
use model_core::machine::Parameter;
use recording::{Recording, Signal};

use super::far_value::{FarValue, far_values};
use super::place::{BEYOND_STROKE, beyond_stroke};
use super::response::{part, prepared};
use super::{Change, Doubt, Raised};
use crate::base_parameters::base_parameters;

/// A rough look sees a tenth of a signal's variation, and one row in so many is independent of the others.
const ROUGH: f64 = 0.1;
const ROWS_EACH: f64 = 25.0;
/// A refit ends when its loss falls by less than this share: what is told apart here differs by far more.
const ROUGHLY: f64 = 3e-3;
/// With the right channels and the machine file's base parameters alone, even a drive that lacks physics is followed to this share of a signal's
/// variation.
const FOLLOWS: f64 = 0.35;
/// A change is worth a note if it leaves less than this share of the miss.
const BETTER: f64 = 0.5;
/// It is certain if it leaves less than this share ...
const FAR_BETTER: f64 = 0.25;
/// ... of a miss that is hopeless: the model does not follow half of the signal's variation.
const HOPELESS: f64 = 0.6;
/// Where values that no drive has make the recordings fit as they are, or ones that are so far from the file, the change has to follow this closely
/// without them.
const CLOSELY: f64 = 0.15;
/// Squared distance of all base parameters from the file, in their standard deviations, that no data sheet is off by: of drives that are known by theirs
/// 23 is the most …
const FAR_OFF: f64 = 40.0;
/// … and to which share of itself it has to fall with the change.
const BACK: f64 = 0.1;
/// Another change that does as well is told only if it pulls them no further off than this.
const FURTHER_OFF: f64 = 25.0;
/// The same where a value is impossible.
const FREED: f64 = 0.5;
/// A position that is this far beyond the stroke, as a share of it, counts from elsewhere.
const FAR_BEYOND_STROKE: f64 = 0.3;
/// Another change does as well as the best one if it misses less than this many times as much.
const AS_WELL: f64 = 1.5;

/// A refit to changed recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The changes; none for the recordings as they are.
    pub changes: Vec<Change>,
    /// NRMSE fit of the signals that raised the doubt, %: the mean square over them.
    pub fit_percent: f64,
    /// Values that it had to move far.
    pub far: Vec<FarValue>,
    /// The same over all signals, as a share that is missed.
    missed: f64,
    /// Squared distance of the base parameters from their nominal values, in their standard deviations.
    pulled: f64,
    /// How far the rod is beyond its stroke, as a share of it.
    beyond_stroke: f64,
}

impl Trial {
    /// Share of the doubtful signals' variation that it misses.
    fn miss(&self) -> f64 {
        1.0 - 0.01 * self.fit_percent
    }

    /// Whether it needs a value that no such drive has.
    #[must_use]
    pub fn is_impossible(&self) -> bool {
        self.beyond_stroke > FAR_BEYOND_STROKE || self.far.iter().any(|far| far.is_impossible)
    }

    /// Whether these changes make so large a difference that the recordings cannot be right without them.
    fn settles(&self, as_recorded: &Self) -> bool {
        let (before, after) = (as_recorded.miss(), self.miss());
        let hopeless_before = before > HOPELESS && after < FAR_BETTER * before && self.missed < as_recorded.missed;
        let impossible_before = as_recorded.is_impossible() && self.pulled < FREED * as_recorded.pulled;
        let follows_closely =
            after < CLOSELY && after < 2.0 * before && (impossible_before || self.brings_back(as_recorded));
        let comes_back = as_recorded.beyond_stroke > FAR_BEYOND_STROKE && self.comes_back(as_recorded);
        !self.is_impossible() && after < FOLLOWS && (hopeless_before || follows_closely || comes_back)
    }

    /// Whether this change brings values back that the recordings pull further off than any data sheet is.
    fn brings_back(&self, as_recorded: &Self) -> bool {
        as_recorded.is_far_off() && self.pulled < BACK * as_recorded.pulled
    }

    fn is_far_off(&self) -> bool {
        self.pulled > FAR_OFF
    }

    /// Whether only this change keeps the rod near its stroke.
    fn comes_back(&self, as_recorded: &Self) -> bool {
        as_recorded.beyond_stroke > BEYOND_STROKE && self.beyond_stroke <= BEYOND_STROKE
    }

    /// Whether it is worth a note.
    fn is_better(&self, as_recorded: &Self) -> bool {
        let frees = as_recorded.is_impossible() && !self.is_impossible() && self.pulled < FREED * as_recorded.pulled;
        // Friction that is missing looks a little like other areas; the right ones bring values back.
        let has_areas = self.changes.iter().any(|change| matches!(change, Change::Cylinder { .. }));
        let fits = self.miss() < BETTER * as_recorded.miss()
            && self.missed < as_recorded.missed
            && (!has_areas || self.pulled < FREED * as_recorded.pulled);
        self.miss() < HOPELESS
            && (fits
                || ((frees || self.comes_back(as_recorded)) && self.miss() < FOLLOWS)
                || (self.brings_back(as_recorded) && self.miss() < CLOSELY))
            && (!self.is_impossible() || as_recorded.is_impossible())
    }
}

/// The best of these changes of recordings that raise a doubt in these signals; `None` where none is better than the recordings as they are. A doubt that
/// is only `possible` is followed up where the recordings as they are pull values further off than any data sheet is.
pub(super) fn tried(
    file: &MachineFile,
    free: &[Free],
    recordings: &[&Recording],
    Raised { changes, signals, is_possible, .. }: &Raised,
) -> Result<Option<Doubt>, FitError> {
    let of_one = |changes: &[Change]| trial(file, free, recordings, signals, changes);
    let Some(as_recorded) = of_one(&[])? else { return Ok(None) };
    if *is_possible && !as_recorded.is_far_off() {
        return Ok(None);
    }
    let trials = parallel::try_each(changes.iter().map(Vec::as_slice), of_one)?.into_iter();
    let mut better: Vec<Trial> = trials.flatten().filter(|trial| trial.is_better(&as_recorded)).collect();
    // Of changes that do about as well in all signals, the simplest and the least pulled comes first.
    let least = better.iter().map(|trial| trial.missed).fold(f64::INFINITY, f64::min);
    let does_as_well = |trial: &Trial| trial.missed < AS_WELL * least + 0.01;
    better.retain(does_as_well);
    better.sort_by(|a, b| {
        let rank = |trial: &Trial| (trial.is_impossible(), trial.changes.len());
        rank(a).cmp(&rank(b)).then((a.missed * (1.0 + a.pulled)).total_cmp(&(b.missed * (1.0 + b.pulled))))
    });
    let pulled = better.first().map_or(0.0, |best| best.pulled + FURTHER_OFF);
    let mut better = better.into_iter();
    let Some(changed) = better.next() else { return Ok(None) };
    let is_certain = changed.settles(&as_recorded);
    let others = better.filter(|other| !other.is_impossible() && other.pulled < pulled).collect();
    let (recordings, signals) = (Vec::new(), signals.clone());
    Ok(Some(Doubt { recordings, in_all: true, signals, as_recorded, changed, others, is_certain }))
}

/// Takes every signal for as noisy as a rough look sees it, so that a refit does not leave what the machine file says for the sake of small things.
fn look_roughly(case: &mut Prepared) {
    for channel in &mut case.channels {
        let (count, sum) = channel.kept().fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
        let square: f64 = channel.kept().map(|value| (value - sum / count).powi(2)).sum();
        let rough = ROUGH * (square / count).sqrt() * f64::sqrt(ROWS_EACH);
        if rough.is_finite() {
            channel.noise = channel.noise.max(rough);
        }
    }
}

/// The NRMSE fit of one signal by a rough refit to the recordings as they are, %; `None` where they cannot be simulated.
pub(super) fn rough_fit_percent(
    file: &MachineFile,
    free: &[Free],
    recordings: &[&Recording],
    signal: Signal,
) -> Result<Option<f64>, FitError> {
    Ok(trial(file, free, recordings, &[signal], &[])?.map(|trial| trial.fit_percent))
}

/// The refit to recordings with these changes; `None` where they cannot be simulated.
fn trial(
    file: &MachineFile,
    free: &[Free],
    recordings: &[&Recording],
    signals: &[Signal],
    changes: &[Change],
) -> Result<Option<Trial>, FitError> {
    let machine = &changes.iter().fold(file.machine, |machine, change| change.on(&machine));
    // What may move, moves around the values of the changed machine.
    let moved;
    let free = if *machine == file.machine {
        free
    } else {
        let mut other = file.clone();
        other.machine = *machine;
        moved = base_parameters(&other);
        &moved
    };
    // What is within tolerances does not show in a rough look.
    let free: &[Free] = &free.iter().filter(|free| free.tolerance().is_none()).copied().collect::<Vec<_>>();
    let changed = |recording: &&Recording| {
        let changed = changes.iter().fold((*recording).clone(), |recording, change| change.of(&recording, machine));
        prepared(&part(file, &changed), machine, file.load_source)
    };
    let Ok(mut cases) = recordings.iter().map(changed).collect::<Result<Vec<Prepared>, CompareError>>() else {
        return Ok(None);
    };
    cases.iter_mut().for_each(look_roughly);
    let starts = vec![StartState::default(); cases.len()];
    if set_tolerances(machine, &mut cases, &starts).is_err() {
        return Ok(None);
    }
    let refitted = |cases: &[Prepared], from: &From<'_>| -> Result<Fit, FitError> {
        fit(machine, free, &cases.iter().collect::<Vec<_>>(), from, ROUGHLY)
    };
    let first = refitted(&cases, &From::default())?;
    set_tolerances(&first.machine, &mut cases, &first.starts).map_err(FitError::from)?;
    let found = refitted(&cases, &From { solution: Some(&first), ..From::default() })?;
    let residuals = standardised_all(&found.machine, cases.iter().zip(found.starts.iter().copied()));
    let residuals = residuals.map_err(FitError::from)?;
    let mean_miss = |wanted: &dyn Fn(Signal) -> bool| {
        let channels = cases.iter().zip(&residuals).flat_map(|(case, all)| case.channels.iter().zip(all));
        let misses: Vec<f64> = channels
            .filter(|(channel, _)| wanted(channel.signal))
            .map(|(channel, residuals)| (1.0 - 0.01 * channel.fit_percent(residuals)).powi(2))
            .collect();
        (misses.iter().sum::<f64>() / misses.len().max(1) as f64).sqrt()
    };
    let stroke_m = machine.get(Parameter::Stroke);
    let beyond = |position_m| beyond_stroke(position_m, stroke_m);
    let positions = cases.iter().flat_map(|case| &case.channels).filter(|channel| channel.signal == Signal::Position);
    Ok(Some(Trial {
        beyond_stroke: positions.flat_map(JudgedSignal::kept).map(beyond).fold(0.0, f64::max),
        changes: changes.to_vec(),
        fit_percent: 100.0 * (1.0 - mean_miss(&|signal| signals.contains(&signal))),
        far: far_values(machine, free, &found.estimates(1.0)),
        missed: mean_miss(&|_| true),
        pulled: found.coordinates.iter().map(|coordinate| coordinate * coordinate).sum(),
    }))
}
