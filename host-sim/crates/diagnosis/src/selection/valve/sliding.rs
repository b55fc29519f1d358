//! Stiction of a spool with mass: it sticks until it breaks away, and then slides until it would turn round.
//!
//! It does not jump, so that the instants of its jumps are not needed. But a model without stiction makes a slow spool of it, from which no search comes
//! back. It is therefore searched from the nominal valve, from several bands and with each structure that the valve may have, on the spool alone.

use identification::fit::{FitError, STRUCTURES, coarse};
use identification::parallel;
use model_core::machine::{Machine, Parameter};

use crate::selection::candidate::{Beginning, Candidate, Goes, Question, SETTLED};

/// Bands that the search starts from, of full travel: those of the usual range, two and a half times apart.
const BANDS: [f64; 3] = [0.008, 0.02, 0.05];
/// Kept shares that it starts from.
const KEPT: [f64; 2] = [0.1, 0.4];
/// Refits to the end, at most: each moves band and kept share, which have no derivative.
const REFITS: usize = 6;

/// Where the search starts.
struct Start {
    band: f64,
    kept: f64,
    /// How much harder the spool can be pulled than its largest speed takes.
    structure: f64,
}

/// Whether the spool of a machine has mass.
pub(super) fn has_mass(machine: &Machine<f64>) -> bool {
    machine.get(Parameter::NaturalFrequency) > 0.0
}

/// The valve with stiction, refitted to the end from the best of the starts. `None` where its spool has no mass.
pub(super) fn slides(question: &Question<'_>, base: &Candidate) -> Result<Option<Candidate>, FitError> {
    let stiction = question.form_with(&[Parameter::StictionBand, Parameter::StictionKept]);
    let Some(stiction) = stiction.filter(|_| has_mass(question.scene.machine)) else { return Ok(None) };
    let coarser = coarse(question.training, &base.fit.machine, &base.fit.starts)?;
    let nominal = question.nominal();
    let structures = nominal.iter().any(|(parameter, _)| *parameter == Parameter::SpeedOverdrive);
    let structures = if structures { STRUCTURES.as_slice() } else { &STRUCTURES[..1] };
    let start = |band, kept, structure| Start { band, kept, structure };
    let of_band = |&band: &f64| {
        KEPT.iter().flat_map(move |&kept| structures.iter().map(move |&structure| start(band, kept, structure)))
    };
    let starts: Vec<Start> = BANDS.iter().flat_map(of_band).collect();
    let from_start = |Start { band, kept, structure }: &Start| {
        let mut values = nominal.clone();
        for (parameter, value) in &mut values {
            if *parameter == Parameter::SpeedOverdrive {
                *value = *structure;
            }
        }
        let jumps = vec![(Parameter::StictionBand, *band), (Parameter::StictionKept, *kept)];
        let from = Beginning { fit: &base.fit, values: &values, settled: &[], goes: Goes::Nearly(&coarser) };
        Candidate::refitted(question, vec![stiction], jumps, &from)
    };
    let near: Vec<Candidate> = parallel::try_each(&starts, from_start)?;
    let Some(mut best) = near.into_iter().min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss)) else { return Ok(None) };
    for _ in 0..REFITS {
        let further = best.finished(question)?;
        let is_there = further.fit.loss > (1.0 - SETTLED) * best.fit.loss;
        if further.fit.loss < best.fit.loss || !best.is_finished {
            best = further;
        }
        if is_there {
            break;
        }
    }
    Ok(Some(best))
}
