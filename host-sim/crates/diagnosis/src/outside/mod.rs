//! Causes outside the drive: a force on the rod that no part of the drive makes, found beside the effects of the catalogue.
//!
//! A push that happened once, a periodic force, a structure that rings on the rod or another load in each recording leave misfits that some effect of
//! the catalogue always lowers a little. So each of them is tried as well; where one of them is likelier than everything that the catalogue has, the
//! search is repeated with that force as an input.

mod proposals;
mod shape;

use std::collections::HashSet;

use identification::experiment::Prepared;
use identification::fit::{Change, Fit, FitError, Sensitivity, StartState, coarse, misfits, set_tolerances, settled};
use identification::parallel;
use model_core::machine::{Machine, Parameter};
use proposals::{Proposal, Sought, proposals};
use shape::{Shape, Unit};

use crate::selection::candidate::{NEARLY, SETTLED};
use crate::selection::decision_rule::{LEAST_EXPLAINED, LIKELIER_BY, OUTSIDE_PROMISES, OUTSIDE_SPOILS};
use crate::selection::likelihood::{misfit_above_noise, straightened};
use crate::selection::{Candidate, Gained, Question, Selection};

/// Rounds of a refit: amounts of force, then base parameters.
const ROUNDS: usize = 10;
/// A refit ends where a round lowers the loss by less than this share.
const ENDS_BELOW: f64 = 1e-3;
/// A round moves a frequency or a damping by at most this share.
const MOST_MOVED: f64 = 0.3;
/// Share by which these are moved to see what that changes.
const TRIED: f64 = 1e-3;
/// Steps by which the amounts in a held-out recording are found: its forces act on a machine that is known.
const STEPS_HELD_OUT: usize = 4;
/// Standard deviations of a sum of squares of noise.
const OF_NOISE: f64 = 3.0;
/// Amount of force whose effect is simulated, as a share of the full force of the drive.
const UNIT_SHARE: f64 = 0.01;

/// A cause outside the drive that explains a mismatch.
#[derive(Clone, Debug, PartialEq)]
pub struct Outside {
    /// What it is.
    pub cause: Cause,
    /// Share of the misfit above the noise that it explains in training, with the base parameters refitted.
    pub explains: f64,
    /// The same in held-out recordings; `None` where there is none, or where the cause acted in training recordings alone.
    pub explains_held_out: Option<f64>,
}

/// What acts from outside.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// Another load in each recording, besides the machine file's: recording and force, N; positive extends.
    Load(Vec<(String, f64)>),
    /// A push that happened once, or a few times.
    Push(Vec<Push>),
    /// A periodic force.
    Periodic {
        /// Frequency, Hz.
        hz: f64,
        /// Amplitude in each recording, N.
        amplitude_n: Vec<(String, f64)>,
    },
    /// A mass that hangs on the rod by a spring.
    Structure {
        /// Its frequency while the rod stands, Hz.
        hz: f64,
        /// Its damping as a share of critical damping.
        damping: f64,
        /// Its mass, kg.
        mass_kg: f64,
    },
}

/// A force that acts for a while.
#[derive(Clone, Debug, PartialEq)]
pub struct Push {
    /// In which recording.
    pub recording: String,
    /// From when, s of the recording's time.
    pub from_s: f64,
    /// Until when.
    pub to_s: f64,
    /// Its mean, N; positive extends. Its course in detail is not known as well.
    pub mean_n: f64,
    /// Its integral over time, N s.
    pub impulse_n_s: f64,
}

/// A force from outside with its amounts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Force {
    shape: Shape,
    amounts: Vec<f64>,
}

/// A force from outside that explains more than any effect does.
pub(crate) struct Found {
    pub(crate) force: Force,
    /// The machine file's model, refitted with it.
    pub(crate) near: Fit,
    /// Share of the misfit above the noise that it explains.
    pub(crate) explains: f64,
}

