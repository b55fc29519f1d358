//! Doubts about when a command was given: what it moves cannot move before it.

use model_core::machine::{Machine, Parameter};
use recording::Signal;
use simulation::InputPoint;

use super::change::Change;
use super::response::Responses;
use super::scale::is_off;

/// A motion is early by this share of the valve's delay and lags; data sheets are off by less.
const EARLY: f64 = 0.5;
/// And by so many rows.
const ROWS: f64 = 2.0;

/// Changes to try, and the signals that raise the doubt, where most recordings do.
pub(super) fn changes(machine: &Machine<f64>, responses: &[Option<Responses>]) -> (Vec<Vec<Change>>, Vec<Signal>) {
    let usual_s = machine.get(Parameter::TransportDelay) + machine.spool_lag_s();
    let early = |responses: &Responses| {
        let driven = responses.to(Signal::Spool).or_else(|| responses.to(Signal::Position))?;
        // What runs the other way, or in another scale, says nothing about when.
        let tells = responses.input_point == InputPoint::Command && driven.correlation > 0.0 && !is_off(driven.ratio);
        let is_early = driven.early_s >= (EARLY * usual_s).max(ROWS * responses.interval_s);
        (tells && is_early).then_some((driven.early_s, driven.signal))
    };
    let mut found: Vec<(f64, Signal)> = responses.iter().flatten().filter_map(early).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(by_s, signal)) = found.get(found.len() / 2).filter(|_| 2 * found.len() > responses.len()) else {
        return (Vec::new(), Vec::new());
    };
    (vec![vec![Change::Earlier(Signal::Command, by_s)]], vec![signal])
}
