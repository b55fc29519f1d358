//! Rough refits to recordings as they are and changed, and what their comparison says.

use identification::compare::CompareError;
use identification::experiment::Prepared;
use identification::fit::residuals::standardised_all;
use identification::fit::{Fit, FitError, Free, From, StartState, fit, set_tolerances};
use identification::parallel;
use machine_file::MachineFile;
use recording::{Recording, Signal};

use super::far_value::{FarValue, far_values};
use super::response::prepared;
use super::{Change, Doubt};
use crate::diagnose::base_parameters;

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
/// Where values that no drive has make the recordings fit as they are, the change has to follow this closely without them.
const CLOSELY: f64 = 0.15;
/// The squared distance of all base parameters, in their standard deviations, has to fall to this share.
const FREED: f64 = 0.5;
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
}

impl Trial {
    /// Share of the doubtful signals' variation that it misses.
    fn miss(&self) -> f64 {
        1.0 - 0.01 * self.fit_percent
    }

    /// Whether it needs a value that no such drive has.
    #[must_use]
    pub fn is_impossible(&self) -> bool {
        self.far.iter().any(|far| far.is_impossible)
    }

    /// Whether these changes make so large a difference that the recordings cannot be right without them.
    fn settles(&self, as_recorded: &Self) -> bool {
        let (before, after) = (as_recorded.miss(), self.miss());
        let hopeless_before = before > HOPELESS && after < FAR_BETTER * before && self.missed < as_recorded.missed;
        let impossible_before = as_recorded.is_impossible()
            && after < CLOSELY
            && after < 2.0 * before
            && self.pulled < FREED * as_recorded.pulled;
        !self.is_impossible() && after < FOLLOWS && (hopeless_before || impossible_before)
    }

    /// Whether it is worth a note.
    fn is_better(&self, as_recorded: &Self) -> bool {
        let frees = as_recorded.is_impossible() && !self.is_impossible() && self.pulled < FREED * as_recorded.pulled;
        let fits = self.miss() < BETTER * as_recorded.miss() && self.missed < as_recorded.missed;
        self.miss() < HOPELESS
            && (fits || (frees && self.miss() < FOLLOWS))
            && (!self.is_impossible() || as_recorded.is_impossible())
    }
}

/// The best of these changes of recordings that raise a doubt in these signals; `None` where none is better than the recordings as they are.
pub(super) fn tried(
    file: &MachineFile,
    free: &[Free],
    parts: &[Recording],
    signals: &[Signal],
    changes: &[Vec<Change>],
) -> Result<Option<Doubt>, FitError> {
    let all = std::iter::once(&[][..]).chain(changes.iter().map(Vec::as_slice));
    let of_one = |changes: &[Change]| trial(file, free, parts, signals, changes);
    let mut trials = parallel::try_each(all, of_one)?.into_iter();
    let Some(as_recorded) = trials.next().flatten() else { return Ok(None) };
    let mut better: Vec<Trial> = trials.flatten().filter(|trial| trial.is_better(&as_recorded)).collect();
    // Of changes that do about as well, the simplest and the least pulled comes first.
    let least = better.iter().map(Trial::miss).fold(f64::INFINITY, f64::min);
    let does_as_well = |trial: &Trial| trial.miss() < AS_WELL * least + 0.01;
    better.retain(does_as_well);
    better.sort_by(|a, b| {
        let rank = |trial: &Trial| (trial.is_impossible(), trial.changes.len());
        rank(a).cmp(&rank(b)).then((a.miss() * (1.0 + a.pulled)).total_cmp(&(b.miss() * (1.0 + b.pulled))))
    });
    let mut better = better.into_iter();
    let Some(changed) = better.next() else { return Ok(None) };
    let is_certain = changed.settles(&as_recorded);
    let others = better.filter(|other| !other.is_impossible()).collect();
    let (recordings, signals) = (Vec::new(), signals.to_vec());
    Ok(Some(Doubt { recordings, in_all: true, signals, as_recorded, changed, others, is_certain }))
}

/// The refit to recordings with these changes; `None` where they cannot be simulated.
fn trial(
    file: &MachineFile,
    free: &[Free],
    parts: &[Recording],
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
    let changed = |part: &Recording| {
        let changed = changes.iter().fold(part.clone(), |recording, change| change.of(&recording, machine));
        prepared(&changed, machine, file.load_source)
    };
    let Ok(mut cases) = parts.iter().map(changed).collect::<Result<Vec<Prepared>, CompareError>>() else {
        return Ok(None);
    };
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
    Ok(Some(Trial {
        changes: changes.to_vec(),
        fit_percent: 100.0 * (1.0 - mean_miss(&|signal| signals.contains(&signal))),
        far: far_values(free, &found.estimates(1.0)),
        missed: mean_miss(&|_| true),
        pulled: found.coordinates.iter().map(|coordinate| coordinate * coordinate).sum(),
    }))
}
