//! A refit of a drive's base parameters to recordings: from a first search to what the best values still leave. Nothing is added to the model.

use identification::experiment::{Prepared, share_range_ends};
use identification::fit::residuals::counts_from;
use identification::fit::{
    Correlation, Counts, Estimate, Fit, FitError, Free, From, Unsettled, effective_samples, first_search,
    fit_with_progress, inflation, level_at_rest, most_evaluations, softened_all, staged, with_channel_tolerances,
};
use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter, Tick};
use recording::Recording;

use crate::agreement::{FarValue, Tolerated, far_values, has_sensor, not_tolerated, tolerated};
use crate::base_parameters::base_parameters;
use crate::before_after::{Shown, show_refit};
use crate::diagnose::DiagnoseError;
use crate::localisation::{Miss, misses};
use crate::since::{Moves, held, is_as_before, strengths};

/// The search ends at this relative precision of the loss.
const PRECISION: f64 = 1e-8;

/// A refit that has not been searched for yet: its recordings prepared, a first solution near the machine file's values.
#[derive(Debug)]
pub struct Refitting {
    file: MachineFile,
    prepared: Vec<Prepared>,
    held_out: Vec<Prepared>,
    free: Vec<Free>,
    /// The amounts of effects that may have changed.
    changeable: Vec<Parameter>,
    near: Fit,
}

/// A refitted drive.
#[derive(Clone, Debug)]
pub struct Refit {
    /// The machine file with the fitted values.
    pub file: MachineFile,
    /// What may move, and how far the machine file says that it is off.
    pub base_parameters: Vec<Free>,
    /// The fitted values that are no tolerances, with their standard deviations.
    pub estimates: Vec<Estimate>,
    /// What the fit used of tolerances.
    pub tolerated: Vec<Tolerated>,
    /// The amounts of effects that may have changed, where the drive was fitted before.
    pub changeable: Vec<Parameter>,
    /// Amounts of effects that these recordings tell, with their standard deviations: what they do not tell is not among them.
    pub strengths: Vec<Estimate>,
    /// Values far from their nominal ones.
    pub far_values: Vec<FarValue>,
    /// Pairs of fitted values of which only a combination is well determined.
    pub correlations: Vec<Correlation>,
    /// What is left of each judged signal's error.
    pub left: Vec<Miss>,
    /// Whether the search came to rest.
    pub converged: bool,
    /// The value that moved most, where it did not.
    pub unsettled: Option<Unsettled>,
    /// Every recording, training first, then held out: simulated with the machine file's values before and after.
    pub shown: Vec<Shown>,
}

impl Refit {
    /// Whether what is of the oil and of the day is all that is different since the drive was fitted before. It follows as well as its sensors read, no value
    /// has come to an end of what is known of it, and of every effect that may have changed the recordings tell that there is as much as before.
    #[must_use]
    pub fn is_of_the_day(&self) -> bool {
        let is_used_up = |one: &Tolerated| one.at_limit || one.left_then.is_some();
        let has_kept = |parameter: &Parameter| {
            let told = self.strengths.iter().find(|one| one.parameter == *parameter);
            let then = self.base_parameters.iter().find(|free| free.parameter == *parameter).map(Free::nominal);
            // An amount that jumps is not refitted: only a search tells it.
            told.zip(then).is_some_and(|(told, then)| is_as_before(told, then))
        };
        let follows = self.converged && !self.left.iter().any(Miss::is_above_noise);
        let is_known = self.far_values.is_empty() && !self.tolerated.iter().any(is_used_up);
        follows && is_known && self.changeable.iter().all(has_kept)
    }
}

impl Refitting {
    /// Prepares the recordings and searches coarsely, from the machine file's values.
    pub fn of(file: &MachineFile, recordings: &[Recording], tick: Option<Tick>) -> Result<Self, DiagnoseError> {
        Self::with(file, recordings, tick, |sheet, _| (sheet, Vec::new()))
    }

    /// The same of a drive that was fitted before: what is of the oil and of the day may move, the rest as far as it is known since then, and the effects
    /// that the file holds may have become more or less, as [`crate::diagnose_since`] has it.
    pub fn since(file: &MachineFile, recordings: &[Recording], tick: Option<Tick>) -> Result<Self, DiagnoseError> {
        Self::with(file, recordings, tick, |sheet, prepared| {
            let on = held(file, &sheet);
            let moves = Moves::of(file, &sheet, Some(&on), prepared);
            (moves.asking_amounts(), moves.changeable.iter().map(|amount| amount.parameter).collect())
        })
    }

