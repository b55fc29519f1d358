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
use crate::selection::likelihood::accepts;
use crate::selection::searched::{Clock, Stage};
use crate::selection::{Selection, explains_enough};

/// Blocks in the time constant with which a wrong velocity decays. With fewer, a block has more than one reversal; with more, neighbours are no longer
/// independent and the sensors' noise weighs more.
const BLOCKS_IN_MEMORY: f64 = 10.0;
/// Blocks at least in the shortest recording: three dozen still tell one model from another.
const LEAST_BLOCKS: f64 = 36.0;
/// Ticks at least in a block: at twice the tick two are left.
const TICKS: f64 = 4.0;

/// Which force the gains say that the base model lacks, once the held-out recordings are opened. `None` where they name none, or nothing is to be asked of
/// them: free runs explain enough (`selection`) or name what is no force, another signal drives the drive, friction stops the rod within a few rows, or a
/// recording is too short.
pub(crate) fn found(
    asked: Asked<'_>,
    selection: &mut Selection,
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
    let is_force = |effect: &Hypothesis| effect.subsystem == Subsystem::Mechanics;
    let names_another = selection.chosen.effects.iter().any(|chosen| !is_force(chosen.effect));
    if names_another || explains_enough(&asked.of(&references), &base, &selection.chosen, SEARCHED_TO) {
        return Ok(None);
    }
    // Gains tell of forces: a sensor's lag, say, is told by where the rod is. They do not tell of finer laws of friction: a real guide is rough, and any further
    // value follows a part of that.
    let is_plain = |effect: &&Hypothesis| is_force(effect) && effect.extends.is_none();
    let forces: Vec<&Hypothesis> = asked.hypotheses.iter().copied().filter(is_plain).collect();
    let asked = Asked { hypotheses: &forces, ..asked };
    let all = || trained.iter().chain(held);
    let Some(blocks) = Blocks::of(&base.fit.machine, all()) else { return Ok(None) };
    let Some(mut in_training) = blocks.whitened(trained)? else { return Ok(None) };
    let mut excerpt = match excerpt {
        None => None,
        Some(excerpt) => match blocks.whitened(&excerpt.cases)? {
            None => return Ok(None),
            Some(cases) => Some(excerpt.with(cases)),
        },
    };
    let mut clock = Clock::of(&asked.of(&references));
    if clock.effort().is_used_up() || !selection.searched.is_finished() {
        selection.searched.leave(Stage::Gains);
        return Ok(None);
    }
    let by_gains = asked.selected(&mut in_training, excerpt.as_mut(), progress)?;
    selection.searched.did(Stage::Gains, clock.lap_s());
    if !by_gains.searched.is_finished() {
        selection.searched.leave(Stage::Gains);
        return Ok(None);
    }
    let mut selection = Selection { searched: selection.searched.clone(), ..by_gains };
    if selection.chosen.effects.is_empty() {
        return Ok(None);
    }
    // Viscous friction had stood in for what was found; without that a wrong velocity lasts longer.
    let blocks = Blocks::of(&selection.chosen.fit.machine, all()).unwrap_or(blocks);
    let (Some(mut in_training), Some(in_held)) = (blocks.whitened(trained)?, blocks.whitened(held)?) else {
        return Ok(None);
    };
    set_tolerances(&selection.base.fit.machine, &mut in_training, &selection.base.fit.starts)?;
    let (in_training, in_held): (Vec<&Prepared>, Vec<&Prepared>) =
        (in_training.iter().collect(), in_held.iter().collect());
    let question = asked.of(&in_training);
    selection.base = selection.base.finished(&question)?;
    selection.chosen = selection.chosen.finished(&question)?;
    let (before, after) = (&selection.base, &selection.chosen);
    if !after.is_plausible(&question) || !accepts(&question, before, before, after)? {
        return Ok(None);
    }
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

/// How recordings are whitened.
struct Blocks {
    machine: Machine<f64>,
    block_s: f64,
    memory_s: f64,
}

impl Blocks {
    /// By the mass and the friction of a model; `None` where a wrong velocity is gone within two rows.
    fn of<'a>(machine: &Machine<f64>, cases: impl Iterator<Item = &'a Prepared>) -> Option<Self> {
        let (mut row_s, mut tick_s, mut shortest_s) = (0.0_f64, 0.0_f64, f64::INFINITY);
        for case in cases {
            row_s = row_s.max(case.duration_s() / case.rows().max(2) as f64);
            tick_s = tick_s.max(case.stimulus.tick.seconds());
            shortest_s = shortest_s.min(case.duration_s());
        }
        let decay_s = machine.get(Parameter::MovingMass) / machine.get(Parameter::ViscousFriction);
        let memory_s = if decay_s.is_finite() { decay_s.min(shortest_s) } else { shortest_s };
        let block_s = (memory_s / BLOCKS_IN_MEMORY).min(shortest_s / LEAST_BLOCKS).max(row_s).max(TICKS * tick_s);
        (memory_s > 2.0 * row_s).then_some(Self { machine: *machine, block_s, memory_s })
    }

    fn whitened(&self, cases: &[Prepared]) -> Result<Option<Vec<Prepared>>, MachineError> {
        cases.iter().map(|case| case.whitened(&self.machine, self.block_s, self.memory_s)).collect()
    }
}
