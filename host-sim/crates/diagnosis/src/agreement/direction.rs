//! Doubts about which way a signal counts, and about which of two lines leads where.

use recording::Signal;
use simulation::InputPoint;

use super::change::Change;
use super::response::{Response, Responses};

/// A signal runs the other way if its correlation with the model's is below this. Missing physics delays and distorts a motion, but leaves its
/// direction.
const AGAINST: f64 = -0.5;
/// Pressures may be exchanged if their mean square distance from each other's simulation is below this share of that from their own.
const CROSSED: f64 = 0.5;

/// Changes to try, the simplest first, and the signals that raise the doubt.
pub(super) fn changes(responses: &Responses) -> (Vec<Vec<Change>>, Vec<Signal>) {
    let against: Vec<Signal> =
        responses.each.iter().filter(|response| runs_against(response)).map(|response| response.signal).collect();
    let crossed = are_crossed(responses);
    let mut found: Vec<Vec<Change>> = Vec::new();
    if !against.is_empty() {
        found.push(against.iter().map(|&signal| Change::Reversed(signal)).collect());
        let has_spool = responses.to(Signal::Spool).is_some();
        if against.contains(&Signal::Spool) == has_spool {
            found.push(vec![Change::Reversed(responses.driver())]);
        } else if responses.input_point == InputPoint::Command {
            found.push(vec![Change::PortsExchanged]);
        }
    }
    if crossed {
        let both: Vec<Vec<Change>> =
            found.iter().map(|changes| changes.iter().copied().chain([Change::PressuresExchanged]).collect()).collect();
        found.push(vec![Change::PressuresExchanged]);
        found.extend(both);
    }
    let pressures = if crossed { [Signal::PressureA, Signal::PressureB].as_slice() } else { &[] };
    (found, against.into_iter().chain(pressures.iter().copied()).collect())
}

/// Whether a spool or a motion runs the other way; pressures have no direction of their own.
pub(super) fn runs_against(response: &Response) -> bool {
    let is_directed = matches!(response.signal, Signal::Spool | Signal::Position | Signal::Velocity);
    is_directed && response.correlation < AGAINST
}

/// Whether each pressure looks like the other one.
pub(super) fn are_crossed(responses: &Responses) -> bool {
    responses.crossed < CROSSED
}
