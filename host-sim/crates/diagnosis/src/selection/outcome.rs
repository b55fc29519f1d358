//! The result of a selection: the candidate models that were tried, and the chosen one.

use identification::fit::Fit;
use model_core::machine::Machine;

use super::candidate::{Candidate, Chosen};
use super::decision_rule::{KEPT_ALONE, SUSPECTED_FROM};
use super::searched::Searched;
use crate::catalogue::Hypothesis;
use crate::selection::valve::jump_spacing::JumpSpacing;

/// What one candidate model gained over the base.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The effect that is new in it.
    pub effect: &'static Hypothesis,
    /// All its effects.
    pub effects: Vec<&'static Hypothesis>,
    /// Log-likelihood gained over the base, less the penalty.
    pub net: f64,
    /// The machine as refitted with them.
    pub machine: Machine<f64>,
}

impl Trial {
    /// Whether its effects are those of a candidate model.
    pub(crate) fn is_of(&self, candidate: &Candidate) -> bool {
        self.effects.len() == candidate.effects.len() && self.effects.iter().all(|own| candidate.has(own))
    }

    /// The effect that it has in the place of one of the chosen ones; `None` where it also has that one, or where any other effect differs.
    pub fn instead_of(&self, effect: &Hypothesis, chosen: &[Chosen]) -> Option<&'static Hypothesis> {
        let is_chosen = |own: &Hypothesis| chosen.iter().any(|one| one.effect.name == own.name);
        let stays = |one: &Chosen| self.has_any(&[one.effect]) != (one.effect.name == effect.name);
        let mut others = self.effects.iter().copied().filter(|own| !is_chosen(own));
        if self.effects.len() == chosen.len() && chosen.iter().all(stays) { others.next() } else { None }
    }

    /// Whether any of these effects is in it.
    pub fn has_any(&self, effects: &[&Hypothesis]) -> bool {
        self.effects.iter().any(|own| effects.iter().any(|effect| effect.name == own.name))
    }
}

/// The outcome of the selection on training recordings, later reduced by the held-out ones.
#[derive(Clone, Debug)]
pub struct Selection {
    /// The machine file's model, refitted.
    pub base: Candidate,
    /// The same, refitted with the noise inflated to its own misfit: the base parameters stay where they can be.
    pub inflated: Fit,
    /// The chosen candidate model; the base again if nothing is accepted.
    pub chosen: Candidate,
    /// Every refitted candidate model, round by round, the best first.
    pub rounds: Vec<Vec<Trial>>,
    /// The plainest of several effects that the valve-first search found: the whole model only had to accept them all together.
    pub joined: Vec<&'static str>,
    /// The jumps of a spool that no sensor measures, where the chosen candidate model has them from the position.
    pub jumps: Option<JumpEvidence>,
    /// What its parts cost, and what a limit left out.
    pub searched: Searched,
}

impl Selection {
    /// Of a search that its limit has ended nothing is chosen: what was not tried cannot be excluded.
    pub(crate) fn claim_only_if_finished(&mut self) {
        if !self.searched.is_finished() {
            self.chosen = self.base.clone();
            self.jumps = None;
        }
    }

    /// The single effect that the training recordings make likelier than none by more than chance, where nothing is accepted.
    #[must_use]
    pub fn suspected(&self) -> Option<&'static Hypothesis> {
        let best = self.rounds.first()?.first()?;
        (self.chosen.effects.is_empty() && best.net > SUSPECTED_FROM).then_some(best.effect)
    }
}

/// What a position shows of the jumps of a spool that no sensor measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpsFound {
    /// Their length, and the evidence for them.
    pub jump_spacing: JumpSpacing,
    /// Share of its band that a stiction alone would have to keep to lag as far as the spool does.
    pub kept_alone: f64,
}

impl JumpsFound {
    /// Whether a stiction alone may keep this share.
    #[must_use]
    pub fn is_alone(&self) -> bool {
        self.kept_alone <= KEPT_ALONE
    }
}

/// The jumps of a spool that no sensor measures.
#[derive(Clone, Debug)]
pub struct JumpEvidence {
    /// What the position shows of them.
    pub found: JumpsFound,
    /// The model without jumps with which the position is compared.
    pub(super) following: Machine<f64>,
    /// What was chosen before.
    pub(super) chosen: Candidate,
    pub(super) rounds: Vec<Vec<Trial>>,
}
