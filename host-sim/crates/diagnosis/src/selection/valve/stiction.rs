//! Effects of the valve beside stiction, found from the instants at which its spool jumps.
//!
//! In a free run, a jump that is a tick late costs more than most effects explain, so that a search ends where the model jumps least: at a band that
//! is mostly kept, with very small jumps. The position of the free spool that the jumps measure depends smoothly on all parameters, and distinguishes
//! stiction from a play beside it.

use identification::parallel;

use identification::experiment::Prepared;
use identification::fit::{FitError, Residuals, StartState, softened_all};
use model_core::machine::Parameter;

use super::sliding::has_mass;
use super::spool_jumps::{Sticking, is_alike};
use crate::catalogue::Hypothesis;
use crate::selection::candidate::{Candidate, Chosen, Question, Reference};
use crate::selection::decision_rule::{
    BESIDE_STICTION_BEYOND_PENALTY, BESIDE_STICTION_EXPLAINS, BESIDE_STICTION_GAINS, FEWEST_STICKING,
    HELD_OUT_JUMPS_GAIN,
};
use crate::selection::likelihood::{Gained, misfit_above_noise, ranked, straightened};
use crate::selection::outcome::Trial;
use crate::selection::round::trial;
use crate::selection::screen::Lead;

/// Forms that are refitted beside stiction.
const REFITTED: usize = 4;
/// Starting values for how far the free spool is ahead, in lengths of a jump: jumps that end short by up to seven tenths of the band.
const AHEAD: [f64; 5] = [0.5, 0.75, 1.1, 1.6, 2.6];

/// A candidate model of the effects beside stiction, refitted to the free spool.
struct Beside {
    candidate: Candidate,
    /// How far the free spool is ahead.
    ahead: f64,
    left_out: Residuals,
}

/// Where a refit beside stiction may start: how far the free spool is ahead, the base parameters there, and the most promising lead.
struct Start {
    ahead: f64,
    from: Candidate,
    lead: Lead,
}

/// A search in the jumps.
struct Search<'q, 'a> {
    question: &'q Question<'q>,
    sticking: Sticking<'a>,
    effects: Vec<&'static Hypothesis>,
}

