//! Valve first: where the spool is recorded, its motion and the flow that it meters are two separate questions. The first is answered by the command;
//! for the second the recorded spool meters the oil, so that no error of the valve's model reaches what is below it.
//!
//! Each side is searched by itself, with the parameters and the effects of its own links. What both find is then tried together, and the whole model
//! has to accept it.

use identification::parallel;

use identification::effort::Effort;
use identification::experiment::Prepared;
use identification::fit::FitError;
use identification::input_noise::by_noise_of_input;
use model_core::machine::{Machine, MachineError, Parameter};
use recording::Signal;

use super::side::Side;
use crate::catalogue::Hypothesis;
use crate::selection::candidate::{Candidate, Chosen, Question};
use crate::selection::confirmation::confirm;
use crate::selection::decision_rule::{EXPLAINED_SIDE_REST_FROM, MOST_EFFECTS, SIDE_EXPLAINED_TO, TOGETHER_WITHIN};
use crate::selection::forward::Course;
use crate::selection::likelihood::accepts;
use crate::selection::misfit_ranking::ranked_by_misfit;
use crate::selection::outcome::Trial;
use crate::selection::round::{enter, explains_enough, finished, reduced, trial};
use crate::selection::search::open_to;
use crate::selection::searched::Stage;

impl Side {
    /// The effects that the signals of this side choose.
    fn searched(
        self,
        question: &Question<'_>,
        followed: &[Prepared],
        effort: &Effort,
        done: &(impl Fn(&str) + Sync),
    ) -> Result<Course, FitError> {
        let base_parameters = self.base_parameters(question);
        let effects = question.hypotheses.iter().copied();
        let hypotheses: Vec<_> = effects.filter(|effect| Self::of_effect(effect) == self).collect();
        let mut training = self.judging(followed);
        for case in &mut training {
            case.effort = effort.clone();
        }
        let near = Candidate::tolerated(question.scene, &base_parameters, &mut training)?;
        let training: Vec<&Prepared> = training.iter().collect();
        let own = Question {
            scene: question.scene,
            base_parameters: &base_parameters,
            hypotheses: &hypotheses,
            training: &training,
        };
        let mut course = Course::of(&own, &near)?;
        if !course.is_enough(&own, self.near()) {
            course.forward(&own, self.near(), done)?;
        }
        let base = &course.base;
        let may_be = |rival: &Candidate| -> Result<bool, FitError> {
            Ok(rival.is_plausible(&own) && accepts(&own, base, base, rival)?)
        };
        let accepted = |rival: Candidate| may_be(&rival).map(|may_be| may_be.then_some(rival));
        let rivals: Vec<_> = parallel::try_each(course.rivals, accepted)?;
        course.rivals = rivals.into_iter().flatten().collect();
        // A spool with mass that sticks is found from the nominal valve alone.
        if self == Self::Valve
            && course.chosen.worst_over_noise(&own) > self.near()
            && let Some(slides) = super::sliding::slides(&own, &course.base)?
            && may_be(&slides)?
            && slides.fit.loss < course.chosen.fit.loss
        {
            course.rounds.truncate(1);
            enter(&own, base, &mut course.rounds, &slides);
            course.rivals.clear();
            course.chosen = slides;
        }
        if explains_enough(&own, base, &course.chosen, SIDE_EXPLAINED_TO) {
            course.explained.push(self);
        }
        // A spool that jumps is judged by its jumps.
        if self == Self::Valve
            && let Some((chosen, round)) = super::stiction::stuck(&own, done)?
        {
            course.rounds.resize(chosen.effects.len(), Vec::new());
            if let [_, last] = course.rounds.as_mut_slice() {
                *last = round;
            }
            course.rivals.clear();
            course.explained = vec![self];
            course.chosen = chosen;
        }
        Ok(course)
    }
}