/// The force from outside that explains most of what the base misses; `None` where none explains most of it, or where an effect is as likely.
pub(crate) fn find(question: &Question<'_>, selection: &Selection) -> Result<Option<Found>, FitError> {
    let base = &selection.base;
    let likeliest = selection.rounds.iter().flatten().map(|trial| trial.net).fold(0.0, f64::max);
    let mut proposed: Vec<(f64, Force, Fit)> = Vec::new();
    // The motion that was recorded drives a structure: nothing that is named in free run is given up for it.
    let with_structures = selection.chosen.effects.is_empty();
    for Solution { fit, once } in solutions(question, selection)? {
        let coarser = coarse(question.training, &fit.machine, &fit.starts)?;
        let cases: Vec<&Prepared> = coarser.iter().collect();
        let Some(sensitivity) = Sensitivity::at(&fit, &cases)? else { continue };
        let (misfit, left) = (sensitivity.misfit_above_noise(), sensitivity.settled_loss());
        let sought = match (once, with_structures) {
            (true, _) => Sought::Pushes,
            (false, false) => Sought::InTime,
            (false, true) => Sought::All,
        };
        for Proposal { force, gain } in proposals(question.scene.machine, &sensitivity, &cases, sought)? {
            if gain > OUTSIDE_PROMISES * misfit {
                proposed.push((left - gain, force, fit.clone()));
            }
        }
    }
    proposed.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The best of each kind.
    let mut kinds = HashSet::new();
    proposed.retain(|(_, force, _)| kinds.insert(force.shape.kind()));
    let mut best: Option<(f64, Found)> = None;
    for (_, force, near) in proposed {
        let (force, with) = force.refitted(question, &near)?;
        let gained = Gained::of(&base.residuals, &with.residuals, base.counts);
        let explains = 1.0 - misfit_above_noise(&with.residuals) / misfit_above_noise(&base.residuals);
        let net = gained.all + straightened(question, base, &with) - gained.cost(force.values());
        let is_told = explains > LEAST_EXPLAINED
            && force.shape.is_within()
            && (gained.repeats || matches!(force.shape, Shape::Pushes(_)));
        if is_told && net > likeliest + LIKELIER_BY && best.as_ref().is_none_or(|(known, _)| net > *known) {
            best = Some((net, Found { force, near: with.fit, explains }));
        }
    }
    Ok(best.map(|(_, found)| found))
}

/// A solution at which forces are sought.
struct Solution {
    fit: Fit,
    /// Whether what is sought happened once: in the recording that it was fitted without.
    once: bool,
}

/// Where forces are sought: the base, the base with inflated noise, and the base without one of the recordings. A force that the model
/// lacks bends the base parameters; with inflated noise they stay where they can be, and what acts in one recording does not bend those of the others.
fn solutions(question: &Question<'_>, selection: &Selection) -> Result<Vec<Solution>, FitError> {
    let of_all = [&selection.base.fit, &selection.inflated];
    let mut all: Vec<Solution> = of_all.map(|fit| Solution { fit: fit.clone(), once: false }).into();
    if question.training.len() < 2 {
        return Ok(all);
    }
    let without = |index: usize| -> Result<Solution, FitError> {
        let mut training = question.training.to_vec();
        training.remove(index);
        let others = Question { training: &training, ..*question };
        // Of sparse rows a search from the nominal values ends in another valley: it starts from the base.
        let mut near = selection.base.fit.clone();
        near.starts.remove(index);
        let near = question.scene.is_sparse.then_some(&near);
        let mut fit = Candidate::rough(&others, near)?.fit;
        fit.starts.insert(index, StartState::default());
        Ok(Solution { fit, once: true })
    };
    all.extend(parallel::try_each(0..question.training.len(), without)?);
    Ok(all)
}

/// The force of a unit amount of a shape on this machine, N; of a structure, its mass, kg.
fn unit(machine: &Machine<f64>, shape: &Shape) -> f64 {
    match shape {
        Shape::Structure { .. } => 0.05 * machine.get(Parameter::MovingMass),
        _ => UNIT_SHARE * machine.full_force_n(),
    }
}

/// What each amount of a shape changes, per unit.
fn directions(
    sensitivity: &Sensitivity<'_>,
    units: Vec<Unit>,
    unit: f64,
    amounts: usize,
    cases: usize,
) -> Result<Vec<Change>, FitError> {
    let of: Vec<usize> = units.iter().map(|unit| unit.amount).collect();
    let forces: Vec<(usize, Vec<f64>)> = units
        .into_iter()
        .map(|Unit { case, force_n, .. }| (case, force_n.into_iter().map(|force_n| unit * force_n).collect()))
        .collect();
    let mut all: Vec<Change> = vec![vec![Vec::new(); cases]; amounts];
    for ((amount, (case, _)), change) in of.into_iter().zip(&forces).zip(sensitivity.changes_by_force(&forces)?) {
        all[amount][*case] = change;
    }
    Ok(all)
}