impl Search<'_, '_> {
    /// Evaluates a question on the recordings of a free spool that is this far ahead.
    fn at<T>(&self, ahead: f64, ask: impl FnOnce(&Question<'_>) -> Result<T, FitError>) -> Result<T, FitError> {
        let freed = self.sticking.freed(ahead);
        let training: Vec<&Prepared> = freed.iter().collect();
        ask(&Question { hypotheses: &self.effects, training: &training, ..*self.question })
    }

    /// The least distance that the free spool can be ahead: that of a jump that ends at the free spool.
    fn least(&self) -> f64 {
        0.5 * self.sticking.length
    }

    /// A candidate model, refitted together with the distance that the free spool is ahead.
    fn settled(&self, mut candidate: Candidate, mut ahead: f64) -> Result<Beside, FitError> {
        /// Newton steps, at most.
        const STEPS: usize = 12;
        for _ in 0..STEPS {
            let further;
            (candidate, further) = self.at(ahead, |question| {
                let candidate = candidate.finished(question)?;
                let further = self.sticking.further(&candidate, question.training)?;
                Ok((candidate, further))
            })?;
            let next = (ahead + further.clamp(-0.5 * ahead, ahead)).max(self.least());
            let is_there = (next - ahead).abs() < 2e-3 * ahead;
            ahead = next;
            if is_there {
                break;
            }
        }
        self.at(ahead, |question| {
            let candidate = candidate.finished(question)?;
            let left_out = candidate.left_out(question)?;
            Ok(Beside { candidate, ahead, left_out })
        })
    }

    /// The base parameters alone, roughly, and where each form could start, the most promising first.
    fn starts(&self) -> Result<(Beginning, Vec<Vec<Start>>), FitError> {
        let at = |times: &f64| {
            let ahead = times * self.sticking.length;
            self.at(ahead, |question| {
                let base = Candidate::rough(question, None)?;
                let leads = Reference::new(question, &base)?.leads(question.hypotheses)?;
                Ok((ahead, base, leads))
            })
        };
        let all: Vec<_> = parallel::try_each(&AHEAD, at)?;
        let mut forms: Vec<Vec<Start>> = Vec::new();
        let mut plain: Vec<Beginning> = Vec::new();
        for (ahead, from, leads) in all {
            for lead in leads {
                let start = Start { ahead, from: from.clone(), lead };
                match forms.iter_mut().find(|form| form.iter().any(|known| known.lead.is_like(&start.lead))) {
                    Some(form) => form.push(start),
                    None => forms.push(vec![start]),
                }
            }
            plain.push((ahead, from));
        }
        let least = |form: &[Start]| form.iter().map(|start| start.lead.loss).fold(f64::INFINITY, f64::min);
        forms.sort_by(|a, b| least(a).total_cmp(&least(b)));
        Ok((nearest(plain), forms))
    }

    /// A form, refitted from the start that leaves the smallest misfit.
    fn refitted(&self, starts: &[Start]) -> Result<Beside, FitError> {
        let rough = |Start { ahead, from, lead }: &Start| {
            let candidate = self.at(*ahead, |question| Reference::new(question, from)?.with(lead))?;
            Ok::<_, FitError>((*ahead, candidate))
        };
        let (ahead, candidate) = nearest(parallel::try_each(starts, rough)?);
        self.settled(candidate, ahead)
    }

    /// Whether an effect is worth its effect parameters beside stiction.
    fn accepts(&self, plain: &Beside, with: &Beside) -> bool {
        let gained = Gained::of(&plain.left_out, &with.left_out, self.question.counts());
        let straightened = straightened(self.question, &plain.candidate, &with.candidate);
        with.candidate.is_plausible(self.question)
            && misfit_above_noise(&with.candidate.residuals)
                < (1.0 - BESIDE_STICTION_EXPLAINS) * misfit_above_noise(&plain.candidate.residuals)
            && gained.all > BESIDE_STICTION_GAINS
            && gained.all + straightened
                > gained.cost(with.candidate.effect_parameters()) + BESIDE_STICTION_BEYOND_PENALTY
            && gained.repeats
    }
}

/// How far the free spool is ahead, with a candidate model that was refitted there.
type Beginning = (f64, Candidate);

/// The one with the smallest loss.
fn nearest(all: Vec<Beginning>) -> Beginning {
    let best = all.into_iter().min_by(|(_, a), (_, b)| a.fit.loss.total_cmp(&b.fit.loss));
    best.expect("it was tried somewhere")
}

/// Whether held-out jumps confirm an effect of the valve in a candidate model with stiction. Stiction itself is confirmed if the spool jumps as far
/// there as in training, any other effect if the free spool that the jumps measure is followed better with it. `None` where the model has no
/// stiction, or its spool has mass, or there are too few jumps.
pub(crate) fn confirms(
    question: &Question<'_>,
    candidate: &Candidate,
    effect: &Hypothesis,
    held_out: &[&Prepared],
) -> Result<Option<bool>, FitError> {
    let is_stiction = |chosen: &&Chosen| chosen.has(Parameter::StictionBand);
    let stiction = candidate.effects.iter().find(is_stiction).filter(|_| !has_mass(question.scene.machine));
    let Some(stiction) = stiction else { return Ok(None) };
    let (Some(sticking), Some(held_out)) =
        (Sticking::of(question.training, FEWEST_STICKING), Sticking::of(held_out, 1))
    else {
        return Ok(None);
    };
    if effect.name == stiction.effect.name {
        return Ok(Some(is_alike(held_out.length, sticking.length)));
    }
    let value = |parameter| candidate.fit.machine.get(parameter);
    let ahead = 0.5 * value(Parameter::StictionBand) * (1.0 + value(Parameter::StictionKept));
    let search = Search { question, sticking, effects: Vec::new() };
    let refitted = |keeps: &(dyn Fn(&Hypothesis) -> bool + Sync)| {
        let is_kept = |one: &Hypothesis| {
            one.subsystem == stiction.effect.subsystem && one.name != stiction.effect.name && keeps(one)
        };
        let beside = search.settled(search.at(ahead, |question| candidate.only(question, is_kept))?, ahead)?;
        let freed = held_out.freed(beside.ahead);
        let cases = freed.iter().map(|case| (case, StartState::default()));
        softened_all(&beside.candidate.fit.machine, cases).map_err(FitError::from)
    };
    let (without, with) = rayon::join(|| refitted(&|one| one.name != effect.name), || refitted(&|_| true));
    let gained = Gained::of(&without?, &with?, question.counts());
    Ok(Some(gained.all > HELD_OUT_JUMPS_GAIN))
}

/// What the valve's side chooses where its spool sticks and, if that is two effects, all tried candidate models of two. `None` where the spool does
/// not stick, or has mass, or where band or kept share would be above their admissible maximum.
pub(crate) fn stuck(
    question: &Question<'_>,
    done: &(impl Fn(&str) + Sync),
) -> Result<Option<(Candidate, Vec<Trial>)>, FitError> {
    let stiction = question.form_with(&[Parameter::StictionBand, Parameter::StictionKept]);
    let jumping = Sticking::of(question.training, FEWEST_STICKING).filter(|_| !has_mass(question.scene.machine));
    let (Some(stiction), Some(sticking)) = (stiction, jumping) else {
        return Ok(None);
    };
    let effects = question.hypotheses.iter().copied().filter(|effect| effect.name != stiction.effect.name).collect();
    let search = Search { question, sticking, effects };
    let ((ahead, base), forms) = search.starts()?;
    let plain = search.settled(base, ahead)?;
    let refit = |starts: &Vec<Start>| {
        let beside = search.refitted(starts);
        starts.iter().take(1).for_each(|start| done(start.lead.effect.name));
        beside
    };
    let tried: Vec<Beside> = parallel::try_each(forms.iter().take(REFITTED), refit)?;
    let with_stiction = |beside: &Beside| {
        let (band, kept) = search.sticking.effect_parameters(beside.ahead);
        let effect_parameters = [(Parameter::StictionBand, band), (Parameter::StictionKept, kept)];
        if effect_parameters.iter().any(|(parameter, value)| *value > parameter.description().max) {
            return None;
        }
        let mut candidate = beside.candidate.clone();
        for (parameter, value) in effect_parameters {
            candidate.fit.machine.set(parameter, value);
            candidate.jumps.push((parameter, value));
        }
        candidate.effects.push(stiction);
        Some(candidate)
    };
    let ranked = ranked(question, &plain.candidate, tried.iter().map(|beside| beside.candidate.clone()).collect());
    // Of each effect only the best form is in the ranking.
    let beside = |candidate: &Candidate| tried.iter().find(|beside| beside.candidate.newest() == candidate.newest());
    let best = ranked.first().and_then(|(best, _)| beside(best)).filter(|best| search.accepts(&plain, best));
    let Some(best) = best else { return Ok(with_stiction(&plain).map(|candidate| (candidate, Vec::new()))) };
    let told = |(candidate, net): &(Candidate, f64)| Some(trial(&with_stiction(beside(candidate)?)?, *net));
    Ok(with_stiction(best).map(|candidate| (candidate, ranked.iter().filter_map(told).collect())))
}
