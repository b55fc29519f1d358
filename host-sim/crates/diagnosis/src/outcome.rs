//! What a diagnosis says: verdict, findings, place, and every recording with its simulations.

use identification::fit::{Correlation, Estimate, Free, Unsettled};
use model_core::machine::Machine;

use crate::agreement::{Doubt, FarValue, Tolerated, far_values, has_sensor, not_tolerated, tolerated};
use crate::before_after::{Fits, Shown, mean_fits, mean_noise_floor};
use crate::catalogue::Hypothesis;
use crate::correction_table::Unnamed;
use crate::finding::Finding;
use crate::localisation::{Location, Miss};
use crate::outside::Outside;
use crate::selection::{Confirmation, Selection};
use crate::since::OtherOil;
use crate::structure::Structure;

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Named effects account for a mismatch, and recordings that were held out confirm it.
    MissingPhysics,
    /// The refitted model follows the recordings within their noise.
    NothingMissing,
    /// There is a mismatch above the noise that no effect of the catalogue accounts for.
    Unexplained,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The drive's name.
    pub machine: String,
    /// The effects of the machine file that may have changed since it was written, where that was asked.
    pub since: Option<Vec<&'static Hypothesis>>,
    /// How the diagnosis of the recordings of then ended, where it was made from such.
    pub then: Option<Verdict>,
    /// Of those effects the ones of which these recordings do not tell whether they have changed.
    pub untested: Vec<&'static Hypothesis>,
    /// What is different with the oil since then, where its temperature is known at both times.
    pub other_oil: Option<OtherOil>,
    /// How it ended.
    pub verdict: Verdict,
    /// Where the misfit is; `None` if nothing is missing and no effect is suspected or was withdrawn.
    pub located: Option<Location>,
    /// Only while everything is within the noise: the effect that the training recordings make likelier than none by more than chance,
    /// but that the decision rule does not accept. Never a finding.
    pub suspected: Option<&'static Hypothesis>,
    /// The accepted effects, most certain first.
    pub findings: Vec<Finding>,
    /// A cause outside the drive that explains most of a mismatch. Never a finding.
    pub outside: Option<Outside>,
    /// Signals whose misfit on the training recordings is still above the noise with the accepted effects.
    pub left: Vec<Miss>,
    /// The same on the held-out recordings.
    pub left_held_out: Vec<Miss>,
    /// How linear models of second order do on the same recordings, and, where the machine's model ends below them, what shows that its structure is wrong.
    pub structure: Structure,
    /// Whether the held-out recordings work where the training ones do not: only refitted to all of them does the model follow all. The machine after the
    /// diagnosis is fitted to the training recordings all the same.
    pub training_is_too_narrow: bool,
    /// The value that was still moving where the refit with the accepted effects ended, if it did not converge.
    pub unsettled: Option<Unsettled>,
    /// Effects that training recordings chose and held-out ones did not confirm.
    pub not_confirmed: Vec<&'static Hypothesis>,
    /// Effects that may have changed and of which there is less by one amount and more by another: they act otherwise than then, as those of the same drive
    /// do that is driven otherwise.
    pub otherwise: Vec<&'static Hypothesis>,
    /// A correction table for what no effect explains, where the model with it follows the held-out recordings better. Never a finding.
    pub unnamed: Option<Unnamed>,
    /// What the held-out recordings said; `None` if there was no choice to confirm.
    pub confirmation: Option<Confirmation>,
    /// What was doubtful about the recordings for this drive before anything was searched, where that was asked ([`crate::agreement::doubts`]).
    pub doubts: Vec<Doubt>,
    /// Base parameters that could move, with their priors.
    pub base_parameters: Vec<Free>,
    /// Base parameters that were refitted (with the effects, if any), and what was used of tolerances.
    pub refitted: Vec<Estimate>,
    /// Pairs of fitted base or effect parameters whose estimates are correlated; the strongest correlation first.
    pub correlated: Vec<Correlation>,
    /// Every recording with its simulations.
    pub shown: Vec<Shown>,
    /// The course of the selection.
    pub selection: Selection,
    /// The machine after the diagnosis: refitted, with the accepted effects.
    pub machine_after: Machine<f64>,
    /// Mean level at rest (pressure in B as a share of the supply) from which the training recordings start with that machine; `None`
    /// where their pressures are recorded. Held-out recordings are shown from the initial state that suits each best.
    pub level_at_rest: Option<f64>,
    /// Effects that these recordings cannot show on any drive.
    pub not_testable: Vec<&'static Hypothesis>,
}