/// The recordings, driven by their recorded spools; `None` unless each recording can be driven so and has signals of both sides.
fn followed(cases: &[&Prepared], machine: &Machine<f64>) -> Result<Option<Vec<Prepared>>, MachineError> {
    let following = |case: &&Prepared| case.following().filter(|case| case.channels.len() > 1);
    let followed: Option<Vec<Prepared>> = cases.iter().map(following).collect();
    let with_noise = |case| with_noise_of_spool(case, machine);
    followed.map(|cases| parallel::try_each(cases, with_noise)).transpose()
}

/// A recording driven by its spool; to the noise of every other channel is added what the spool's noise causes there.
fn with_noise_of_spool(mut case: Prepared, machine: &Machine<f64>) -> Result<Prepared, MachineError> {
    /// Random draws over which the added noise is averaged.
    const DRAWS: usize = 4;
    let of_spool = case.channels.iter().find(|channel| channel.signal == Signal::Spool);
    let of_spool = of_spool.map_or(0.0, |spool| spool.noise);
    let added = by_noise_of_input(&case, machine, of_spool, DRAWS)?;
    for (channel, added) in case.channels.iter_mut().zip(added) {
        channel.add_input_noise(added);
    }
    Ok(case)
}

/// Whether held-out recordings gain by an effect of a candidate model on the effect's own side of the spool. That side is refitted to the training
/// recordings by itself, with the effect and without. This shows that the effect is there, whatever value its effect parameter has in the whole
/// model.
pub(crate) fn gains_on_own_side(
    question: &Question<'_>,
    candidate: &Candidate,
    effect: &Hypothesis,
    held_out: &[&Prepared],
) -> Result<bool, FitError> {
    let (side, machine) = (Side::of_effect(effect), &candidate.fit.machine);
    let (Some(training), Some(held_out)) = (followed(question.training, machine)?, followed(held_out, machine)?) else {
        return Ok(false);
    };
    let (mut training, held_out) = (side.judging(&training), side.judging(&held_out));
    let base_parameters = side.base_parameters(question);
    Candidate::tolerated(question.scene, &base_parameters, &mut training)?;
    let (training, held_out): (Vec<_>, Vec<_>) = (training.iter().collect(), held_out.iter().collect());
    let own =
        Question { scene: question.scene, base_parameters: &base_parameters, hypotheses: &[], training: &training };
    if side == Side::Valve
        && let Some(told) = super::stiction::confirms(&own, candidate, effect, &held_out)?
    {
        return Ok(told);
    }
    let of_side = |one: &Hypothesis| Side::of_effect(one) == side;
    let (with, without) = rayon::join(
        || candidate.only(&own, of_side),
        || candidate.only(&own, |one| of_side(one) && one.name != effect.name),
    );
    let (with, without) = (with?, without?);
    if !with.is_plausible(&own) {
        return Ok(false);
    }
    Ok(confirm(&without, &with, own.training, &held_out)?.gains_as_promised())
}

impl Course {
    /// Looks for effects on each side of the recorded spool, and takes over the found effects that the whole model accepts.
    pub(crate) fn join(&mut self, question: &Question<'_>, done: &(impl Fn(&str) + Sync)) -> Result<(), FitError> {
        let Some(followed) = followed(question.training, question.scene.machine)? else { return Ok(()) };
        let all = question.effort();
        let (began_s, of_valve, of_below) = (all.spent_s(), all.apart(), all.apart());
        let searched = |side: Side, effort: &Effort| side.searched(question, &followed, effort, done);
        let (valve, below) = rayon::join(|| searched(Side::Valve, &of_valve), || searched(Side::Below, &of_below));
        let (valve, below) = (valve?, below?);
        for one in [of_valve, of_below] {
            all.join(&one, began_s);
        }
        if !(valve.searched.is_finished() && below.searched.is_finished()) {
            self.searched.leave(Stage::Sides);
        }
        let start = below.base.fit.beside(&valve.base.fit);
        if let Some(better) = Candidate::below(question, &start, self.base.fit.loss)? {
            self.rebase(better);
        }
        if valve.chosen.effects.is_empty() && below.chosen.effects.is_empty() {
            return Ok(());
        }
        let ranked = joined(question, &self.base, &valve, &below)?;
        // A candidate model that cannot be accepted may still be the true one, and nothing less likely is taken in its place.
        let least = ranked.first().map_or(f64::INFINITY, |(_, net)| net - TOGETHER_WITHIN);
        for (found, net) in ranked.iter().take_while(|(_, net)| *net > least) {
            if self.is_accepted(question, found)? {
                self.chosen = found.clone();
                self.beam = vec![found.clone()];
                if found.effects.len() > 1 {
                    self.joined = found.effects.iter().map(|chosen| chosen.effect.plainest()).collect();
                }
                // A side counts as explained only by the effects that it chose itself, not by those that the whole model put in their place.
                let both = [valve.chosen.effects.as_slice(), &below.chosen.effects].concat();
                if both.len() == found.effects.len() && both.iter().all(|own| found.has(own.effect)) {
                    self.explained = [valve.explained.as_slice(), &below.explained].concat();
                }
                self.rounds = together(question.scene.machine, &valve, &below);
                complete_last_round(&mut self.rounds, &ranked, (found, *net));
                break;
            }
        }
        Ok(())
    }

