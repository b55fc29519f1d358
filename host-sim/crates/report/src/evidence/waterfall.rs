//! The waterfall of the error: what each stage of the diagnosis leaves of it, from the machine file down to the noise.
//!
//! Every stage is a whole machine, in free run over the held-out recordings from the initial state that fits best. Its mean square
//! error as a multiple of the noise's variance is 1 where nothing is left to explain.

use diagnosis::catalogue::Hypothesis;
use diagnosis::selection::Selection;
use diagnosis::{Diagnosis, Shown};
use identification::experiment::Prepared;
use identification::fit::{misfits, settle};
use model_core::machine::{Machine, MachineError};
use recording::Signal;

/// The error that one machine leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// What was done up to this stage, in words.
    pub label: String,
    /// The effect that is new in it, if one is.
    pub effect: Option<&'static str>,
    /// Mean square error over the noise's variance, for each signal.
    pub signals: Vec<(Signal, f64)>,
    /// The same over all signals.
    pub total: f64,
}

/// The stages, in the order in which the diagnosis goes through them; the last is the noise alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Waterfall {
    /// Whether held-out recordings are judged; where there are none, the training ones are.
    pub held_out: bool,
    /// The stages.
    pub stages: Vec<Stage>,
}

impl Waterfall {
    /// Runs every stage: `nominal` is the machine file's drive.
    pub fn of(nominal: &Machine<f64>, diagnosis: &Diagnosis) -> Result<Self, MachineError> {
        let held_out = diagnosis.shown.iter().any(|shown| shown.held_out);
        let cases: Vec<&Prepared> = judged(&diagnosis.shown, held_out).map(|shown| &shown.prepared).collect();
        let mut stages = vec![
            stage("machine file", None, nominal, &cases)?,
            stage("base parameters refitted", None, &diagnosis.selection.base.fit.machine, &cases)?,
        ];
        if !diagnosis.findings.is_empty() {
            for (effect, machine) in steps(&diagnosis.selection) {
                stages.push(stage(&format!("with {}", effect.name), Some(effect.name), &machine, &cases)?);
            }
        }
        let floor = stages[0].signals.iter().map(|(signal, _)| (*signal, 1.0)).collect();
        stages.push(Stage { label: "noise".to_owned(), effect: None, signals: floor, total: 1.0 });
        Ok(Self { held_out, stages })
    }

    /// Share of the machine file's error above the noise that each stage removes, over all signals together; 0 for the
    /// first stage, and for the last the share that no stage removed. `None` where the machine file is already at the noise.
    #[must_use]
    pub fn shares(&self) -> Option<Vec<f64>> {
        let first = self.stages.first()?.total;
        let above = first - 1.0;
        (above > 0.0).then(|| {
            let before = std::iter::once(first).chain(self.stages.iter().map(|stage| stage.total));
            self.stages.iter().zip(before).map(|(stage, before)| (before - stage.total) / above).collect()
        })
    }

    /// Whether a share says nothing: the machine file leaves less misfit than noise, of which chance alone takes more than there is, or less
    /// than none.
    #[must_use]
    pub fn is_chance(&self, share: f64) -> bool {
        self.stages.first().is_some_and(|first| first.total < 2.0) && !(-5e-4..1.0005).contains(&share)
    }
}

fn judged(shown: &[Shown], held_out: bool) -> impl Iterator<Item = &Shown> {
    shown.iter().filter(move |shown| shown.held_out == held_out)
}

/// The chosen effects one after the other, each with the machine that was refitted with it and those before: from the candidate models
/// that were tried and lead to the chosen one, the best of each size.
fn steps(selection: &Selection) -> Vec<(&'static Hypothesis, Machine<f64>)> {
    let chosen: Vec<&'static Hypothesis> = selection.chosen.effects.iter().map(|chosen| chosen.effect).collect();
    let mut known: Vec<&'static Hypothesis> = Vec::new();
    let mut found = Vec::new();
    let holds = |effects: &[&'static Hypothesis], name: &str| effects.iter().any(|effect| effect.name == name);
    for round in selection.rounds.iter().take(chosen.len().saturating_sub(1)) {
        let leads_on = round.iter().find(|trial| {
            trial.effects.len() == known.len() + 1
                && trial.effects.iter().all(|effect| holds(&chosen, effect.name))
                && known.iter().all(|effect| holds(&trial.effects, effect.name))
        });
        let Some(trial) = leads_on else { break };
        let Some(new) = trial.effects.iter().copied().find(|effect| !holds(&known, effect.name)) else { break };
        known.push(new);
        found.push((new, trial.machine));
    }
    // Effects that are not known one by one were added together.
    for effect in chosen.iter().copied().filter(|effect| !holds(&known, effect.name)).collect::<Vec<_>>() {
        found.push((effect, selection.chosen.fit.machine));
    }
    found
}

fn stage(
    label: &str,
    effect: Option<&'static str>,
    machine: &Machine<f64>,
    cases: &[&Prepared],
) -> Result<Stage, MachineError> {
    let starts = cases.iter().map(|case| settle(machine, case)).collect::<Result<Vec<_>, _>>()?;
    let misfits = misfits(machine, cases.iter().copied().zip(starts))?;
    let (square, rows) = misfits.iter().fold((0.0, 0.0), |all, misfit| (all.0 + misfit.square, all.1 + misfit.rows));
    Ok(Stage {
        label: label.to_owned(),
        effect,
        signals: misfits.iter().map(|misfit| (misfit.signal, misfit.mean_square())).collect(),
        total: square / f64::max(rows, 1.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_say_who_took_what_and_add_up_to_one() {
        let stage = |label: &str, total| Stage { label: label.into(), effect: None, signals: Vec::new(), total };
        let stages = vec![stage("file", 101.0), stage("refitted", 61.0), stage("with it", 2.0), stage("noise", 1.0)];
        let shares = Waterfall { held_out: true, stages }.shares().unwrap();
        for (share, expected) in shares.iter().zip([0.0, 0.4, 0.59, 0.01]) {
            assert!((share - expected).abs() < 1e-12, "{shares:?}");
        }
        let quiet = Waterfall { held_out: true, stages: vec![stage("file", 0.98), stage("noise", 1.0)] };
        assert_eq!(quiet.shares(), None);
    }

    #[test]
    fn a_share_of_next_to_nothing_is_chance_and_one_of_much_is_not() {
        let of = |total| Waterfall {
            held_out: true,
            stages: vec![Stage { label: "file".into(), effect: None, signals: Vec::new(), total }],
        };
        assert!(of(1.02).is_chance(-1.23) && of(1.02).is_chance(1.4) && !of(1.02).is_chance(0.6));
        assert!(!of(60.0).is_chance(-0.03));
    }
}
