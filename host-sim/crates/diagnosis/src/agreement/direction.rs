//! Doubts about which way a signal counts, and about which of two lines leads where.

use recording::Signal;
use simulation::InputPoint;

use super::change::Change;
use super::response::Responses;

/// A signal runs the other way if its correlation with the model's is below this. Missing physics delays and distorts a motion, but leaves its
/// direction.
const AGAINST: f64 = -0.5;
/// Pressures may be exchanged if their mean square distance from each other's simulation is below this share of that from their own.
const CROSSED: f64 = 0.5;

/// Changes to try, the simplest first, and the signals that raise the doubt.
pub(super) fn changes(responses: &Responses) -> (Vec<Vec<Change>>, Vec<Signal>) {
    let runs_against = |signal| responses.to(signal).is_some_and(|response| response.correlation < AGAINST);
    let against: Vec<Signal> = [Signal::Spool, Signal::Position, Signal::Velocity]
        .into_iter()
        .filter(|signal| runs_against(*signal))
        .collect();
    let crossed = responses.crossed < CROSSED;
    let moves_against = runs_against(Signal::Position) || runs_against(Signal::Velocity);
    let mut found: Vec<Vec<Change>> = Vec::new();
    if !against.is_empty() {
        found.push(against.iter().map(|&signal| Change::Reversed(signal)).collect());
        let has_spool = responses.to(Signal::Spool).is_some();
        if runs_against(Signal::Spool) == has_spool {
            found.push(vec![Change::Reversed(responses.driver())]);
        } else if moves_against && responses.input_point == InputPoint::Command {
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
