//! Where the misfit of a diagnosis is, what it looks like, and what a correction table for it gains.

use std::collections::BTreeMap;

use identification::experiment::Prepared;
use identification::fit::{Estimate, FitError, StartState};
use recording::Recording;

use crate::asked::Asked;
use crate::catalogue::{Hypothesis, Subsystem};
use crate::correction_table::{Unnamed, improved, may_help};
use crate::decision::Decision;
use crate::localisation::locate::locate;
use crate::localisation::{Case, Location, Sought};
use crate::outcome::Verdict;
use crate::selection::candidate::Reference;
use crate::selection::screen::Lead;
use crate::selection::searched::{Clock, Searched, Stage};
use crate::selection::{Candidate, Question};

/// The recordings by which the misfit is told: those that were searched.
pub(crate) struct Seen<'a> {
    pub(crate) asked: Asked<'a>,
    pub(crate) recordings: &'a [Recording],
    pub(crate) cases: &'a [&'a Prepared],
    /// Whether they are a part of the whole recordings.
    pub(crate) is_excerpt: bool,
}

/// Where the misfit is, and the model with a correction table.
pub(crate) struct Place {
    /// `None` if nothing is missing and no effect is suspected or was withdrawn.
    pub(crate) located: Option<Location>,
    /// The model with the best table and its values, where nothing explains the misfit and the table improves held-out fits.
    pub(crate) tabled: Option<(Candidate, Vec<Estimate>, Unnamed)>,
}

impl Seen<'_> {
    /// Where the misfit of the `base` model is, by how the diagnosis ends. Tables are tried where held-out recordings are given that may judge them.
    pub(crate) fn place(
        &self,
        base: &Candidate,
        (verdict, decided, suspected): (Verdict, &Decision, Option<&'static Hypothesis>),
        held: Option<&[&Prepared]>,
        searched: &mut Searched,
    ) -> Result<Place, FitError> {
        let question = self.asked.of(self.cases);
        let base = if self.is_excerpt { base.finished(&question)? } else { base.clone() };
        let cases = cases(self.recordings, self.cases, &base.fit.starts);
        // What was named tells the link better than what it looks like from outside; within the noise, only what was all but named.
        let effects: Vec<&Hypothesis> = match verdict {
            Verdict::MissingPhysics => decided.findings.iter().map(|finding| finding.effect).collect(),
            Verdict::NothingMissing => suspected.into_iter().chain(decided.not_confirmed.iter().copied()).collect(),
            Verdict::Unexplained => Vec::new(),
        };
        let named: Vec<Subsystem> = effects.iter().map(|effect| effect.subsystem).collect();
        if verdict == Verdict::NothingMissing && named.is_empty() {
            return Ok(Place { located: None, tabled: None });
        }
        let location = place(&question, &base, &cases, &named)?;
        let is_asked = |held: &&[&Prepared]| verdict == Verdict::Unexplained && may_help(&question, &location, held);
        let mut tabled = None;
        if let Some(held) = held.filter(is_asked) {
            let mut clock = Clock::of(&question);
            if clock.effort().is_used_up() || !searched.is_finished() {
                searched.leave(Stage::Tables);
            } else if let Some((with, unnamed)) = improved(&question, &base, &location, &cases, held)? {
                let estimates = with.estimates(&question)?;
                tabled = Some((with, estimates, unnamed));
            }
            searched.did(Stage::Tables, clock.lap_s());
        }
        Ok(Place { located: Some(location), tabled })
    }
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