    /// Effects that may still be added. Where the whole model is far off, a side that is already explained is not searched again: the misfit of the
    /// whole model then comes from the other side, or from the form errors of both.
    pub(crate) fn open(&self, question: &Question<'_>) -> Vec<&'static Hypothesis> {
        let is_far = !self.explained.is_empty() && self.chosen.worst_over_noise(question) > EXPLAINED_SIDE_REST_FROM;
        let is_open = |effect: &&'static Hypothesis| !(is_far && self.explained.contains(&Side::of_effect(effect)));
        question.hypotheses.iter().copied().filter(is_open).collect()
    }
}

/// What both sides chose, and what was nearly as likely on one of them, refitted in the whole model and ranked there, with inflated noise where
/// needed.
fn joined(
    question: &Question<'_>,
    base: &Candidate,
    valve: &Course,
    below: &Course,
) -> Result<Vec<(Candidate, f64)>, FitError> {
    let pairs: Vec<(&Candidate, &Candidate)> = std::iter::once((&valve.chosen, &below.chosen))
        .chain(below.rivals.iter().map(|rival| (&valve.chosen, rival)))
        .chain(valve.rivals.iter().map(|rival| (rival, &below.chosen)))
        .collect();
    let few = pairs.into_iter().filter(|(valve, below)| valve.effects.len() + below.effects.len() <= MOST_EFFECTS);
    let together = |(valve, below): (&Candidate, &Candidate)| below.beside(question, valve);
    let mut candidates: Vec<Candidate> = parallel::try_each(few, together)?;
    let exchanged = candidates.first().map(|found| misread(question, found)).transpose()?.flatten();
    if let Some(other) = exchanged.clone() {
        // Of the effects, only those that the valve's side chose may become superfluous by the exchange: the others stay.
        let stay = other.effects.iter().filter(|chosen| !valve.chosen.has(chosen.effect));
        let stay: Vec<&str> = stay.map(|chosen| chosen.effect.plainest()).collect();
        candidates.extend(reduced(question, base, other, &stay)?);
    }
    // With the spool as the model has it, a rod that sticks and slips gets out of step once more.
    let led = candidates.first().map(|found| found.sticking(question)).transpose()?.flatten();
    candidates.extend(led);
    ranked_by_misfit(question, base, finished(question, base, candidates)?, exchanged)
}

/// Puts into the last round the net gains of the candidate models that were refitted in the whole model; the others keep the distance behind the
/// chosen one that they had when each side was searched by itself.
fn complete_last_round(rounds: &mut Vec<Vec<Trial>>, ranked: &[(Candidate, f64)], (chosen, net): (&Candidate, f64)) {
    rounds.truncate(chosen.effects.len());
    let Some(round) = rounds.last_mut() else { return };
    let ranked: Vec<_> =
        ranked.iter().filter(|(candidate, _)| candidate.effects.len() == chosen.effects.len()).collect();
    match round.iter().find(|trial| trial.is_of(chosen)).map(|trial| net - trial.net) {
        Some(shift) => {
            for candidate in round.iter_mut() {
                candidate.net += shift;
            }
        }
        // If neither side had tried the chosen one, the round has no distances to it.
        None => round.clear(),
    }
    round.retain(|trial| !ranked.iter().any(|(candidate, _)| trial.is_of(candidate)));
    round.extend(ranked.iter().map(|(candidate, net)| trial(candidate, *net)));
    round.sort_by(|a, b| b.net.total_cmp(&a.net));
}

/// The candidate model with a spool that reads o too much in the place of edges that lie 2·o further apart on one side, or the other way round: below
/// the spool both have the same effect, and only the valve's own offset distinguishes them. `None` where it has neither.
fn misread(question: &Question<'_>, candidate: &Candidate) -> Result<Option<Candidate>, FitError> {
    let value = |parameter| candidate.fit.machine.get(parameter);
    let (read, edges) = (Parameter::SpoolOffset, Parameter::DeadZoneDifference);
    let offset = value(Parameter::ValveOffset);
    for (index, chosen) in candidate.effects.iter().enumerate() {
        let (to, size, offset) = if chosen.has(edges) {
            (read, 0.5 * value(edges), offset - 0.5 * value(edges))
        } else if chosen.has(read) {
            (edges, 2.0 * value(read), offset + value(read))
        } else {
            continue;
        };
        let other = open_to(question, candidate).into_iter().find_map(|effect| {
            let form = effect
                .forms_in(question.scene)
                .find(|form| form.iter().any(|effect_parameter| effect_parameter.parameter == to))?;
            Some(Chosen { effect, form })
        });
        let Some(other) = other else { return Ok(None) };
        return candidate.instead(question, index, other, &[(to, size), (Parameter::ValveOffset, offset)]).map(Some);
    }
    Ok(None)
}

/// A candidate model of one side: its effects, its net gain and its machine.
type Part = (Vec<&'static Hypothesis>, f64, Machine<f64>);

/// Rounds of a side up to the number of effects that it chose; the first round is that without any effect.
fn parts(course: &Course) -> Vec<Vec<Part>> {
    let rounds = course.rounds.iter().take(course.chosen.effects.len());
    let part = |trial: &Trial| (trial.effects.clone(), trial.net, trial.machine);
    let none = vec![(Vec::new(), 0.0, course.base.fit.machine)];
    std::iter::once(none).chain(rounds.map(|round| round.iter().map(part).collect())).collect()
}

/// Candidate models of both sides together, round by round, the valve's effects before those below: the gains of the two sides are independent and
/// add up.
fn together(nominal: &Machine<f64>, valve: &Course, below: &Course) -> Vec<Vec<Trial>> {
    let (valve, below) = (parts(valve), parts(below));
    let last = valve.len() - 1;
    let rounds = (1..=last).map(|own| (own, 0)).chain((1..below.len()).map(|other| (last, other)));
    let joined = |(own, other): (usize, usize)| {
        let pairs = valve[own].iter().flat_map(|above| below[other].iter().map(move |below| (above, below)));
        let mut round: Vec<Trial> = pairs.filter_map(|(above, below)| both(nominal, above, below)).collect();
        round.sort_by(|a, b| b.net.total_cmp(&a.net));
        round
    };
    rounds.map(joined).collect()
}

/// One candidate model of each side, joined; `None` where neither has an effect.
fn both(nominal: &Machine<f64>, valve: &Part, below: &Part) -> Option<Trial> {
    let effects: Vec<&'static Hypothesis> = valve.0.iter().chain(&below.0).copied().collect();
    let effect = *effects.last()?;
    let mut machine = below.2;
    for &parameter in Parameter::ALL {
        let value = valve.2.get(parameter);
        if value.to_bits() != nominal.get(parameter).to_bits() {
            machine.set(parameter, value);
        }
    }
    Some(Trial { effect, effects, net: valve.1 + below.1, machine })
}

#[cfg(test)]
mod tests;