    fn with(
        file: &MachineFile,
        recordings: &[Recording],
        tick: Option<Tick>,
        moves: impl FnOnce(Vec<Free>, &[Prepared]) -> (Vec<Free>, Vec<Parameter>),
    ) -> Result<Self, DiagnoseError> {
        let mut prepared: Vec<Prepared> = Vec::new();
        for recording in recordings {
            prepared.push(Prepared::new(recording, &file.machine, file.load_source, tick)?);
        }
        share_range_ends(&mut prepared.iter_mut().collect::<Vec<_>>());
        let (free, changeable) = moves(base_parameters(file), &prepared);
        let near = near(&file.machine, &free, &mut prepared)?;
        Ok(Self { file: file.clone(), prepared, held_out: Vec::new(), free, changeable, near })
    }

    /// With recordings that take no part in the fit and show what it is worth. They learn from the others where a sensor's range ends, not the reverse.
    pub fn with_held_out(mut self, recordings: &[Recording], tick: Option<Tick>) -> Result<Self, DiagnoseError> {
        for recording in recordings {
            self.held_out.push(Prepared::new(recording, &self.file.machine, self.file.load_source, tick)?);
        }
        let mut trained = self.prepared.clone();
        share_range_ends(&mut trained.iter_mut().chain(&mut self.held_out).collect::<Vec<_>>());
        Ok(self)
    }

    /// The number of rows of all recordings.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.prepared.iter().map(Prepared::rows).sum()
    }

    /// The number of parameters that may move.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.free.len()
    }

    /// Largest number of rows that the search goes through, each as often as it is evaluated.
    #[must_use]
    pub fn most_rows(&self) -> usize {
        self.rows() * most_evaluations(self.free.len(), self.prepared.len())
    }

    /// Searches; `told` is given the rows of a recording after each of its evaluations.
    pub fn search(self, told: &(dyn Fn(usize) + Sync)) -> Result<Refit, DiagnoseError> {
        let Self { mut file, prepared, held_out, free, changeable, near } = self;
        let nominal = file.machine;
        let cases: Vec<&Prepared> = prepared.iter().collect();
        let from = From { solution: Some(&near), ..From::default() };
        let fitted = fit_with_progress(&file.machine, &free, &cases, &from, PRECISION, &|case| told(case.rows()))?;
        file.machine = fitted.machine;
        // The band was that of other values.
        file.band = None;
        file.start_at(level_at_rest(&fitted.machine, &cases, &fitted.starts));
        file.given.extend(fitted.free.iter().map(|free| free.parameter));
        let with_starts = || cases.iter().copied().zip(fitted.starts.iter().copied());
        let residuals = softened_all(&fitted.machine, with_starts())?;
        let counts = cases.first().map_or(effective_samples as Counts, |case| counts_from(case.stimulus.input_point));
        let inflation = inflation(&residuals, counts);
        let estimates = fitted.estimates(inflation);
        let mut within = tolerated(&free, &estimates);
        within.retain(|one| has_sensor(cases.iter().copied(), one.parameter));
        let left = misses(&fitted.machine, with_starts())?;
        let far_values = far_values(&file.machine, &free, &estimates);
        let trained = prepared.into_iter().zip(fitted.starts.iter().copied()).collect();
        Ok(Refit {
            estimates: not_tolerated(&free, &estimates),
            tolerated: within,
            changeable,
            strengths: strengths(&free, &estimates),
            far_values,
            correlations: fitted.correlations(inflation),
            left,
            converged: fitted.converged,
            unsettled: fitted.unsettled(inflation),
            base_parameters: free,
            shown: show_refit(trained, held_out, &nominal, &fitted.machine)?,
            file,
        })
    }
}

/// A first solution, with the tolerance of every channel at its misfit: residuals far beyond it count linearly in all later fits.
fn near(machine: &Machine<f64>, free: &[Free], prepared: &mut [Prepared]) -> Result<Fit, FitError> {
    /// The first search ends when the loss falls by less than this share in a step.
    const SETTLED: f64 = 1e-3;
    with_channel_tolerances(machine, prepared, |cases| {
        let is_sparse = cases.iter().any(|case| case.is_sparse());
        if is_sparse { staged(machine, free, cases, SETTLED) } else { first_search(machine, free, cases, SETTLED) }
    })
}