impl Force {
    /// Number of values that were fitted or chosen.
    fn values(&self) -> usize {
        let windows = if let Shape::Pushes(windows) = &self.shape { 2 * windows.len() } else { 0 };
        self.amounts.len() + self.shape.shaping() + windows
    }

    /// The force in each recording, N at the points of its grid; empty where there is none.
    fn in_each(&self, cases: &[&Prepared]) -> Vec<Vec<f64>> {
        let mut all = vec![Vec::new(); cases.len()];
        for Unit { amount, case, force_n } in self.shape.units(cases) {
            let sum: &mut Vec<f64> = &mut all[case];
            sum.resize(force_n.len(), 0.0);
            for (sum, force_n) in sum.iter_mut().zip(force_n) {
                *sum += self.amounts[amount] * force_n;
            }
        }
        all
    }

    /// Whether it comes from what was recorded: then a model that has it as an input does not run freely.
    pub(crate) fn follows_recorded_motion(&self) -> bool {
        matches!(self.shape, Shape::Structure { .. })
    }

    /// Recordings with the force as an input.
    pub(crate) fn on(&self, cases: &[&Prepared]) -> Vec<Prepared> {
        let forced = |(case, force_n): (&&Prepared, Vec<f64>)| Prepared {
            stimulus: case.stimulus.with_force(&force_n),
            ..(*case).clone()
        };
        cases.iter().zip(self.in_each(cases)).map(forced).collect()
    }

    /// Its amounts and the base parameters, refitted in turn.
    fn refitted(mut self, question: &Question<'_>, from: &Fit) -> Result<(Self, Candidate), FitError> {
        let with = |force: &Self, near: &Fit, precision| {
            let forced = force.on(question.training);
            let training: Vec<&Prepared> = forced.iter().collect();
            Candidate::base_parameters(&Question { training: &training, ..*question }, Some(near), precision)
        };
        let mut near = with(&self, from, SETTLED)?;
        for _ in 0..ROUNDS {
            let next = self.stepped(question, &near.fit)?;
            let there = with(&next, &near.fit, SETTLED)?;
            let gained = near.fit.loss - there.fit.loss;
            if gained > 0.0 {
                self = next;
            }
            if gained <= ENDS_BELOW * near.fit.loss {
                break;
            }
            near = there;
        }
        let near = with(&self, &near.fit, NEARLY)?;
        Ok((self, near))
    }

    /// One step of Gauss and Newton, the base parameters refitted linearly.
    fn stepped(&self, question: &Question<'_>, fit: &Fit) -> Result<Self, FitError> {
        let forced = self.on(question.training);
        let coarser = coarse(&forced.iter().collect::<Vec<_>>(), &fit.machine, &fit.starts)?;
        self.stepped_on(fit, &coarser, question.scene.machine, self.shape.shaping())
    }

    /// The same on recordings that have this force as an input, with this many of the shaping values.
    fn stepped_on(
        &self,
        fit: &Fit,
        forced: &[Prepared],
        machine: &Machine<f64>,
        shaping: usize,
    ) -> Result<Self, FitError> {
        let cases: Vec<&Prepared> = forced.iter().collect();
        let Some(sensitivity) = Sensitivity::at(fit, &cases)? else { return Ok(self.clone()) };
        let unit = unit(machine, &self.shape);
        let units = self.shape.units(&cases);
        let mut all = directions(&sensitivity, units, unit, self.amounts.len(), cases.len())?;
        let here = self.in_each(&cases);
        for index in 0..shaping {
            let moved = Self { shape: self.shape.moved(index, TRIED), amounts: self.amounts.clone() };
            let more = |(here, there): (&Vec<f64>, Vec<f64>)| {
                here.iter().zip(there).map(|(here, there)| there - here).collect()
            };
            let forces: Vec<(usize, Vec<f64>)> = here.iter().zip(moved.in_each(&cases)).map(more).enumerate().collect();
            all.push(sensitivity.changes_by_force(&forces)?);
        }
        let (steps, _) = sensitivity.directed(&all).amounts(&vec![false; all.len()]);
        let (of_amounts, of_shape) = steps.split_at(self.amounts.len());
        let mut next = self.clone();
        let (least, most) = (if self.shape.is_positive() { 0.0 } else { f64::NEG_INFINITY }, self.shape.most(machine));
        for (amount, step) in next.amounts.iter_mut().zip(of_amounts) {
            *amount = (*amount + unit * step).clamp(least, most);
        }
        for (index, step) in of_shape.iter().enumerate() {
            next.shape = next.shape.moved(index, (TRIED * step).clamp(-MOST_MOVED, MOST_MOVED));
        }
        Ok(next)
    }

