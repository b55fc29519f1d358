//! How a diagnosis ends that names nothing: the base model follows, or something is missing that no effect accounts for.

use identification::experiment::Prepared;
use identification::fit::{Fit, FitError, set_tolerances, settled};
use model_core::machine::{Machine, MachineError};

use crate::asked::Asked;
use crate::localisation::{Miss, misses};
use crate::outcome::Verdict;
use crate::selection::Candidate;
use crate::selection::decision_rule::HELD_OUT_MAY_MISS;

/// How it ended, and whether the training recordings told too little.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Ending {
    pub(crate) verdict: Verdict,
    /// Whether the held-out recordings were needed to determine the base parameters.
    pub(crate) training_is_too_narrow: bool,
}

impl Ending {
    /// The ending with effects that are named.
    pub(crate) const FOUND: Self = Self { verdict: Verdict::MissingPhysics, training_is_too_narrow: false };

    /// The ending of a search that its limit has ended: what it found is no answer.
    pub(crate) const UNFINISHED: Self = Self { verdict: Verdict::Unexplained, training_is_too_narrow: false };

    /// The ending with the base model alone: whether it misses more than noise, or follows only with a value that no such drive has.
    ///
    /// Where it follows the training recordings but not the held-out ones, it is refitted to all of them. If it then follows all, nothing is missing: the
    /// held-out recordings work where the training ones do not, and a value was left open that they need.
    pub(crate) fn of_base(
        asked: Asked<'_>,
        base: &Candidate,
        is_impossible: bool,
        (training, held_out): (&[&Prepared], &[&Prepared]),
    ) -> Result<Self, FitError> {
        let ends = |verdict, training_is_too_narrow| Ok(Self { verdict, training_is_too_narrow });
        let question = asked.of(training);
        let least = question.unexplained_from();
        if is_impossible || base.worst_over_noise(&question) > least {
            return ends(Verdict::Unexplained, false);
        }
        if most(&missed_in(&base.fit.machine, held_out)?) <= HELD_OUT_MAY_MISS * least {
            return ends(Verdict::NothingMissing, false);
        }
        let all: Vec<Prepared> = training.iter().chain(held_out).copied().cloned().collect();
        let follows = follows_all(asked, base, all, least)?;
        ends(if follows { Verdict::NothingMissing } else { Verdict::Unexplained }, follows)
    }
}

/// Whether the base model, refitted to all these recordings, is nowhere off by more than so many times the noise.
fn follows_all(asked: Asked<'_>, base: &Candidate, mut all: Vec<Prepared>, least: f64) -> Result<bool, FitError> {
    let starts = settled(&base.fit.machine, &all.iter().collect::<Vec<_>>())?;
    set_tolerances(&base.fit.machine, &mut all, &starts)?;
    let near = Fit { starts, ..base.fit.clone() };
    let all: Vec<&Prepared> = all.iter().collect();
    let refitted = Candidate::base(&asked.of(&all), &near, &near)?;
    Ok(most(&missed_in(&refitted.fit.machine, &all)?) <= least)
}

fn most(misses: &[Miss]) -> f64 {
    misses.iter().map(|miss| miss.over_noise).fold(0.0, f64::max)
}

/// How far each signal of these recordings is off, each from the start that fits it best.
pub(crate) fn missed_in(machine: &Machine<f64>, cases: &[&Prepared]) -> Result<Vec<Miss>, MachineError> {
    misses(machine, cases.iter().copied().zip(settled(machine, cases)?))
}
