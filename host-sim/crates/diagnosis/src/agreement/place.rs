//! Doubts about where a position counts from: no rod is beyond its stroke.

use model_core::machine::{Machine, Parameter};
use recording::{Recording, Signal};
use simulation::signal::noise::extent;

use super::change::Change;

/// A rod may seem to be beyond its stroke by this share of it, as strokes are often given for the load.
pub(super) const BEYOND_STROKE: f64 = 0.1;

/// How far a position is beyond the stroke, as a share of it; negative within.
pub(super) fn beyond_stroke(position_m: f64, stroke_m: f64) -> f64 {
    (-position_m).max(position_m - stroke_m) / stroke_m
}

/// Changes to try, and the signal that raises the doubt. A zero in the middle of the stroke leaves open how far the rod is out; the middle of what is
/// possible is taken.
pub(super) fn changes(machine: &Machine<f64>, recordings: &[&Recording]) -> (Vec<Vec<Change>>, Vec<Signal>) {
    let positions = recordings.iter().filter_map(|recording| recording.signal(Signal::Position));
    let (low, high) = extent(positions.flatten().copied());
    let stroke_m = machine.get(Parameter::Stroke);
    let is_within =
        |low: f64, high: f64| beyond_stroke(low, stroke_m).max(beyond_stroke(high, stroke_m)) <= BEYOND_STROKE;
    if !(low <= high && stroke_m.is_finite()) || is_within(low, high) {
        return (Vec::new(), Vec::new());
    }
    let reversed = is_within(-high, -low).then_some(Change::Reversed(Signal::Position));
    let moved = (high - low <= stroke_m).then_some(Change::Moved(Signal::Position, 0.5 * (stroke_m - low - high)));
    (reversed.into_iter().chain(moved).map(|change| vec![change]).collect(), vec![Signal::Position])
}

#[cfg(test)]
mod tests {
    use model_core::machine::Source;
    use recording::Column;

    use super::*;

    #[test]
    fn a_position_within_the_stroke_is_not_moved_and_one_beyond_it_is_moved_inside_or_turned_round() {
        let machine = Machine::with_defaults(Source::Valve).with(&[(Parameter::Stroke, 0.3)]);
        let changes = |from: f64, to: f64| {
            let columns = vec![
                Column::si(Signal::Time, (0..50).map(f64::from).collect()),
                Column::si(Signal::Position, (0..50).map(|row| from + (to - from) * f64::from(row) / 49.0).collect()),
            ];
            let recording = Recording::new("a run", columns).unwrap();
            super::changes(&machine, &[&recording]).0.concat()
        };
        assert_eq!(changes(0.0, 0.3), []);
        assert_eq!(changes(-0.02, 0.25), []);
        assert!(matches!(changes(-0.1, 0.1)[..], [Change::Moved(Signal::Position, by)] if (by - 0.15).abs() < 1e-9));
        let turned = changes(-0.25, -0.05);
        assert!(matches!(turned[..], [Change::Reversed(Signal::Position), Change::Moved(..)]), "{turned:?}");
        assert_eq!(changes(0.0, 0.5), []);
    }
}