    /// The same cause in recordings that were held out: what differs from recording to recording is taken from each of them. `None` where the cause
    /// acted in training recordings alone.
    pub(crate) fn in_others(&self, machine: &Machine<f64>, cases: &[&Prepared]) -> Result<Option<Self>, FitError> {
        match self.shape {
            Shape::Pushes(_) => Ok(None),
            Shape::Structure { .. } => Ok(Some(self.clone())),
            Shape::Load | Shape::Periodic { .. } => {
                let mut force = Self { shape: self.shape.clone(), amounts: vec![0.0; self.shape.amounts(cases.len())] };
                for _ in 0..STEPS_HELD_OUT {
                    let mut forced = force.on(cases);
                    let starts = settled(machine, &forced.iter().collect::<Vec<_>>())?;
                    // What is far off beforehand must not count less.
                    set_tolerances(machine, &mut forced, &starts)?;
                    force = force.stepped_on(&Fit::of(*machine, starts), &forced, machine, 0)?;
                }
                Ok(Some(force))
            }
        }
    }

    /// What it is, said of these recordings.
    pub(crate) fn cause(&self, cases: &[&Prepared]) -> Cause {
        let named = |case: usize| cases[case].name.clone();
        match &self.shape {
            Shape::Load => {
                Cause::Load(self.amounts.iter().enumerate().map(|(case, force_n)| (named(case), *force_n)).collect())
            }
            Shape::Pushes(windows) => {
                let forces = self.in_each(cases);
                let push = |window: &shape::Window| {
                    let (case, force_n) = (cases[window.case], &forces[window.case]);
                    let begins_s = case.time_s.first().copied().unwrap_or(0.0);
                    let (from_s, to_s) = window.time_s(case);
                    let impulse_n_s = force_n.iter().sum::<f64>() * case.stimulus.tick.seconds();
                    Push {
                        recording: named(window.case),
                        from_s: begins_s + from_s,
                        to_s: begins_s + to_s,
                        mean_n: impulse_n_s / (to_s - from_s),
                        impulse_n_s,
                    }
                };
                Cause::Push(windows.iter().map(push).collect())
            }
            &Shape::Periodic { hz } => {
                let amplitude = |(case, parts): (usize, &[f64])| (named(case), libm::hypot(parts[0], parts[1]));
                Cause::Periodic { hz, amplitude_n: self.amounts.chunks_exact(2).enumerate().map(amplitude).collect() }
            }
            &Shape::Structure { hz, damping, .. } => Cause::Structure { hz, damping, mass_kg: self.amounts[0] },
        }
    }
}

/// What a machine with a force as an input changes on held-out recordings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldOut {
    /// Misfit above the noise without and with it, in squares over the noise.
    without: f64,
    with: f64,
    /// Rows that were judged, of all signals.
    rows: f64,
}

impl HeldOut {
    /// The recordings as they are with one machine, and with the force as an input with the other.
    pub(crate) fn of(
        without: (&Machine<f64>, &[&Prepared]),
        with: (&Machine<f64>, &[&Prepared]),
    ) -> Result<Self, FitError> {
        let mut rows = 0.0;
        let mut above = |(machine, cases): (&Machine<f64>, &[&Prepared])| -> Result<f64, FitError> {
            let misfits = misfits(machine, cases.iter().copied().zip(settled(machine, cases)?))?;
            rows = misfits.iter().map(|misfit| misfit.rows).sum();
            Ok(misfits.iter().map(|misfit| (misfit.square - misfit.rows).max(0.0)).sum())
        };
        let (without, with) = (above(without)?, above(with)?);
        Ok(Self { without, with, rows })
    }

    /// Share of the misfit above the noise that the force explains.
    pub(crate) fn explains(&self) -> f64 {
        1.0 - self.with / self.without.max(1.0)
    }

    /// Whether the model follows them worse than before, by more than noise does.
    pub(crate) fn is_worse(&self) -> bool {
        self.with - self.without > OUTSIDE_SPOILS * self.without + OF_NOISE * (2.0 * self.rows).sqrt()
    }
}
