//! Effects of a drive that is entered at a measured force: sought in what its velocity and position gain from block to block.
//!
//! What a measured force lacks is integrated by the mass. The free run is then off for seconds, its residual says no more than a few independent samples do, and
//! a base value takes what it can of it. Whitened ([`Whitening`](simulation::Whitening)), it says as many as there are blocks, and says the same whether the
//! position is recorded, the velocity or both. The model still runs free; fits of the report are those of the free run.

use identification::experiment::Prepared;
use identification::fit::{FitError, set_tolerances, settled};
use model_core::machine::{Machine, MachineError, Parameter};
use simulation::InputPoint;

use crate::asked::Asked;
use crate::catalogue::{Hypothesis, Subsystem};
use crate::decision::{Decision, decide};
use crate::diagnose::Progress;
use crate::selection::decision_rule::{RECORDINGS_GAIN, SEARCHED_TO};
use crate::selection::excerpt::Excerpt;
use crate::selection::{Selection, Trial, explains_enough};

/// Blocks in the time constant with which a wrong velocity decays. With fewer, a block has more than one reversal; with more, neighbours are no longer
/// independent and the sensors' noise weighs more.
const BLOCKS_IN_MEMORY: f64 = 10.0;
/// Blocks at least in the longest recording: three dozen still tell one model from another.
const LEAST_BLOCKS: f64 = 36.0;

/// Which force the gains say that the base model lacks, once the held-out recordings are opened. `None` where they name none, or nothing is to be asked of
/// them: free runs explain enough (`selection`), another signal drives the drive, or friction stops the rod within a few rows.
pub(crate) fn found(
    asked: Asked<'_>,
    selection: &Selection,
    (trained, held): (&[Prepared], &[Prepared]),
    excerpt: Option<&Excerpt>,
    progress: Progress<'_>,
) -> Result<Option<(Selection, Decision)>, FitError> {
    let is_entered = |case: &Prepared| case.stimulus.input_point == InputPoint::Force && !case.stimulus.is_balanced();
    if !trained.iter().all(is_entered) {
        return Ok(None);
    }
    let references: Vec<&Prepared> = trained.iter().collect();
    let base = selection.base.clone();
    if explains_enough(&asked.of(&references), &base, &selection.chosen, SEARCHED_TO) {
        return Ok(None);
    }
    // Impulses tell of forces. A sensor's lag, say, is told by where the rod is.
    let forces: Vec<&Hypothesis> =
        asked.hypotheses.iter().copied().filter(|effect| effect.subsystem == Subsystem::Mechanics).collect();
    let asked = Asked { hypotheses: &forces, ..asked };
    let Some(blocks) = Blocks::of(&base.fit.machine, trained) else { return Ok(None) };
    let Some(mut in_training) = blocks.whitened(trained)? else { return Ok(None) };
    let mut excerpt = match excerpt {
        None => None,
        Some(excerpt) => match blocks.whitened(&excerpt.cases)? {
            None => return Ok(None),
            Some(cases) => Some(excerpt.with(cases)),
        },
    };
    let mut selection = asked.selected(&mut in_training, excerpt.as_mut(), progress)?;
    if selection.chosen.effects.is_empty() || !is_plain_enough(&selection) {
        return Ok(None);
    }
    // Viscous friction had stood in for what was found; without that a wrong velocity lasts longer.
    let blocks = Blocks::of(&selection.chosen.fit.machine, trained).unwrap_or(blocks);
    let (Some(mut in_training), Some(in_held)) = (blocks.whitened(trained)?, blocks.whitened(held)?) else {
        return Ok(None);
    };
    set_tolerances(&selection.base.fit.machine, &mut in_training, &selection.base.fit.starts)?;
    let (in_training, in_held): (Vec<&Prepared>, Vec<&Prepared>) =
        (in_training.iter().collect(), in_held.iter().collect());
    let question = asked.of(&in_training);
    selection.base = selection.base.finished(&question)?;
    selection.chosen = selection.chosen.finished(&question)?;
    let mut decision = decide(&question, &mut selection, &in_held)?;
    let is_told = decision.confirmation.as_ref().is_none_or(|confirmation| confirmation.gain > RECORDINGS_GAIN);
    if decision.findings.is_empty() || !is_told {
        return Ok(None);
    }
    // What is shown are free runs, and the base model is the one that follows these best.
    decision.after.fit.starts = settled(&decision.after.fit.machine, &references)?;
    selection.base = base;
    Ok(Some((selection, decision)))
}

/// Whether none of its effects is a finer law in the place of a plainer one that is likelier and was not accepted: it then stands in for something else.
fn is_plain_enough(selection: &Selection) -> bool {
    let chosen = &selection.chosen;
    let Some(round) = selection.rounds.get(chosen.effects.len() - 1) else { return true };
    let net = round.iter().find(|trial| trial.is_of(chosen)).map_or(f64::NEG_INFINITY, |trial| trial.net);
    let is_plainer = |trial: &Trial| {
        let names = |effects: &mut dyn Iterator<Item = &'static Hypothesis>| {
            let mut names: Vec<&str> = effects.map(Hypothesis::plainest).collect();
            names.sort_unstable();
            names
        };
        let of_trial = names(&mut trial.effects.iter().copied());
        !trial.is_of(chosen)
            && of_trial == names(&mut chosen.effects.iter().map(|one| one.effect))
            && trial.effects.iter().all(|own| own.extends.is_none() || chosen.has(own))
    };
    !round.iter().any(|trial| is_plainer(trial) && trial.net > net)
}

/// How recordings are whitened.
struct Blocks {
    machine: Machine<f64>,
    block_s: f64,
    memory_s: f64,
}

impl Blocks {
    /// By the mass and the friction of a model; `None` where a wrong velocity is gone within two rows.
    fn of(machine: &Machine<f64>, cases: &[Prepared]) -> Option<Self> {
        let row_s = cases.iter().map(|case| case.duration_s() / case.rows().max(2) as f64).fold(0.0, f64::max);
        let longest_s = cases.iter().map(Prepared::duration_s).fold(0.0, f64::max);
        let decay_s = machine.get(Parameter::MovingMass) / machine.get(Parameter::ViscousFriction);
        let memory_s = if decay_s.is_finite() { decay_s.min(longest_s) } else { longest_s };
        let block_s = (memory_s / BLOCKS_IN_MEMORY).min(longest_s / LEAST_BLOCKS).max(row_s);
        (memory_s > 2.0 * row_s).then_some(Self { machine: *machine, block_s, memory_s })
    }

    fn whitened(&self, cases: &[Prepared]) -> Result<Option<Vec<Prepared>>, MachineError> {
        cases.iter().map(|case| case.whitened(&self.machine, self.block_s, self.memory_s)).collect()
    }
}
