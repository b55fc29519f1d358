//! The searches of a diagnosis: for effects, and for a cause outside the drive beside them.

use identification::experiment::Prepared;
use identification::fit::{FitError, Free, set_tolerances};

use crate::catalogue::{Hypothesis, Scene};
use crate::decision::Decision;
use crate::diagnose::Progress;
use crate::gains;
use crate::outside::{self, Outside};
use crate::selection::decision_rule::{OUTSIDE_KEEPS, SEARCHED_TO};
use crate::selection::excerpt::Excerpt;
use crate::selection::forward::select;
use crate::selection::searched::{Clock, Stage};
use crate::selection::{Candidate, Question, Selection, explains_enough, lengthened};

/// What is asked of the recordings, whichever part of them is looked at.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) base_parameters: &'a [Free],
    pub(crate) hypotheses: &'a [&'static Hypothesis],
}

impl<'a> Asked<'a> {
    /// Of these training recordings.
    pub(crate) fn of<'b>(self, training: &'b [&'b Prepared]) -> Question<'b>
    where
        'a: 'b,
    {
        Question { scene: self.scene, base_parameters: self.base_parameters, hypotheses: self.hypotheses, training }
    }

    /// What free runs choose, and what they choose beside a cause from outside; or what the gains of a drive that is entered at a measured force say, which
    /// is decided already. Of a search that its limit has ended nothing is chosen: what was not tried cannot be excluded.
    pub(crate) fn found(
        self,
        (mut trained, held): (Vec<Prepared>, Vec<Prepared>),
        mut excerpt: Option<&mut Excerpt>,
        progress: Progress<'_>,
    ) -> Result<Found, FitError> {
        let mut selection = self.selected(&mut trained, excerpt.as_deref_mut(), progress)?;
        let beside = if excerpt.is_none() { self.outside(&mut selection, &trained, &held, progress)? } else { None };
        if let Some(Beside { told, selection: mut forced, trained: with, held: held_with }) = beside {
            let plain = Plain { trained, held, base: selection.base };
            forced.claim_only_if_finished();
            let (plain, outside) = (Some(plain), Some(told));
            return Ok(Found { selection: forced, decided: None, plain, outside, trained: with, held: held_with });
        }
        let gained = gains::found(self, &mut selection, (&trained, &held), excerpt.as_deref(), progress)?;
        let (mut selection, decided) =
            gained.map_or((selection, None), |(selection, decision)| (selection, Some(decision)));
        selection.claim_only_if_finished();
        Ok(Found { selection, decided, plain: None, outside: None, trained, held })
    }

    /// The effects that the training recordings choose: of long ones their excerpt, and then the whole.
    pub(crate) fn selected(
        self,
        trained: &mut [Prepared],
        excerpt: Option<&mut Excerpt>,
        progress: Progress<'_>,
    ) -> Result<Selection, FitError> {
        let done = |name: &str| progress(name);
        let mut selection = self.searched(trained, excerpt, &done)?;
        let references: Vec<&Prepared> = trained.iter().collect();
        selection.find_jumps(&self.of(&references), &done)?;
        Ok(selection)
    }

    /// A cause outside the drive that explains what the catalogue does not, with the search repeated beside it.
    fn outside(
        self,
        selection: &mut Selection,
        trained: &[Prepared],
        held: &[Prepared],
        progress: Progress<'_>,
    ) -> Result<Option<Beside>, FitError> {
        let references: Vec<&Prepared> = trained.iter().collect();
        let question = self.of(&references);
        let is_explained = explains_enough(&question, &selection.base, &selection.chosen, SEARCHED_TO)
            || !selection.base.misses_by_more_than_noise(&question);
        // The load that balances recorded pressures has every force in it.
        if is_explained || trained.iter().any(|case| case.stimulus.is_balanced()) {
            return Ok(None);
        }
        let mut clock = Clock::of(&question);
        if clock.effort().is_used_up() || !selection.searched.is_finished() {
            selection.searched.leave(Stage::Outside);
            return Ok(None);
        }
        let found = outside::find(&question, selection)?;
        selection.searched.did(Stage::Outside, clock.lap_s());
        let Some(found) = found else { return Ok(None) };
        let done = |name: &str| progress(name);
        let trained = found.force.on(&references);
        let forced: Vec<&Prepared> = trained.iter().collect();
        let forced_question = self.of(&forced);
        let beside = if found.force.follows_recorded_motion() {
            // Nothing is named beside it: a finding is made in free run.
            let base = Candidate::base(&forced_question, &found.near, &found.near)?;
            Selection { chosen: base.clone(), base, jumps: None, ..selection.clone() }
        } else {
            let mut beside = select(&forced_question, &found.near, &done)?;
            beside.find_jumps(&forced_question, &done)?;
            beside.searched = beside.searched.after(&selection.searched);
            beside
        };
        // Beside a search that did not come to its end no cause is told.
        if !beside.searched.is_finished() {
            selection.searched = beside.searched;
            return Ok(None);
        }
        let opened: Vec<&Prepared> = held.iter().collect();
        let (was, is) = (&selection.base.fit.machine, &beside.base.fit.machine);
        let in_held = found.force.in_others(is, &opened)?;
        let held = in_held.as_ref().map_or_else(|| held.to_vec(), |force| force.on(&opened));
        let with: Vec<&Prepared> = held.iter().collect();
        let told = if held.is_empty() { None } else { Some(outside::HeldOut::of((was, &opened), (is, &with))?) };
        let is_kept = told.is_none_or(|held| match in_held {
            Some(_) => held.explains() > OUTSIDE_KEEPS * found.explains,
            None => !held.is_worse(),
        });
        let told = Outside {
            cause: found.force.cause(&references),
            explains: found.explains,
            explains_held_out: told.filter(|_| in_held.is_some()).map(|held| held.explains()),
        };
        Ok(is_kept.then_some(Beside { told, selection: beside, trained, held }))
    }

    /// The same as far as free runs tell.
    fn searched(
        self,
        trained: &mut [Prepared],
        excerpt: Option<&mut Excerpt>,
        done: &(impl Fn(&str) + Sync),
    ) -> Result<Selection, FitError> {
        let search = |cases: &mut [Prepared]| {
            let effort = cases.first().map(|case| case.effort.clone()).unwrap_or_default();
            let began_s = effort.spent_s();
            let near = Candidate::tolerated(self.scene, self.base_parameters, cases)?;
            let near_s = effort.spent_s() - began_s;
            let references: Vec<&Prepared> = cases.iter().collect();
            let mut found = select(&self.of(&references), &near, done)?;
            found.searched.did(Stage::Base, near_s);
            Ok::<_, FitError>(found)
        };
        let Some(excerpt) = excerpt else { return search(trained) };
        let mut found = search(&mut excerpt.cases)?;
        for candidate in [&mut found.base, &mut found.chosen] {
            candidate.fit.starts = excerpt.starts_of_all(&candidate.fit.starts, trained.len());
        }
        set_tolerances(&found.base.fit.machine, trained, &found.base.fit.starts)?;
        let references: Vec<&Prepared> = trained.iter().collect();
        lengthened(&self.of(&references), &found, done)
    }
}

/// What the searches found, with the recordings that they end with: those with a force from outside as an input, where there is one.
pub(crate) struct Found {
    pub(crate) selection: Selection,
    /// What is decided already.
    pub(crate) decided: Option<Decision>,
    pub(crate) plain: Option<Plain>,
    pub(crate) outside: Option<Outside>,
    pub(crate) trained: Vec<Prepared>,
    pub(crate) held: Vec<Prepared>,
}

/// What there was before a force from outside became an input.
pub(crate) struct Plain {
    pub(crate) trained: Vec<Prepared>,
    pub(crate) held: Vec<Prepared>,
    pub(crate) base: Candidate,
}

/// A search beside a force from outside, with the recordings that have that force as an input.
struct Beside {
    told: Outside,
    selection: Selection,
    trained: Vec<Prepared>,
    held: Vec<Prepared>,
}