impl Diagnosis {
    /// Mean NRMSE fit of each signal, before or after, on training or held-out recordings.
    #[must_use]
    pub fn mean_fits(&self, held_out: bool, after: bool) -> Fits {
        mean_fits(&self.shown, held_out, after)
    }

    /// Mean NRMSE fit that a perfect model would reach on held-out recordings.
    #[must_use]
    pub fn noise_floor(&self, held_out: bool) -> Fits {
        mean_noise_floor(&self.shown, held_out)
    }

    fn trained(&self) -> impl Iterator<Item = &Shown> {
        self.shown.iter().filter(|shown| !shown.held_out)
    }

    /// Whether the model after differs from the one before: by accepted effects, a force from outside, or a correction table.
    #[must_use]
    pub fn changes(&self) -> bool {
        !self.findings.is_empty() || self.unnamed.is_some() || self.outside.is_some()
    }

    /// Effects that may have changed, by the training recordings, and of which the held-out ones did not confirm it.
    #[must_use]
    pub fn doubtful_changes(&self) -> Vec<&'static Hypothesis> {
        let held = self.since.as_deref().unwrap_or_default();
        let is_held = |effect: &&Hypothesis| held.iter().any(|held| held.name == effect.name);
        self.not_confirmed.iter().copied().filter(is_held).collect()
    }

    /// Whether nothing has changed since then, as far as was asked: the model of then follows, with values near those that it had, and the recordings would
    /// show a change of each of its effects.
    #[must_use]
    pub fn is_unchanged(&self) -> bool {
        let follows = self.since.is_some() && self.verdict == Verdict::NothingMissing;
        let is_open = !self.untested.is_empty() || !self.otherwise.is_empty() || !self.doubtful_changes().is_empty();
        follows && !is_open && self.far_values().is_empty()
    }

    /// Refitted base parameters far from where the machine file says they are.
    #[must_use]
    pub fn far_values(&self) -> Vec<FarValue> {
        far_values(&self.machine_after, &self.base_parameters, &self.refitted)
    }

    /// Base parameters that were refitted, without tolerances.
    #[must_use]
    pub fn base_values(&self) -> Vec<Estimate> {
        not_tolerated(&self.base_parameters, &self.refitted)
    }

    /// What the fit used of tolerances, without those of sensors that are not recorded; what a finding has taken over is the finding's.
    #[must_use]
    pub fn tolerances(&self) -> Vec<Tolerated> {
        let is_found = |one: &Tolerated| {
            self.findings.iter().flat_map(|finding| &finding.parameters).any(|own| own.parameter == one.parameter)
        };
        let mut all = tolerated(&self.base_parameters, &self.refitted);
        let is_recorded = |one: &Tolerated| has_sensor(self.trained().map(|shown| &shown.prepared), one.parameter);
        all.retain(|one| !is_found(one) && is_recorded(one));
        all
    }

    /// What the model before is called in reports: it is the only model where nothing changes.
    pub fn before_is_called(&self) -> &'static str {
        if self.changes() { "before" } else { "refitted" }
    }

    /// The recording to show first: a held-out one where there is one.
    #[must_use]
    pub fn example(&self) -> Option<&Shown> {
        self.shown.iter().find(|shown| shown.held_out).or(self.shown.first())
    }
}
