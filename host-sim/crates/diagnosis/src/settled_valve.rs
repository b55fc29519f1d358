//! A valve that its recorded spool shows wholly: it is settled before anything below it is searched.
//!
//! Of a drive that is known by its data sheet much is free. What is missing below the spool would bend the valve, whose values are known well from the
//! spool, and an effect of the valve would be tried for it. So the valve is fitted to the spool alone. Where that comes down to the noise, what the
//! spool tells is kept, and no effect of the valve is missing. What may have changed stays free: how much there was of it is not overwritten.

use identification::experiment::Prepared;
use identification::fit::residuals::counts_from;
use identification::fit::{Estimate, Fit, FitError, Free, inflation, softened_all, spool_alone};
use model_core::machine::Machine;

use crate::catalogue::EffectParameter;
use crate::localisation::misses;
use crate::selection::decision_rule::{SPOOL_TOLD_WITHIN, VALVE_SETTLED_WITHIN};

/// What the spool tells.
pub(crate) struct SettledValve {
    /// The machine with it.
    pub(crate) machine: Machine<f64>,
    /// What is still free.
    pub(crate) free: Vec<Free>,
    /// What is no longer.
    pub(crate) estimates: Vec<Estimate>,
}

impl SettledValve {
    /// `None` where a recording lacks the spool or anything below it, where the spool is not explained, or where nothing is a tolerance: such a drive is
    /// known well enough.
    ///
    /// The amounts that are `changeable` stay free.
    pub(crate) fn of(
        machine: &Machine<f64>,
        free: &[Free],
        changeable: &[&EffectParameter],
        cases: &[Prepared],
    ) -> Result<Option<Self>, FitError> {
        if free.iter().all(|free| free.tolerance().is_none()) {
            return Ok(None);
        }
        let Some((fit, spools)) = spool_alone(machine, free, cases)? else { return Ok(None) };
        let with_starts = || spools.iter().zip(fit.starts.iter().copied());
        if misses(&fit.machine, with_starts())?.iter().any(|miss| miss.over_noise > VALVE_SETTLED_WITHIN) {
            return Ok(None);
        }
        let residuals = softened_all(&fit.machine, with_starts())?;
        let counts = counts_from(spools[0].stimulus.input_point);
        let may_change = |parameter| changeable.iter().any(|amount| amount.parameter == parameter);
        let is_settled = |one: &Estimate| !may_change(one.parameter) && is_told(&fit, one);
        let estimates: Vec<Estimate> =
            fit.estimates(inflation(&residuals, counts)).into_iter().filter(is_settled).collect();
        let mut settled = *machine;
        for told in &estimates {
            settled.set(told.parameter, told.value);
        }
        let is_free = |free: &&Free| estimates.iter().all(|told| told.parameter != free.parameter);
        Ok(Some(Self { machine: settled, free: free.iter().filter(is_free).copied().collect(), estimates }))
    }
}

/// Whether the spool tells a value much better than it was known before.
fn is_told(fit: &Fit, estimate: &Estimate) -> bool {
    let free = fit.free.iter().find(|free| free.parameter == estimate.parameter);
    let known_before = free.map_or(0.0, |free| free.width(estimate.value));
    estimate.std < SPOOL_TOLD_WITHIN * known_before
}
